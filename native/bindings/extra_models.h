// SPDX-License-Identifier: GPL-3.0-or-later
// The models that the Blender add-on does not use: its wheel is built without them.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "job_handle.h"

namespace arap_native {

namespace py = pybind11;

/// Adds them, their options, LatticeTets and transfer_cage() to the module.
void bind_extra_models(py::module_& m, const std::shared_ptr<Jobs>& jobs);

}  // namespace arap_native
