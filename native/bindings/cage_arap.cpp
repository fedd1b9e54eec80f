// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/cage_arap.h"

#include "bound_model.h"
#include "docstrings.h"

namespace arap_native {

void bind_cage_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  using Bound = BoundAs<arap::CageArap>;
  bind_class<arap::CageArap>(m, jobs, docstrings::CageArap, docstrings::CageArap_init, docstrings::CageArap_begin_bind,
                             &caged_from, py::arg("rest_positions"), py::arg("faces"), py::arg("face_sizes"),
                             py::arg("cage"))
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
