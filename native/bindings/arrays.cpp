// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

namespace arap_native {

static_assert(sizeof(int) == 4 && sizeof(float) == 4 && sizeof(double) == 8);

namespace {

/// At most so much of a text that anything may be in.
std::string cut(const py::object& text) {
  constexpr py::ssize_t kMost = 60;
  if (py::len(text) <= kMost) return py::str(text);
  return std::string(py::str(text[py::slice(0, kMost, 1)])) + "...";
}

constexpr const char* kReals = "real numbers";
constexpr const char* kIntegers = "integers";

using Limits = std::numeric_limits<int>;

[[noreturn]] void refuse_entry(const std::string& entry, py::ssize_t place, const std::string& name) {
  throw py::value_error(name + " has the entry " + entry + " at place " + std::to_string(place) + ", must be from " +
                        std::to_string(Limits::min()) + " to " + std::to_string(Limits::max()));
}

/// numpy would leave out which values are not valid.
void require_unmasked(const py::object& array, const std::string& name) {
  const bool is_plain = Py_TYPE(array.ptr()) == py::detail::npy_api::get().PyArray_Type_;
  if (!is_plain && py::module_::import("numpy").attr("ma").attr("is_masked")(array).cast<bool>())
    throw py::value_error(name + " has masked values, expected an array without: fill them or leave them out");
}

/// Refuses what numpy would make numbers of another kind: a bool among numbers, and an integer that does not fit.
template <typename T>
class Entries {
 public:
  Entries(const std::string& name, const char* expected) : name_(name), expected_(expected) {}

  void require(py::handle list, int depth = 1) {
    constexpr int kDeepest = 4;  // numpy refuses what is deeper
    for (const py::handle entry : list) {
      if (py::isinstance<py::list>(entry) || py::isinstance<py::tuple>(entry)) {
        if (depth < kDeepest) require(entry, depth + 1);
      } else {
        require_number(entry);
        ++place_;
      }
    }
  }

 private:
  void require_number(py::handle entry) const {
    if (py::isinstance<py::bool_>(entry) || py::isinstance(entry, numpy_bool_))
      throw py::value_error(name_ + " has the entry " + cut(py::str(entry)) + " at place " + std::to_string(place_) +
                            ", expected " + expected_);
    if (!std::is_same_v<T, int> || !PyLong_Check(entry.ptr())) return;
    int overflow = 0;
    const std::int64_t value = PyLong_AsLongLongAndOverflow(entry.ptr(), &overflow);
    if (overflow != 0 || !std::in_range<int>(value)) refuse_entry(shown(entry), place_, name_);
  }

