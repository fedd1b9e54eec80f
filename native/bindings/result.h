// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <future>
#include <string>
#include <utility>

#include "arap/surface_arap.h"
#include "arrays.h"

namespace arap_native {

namespace py = pybind11;

/// The library's result with its arrays handed over to numpy.
struct SolveResult {
  /// @param out           the array that has the positions, or None
  /// @param all_parts     of the model
  /// @param joined_parts  how many these would be with seams joined, found when somebody asks
  SolveResult(arap::SolveResult result, const py::object& out, int all_parts, std::shared_future<int> joined_parts)
      : positions(out.is_none() ? to_array(std::move(result.positions)) : py::reinterpret_borrow<py::array>(out)),
        parts_at_rest(to_array(std::move(result.parts_at_rest))),
        loose_vertices(to_array(std::move(result.loose_vertices))),
        energy_before(result.energy_before),
        energy_after(result.energy_after),
        iterations(result.iterations),
        step(result.step),
        stop_reason(result.stop_reason),
        n_parts(all_parts),
        n_parts_joined(std::move(joined_parts)) {}

  py::array positions, parts_at_rest, loose_vertices;
  double energy_before, energy_after;
  int iterations;
  double step;
  arap::StopReason stop_reason;
  int n_parts;
  std::shared_future<int> n_parts_joined;
};

/// "13 parts (1 with seams joined)"
std::string parts_text(int n_parts, const std::shared_future<int>& n_joined);

/// Adds SolveResult to the module.
void bind_result(py::module_& m);

}  // namespace arap_native
