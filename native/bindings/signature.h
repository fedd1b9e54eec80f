// SPDX-License-Identifier: GPL-3.0-or-later
// Functions of the module take their arguments through a signature of the stub: its names, its order, its defaults.
// pybind11 is never asked which overload fits, for it answers with all arguments printed. What does not fit is told in
// one sentence that names the argument.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.h"

namespace arap_native {

namespace py = pybind11;

/// The parameters of a function of Python.
class Signature {
 public:
  /// @param text   as "name(self, a, b=None, *, c=1)", up to the first ")"
  /// @param shown  the function's name in messages; empty: its own. That of a constructor is its class's
  explicit Signature(const std::string& text, std::string shown = {});

  [[nodiscard]] const std::string& function() const { return function_; }
  [[nodiscard]] const std::string& shown() const { return shown_; }
  [[nodiscard]] int size() const { return static_cast<int>(parameters_.size()); }
  [[nodiscard]] const std::string& name(int i) const { return parameters_[i].name; }

  /// The arguments of a call by parameter; no object where none is given. Throws a TypeError that names the argument
  /// that is missing, given twice, or not one of these.
  [[nodiscard]] std::vector<py::object> given(const py::args& args, const py::kwargs& kwargs) const;
  /// The same, with the defaults.
  [[nodiscard]] std::vector<py::object> bound(const py::args& args, const py::kwargs& kwargs) const;

 private:
  struct Parameter {
    std::string name;
    py::object default_value;  ///< none: it must be given
    bool is_by_keyword;
  };

  void require_positions(const py::args& args) const;
  [[nodiscard]] int find(py::handle keyword) const;
  [[nodiscard]] std::string names(bool is_by_keyword_only) const;

  std::string function_;
  std::string shown_;
  std::vector<Parameter> parameters_;
};

/// "name = value is of type ..., expected ...".
[[nodiscard]] py::type_error wrong_type(const std::string& name, py::handle given, const std::string& expected);

/// Throws a TypeError if a script has only called __new__ of the class of this instance: pybind11 would take memory for
/// it, without an object in it.
void require_made(py::handle instance);

/// A name in Python for a type of numbers, for messages.
template <typename Number>
constexpr const char* kNumberName = std::is_same_v<Number, bool> ? "bool"
                                    : std::is_integral_v<Number> ? "int"
                                                                 : "float";

/// A number, or what may stand for one: numpy's numbers, for a float also an int.
template <typename Number>
Number number_from(const py::object& given, const std::string& name) {
  constexpr bool kIsBool = std::is_same_v<Number, bool>;
  if (kIsBool || !PyBool_Check(given.ptr())) {
    py::detail::make_caster<Number> caster;
    if (caster.load(given, !kIsBool)) return py::detail::cast_op<Number>(caster);
  }
  if (!kIsBool && PyLong_Check(given.ptr()) && !PyBool_Check(given.ptr())) {
    using Limits = std::numeric_limits<Number>;
    throw py::value_error(py::str("{} = {} does not fit, must be from {} to {}")
                              .format(name, shown(given), Limits::lowest(), Limits::max()));
  }
  throw wrong_type(name, given, kNumberName<Number>);
}

/// An argument as C++ has it: an object; a number; a reference to an instance of a class, or a pointer, where None is
/// null.
template <typename T>
T converted(const py::object& given, const std::string& name) {
  using Plain = std::remove_cv_t<std::remove_pointer_t<std::remove_reference_t<T>>>;
  if constexpr (std::is_same_v<Plain, py::object>) {
    return given;  // NOLINT(bugprone-return-const-ref-from-parameter): what is bound outlives the call
  } else if constexpr (std::is_arithmetic_v<Plain>) {
    return number_from<Plain>(given, name);
  } else {
    if constexpr (std::is_pointer_v<T>)
      if (given.is_none()) return nullptr;
    if (!py::isinstance<Plain>(given)) {
      const std::string expected = class_name(py::type::of<Plain>());
      throw wrong_type(name, given, std::is_pointer_v<T> ? expected + " or None" : expected);
    }
    require_made(given);
    return given.cast<T>();
  }
}

/// A call of f(Given...) as Python makes it: f(args, kwargs).
template <typename Function, typename Result, typename... Given>
class Call {
 public:
  Call(Signature signature, Function f) : signature_(std::move(signature)), f_(std::move(f)) {
    if (signature_.size() != sizeof...(Given)) py::pybind11_fail(signature_.shown() + "(): the stub says otherwise");
  }

