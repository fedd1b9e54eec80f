// SPDX-License-Identifier: GPL-3.0-or-later
#include "signature.h"

#include <pybind11/eval.h>

#include <algorithm>
#include <string_view>

namespace arap_native {

namespace {

constexpr const char* kConstructor = "__init__";

/// What is between the first two of these marks.
std::string between(const std::string& text, char begin, char end) {
  const size_t first = text.find(begin) + 1;
  return text.substr(first, text.find(end, first) - first);
}

std::vector<std::string> split(const std::string& text) {
  constexpr std::string_view kComma = ", ";
  std::vector<std::string> parts;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(kComma, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + kComma.size();
  }
  return parts;
}

bool is_options(py::handle object) { return type_name(object).ends_with("Options"); }

}  // namespace

Signature::Signature(const std::string& text, std::string shown)
    : function_(text.substr(0, text.find('('))), shown_(shown.empty() ? function_ : std::move(shown)) {
  bool is_by_keyword = false;
  for (const std::string& part : split(between(text, '(', ')'))) {
    if (part == "*") {
      is_by_keyword = true;
    } else if (part != "/" && !(function_ == kConstructor && part == "self")) {
      const size_t equals = std::min(part.find('='), part.size());
      const py::object default_value = equals < part.size() ? py::eval(part.substr(equals + 1)) : py::object();
      parameters_.push_back({part.substr(0, equals), default_value, is_by_keyword});
    }
  }
}

std::vector<py::object> Signature::given(const py::args& args, const py::kwargs& kwargs) const {
  require_positions(args);
  std::vector<py::object> given(parameters_.size());
  for (size_t i = 0; i < args.size(); ++i) given[i] = args[i];
  for (const auto& [keyword, value] : kwargs) {
    py::object& argument = given[find(keyword)];
    if (argument)
      throw py::type_error(shown_ + "() got the argument " + arap_native::shown(keyword) +
                           " twice, by its position and by its name");
    argument = py::reinterpret_borrow<py::object>(value);
  }
  for (int i = 0; i < size(); ++i)
    if (!given[i] && !parameters_[i].default_value)
      throw py::type_error(shown_ + "() is missing the argument '" + name(i) + "'");
  return given;
}

std::vector<py::object> Signature::bound(const py::args& args, const py::kwargs& kwargs) const {
  std::vector<py::object> arguments = given(args, kwargs);
  for (int i = 0; i < size(); ++i)
    if (!arguments[i]) arguments[i] = parameters_[i].default_value;
  return arguments;
}

void Signature::require_positions(const py::args& args) const {
  const auto begin_of_names = std::ranges::find_if(parameters_, &Parameter::is_by_keyword);
  const auto most = static_cast<size_t>(begin_of_names - parameters_.begin());
  const bool has_self = most > 0 && parameters_.front().name == "self";
  const bool has_options =
      std::ranges::find(begin_of_names, parameters_.end(), "options", &Parameter::name) != parameters_.end();
  for (size_t i = 0; has_options && i < std::min(args.size(), most); ++i)
    if (is_options(args[i]) && !(has_self && i == 0))
      throw py::type_error(name(static_cast<int>(i)) + " is of type " + type_name(args[i]) +
                           ": options are given by name, " + shown_ + "(..., options=...)");
  if (args.size() <= most) return;
  const std::string by_name = names(true);
  throw py::type_error(shown_ + "() takes " + std::to_string(most - (has_self ? 1 : 0)) + " arguments by position, " +
                       std::to_string(args.size() - (has_self ? 1 : 0)) + " are given" +
                       (by_name.empty() ? "" : "; by name it takes " + by_name));
}

int Signature::find(py::handle keyword) const {
  for (int i = 0; i < size(); ++i)
    if (PyUnicode_CompareWithASCIIString(keyword.ptr(), name(i).c_str()) == 0) return i;
  const std::string taken = names(false);
  throw py::type_error(shown_ + "() got an unexpected keyword argument " + arap_native::shown(keyword) +
                       (taken.empty() ? "" : "; it takes " + taken));
}

std::string Signature::names(bool is_by_keyword_only) const {
  std::string text;
  for (const Parameter& parameter : parameters_)
    if ((parameter.is_by_keyword || !is_by_keyword_only) && parameter.name != "self")
      text += (text.empty() ? "" : ", ") + parameter.name;
  return text;
}

void require_made(py::handle instance) {
  py::detail::values_and_holders values(reinterpret_cast<py::detail::instance*>(instance.ptr()));
  if ((*values.begin()).value_ptr() == nullptr)
    throw py::type_error("this " + type_name(instance) + " is empty, because only __new__ was called");
}

py::type_error wrong_type(const std::string& name, py::handle given, const std::string& expected) {
  // What an array or a mesh is says its type; of other things the value helps.
  const bool is_plain = given.is_none() || PyLong_Check(given.ptr()) || PyFloat_Check(given.ptr()) ||
                        PyUnicode_Check(given.ptr()) || PyBytes_Check(given.ptr());
  py::type_error error(name + (is_plain ? " = " + shown(given) : "") + " is of type " + type_name(given) +
                       ", expected " + expected);
  return error;
}

}  // namespace arap_native
