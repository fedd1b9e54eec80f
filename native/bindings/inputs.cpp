// SPDX-License-Identifier: GPL-3.0-or-later
#include "inputs.h"

#include <memory>
#include <utility>

#include "arap/error.h"

namespace arap_native {

namespace {

arap::Patches patches_from(const py::object& object) {
  if (object.is_none()) return {};
  if (!py::isinstance<py::tuple>(object) || py::len(object) != 3)
    throw py::type_error("patches is not a tuple of three arrays, expected (offsets, vertices, weights)");
  const auto fields = py::reinterpret_borrow<py::tuple>(object);
  arap::Patches patches;
  patches.offsets =
      vector_from<int>(fields[0], "patch offsets", "n_patches + 1", "where each patch begins, and the end");
  patches.vertices = vector_from<int>(fields[1], "patch vertices", "e", "one entry per vertex of a patch");
  patches.weights = vector_from<double>(fields[2], "patch weights", static_cast<py::ssize_t>(patches.vertices.size()),
                                        "one entry per vertex of a patch");
  return patches;
}

/// Adds faces that are lists of their own, of any lengths.
void add_faces(MeshArrays& mesh, const py::object& faces) {
  const std::string name = mesh.prefix + "faces";
  py::list corner_vertices;
  for (const py::handle face : faces) {
    if (!py::isinstance<py::sequence>(face))
      throw py::type_error(py::str("{}[{}] is of type {}, expected a list of vertices: flat faces need face_sizes")
                               .format(name, mesh.face_sizes.size(), type_name(face)));
    auto numbers = py::reinterpret_borrow<py::object>(face);
    // By its own dtype: numpy makes floats of uint64 beside int.
    if (py::isinstance<py::array>(face)) numbers = numbers_from<int>(numbers, name).attr("tolist")();
    corner_vertices.attr("extend")(numbers);
    mesh.face_sizes.push_back(static_cast<int>(py::len(face)));
  }
  mesh.corner_vertices = vector_from<int>(corner_vertices, name, "c", "one number per vertex of a face");
}

}  // namespace

MeshArrays mesh_from(const py::object& rest_positions, const py::object& faces, const py::object& face_sizes) {
  return prefixed_mesh_from({}, rest_positions, faces, face_sizes);
}

MeshArrays prefixed_mesh_from(const std::string& prefix, const py::object& rest_positions, const py::object& faces,
                              const py::object& face_sizes) {
  const std::string name = prefix + "faces";
  MeshArrays mesh{prefix, positions_from(rest_positions, prefix + "rest_positions", "n", "one row per vertex"), {}, {}};
  if (!face_sizes.is_none()) {
    mesh.corner_vertices =
        vector_from<int>(faces, name, "c", "one face after the other, as face_sizes says how long each is");
    mesh.face_sizes = vector_from<int>(face_sizes, prefix + "face_sizes", "f", "one entry per face");
  } else if (py::isinstance<py::list>(faces) || py::isinstance<py::tuple>(faces)) {
    add_faces(mesh, faces);
  } else {
    const py::array array = require_array<int>(faces, name, {"m", "k"}, "one row per face; flat faces need face_sizes");
    const py::ssize_t n_corners = array.shape(1);
    if (n_corners < 3)
      throw py::value_error(name + " has shape " + shape_text(array) + ", expected three or more vertices in a row");
    mesh.corner_vertices = to_vector<int>(array);
    mesh.face_sizes.assign(static_cast<size_t>(array.shape(0)), static_cast<int>(n_corners));
  }
  return mesh;
}

MeshArrays mesh_from_tuple(const py::object& object, const std::string& name) {
  const bool is_sequence = py::isinstance<py::tuple>(object) || py::isinstance<py::list>(object);
  if (!is_sequence || py::len(object) < 2 || py::len(object) > 3)
    throw py::type_error(name + " is not a tuple of arrays, expected (rest_positions, faces)");
  const py::tuple fields(object);
  return prefixed_mesh_from(name + ": ", fields[0], fields[1], fields.size() == 3 ? py::object(fields[2]) : py::none());
}

CagedArrays caged_from(const py::object& rest_positions, const py::object& faces, const py::object& face_sizes,
                       const py::object& cage) {
  return {mesh_from(rest_positions, faces, face_sizes), mesh_from_tuple(cage, "cage")};
}

arap::PolygonMesh mesh_of(MeshArrays arrays) {
  try {
    return {std::move(arrays.positions), std::move(arrays.corner_vertices), std::move(arrays.face_sizes)};
  } catch (const arap::InvalidInput& error) {
    throw arap::InvalidInput(arrays.prefix + error.what());
  }
}

TetArrays tets_from(const py::object& rest_positions, const py::object& tets) {
  TetArrays mesh{positions_from(rest_positions, "rest_positions", "n", "one row per vertex"), {}};
  const std::vector<int> vertices =
      to_vector<int>(require_array<int>(tets, "tets", {"m", 4}, "one row per tetrahedron"));
  mesh.tets.resize(vertices.size() / 4);
  for (size_t k = 0; k < vertices.size(); ++k) mesh.tets[k / 4][k % 4] = vertices[k];
  return mesh;
}

arap::TetMesh mesh_of(TetArrays arrays) { return {std::move(arrays.positions), std::move(arrays.tets)}; }

arap::VertexProperties properties_from(const py::object& stiffness, const py::object& rigid_regions, const Extent& n) {
  arap::VertexProperties properties;
  if (!stiffness.is_none())
    properties.stiffness = vector_from<double>(stiffness, "stiffness", n, "one entry per vertex");
  if (!rigid_regions.is_none())
    properties.rigid_regions = vector_from<int>(rigid_regions, "rigid_regions", n, "one entry per vertex");
  return properties;
}

std::vector<arap::Segment> segments_from(const py::object& object) {
  if (object.is_none()) return {};
  const std::vector<double> values =
      to_vector<double>(require_array<double>(object, "segments", {"s", 2, 3}, "head and tail of each segment"));
  std::vector<arap::Segment> segments(values.size() / 6);
  for (size_t s = 0; s < segments.size(); ++s)
    segments[s] = {arap::Vector3::Map(&values[6 * s]), arap::Vector3::Map(&values[6 * s + 3])};
  return segments;
}

arap::ConstraintSet constraints_from(const py::object& vertices, const py::object& strengths, const py::object& patches,
                                     const py::object& segments) {
  arap::ConstraintSet set;
  set.vertices = vector_from<int>(vertices, "vertices", "k", "one entry per constrained vertex");
  if (!strengths.is_none())
    set.strengths = vector_from<double>(strengths, "strengths", static_cast<py::ssize_t>(set.vertices.size()),
                                        "one entry per constrained vertex");
  set.patches = patches_from(patches);
  set.segments = segments_from(segments);
  return set;
}

std::vector<arap::Matrix3> rotations_from(const py::object& object, const Extent& rows) {
  if (object.is_none()) return {};
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const std::vector<double> values =
      to_vector<double>(require_array<double>(object, "rotations", {rows, 3, 3}, "one matrix per row of targets"));
  std::vector<arap::Matrix3> rotations(values.size() / 9);
  for (size_t r = 0; r < rotations.size(); ++r) rotations[r] = Eigen::Map<const RowMajor>(&values[9 * r]);
  return rotations;
}

}  // namespace arap_native
