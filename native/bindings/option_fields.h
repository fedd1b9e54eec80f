// SPDX-License-Identifier: GPL-3.0-or-later
// Options as Python classes: attributes that are validated, a constructor with keywords, and a repr that is a call of
// it.
#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "enum_names.h"

namespace arap_native {

/// Assigns one field; the options stay as they are where the new value is not allowed.
template <typename Options, typename T>
void assign(Options& options, T Options::*field, T value) {
  Options changed = options;
  changed.*field = value;
  changed.validate();
  options = changed;
}

/// Adds a field as an attribute that is validated when it is set.
template <typename Options, typename T>
void def_field(py::class_<Options>& type, const char* name, T Options::*field, const char* doc) {
  type.def_property(
      name, [field](const Options& options) { return options.*field; },
      [field](Options& options, T value) { assign(options, field, value); }, doc);
}

/// Adds an enum as an attribute that is a string.
template <typename Options, typename Enum>
void def_enum(py::class_<Options>& type, const char* name, Enum Options::*field, Names<Enum> names, const char* doc) {
  type.def_property(
      name, [field, names](const Options& options) { return name_of(options.*field, names); },
      [field, name, names](Options& options, const std::string& value) {
        assign(options, field, value_of(value, name, names));
      },
      doc);
}

/// Sets an option. Throws a TypeError that names it if the value is of another type than the default.
inline void set_option(const py::object& options, const std::string& name, const py::handle& value) {
  const std::string expected = type_name(options.attr(name.c_str()));
  try {
    py::setattr(options, name.c_str(), value);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
    throw py::type_error(
        py::str("{} = {!r} is of type {}, expected {}").format(name, value, type_name(value), expected));
  }
}

/// Adds the constructor, with every attribute as a keyword, and the repr, which is a call of it.
template <typename Options>
void def_construction(py::class_<Options>& type, const char* init_doc, std::vector<const char*> attributes) {
  const std::string name = py::str(type.attr("__name__"));
  type.def(py::init([name, attributes](const py::kwargs& values) {
             const py::object options = py::cast(Options{});
             for (const auto& [key, value] : values) {
               const std::string attribute = py::str(key);
               if (std::find(attributes.begin(), attributes.end(), attribute) == attributes.end())
                 throw py::type_error(py::str("{}() got an unexpected keyword argument {!r}").format(name, key));
               set_option(options, attribute, value);
             }
             return options.cast<Options>();
           }),
           init_doc);
  type.def("__repr__", [name, attributes = std::move(attributes)](py::handle self) {
    std::string text;
    for (const char* attribute : attributes)
      text += (text.empty() ? "" : ", ") + std::string(attribute) + "=" + std::string(py::repr(self.attr(attribute)));
    return name + "(" + text + ")";
  });
}

}  // namespace arap_native