  const std::string& name_;
  const char* expected_;
  py::object numpy_bool_ = py::module_::import("numpy").attr("bool_");
  py::ssize_t place_ = 0;  ///< how many entries come before
};

/// `object` as an array of any dtype of numbers.
template <typename T>
py::array as_array(const py::object& object, const std::string& name, const char* expected) {
  if (py::isinstance<py::array>(object)) {
    require_unmasked(object, name);
    return py::reinterpret_borrow<py::array>(object);
  }
  if (py::isinstance<py::list>(object) || py::isinstance<py::tuple>(object)) Entries<T>(name, expected).require(object);
  const auto refused = [&] {
    return py::type_error(name + " is of type " + type_name(object) + ", expected an array of " + expected +
                          ", or what numpy.asarray() makes one");
  };
  try {
    const py::array array = py::module_::import("numpy").attr("asarray")(object);
    if (std::string("biufc").find(array.dtype().kind()) == std::string::npos) throw refused();
    return array;
  } catch (const py::error_already_set& error) {
    // Rows of different lengths; numpy before 1.24 warns of them, which may be made an error.
    if (error.matches(PyExc_ValueError) || error.matches(PyExc_Warning)) throw refused();
    throw;
  }
}

[[noreturn]] void refuse_dtype(const py::array& array, const std::string& name, const char* expected) {
  throw py::value_error(name + " has dtype " + cut(py::str(array.dtype())) + ", expected " + expected);
}

constexpr int kReadable = py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_;

/// As native Ts in C order; the same array where it is so already.
template <typename T>
py::array_t<T, kReadable> cast(const py::array& array) {
  return {array};
}

/// Integers of another width as int32.
template <typename Wide>
py::array narrowed(const py::array& array, const std::string& name) {
  const auto wide = cast<Wide>(array);
  const Wide* const begin = wide.data();
  const Wide* const end = begin + wide.size();
  const Wide* const too_large = std::find_if(begin, end, [](Wide value) { return !std::in_range<int>(value); });
  if (too_large != end) refuse_entry(std::to_string(*too_large), too_large - begin, name);
  return cast<int>(wide);
}

bool has_shape(const py::array& array, Shape shape) {
  if (array.ndim() != static_cast<py::ssize_t>(shape.size())) return false;
  const py::ssize_t* given = array.shape();
  for (const Extent& extent : shape) {
    if (!extent.accepts(*given++)) return false;
  }
  return true;
}

}  // namespace

template <>
py::array numbers_from<double>(const py::object& object, const std::string& name) {
  const py::array array = as_array<double>(object, name, kReals);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') refuse_dtype(array, name, kReals);
  return cast<double>(array);
}

template <>
py::array numbers_from<int>(const py::object& object, const std::string& name) {
  const py::array array = as_array<int>(object, name, kIntegers);
  const char kind = array.dtype().kind();
  if (kind == 'b') refuse_dtype(array, name, "integers: indices, not a mask");
  if (kind == 'u') return narrowed<uint64_t>(array, name);
  if (kind == 'i') return array.itemsize() > 4 ? narrowed<int64_t>(array, name) : cast<int>(array);
  if (kind == 'f' && array.size() == 0) return cast<int>(array);  // numpy makes [] an array of floats
  refuse_dtype(array, name, kIntegers);
}

std::string shape_text(Shape shape) {
  std::string text;
  for (const Extent& extent : shape) {
    if (!text.empty()) text += ", ";
    text += extent.text();
  }
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

std::string shape_text(const py::array& array) { return cut(py::str(py::tuple(array.attr("shape")))); }

std::string shown(py::handle object) {
  const auto text = py::reinterpret_steal<py::object>(PyObject_Repr(object.ptr()));
  if (text) return cut(text);
  PyErr_Clear();  // as of an integer with too many digits
  return "a value of type " + type_name(object);
}

std::string class_name(py::handle type) { return cut(type.attr("__name__")); }

std::string type_name(py::handle object) { return class_name(py::type::handle_of(object)); }

void require_shape(const py::array& array, const std::string& name, Shape shape, const char* rows) {
  if (!has_shape(array, shape))
    throw py::value_error(name + " has shape " + shape_text(array) + ", expected " + shape_text(shape) + ": " + rows);
}

arap::Positions positions_from(const py::object& object, const std::string& name, const Extent& rows,
                               const char* rows_text) {
  const py::array array = require_array<double>(object, name, {rows, 3}, rows_text);
  arap::Positions positions(array.shape(0), 3);
  if (positions.size() > 0) std::memcpy(positions.data(), array.data(), static_cast<size_t>(array.nbytes()));
  return positions;
}

std::span<float> out_from(const py::object& object, py::ssize_t n_rows, const char* rows_text) {
  if (object.is_none()) return {};
  if (!py::isinstance<py::array>(object))
    throw py::type_error("out is of type " + type_name(object) + ", expected a numpy array of float32");
  require_unmasked(object, "out");
  auto array = py::reinterpret_borrow<py::array>(object);
  if (!array.dtype().equal(py::dtype::of<float>())) refuse_dtype(array, "out", "float32");
  require_shape(array, "out", {n_rows, 3}, rows_text);
  if ((array.flags() & py::array::c_style) == 0)
    throw py::value_error("out is not C-contiguous, expected rows one after the other: pass an array made by numpy");
  if (!array.writeable()) throw py::value_error("out is read-only, expected an array that can be written to");
  if ((array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0)
    throw py::value_error(
        "out is not aligned, expected numbers at multiples of their size: pass an array made by numpy");
  return {static_cast<float*>(array.mutable_data()), static_cast<size_t>(array.size())};
}

std::optional<std::span<const float>> singles_of(const py::object& object, py::ssize_t n_rows) {
  // Of numpy itself: subclasses may mean something else by their numbers.
  const bool is_array = Py_TYPE(object.ptr()) == py::detail::npy_api::get().PyArray_Type_;
  if (!is_array || !py::isinstance<py::array_t<float, py::array::c_style>>(object)) return std::nullopt;
  const auto array = py::reinterpret_borrow<py::array>(object);
  const bool is_aligned = (array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0;
  if (!is_aligned || array.ndim() != 2 || array.shape(0) != n_rows || array.shape(1) != 3) return std::nullopt;
  return std::span(static_cast<const float*>(array.data()), static_cast<size_t>(array.size()));
}

py::array to_array(arap::Positions values) {
  const py::ssize_t rows = values.rows();
  return array_keeping<double>(std::move(values), {rows, py::ssize_t{3}});
}

}  // namespace arap_native
