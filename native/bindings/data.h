// SPDX-License-Identifier: GPL-3.0-or-later
// Objects as data: ==, and what pickle and copy make them again by, a call of their class.
#pragma once

#include <pybind11/pybind11.h>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "arap/tet_mesh.h"
#include "arap/vertex_properties.h"
#include "signature.h"

namespace arap_native {

namespace py = pybind11;

/// The attributes that are named as the parameters.
py::dict attributes_of(const py::object& self, const Signature& signature);

/// Whether all values are equal, those of arrays, too.
bool are_equal(const py::dict& a, const py::dict& b);

/// What __reduce__() returns: how _rebuilt.py makes the object again.
/// @param state  of a model: constraints and positions
py::tuple rebuilt_by(const py::object& self, const py::dict& arguments, const py::tuple& state = py::tuple());

/// Adds ==, so that Python takes the hash away, as from all that changes, and what copies and pickles are made by.
/// @param attributes  attributes(object): a dict, by which the constructor makes it again
template <typename Class, typename Attributes>
void def_data(py::class_<Class>& type, const Attributes& attributes) {
  def(type, "__eq__(self, other)", [attributes](const Class& object, const py::object& other) -> py::object {
    if (!py::isinstance<Class>(other)) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
    return py::bool_(are_equal(attributes(object), attributes(converted<const Class&>(other, "other"))));
  });
  def(type, "__reduce__(self)", [attributes](const py::object& self) {
    return rebuilt_by(self, attributes(converted<const Class&>(self, "self")));
  });
}

/// What a constructor is given, by its names: inputs.h backwards.
py::dict arguments_of(const arap::PolygonMesh& mesh);
py::dict arguments_of(const arap::TetMesh& mesh);
void add_arguments(const arap::VertexProperties& properties, py::dict& arguments);
/// (rest_positions, faces, face_sizes)
py::tuple tuple_of(const arap::PolygonMesh& mesh);

/// The arguments of set_constraints(): (vertices, strengths, patches, segments).
py::tuple tuple_of(const arap::ConstraintSet& set);

}  // namespace arap_native
