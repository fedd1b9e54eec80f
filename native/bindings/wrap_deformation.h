// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "job_handle.h"

namespace arap_native {

namespace py = pybind11;

/// Adds WrapSurface and WrapDeformation to the module.
void bind_wrap_deformation(py::module_& m, const std::shared_ptr<Jobs>& jobs);

}  // namespace arap_native
