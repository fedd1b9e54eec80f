// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

namespace arap_native {

namespace py = pybind11;

/// Each adds one class of options to the module.
void bind_options(py::module_& m);
void bind_lattice_options(py::module_& m);
void bind_cage_options(py::module_& m);
void bind_wrap_options(py::module_& m);
void bind_solve_options(py::module_& m);

// Of the extra models.
void bind_embedded_options(py::module_& m);
void bind_poisson_options(py::module_& m);
void bind_tet_options(py::module_& m);
void bind_cage_arap_options(py::module_& m);

}  // namespace arap_native
