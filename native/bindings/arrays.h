// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays of numpy in and out: converted where every number fits, else a TypeError or ValueError that says what is
// wrong.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arap/types.h"

namespace arap_native {

namespace py = pybind11;

/// One dimension of an expected shape: a size, or a letter for any size.
class Extent {
 public:
  // Implicit, so that {n, 3} and {"n", 3} read as shapes.
  Extent(py::ssize_t size) : size_(size), text_(std::to_string(size)) {}  // NOLINT(google-explicit-constructor)
  Extent(const char* letter) : text_(letter) {}                           // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool accepts(py::ssize_t given) const { return size_ < 0 || size_ == given; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  py::ssize_t size_ = -1;
  std::string text_;
};
using Shape = std::initializer_list<Extent>;

std::string shape_text(Shape shape);
std::string shape_text(const py::array& array);
/// What repr() says, cut where it is long: messages are one sentence.
std::string shown(py::handle object);
std::string class_name(py::handle type);
/// Of the class of an object.
std::string type_name(py::handle object);

/// `object`, an array or what numpy makes one, as float64 or int32 in C order; itself where it is so already. Throws a
/// TypeError for what is no array, a ValueError for another kind of numbers, masked values or an integer that does not
/// fit.
template <typename T>
py::array numbers_from(const py::object& object, const std::string& name);
template <>
py::array numbers_from<double>(const py::object& object, const std::string& name);
template <>
py::array numbers_from<int>(const py::object& object, const std::string& name);

/// Throws a ValueError if the shape is another one; `rows` says what a row stands for.
void require_shape(const py::array& array, const std::string& name, Shape shape, const char* rows);

/// Such numbers in exactly this shape.
template <typename T>
py::array require_array(const py::object& object, const std::string& name, Shape shape, const char* rows) {
  py::array array = numbers_from<T>(object, name);
  require_shape(array, name, shape, rows);
  return array;
}

/// A copy: the library keeps it, or works on it while other Python threads may write to the array.
template <typename T>
std::vector<T> to_vector(const py::array& array) {
  std::vector<T> values(static_cast<size_t>(array.size()));
  if (!values.empty()) std::memcpy(values.data(), array.data(), values.size() * sizeof(T));
  return values;
}

template <typename T>
std::vector<T> vector_from(const py::object& object, const std::string& name, const Extent& size, const char* rows) {
  return to_vector<T>(require_array<T>(object, name, {size}, rows));
}

arap::Positions positions_from(const py::object& object, const std::string& name, const Extent& rows,
                               const char* rows_text);

/// The numbers of a float32 array (n_rows, 3) in C order that is written to, so nothing is converted; none for None.
/// The array must outlive them.
std::span<float> out_from(const py::object& object, py::ssize_t n_rows, const char* rows_text = "one row per vertex");

/// The numbers of an array of float32, (n_rows, 3), rows one after the other; of any other object nothing.
std::optional<std::span<const float>> singles_of(const py::object& object, py::ssize_t n_rows);

/// An array of `values`, whose numbers are Ts one after the other; it keeps them.
template <typename T, typename Values>
py::array array_keeping(Values values, py::array::ShapeContainer shape) {
  auto kept = std::make_unique<Values>(std::move(values));
  const void* data = kept->data();
  const py::capsule owner(kept.release(), [](void* p) { delete static_cast<Values*>(p); });
  return {py::dtype::of<T>(), std::move(shape), data, owner};
}

template <typename T>
py::array to_array(std::vector<T> values) {
  const auto size = std::ssize(values);
  return array_keeping<T>(std::move(values), {size});
}

/// A row per entry.
template <typename T, size_t N>
py::array to_array(std::vector<std::array<T, N>> values) {
  const auto rows = std::ssize(values);
  return array_keeping<T>(std::move(values), {rows, static_cast<py::ssize_t>(N)});
}

py::array to_array(arap::Positions values);

}  // namespace arap_native
