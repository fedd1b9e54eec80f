// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <utility>

#include "arap/surface_arap.h"
#include "arrays.h"

namespace arap_native {

namespace py = pybind11;

/// The library's result with its arrays handed over to numpy.
struct SolveResult {
  /// @param out  the array that has the positions, or None
  SolveResult(arap::SolveResult result, const py::object& out)
      : positions(out.is_none() ? to_array(std::move(result.positions)) : py::reinterpret_borrow<py::array>(out)),
        parts_at_rest(to_array(std::move(result.parts_at_rest))),
        loose_vertices(to_array(std::move(result.loose_vertices))),
        energy_before(result.energy_before),
        energy_after(result.energy_after),
        iterations(result.iterations),
        step(result.step),
        stop_reason(result.stop_reason) {}

  py::array positions, parts_at_rest, loose_vertices;
  double energy_before, energy_after;
  int iterations;
  double step;
  arap::StopReason stop_reason;
};

/// Adds SolveResult to the module.
void bind_result(py::module_& m);

}  // namespace arap_native
