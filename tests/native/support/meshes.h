// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap_test {

using arap::Matrix3;
using arap::Positions;
using arap::Vector3;

/// A mesh before the library validates it: it may be as broken as a test needs.
struct MeshData {
  std::string name;
  std::vector<Vector3> vertices;
  std::vector<std::vector<int>> faces;

  [[nodiscard]] int n_vertices() const { return static_cast<int>(vertices.size()); }
  [[nodiscard]] int n_faces() const { return static_cast<int>(faces.size()); }
  [[nodiscard]] Positions positions() const;
  [[nodiscard]] arap::PolygonMesh mesh() const;
  [[nodiscard]] double diagonal() const;

  /// Index of the new vertex.
  int add_vertex(const Vector3& position);
  /// The vertex of the mesh at `position` (to 1e-9), or a new one.
  int vertex_at(const Vector3& position);
};

enum class Faces { kTriangles, kQuads };

// Small named meshes. Closed ones are oriented outwards.

/// Regular, edge length 2 sqrt 2, centred.
MeshData tetrahedron();
/// Unit cube of six quads, centred.
MeshData cube();
/// Surface of a box of nx * ny * nz cells, centred; `size` along each axis. Mirror symmetric if `faces` are quads.
MeshData box(std::array<int, 3> cells, const Vector3& size, Faces faces);
/// box of 4 n * n * n square cells, long in x.
MeshData bar(int n, Faces faces);
/// Unit square in z = height(x, y), centred, n * n cells. No height: flat.
MeshData grid(int n, Faces faces, const std::function<double(double, double)>& height = {});
/// A polygon in the plane, extruded along z by `height` in `n_layers` rings of quads, closed by two n-gons.
MeshData prism(const std::vector<std::array<double, 2>>& polygon, double height, int n_layers);
/// prism of a regular polygon, radius .5, height 2.
MeshData cylinder(int n_around, int n_along);
/// The same without the caps.
MeshData open_cylinder(int n_around, int n_along, Faces faces);
/// open_cylinder cut along one line: the vertices of the seam exist twice. Their copies come last, from bottom to top.
MeshData cylinder_with_open_seam(int n_around, int n_along, Faces faces);
/// prism of an L, whose caps are concave hexagons.
MeshData l_prism(int n_layers);
/// prism of a star with `n_tips`, whose caps are concave 2 n-gons.
MeshData star_prism(int n_tips, int n_layers);
/// Unit sphere from an icosahedron whose triangles are cut in four `levels` times.
MeshData icosphere(int levels);
/// icosphere with a smooth, asymmetric relief.
MeshData bumpy_sphere(int levels);
/// Sphere of 6 n * n quads with a relief that is mirror symmetric in x.
MeshData quad_sphere(int n);
/// Quads around a strip with half a twist: not orientable.
MeshData moebius_strip(int n_around, int n_across);
/// Two bumpy spheres that do not touch; the second one has the higher vertices.
MeshData two_spheres(int levels);
/// Two fingers of a hand, .5 x .5 x 2, with a gap in between, as one part. The first has x < 0.
MeshData hand(double gap);
/// Two tetrahedra that share one vertex: not a manifold there.
MeshData bow_tie();
/// Three bumpy sheets that meet in one row of edges, as the pages of a book.
MeshData book(int n, Faces faces);
/// An open cylinder whose triangles are sheared until most of them are obtuse.
MeshData sheared_cylinder(int n_around, int n_along);
/// Sheet of one n-gon row and quads: 8-gons with vertices in the middle of straight sides.
MeshData sheet_with_collinear_corners();

/// Meshes of every kind without degenerate triangles, in every fan from every corner.
std::vector<MeshData> all_small_meshes();

/// Cuts every triangle in four at the middles of its edges; triangles only.
MeshData subdivide(const MeshData& triangles);
/// Replaces every polygon by the fan from its first corner.
MeshData triangulate(const MeshData& mesh);
/// Both as one mesh; vertices of `second` come last.
MeshData join(const MeshData& first, const MeshData& second);
/// Applies `map` to every vertex.
MeshData transformed(const MeshData& mesh, const std::function<Vector3(const Vector3&)>& map);
/// Scaled to a diagonal of 1.
MeshData in_unit_size(const MeshData& mesh);

struct RigidMotion {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 translation = Vector3::Zero();

  [[nodiscard]] Positions apply(const Positions& points) const;
  [[nodiscard]] Vector3 apply(const Vector3& point) const { return rotation * point + translation; }
};

/// The rotation R with the greatest <R, S>, by SVD: [SA07] Eq. (6) transposed.
Matrix3 best_rotation(const Matrix3& S);

/// The rotation and translation that bring `from` closest to `to`.
RigidMotion best_rigid_motion(const Positions& from, const Positions& to);

/// Random numbers that are the same with every compiler.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);
  Vector3 vector(double size);  ///< each component in [-size, size]
  RigidMotion rigid_motion(double angle_rad, double translation);
  Positions noise(int n, double size);

 private:
  std::uint64_t state_;
};

Matrix3 rotation_about(const Vector3& axis, double angle_rad);

/// Reads an OFF file; throws std::runtime_error that names the file.
MeshData load_off(const std::string& path);
/// Directory of real meshes, from ARAP_TEST_MESHES; empty if that is not set.
std::optional<std::string> real_mesh_directory();

}  // namespace arap_test
