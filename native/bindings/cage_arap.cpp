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
  // Not by bind_class: the cage comes after what all models take.
  py::class_<Bound, BoundModel> type(m, "CageArap", docstrings::CageArap);
  def_init(
      type, docstrings::CageArap_init,
      [](Object rest_positions, Object faces, Object face_sizes, const Options* options, Object cage, Object progress) {
        return Bound::bind({caged_from(rest_positions, faces, face_sizes, cage), options}, progress);
      });
  def_static(type, docstrings::CageArap_begin_bind,
             [jobs](Object rest_positions, Object faces, Object face_sizes, const Options* options, Object cage) {
               return Bound::begin_bind(*jobs, {caged_from(rest_positions, faces, face_sizes, cage), options});
             });
  def_pickle(type);
  def(type, docstrings::CageArap_cage_positions, [](const Bound& model) {
    return to_array(model.exclusively([](arap::CageArap& native) { return native.cage_positions(); }));
  });
  def_property(
      type, "n_cage_vertices", [](const Bound& model) { return model.native().n_cage_vertices(); },
      docstrings::CageArap_n_cage_vertices);
}

}  // namespace arap_native
