// SPDX-License-Identifier: GPL-3.0-or-later
#include "result.h"

#include <string>

#include "data.h"
#include "docstrings.h"
#include "enum_names.h"
#include "gil.h"
#include "signature.h"

namespace arap_native {

namespace {

int count(const std::shared_future<int>& parts) {
  const WithoutGil no_gil;
  return parts.get();
}

std::string result_repr(const SolveResult& result) {
  return py::str(
             "<SolveResult: {} after {} iterations, energy {:.6g} -> {:.6g}, step {:.2g}, {}, {} at rest, {} loose "
             "vertices>")
      .format(name_of<arap::StopReason>(result.stop_reason, kStopReasons), result.iterations, result.energy_before,
              result.energy_after, result.step, parts_text(result.n_parts, result.n_parts_joined),
              result.parts_at_rest.size(), result.loose_vertices.size());
}

py::array array_from(const py::object& object, const char* name) {
  if (!py::isinstance<py::array>(object)) throw wrong_type(name, object, "array");
  return py::reinterpret_borrow<py::array>(object);
}

/// Of these values, for copies and tests.
SolveResult result_of(const py::object& positions, double energy_before, double energy_after, int iterations,
                      double step, const py::object& stop_reason, const py::object& parts_at_rest,
                      const py::object& loose_vertices, int n_parts, int n_parts_joined) {
  arap::SolveResult native;
  native.energy_before = energy_before;
  native.energy_after = energy_after;
  native.iterations = iterations;
  native.step = step;
  native.stop_reason = value_of<arap::StopReason>(stop_reason, "stop_reason", kStopReasons);
  std::promise<int> joined;
  joined.set_value(n_parts_joined);
  SolveResult result(native, array_from(positions, "positions"), n_parts, joined.get_future().share());
  require_shape(result.positions, "positions", {"n", 3}, "one row per vertex");
  result.parts_at_rest = array_from(parts_at_rest, "parts_at_rest");
  result.loose_vertices = array_from(loose_vertices, "loose_vertices");
  return result;
}

template <typename Value>
void def_value(py::class_<SolveResult>& type, const char* name, Value SolveResult::*value, const char* doc) {
  def_property(
      type, name, [value](const SolveResult& result) { return result.*value; }, doc);
}

}  // namespace

std::string parts_text(int n_parts, const std::shared_future<int>& n_joined) {
  std::string text = std::to_string(n_parts) + (n_parts == 1 ? " part" : " parts");
  const int joined = count(n_joined);
  if (joined < n_parts) text += " (" + std::to_string(joined) + " with seams joined)";
  return text;
}

void bind_result(py::module_& m) {
  py::class_<SolveResult> type(m, "SolveResult", docstrings::SolveResult);
  def_init(type, docstrings::SolveResult_init, &result_of);
  def_value(type, "positions", &SolveResult::positions, docstrings::SolveResult_positions);
  def_value(type, "energy_before", &SolveResult::energy_before, docstrings::SolveResult_energy_before);
  def_value(type, "energy_after", &SolveResult::energy_after, docstrings::SolveResult_energy_after);
  def_value(type, "iterations", &SolveResult::iterations, docstrings::SolveResult_iterations);
  def_value(type, "step", &SolveResult::step, docstrings::SolveResult_step);
  def_property(
      type, "stop_reason",
      [](const SolveResult& result) { return name_of<arap::StopReason>(result.stop_reason, kStopReasons); },
      docstrings::SolveResult_stop_reason);
  def_value(type, "parts_at_rest", &SolveResult::parts_at_rest, docstrings::SolveResult_parts_at_rest);
  def_value(type, "loose_vertices", &SolveResult::loose_vertices, docstrings::SolveResult_loose_vertices);
  def_value(type, "n_parts", &SolveResult::n_parts, docstrings::SolveResult_n_parts);
  def_property(
      type, "n_parts_joined", [](const SolveResult& result) { return count(result.n_parts_joined); },
      docstrings::SolveResult_n_parts_joined);
  def(type, "__repr__(self)", &result_repr);
  const Signature signature(docstrings::SolveResult_init);
  def_data<SolveResult>(type, [signature](const SolveResult& result) {
    return attributes_of(py::cast(&result, py::return_value_policy::reference), signature);
  });
}

}  // namespace arap_native
