// SPDX-License-Identifier: GPL-3.0-or-later
// Options as Python classes: attributes that are validated, a constructor with keywords, and a repr that is a call of
// it.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "data.h"
#include "enum_names.h"
#include "signature.h"

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
  def_property(
      type, name, [field](const Options& options) { return options.*field; },
      [field, name](Options& options, const py::object& value) { assign(options, field, number_from<T>(value, name)); },
      doc);
}

/// Adds an enum as an attribute that is a string.
template <typename Options, typename Enum>
void def_enum(py::class_<Options>& type, const char* name, Enum Options::*field, Names<Enum> names, const char* doc) {
  def_property(
      type, name, [field, names](const Options& options) { return name_of(options.*field, names); },
      [field, name, names](Options& options, const py::object& value) {
        assign(options, field, value_of(value, name, names));
      },
      doc);
}

/// Adds the constructor, with every attribute as a keyword, the repr, which is a call of it, and what makes options
/// data.
template <typename Options>
void def_construction(py::class_<Options>& type, const char* init_doc) {
  const Signature signature(init_doc, class_name(type));
  type.def(py::init([signature](const py::args& args, const py::kwargs& kwargs) {
             const auto given = signature.given(args, kwargs);
             const py::object options = py::cast(Options{});
             for (int i = 0; i < signature.size(); ++i)
               if (given[i]) py::setattr(options, signature.name(i).c_str(), given[i]);
             return options.cast<Options>();
           }),
           init_doc);
  const auto attributes = [signature](const Options& options) {
    return attributes_of(py::cast(&options, py::return_value_policy::reference), signature);
  };
  def(type, "__repr__(self)", [attributes](const Options& options) {
    std::string text;
    for (const auto& [name, value] : attributes(options))
      text += (text.empty() ? "" : ", ") + std::string(py::str(name)) + "=" + std::string(py::repr(value));
    return class_name(py::type::of<Options>()) + "(" + text + ")";
  });
  def_data<Options>(type, attributes);
}

}  // namespace arap_native
