// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/embedded_deformation.h"

#include "bound_model.h"
#include "docstrings.h"

namespace arap_native {

void bind_embedded_deformation(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  using Bound = BoundAs<arap::EmbeddedDeformation>;
  auto type = bind_polygon_class<arap::EmbeddedDeformation>(m, jobs, docstrings::EmbeddedDeformation,
                                                            docstrings::EmbeddedDeformation_init,
                                                            docstrings::EmbeddedDeformation_begin_bind);
  def_property(
      type, "n_nodes", [](const Bound& model) { return model.native().n_nodes(); },
      docstrings::EmbeddedDeformation_n_nodes);
  def_property(
      type, "nodes", [](const Bound& model) { return to_array(model.native().nodes()); },
      docstrings::EmbeddedDeformation_nodes);
}

}  // namespace arap_native
