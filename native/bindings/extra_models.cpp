// SPDX-License-Identifier: GPL-3.0-or-later
#include "extra_models.h"

#include <utility>

#include "arap/cage_transfer.h"
#include "arrays.h"
#include "bound_model.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"
#include "lattice_tets.h"
#include "options.h"
#include "progress_call.h"
#include "signature.h"

namespace arap_native {

namespace {

using Object = const py::object&;

arap::Positions transferred(MeshArrays source, const arap::Positions& moved_source, MeshArrays target,
                            const py::object& progress) {
  ProgressCall call(progress);
  const WithoutGil no_gil;
  return arap::transfer_cage(mesh_of(std::move(source)), moved_source, mesh_of(std::move(target)), call.function());
}

void bind_transfer(py::module_& m) {
  def(m, docstrings::transfer_cage, [](Object source, Object moved_source, Object target, Object progress) {
    MeshArrays from = mesh_from_tuple(source, "source");
    const arap::Positions moved =
        positions_from(moved_source, "moved_source", from.positions.rows(), "one row per vertex of the source");
    return to_array(transferred(std::move(from), moved, mesh_from_tuple(target, "target"), progress));
  });
}

}  // namespace

void bind_extra_models(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  bind_poisson_options(m);
  bind_embedded_options(m);
  bind_tet_options(m);
  bind_cage_arap_options(m);
  bind_poisson_editing(m, jobs);
  bind_embedded_deformation(m, jobs);
  bind_cage_arap(m, jobs);
  bind_tet_arap(m, jobs);
  bind_lattice_tets(m);
  bind_transfer(m);
  for (const char* name : {"CageArap", "CageArapOptions", "EmbeddedDeformation", "EmbeddedOptions", "LatticeTets",
                           "PoissonEditing", "PoissonOptions", "TetArap", "TetOptions"})
    m.attr(name).attr("__module__") = "arap_native";
}

}  // namespace arap_native
