// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"

#include <utility>

namespace arap_native {

std::string shape_text(Shape shape) {
  std::string text;
  for (const Extent& extent : shape) {
    if (!text.empty()) text += ", ";
    text += extent.text();
  }
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

std::string shape_text(const py::array& array) { return py::str(py::tuple(array.attr("shape"))); }

std::string type_name(py::handle object) { return py::str(py::type::handle_of(object).attr("__name__")); }

bool has_shape(const py::array& array, Shape shape) {
  if (array.ndim() != static_cast<py::ssize_t>(shape.size())) return false;
  const py::ssize_t* given = array.shape();
  for (const Extent& extent : shape) {
    if (!extent.accepts(*given++)) return false;
  }
  return true;
}

arap::Positions positions_from(const py::object& object, const char* name, const Extent& rows, const char* rows_text) {
  const py::array array = require_array<double>(object, name, {rows, 3}, rows_text);
  arap::Positions positions(array.shape(0), 3);
  if (positions.size() > 0) std::memcpy(positions.data(), array.data(), static_cast<size_t>(array.nbytes()));
  return positions;
}

std::span<float> out_from(const py::object& object, py::ssize_t n_rows, const char* rows_text) {
  if (object.is_none()) return {};
  py::array array = require_array<float>(object, "out", {n_rows, 3}, rows_text);
  if (!array.writeable()) throw py::value_error("out is read-only, expected an array that can be written to");
  if ((array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0)
    throw py::value_error(
        "out is not aligned, expected numbers at multiples of their size: pass an array made by numpy");
  return {static_cast<float*>(array.mutable_data()), static_cast<size_t>(array.size())};
}

py::array to_array(arap::Positions values) {
  const py::ssize_t rows = values.rows();
  return array_keeping<double>(std::move(values), {rows, py::ssize_t{3}});
}

}  // namespace arap_native
