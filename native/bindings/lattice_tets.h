// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

namespace arap_native {

namespace py = pybind11;

/// Adds LatticeTets to the module.
void bind_lattice_tets(py::module_& m);

}  // namespace arap_native