  Result operator()(const py::args& args, const py::kwargs& kwargs) const {
    return with(signature_.bound(args, kwargs), std::index_sequence_for<Given...>());
  }

 private:
  template <size_t... I>
  Result with(  // NOLINT(modernize-use-nodiscard): it may be void
      const std::vector<py::object>& bound, std::index_sequence<I...> /*of Given*/) const {
    // In a list, so that they are converted in order.
    std::tuple<Given...> arguments{converted<Given>(bound[I], signature_.name(static_cast<int>(I)))...};
    return std::apply(f_, std::move(arguments));
  }

  Signature signature_;
  Function f_;
};

/// The call of a function, or of what is like one.
template <typename Function>
auto call_of(Signature signature, Function f) {
  const auto with_types = [&]<typename Result, typename... Given>(Result (*)(Given...)) {
    return Call<Function, Result, Given...>(std::move(signature), std::move(f));
  };
  return with_types(static_cast<py::detail::function_signature_t<Function>*>(nullptr));
}

/// What follows the signature in a docstring of the stub; both, as Python takes them.
inline const char* doc_of(const char* text) { return std::string(text).find("\n--") == std::string::npos ? "" : text; }

/// Adds a function to the module.
/// @param text  its docstring, see docstrings.py, or its signature alone
template <typename Function>
void def(py::module_& m, const char* text, Function f) {
  Signature signature(text);
  const std::string name = signature.function();
  auto call = call_of(std::move(signature), std::move(f));
  m.def(
      name.c_str(), [call](const py::args& args, const py::kwargs& kwargs) { return call(args, kwargs); },
      doc_of(text));
}

/// Adds a method to a class.
template <typename Class, typename Function>
void def(Class& type, const char* text, Function f) {
  Signature signature(text);
  const std::string name = signature.function();
  auto call = call_of(std::move(signature), std::move(f));
  type.def(
      name.c_str(), [call](const py::args& args, const py::kwargs& kwargs) { return call(args, kwargs); },
      doc_of(text));
}

template <typename Class, typename Function>
void def_static(Class& type, const char* text, Function f) {
  Signature signature(text);
  const std::string name = signature.function();
  auto call = call_of(std::move(signature), std::move(f));
  type.def_static(
      name.c_str(), [call](const py::args& args, const py::kwargs& kwargs) { return call(args, kwargs); },
      doc_of(text));
}

/// Adds a constructor.
template <typename Class, typename Function>
void def_init(Class& type, const char* text, Function f) {
  auto call = call_of(Signature(text, class_name(type)), std::move(f));
  type.def(py::init([call](const py::args& args, const py::kwargs& kwargs) { return call(args, kwargs); }), text);
}

/// Adds an attribute that is read.
template <typename Class, typename Get>
void def_property(Class& type, const char* name, Get get, const char* doc) {
  using Self = const typename Class::type&;
  type.def_property_readonly(
      name, [get](const py::object& self) { return get(converted<Self>(self, "self")); }, doc);
}

/// Adds an attribute that is read and set.
template <typename Class, typename Get, typename Set>
void def_property(Class& type, const char* name, Get get, Set set, const char* doc) {
  using Self = typename Class::type&;
  type.def_property(
      name, [get](const py::object& self) { return get(converted<Self>(self, "self")); },
      [set](const py::object& self, const py::object& value) { set(converted<Self>(self, "self"), value); }, doc);
}

}  // namespace arap_native
