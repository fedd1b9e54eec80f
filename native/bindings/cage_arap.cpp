// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/cage_arap.h"

#include <memory>
#include <utility>

#include "bound_model.h"
#include "docstrings.h"

namespace arap_native {

void bind_cage_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  using Bound = BoundAs<arap::CageArap>;
  using Options = arap::CageArapOptions;
  using Object = const py::object&;
  const py::object none = py::none();
  // Not by bind_class: the cage comes after what all models take.
  py::class_<Bound, BoundModel>(m, "CageArap", docstrings::CageArap)
      .def(py::init([](Object rest_positions, Object faces, Object face_sizes, const Options* options, Object cage,
                       py::object progress) {
             return Bound::bind({caged_from(rest_positions, faces, face_sizes, cage), options}, std::move(progress));
           }),
           docstrings::CageArap_init, py::arg("rest_positions"), py::arg("faces"), py::arg("face_sizes") = none,
           py::arg("options") = none, py::kw_only(), py::arg("cage"), py::arg("progress") = none)
      .def_static(
          "begin_bind",
          [jobs](Object rest_positions, Object faces, Object face_sizes, const Options* options, Object cage) {
            return Bound::begin_bind(*jobs, {caged_from(rest_positions, faces, face_sizes, cage), options});
          },
          docstrings::CageArap_begin_bind, py::arg("rest_positions"), py::arg("faces"), py::arg("face_sizes") = none,
          py::arg("options") = none, py::kw_only(), py::arg("cage"))
      .def(
          "cage_positions",
          [](const Bound& model) {
            return to_array(model.exclusively([](arap::CageArap& native) { return native.cage_positions(); }));
          },
          docstrings::CageArap_cage_positions)
      .def_property_readonly(
          "n_cage_vertices", [](const Bound& model) { return model.native().n_cage_vertices(); },
          docstrings::CageArap_n_cage_vertices);
}

}  // namespace arap_native
