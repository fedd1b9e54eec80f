// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/surface_arap.h"

#include <utility>
#include <vector>

#include "bound_model.h"
#include "docstrings.h"

namespace arap_native {

namespace {

using Bound = BoundAs<arap::SurfaceArap>;

py::tuple patch_to_python(const arap::Patch& patch) {
  return py::make_tuple(to_array(patch.vertices), to_array(patch.weights),
                        to_array(std::vector<double>(patch.rest_position.begin(), patch.rest_position.end())));
}

py::tuple patch_around(const Bound& model, const py::object& vertices, double radius) {
  const auto indices = vector_from<int>(vertices, "vertices", "k", "one entry per vertex");
  return patch_to_python(
      model.exclusively([&](arap::SurfaceArap& surface) { return surface.patch_around(indices, radius); }));
}

std::unique_ptr<JobHandle> begin_patches(const Bound& model, Jobs& jobs, const py::object& around,
                                         const py::object& radii) {
  if (!py::isinstance<py::sequence>(around))
    throw py::type_error("around is of type " + type_name(around) + ", expected a list of arrays of integers");
  std::vector<std::vector<int>> groups;
  for (const py::handle vertices : around)
    groups.push_back(vector_from<int>(py::reinterpret_borrow<py::object>(vertices), "an array of around", "k",
                                      "one entry per vertex"));
  auto reaches = vector_from<double>(radii, "radii", static_cast<py::ssize_t>(groups.size()), "one entry per patch");
  return begin_job(
      jobs,
      [turn = model.turn(), groups = std::move(groups), reaches = std::move(reaches)](const arap::Progress& progress) {
        std::vector<arap::Patch> patches;
        for (size_t i = 0; i < groups.size(); ++i) {
          if (!progress(static_cast<double>(i) / static_cast<double>(groups.size())))
            throw arap::Cancelled("finding patches was cancelled");
          patches.push_back((*turn).native.patch_around(groups[i], reaches[i]));
        }
        return patches;
      },
      [](const std::vector<arap::Patch>& patches) {
        py::list result;
        for (const arap::Patch& patch : patches) result.append(patch_to_python(patch));
        return result;
      });
}

}  // namespace

void bind_surface_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  auto type = bind_polygon_class<arap::SurfaceArap>(m, jobs, docstrings::SurfaceArap, docstrings::SurfaceArap_init,
                                                    docstrings::SurfaceArap_begin_bind);
  def(type, docstrings::SurfaceArap_patch_around, &patch_around);
  def(type, docstrings::SurfaceArap_begin_patches,
      [jobs](const Bound& model, const py::object& around, const py::object& radii) {
        return begin_patches(model, *jobs, around, radii);
      });
  def_energy(type, docstrings::SurfaceArap_energy, docstrings::SurfaceArap_energy_gradient);
}

}  // namespace arap_native
