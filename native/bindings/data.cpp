// SPDX-License-Identifier: GPL-3.0-or-later
#include "data.h"

#include <pybind11/numpy.h>

#include <vector>

#include "arrays.h"

namespace arap_native {

py::dict attributes_of(const py::object& self, const Signature& signature) {
  py::dict attributes;
  for (int i = 0; i < signature.size(); ++i) {
    const py::str name(signature.name(i));
    attributes[name] = self.attr(name);
  }
  return attributes;
}

bool are_equal(const py::dict& a, const py::dict& b) {
  for (const auto& [name, value] : a) {
    const py::object other = b[name];
    const bool is_same = py::isinstance<py::array>(value)
                             ? py::module_::import("numpy").attr("array_equal")(value, other).cast<bool>()
                             : value.equal(other);
    if (!is_same) return false;
  }
  return true;
}

py::tuple rebuilt_by(const py::object& self, const py::dict& arguments, const py::tuple& state) {
  const py::tuple call = py::make_tuple(py::type::of(self), arguments);
  return py::make_tuple(py::module_::import("arap_native._rebuilt").attr("rebuilt"), call + state);
}

py::tuple tuple_of(const arap::PolygonMesh& mesh) {
  std::vector<int> corners;
  std::vector<int> sizes;
  corners.reserve(mesh.n_corners());
  sizes.reserve(mesh.n_faces());
  for (int f = 0; f < mesh.n_faces(); ++f) {
    corners.insert(corners.end(), mesh.face(f).begin(), mesh.face(f).end());
    sizes.push_back(static_cast<int>(mesh.face(f).size()));
  }
  return py::make_tuple(to_array(mesh.positions()), to_array(std::move(corners)), to_array(std::move(sizes)));
}

py::dict arguments_of(const arap::PolygonMesh& mesh) {
  const py::tuple arrays = tuple_of(mesh);
  py::dict arguments;
  arguments["rest_positions"] = arrays[0];
  arguments["faces"] = arrays[1];
  arguments["face_sizes"] = arrays[2];
  return arguments;
}

py::dict arguments_of(const arap::TetMesh& mesh) {
  py::dict arguments;
  arguments["rest_positions"] = to_array(mesh.positions());
  arguments["tets"] = to_array(mesh.tets());
  return arguments;
}

void add_arguments(const arap::VertexProperties& properties, py::dict& arguments) {
  if (!properties.stiffness.empty()) arguments["stiffness"] = to_array(properties.stiffness);
  if (!properties.rigid_regions.empty()) arguments["rigid_regions"] = to_array(properties.rigid_regions);
}

py::tuple tuple_of(const arap::ConstraintSet& set) {
  py::object strengths = py::none();
  py::object patches = py::none();
  py::object segments = py::none();
  if (!set.strengths.empty()) strengths = to_array(set.strengths);
  if (!set.patches.offsets.empty())
    patches =
        py::make_tuple(to_array(set.patches.offsets), to_array(set.patches.vertices), to_array(set.patches.weights));
  if (!set.segments.empty()) {
    std::vector<double> ends;
    for (const arap::Segment& segment : set.segments)
      for (const arap::Vector3& end : {segment.head, segment.tail}) ends.insert(ends.end(), end.begin(), end.end());
    segments = to_array(std::move(ends)).attr("reshape")(set.segments.size(), 2, 3);
  }
  return py::make_tuple(to_array(set.vertices), strengths, patches, segments);
}

}  // namespace arap_native
