// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/tet_arap.h"

#include "bound_model.h"
#include "docstrings.h"

namespace arap_native {

void bind_tet_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  auto type = bind_class<arap::TetArap>(m, jobs, docstrings::TetArap, docstrings::TetArap_init,
                                        docstrings::TetArap_begin_bind, &tets_from);
  def_energy(type, docstrings::TetArap_energy, docstrings::TetArap_energy_gradient);
}

}  // namespace arap_native
