// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

namespace arap_native {

namespace py = pybind11;

/// Adds Options to the module.
void bind_options(py::module_& m);
/// Adds LatticeOptions.
void bind_lattice_options(py::module_& m);
/// Adds PoissonOptions.
void bind_embedded_options(py::module_& m);
void bind_poisson_options(py::module_& m);
/// Adds TetOptions.
void bind_tet_options(py::module_& m);
/// Adds CageOptions.
void bind_cage_options(py::module_& m);
void bind_cage_arap_options(py::module_& m);
/// Adds WrapOptions.
void bind_wrap_options(py::module_& m);
/// Adds SolveOptions.
void bind_solve_options(py::module_& m);

}  // namespace arap_native
