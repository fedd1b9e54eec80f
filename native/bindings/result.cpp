// SPDX-License-Identifier: GPL-3.0-or-later
#include "result.h"

#include <string>

#include "docstrings.h"
#include "enum_names.h"

namespace arap_native {

namespace {

std::string result_repr(const SolveResult& result) {
  return py::str(
             "<SolveResult: {} after {} iterations, energy {:.6g} -> {:.6g}, step {:.2g}, {} parts at rest, {} loose "
             "vertices>")
      .format(name_of<arap::StopReason>(result.stop_reason, kStopReasons), result.iterations, result.energy_before,
              result.energy_after, result.step, result.parts_at_rest.size(), result.loose_vertices.size());
}

}  // namespace

void bind_result(py::module_& m) {
  py::class_<SolveResult>(m, "SolveResult", docstrings::SolveResult)
      .def_readonly("positions", &SolveResult::positions, docstrings::SolveResult_positions)
      .def_readonly("energy_before", &SolveResult::energy_before, docstrings::SolveResult_energy_before)
      .def_readonly("energy_after", &SolveResult::energy_after, docstrings::SolveResult_energy_after)
      .def_readonly("iterations", &SolveResult::iterations, docstrings::SolveResult_iterations)
      .def_readonly("step", &SolveResult::step, docstrings::SolveResult_step)
      .def_property_readonly(
          "stop_reason",
          [](const SolveResult& result) { return name_of<arap::StopReason>(result.stop_reason, kStopReasons); },
          docstrings::SolveResult_stop_reason)
      .def_readonly("parts_at_rest", &SolveResult::parts_at_rest, docstrings::SolveResult_parts_at_rest)
      .def_readonly("loose_vertices", &SolveResult::loose_vertices, docstrings::SolveResult_loose_vertices)
      .def("__repr__", &result_repr);
}

}  // namespace arap_native
