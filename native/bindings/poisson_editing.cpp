// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/poisson_editing.h"

#include "bound_model.h"
#include "docstrings.h"

namespace arap_native {

void bind_poisson_editing(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  bind_polygon_class<arap::PoissonEditing>(m, jobs, docstrings::PoissonEditing, docstrings::PoissonEditing_init,
                                           docstrings::PoissonEditing_begin_bind);
}

}  // namespace arap_native
