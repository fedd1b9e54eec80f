// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/lattice_arap.h"

#include "bound_model.h"
#include "docstrings.h"

namespace arap_native {

void bind_lattice_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  using Bound = BoundAs<arap::LatticeArap>;
  auto type = bind_polygon_class<arap::LatticeArap>(m, jobs, docstrings::LatticeArap, docstrings::LatticeArap_init,
                                                    docstrings::LatticeArap_begin_bind);
  def(type, docstrings::LatticeArap_segments_outside, [](const Bound& model, const py::object& segments) {
    return to_array(model.native().segments_outside(segments_from(segments)));
  });
  def(type, docstrings::LatticeArap_cube_corners, [](const Bound& model) {
    return to_array(model.exclusively([](arap::LatticeArap& lattice) { return lattice.cube_corners(); }));
  });
  def_property(
      type, "n_control_points", [](const Bound& model) { return model.native().n_control_points(); },
      docstrings::LatticeArap_n_control_points);
  def_property(
      type, "has_inside", [](const Bound& model) { return model.native().has_inside(); },
      docstrings::LatticeArap_has_inside);
  def_property(
      type, "sheets", [](const Bound& model) { return to_array(model.native().sheets()); },
      docstrings::LatticeArap_sheets);
  def_property(
      type, "cube_size", [](const Bound& model) { return model.native().cube_size(); },
      docstrings::LatticeArap_cube_size);
}

}  // namespace arap_native
