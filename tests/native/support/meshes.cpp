// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace arap_test {

namespace {

constexpr double kPi = std::numbers::pi;

void add_quad(MeshData& mesh, const std::array<int, 4>& q, Faces kind) {
  if (kind == Faces::kQuads) {
    mesh.faces.push_back({q[0], q[1], q[2], q[3]});
    return;
  }
  mesh.faces.push_back({q[0], q[1], q[2]});
  mesh.faces.push_back({q[0], q[2], q[3]});
}

Vector3 relief(const Vector3& direction) {
  const double bump = .15 * std::sin(3 * direction.x() + 1) * std::cos(4 * direction.y()) + .1 * direction.z();
  return direction * (1 + bump);
}

}  // namespace

Positions MeshData::positions() const {
  Positions result(n_vertices(), 3);
  for (int v = 0; v < n_vertices(); ++v) result.row(v) = vertices[v].transpose();
  return result;
}

arap::PolygonMesh MeshData::mesh() const {
  std::vector<int> corner_vertices;
  std::vector<int> face_sizes;
  for (const auto& face : faces) {
    corner_vertices.insert(corner_vertices.end(), face.begin(), face.end());
    face_sizes.push_back(static_cast<int>(face.size()));
  }
  return {positions(), std::move(corner_vertices), std::move(face_sizes)};
}

double MeshData::diagonal() const {
  const Positions p = positions();
  return (p.colwise().maxCoeff() - p.colwise().minCoeff()).norm();
}

int MeshData::add_vertex(const Vector3& position) {
  vertices.push_back(position);
  return n_vertices() - 1;
}

int MeshData::vertex_at(const Vector3& position) {
  for (int v = 0; v < n_vertices(); ++v)
    if ((vertices[v] - position).norm() < 1e-9) return v;
  return add_vertex(position);
}

MeshData tetrahedron() {
  return {
      "tetrahedron", {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
}

MeshData cube() {
  MeshData mesh = box({1, 1, 1}, {1, 1, 1}, Faces::kQuads);
  mesh.name = "cube";
  return mesh;
}

MeshData box(std::array<int, 3> cells, const Vector3& size, Faces faces) {
  MeshData mesh{"box", {}, {}};
  std::map<std::tuple<int, int, int>, int> index;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, is_new] = index.try_emplace({at[0], at[1], at[2]}, mesh.n_vertices());
    if (is_new) {
      Vector3 position;
      for (int axis = 0; axis < 3; ++axis) position[axis] = size[axis] * (double(at[axis]) / cells[axis] - .5);
      mesh.add_vertex(position);
    }
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const int side : {0, 1}) {
      for (int i = 0; i < cells[u]; ++i) {
        for (int j = 0; j < cells[v]; ++j) {
          std::array<std::array<int, 2>, 4> corners{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
          if (side == 0) std::swap(corners[1], corners[3]);
          std::array<int, 4> quad{};
          for (int c = 0; c < 4; ++c) {
            std::array<int, 3> at{};
            at[axis] = side * cells[axis];
            at[u] = corners[c][0];
            at[v] = corners[c][1];
            quad[c] = vertex(at);
          }
          add_quad(mesh, quad, faces);
        }
      }
    }
  }
  return mesh;
}

MeshData bar(int n, Faces faces) {
  MeshData mesh = box({4 * n, n, n}, {4, 1, 1}, faces);
  mesh.name = faces == Faces::kQuads ? "quad_bar" : "triangle_bar";
  return mesh;
}

MeshData grid(int n, Faces faces, const std::function<double(double, double)>& height) {
  MeshData mesh{faces == Faces::kQuads ? "quad_grid" : "triangle_grid", {}, {}};
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = double(i) / n - .5;
      const double y = double(j) / n - .5;
      mesh.add_vertex({x, y, height ? height(x, y) : 0});
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int v = j * (n + 1) + i;
      add_quad(mesh, {v, v + 1, v + n + 2, v + n + 1}, faces);
    }
  }
  return mesh;
}

MeshData prism(const std::vector<std::array<double, 2>>& polygon, double height, int n_layers) {
  const int n = static_cast<int>(polygon.size());
  MeshData mesh{"prism", {}, {}};
  for (int layer = 0; layer <= n_layers; ++layer)
    for (const auto& [x, y] : polygon) mesh.add_vertex({x, y, height * (double(layer) / n_layers - .5)});
  for (int layer = 0; layer < n_layers; ++layer) {
    for (int i = 0; i < n; ++i) {
      const int v = layer * n + i;
      const int next = layer * n + (i + 1) % n;
      mesh.faces.push_back({v, next, next + n, v + n});
    }
  }
  std::vector<int> bottom(n);
  std::vector<int> top(n);
  for (int i = 0; i < n; ++i) {
    bottom[i] = n - 1 - i;
    top[i] = n_layers * n + i;
  }
  mesh.faces.push_back(bottom);
  mesh.faces.push_back(top);
  return mesh;
}

MeshData cylinder(int n_around, int n_along) {
  std::vector<std::array<double, 2>> circle;
  for (int i = 0; i < n_around; ++i)
    circle.push_back({.5 * std::cos(2 * kPi * i / n_around), .5 * std::sin(2 * kPi * i / n_around)});
  MeshData mesh = prism(circle, 2, n_along);
  mesh.name = "cylinder";
  return mesh;
}

MeshData open_cylinder(int n_around, int n_along, Faces faces) {
  MeshData mesh = cylinder(n_around, n_along);
  mesh.name = "open_cylinder";
  mesh.faces.resize(mesh.faces.size() - 2);
  return faces == Faces::kQuads ? mesh : triangulate(mesh);
}

MeshData cylinder_with_open_seam(int n_around, int n_along, Faces faces) {
  MeshData mesh = open_cylinder(n_around, n_along, Faces::kQuads);
  mesh.name = "cylinder_with_open_seam";
  for (int layer = 0; layer <= n_along; ++layer) mesh.add_vertex(mesh.vertices[layer * n_around]);
  const int first_twin = n_around * (n_along + 1);
  for (auto& face : mesh.faces) {
    const bool is_last = std::any_of(face.begin(), face.end(), [&](int v) { return v % n_around == n_around - 1; });
    if (!is_last) continue;
    for (int& v : face)
      if (v % n_around == 0) v = first_twin + v / n_around;
  }
  return faces == Faces::kQuads ? mesh : triangulate(mesh);
}

MeshData l_prism(int n_layers) {
  MeshData mesh = prism({{-.5, -.5}, {.5, -.5}, {.5, 0}, {0, 0}, {0, .5}, {-.5, .5}}, 2, n_layers);
  mesh.name = "l_prism";
  return mesh;
}

MeshData star_prism(int n_tips, int n_layers) {
  std::vector<std::array<double, 2>> star;
  for (int i = 0; i < 2 * n_tips; ++i) {
    const double radius = i % 2 == 0 ? .6 : .33;
    star.push_back({radius * std::cos(kPi * i / n_tips), radius * std::sin(kPi * i / n_tips)});
  }
  MeshData mesh = prism(star, 2, n_layers);
  mesh.name = "star_prism";
  return mesh;
}

MeshData icosphere(int levels) {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  MeshData mesh{"icosphere", {}, {}};
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-golden, golden}) {
      mesh.add_vertex({0, a, b});
      mesh.add_vertex({a, b, 0});
      mesh.add_vertex({b, 0, a});
    }
  }
  // The icosahedron's faces are the triples of vertices two apart from each other.
  const auto are_neighbours = [&](int a, int b) { return (mesh.vertices[a] - mesh.vertices[b]).norm() < 2.1; };
  for (int a = 0; a < 12; ++a) {
    for (int b = a + 1; b < 12; ++b) {
      for (int c = b + 1; c < 12; ++c) {
        if (!are_neighbours(a, b) || !are_neighbours(b, c) || !are_neighbours(c, a)) continue;
        Matrix3 corners;
        corners << mesh.vertices[a], mesh.vertices[b], mesh.vertices[c];
        if (corners.determinant() > 0)
          mesh.faces.push_back({a, b, c});
        else
          mesh.faces.push_back({a, c, b});
      }
    }
  }
  for (int level = 0; level < levels; ++level) {
    mesh = subdivide(mesh);
    for (Vector3& vertex : mesh.vertices) vertex.normalize();
  }
  for (Vector3& vertex : mesh.vertices) vertex.normalize();
  mesh.name = "icosphere";
  return mesh;
}

MeshData bumpy_sphere(int levels) {
  MeshData mesh = transformed(icosphere(levels), relief);
  mesh.name = "bumpy_sphere";
  return mesh;
}

MeshData quad_sphere(int n) {
  MeshData mesh = transformed(box({n, n, n}, {1, 1, 1}, Faces::kQuads), [](const Vector3& p) {
    const Vector3 d = p.normalized();
    return Vector3(d * (1 + .2 * std::abs(d.x()) + .1 * std::sin(3 * d.y()) + .1 * d.z()));
  });
  mesh.name = "quad_sphere";
  return mesh;
}

MeshData moebius_strip(int n_around, int n_across) {
  MeshData mesh{"moebius_strip", {}, {}};
  for (int i = 0; i < n_around; ++i) {
    const double angle = 2 * kPi * i / n_around;
    for (int j = 0; j <= n_across; ++j) {
      const double s = .8 * (double(j) / n_across - .5);
      const double radius = 1 + s * std::cos(angle / 2);
      mesh.add_vertex({radius * std::cos(angle), radius * std::sin(angle), s * std::sin(angle / 2)});
    }
  }
  const auto vertex = [&](int i, int j) { return i < n_around ? i * (n_across + 1) + j : n_across - j; };
  for (int i = 0; i < n_around; ++i)
    for (int j = 0; j < n_across; ++j)
      mesh.faces.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
  return mesh;
}

MeshData two_spheres(int levels) {
  const MeshData sphere = bumpy_sphere(levels);
  MeshData mesh = join(sphere, transformed(sphere, [](const Vector3& p) { return Vector3(p + Vector3(3, .5, 0)); }));
  mesh.name = "two_spheres";
  return mesh;
}

MeshData hand(double gap) {
  MeshData fingers = box({5, 5, 20}, {.5, .5, 2}, Faces::kQuads);
  const MeshData first =
      transformed(fingers, [&](const Vector3& x) { return Vector3(x - Vector3(.25 + gap / 2, 0, 0)); });
  const MeshData second =
      transformed(fingers, [&](const Vector3& x) { return Vector3(x + Vector3(.25 + gap / 2, 0, 0)); });
  MeshData mesh = join(first, second);
  // A palm: a strip between their lower ends, which makes them one part.
  const auto corner = [&](double x, double y) { return mesh.vertex_at(Vector3(x, y, -1)); };
  mesh.faces.push_back({corner(-gap / 2, -.25), corner(gap / 2, -.25), corner(gap / 2, .25), corner(-gap / 2, .25)});
  return mesh;
}

MeshData bow_tie() {
  return {"bow_tie",
          {{0, 0, 0}, {1, .1, 0}, {1.2, 1, 0}, {.9, .4, 1}, {-1, 0, .1}, {-1.1, -1, 0}, {-.8, -.5, -1}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 4, 5}, {0, 5, 6}, {0, 6, 4}, {4, 6, 5}}};
}

MeshData book(int n, Faces faces) {
  MeshData mesh{"book", {}, {}};
  for (int page = 0; page < 3; ++page) {
    const double angle = 2 * kPi * page / 3 + .2;
    const auto vertex = [&](int i, int j) {
      const double across = double(i) / n;
      const double along = 2.0 * j / n;
      const double lift = .1 * std::sin(3 * along + page) * across;
      return mesh.vertex_at({across * std::cos(angle) - lift * std::sin(angle),
                             across * std::sin(angle) + lift * std::cos(angle), along});
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        add_quad(mesh, {vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)}, faces);
  }
  return mesh;
}

MeshData sheared_cylinder(int n_around, int n_along) {
  MeshData mesh = open_cylinder(n_around, n_along, Faces::kTriangles);
  mesh.name = "sheared_cylinder";
  // Each ring turns by more than one step against the one below: the triangles get obtuse at one end of their base.
  for (int layer = 0; layer <= n_along; ++layer) {
    for (int i = 0; i < n_around; ++i) {
      Vector3& p = mesh.vertices[layer * n_around + i];
      p = rotation_about(Vector3::UnitZ(), 2 * kPi / n_around * 1.7 * layer) * p;
      p.x() *= 1 + .1 * p.z();
    }
  }
  return mesh;
}

MeshData sheet_with_collinear_corners() {
  MeshData mesh{"sheet_with_collinear_corners", {}, {}};
  const auto vertex = [&](double x, double y) { return mesh.vertex_at({x, y, .3 * std::sin(2 * y)}); };
  // Octagons that are squares with a vertex in the middle of every side, beside two columns of small quads.
  for (int j = 0; j < 3; ++j) {
    const double y = j;
    mesh.faces.push_back({vertex(0, y), vertex(.5, y), vertex(1, y), vertex(1, y + .5), vertex(1, y + 1),
                          vertex(.5, y + 1), vertex(0, y + 1), vertex(0, y + .5)});
    for (const double low : {y, y + .5}) {
      for (const double left : {1.0, 1.5})
        mesh.faces.push_back(
            {vertex(left, low), vertex(left + .5, low), vertex(left + .5, low + .5), vertex(left, low + .5)});
    }
  }
  return mesh;
}

std::vector<MeshData> all_small_meshes() {
  const auto hill = [](double x, double y) { return .2 * std::cos(3 * x + 1) * std::sin(4 * y); };
  return {tetrahedron(),
          cube(),
          bar(2, Faces::kTriangles),
          bar(2, Faces::kQuads),
          grid(5, Faces::kTriangles, hill),
          grid(5, Faces::kQuads, hill),
          cylinder(8, 4),
          open_cylinder(8, 5, Faces::kTriangles),
          l_prism(4),
          star_prism(5, 3),
          icosphere(1),
          bumpy_sphere(1),
          quad_sphere(3),
          moebius_strip(12, 2),
          two_spheres(1),
          bow_tie(),
          book(3, Faces::kTriangles),
          sheared_cylinder(8, 4)};
}

MeshData subdivide(const MeshData& triangles) {
  MeshData mesh{triangles.name, triangles.vertices, {}};
  std::map<std::pair<int, int>, int> middle_of_edge;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] = middle_of_edge.try_emplace(std::minmax(a, b), mesh.n_vertices());
    if (is_new) mesh.add_vertex((mesh.vertices[a] + mesh.vertices[b]) / 2);
    return entry->second;
  };
  for (const auto& face : triangles.faces) {
    const int a = face.at(0);
    const int b = face.at(1);
    const int c = face.at(2);
    const int ab = middle(a, b);
    const int bc = middle(b, c);
    const int ca = middle(c, a);
    mesh.faces.insert(mesh.faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return mesh;
}

MeshData triangulate(const MeshData& mesh) {
  MeshData result{mesh.name, mesh.vertices, {}};
  for (const auto& face : mesh.faces)
    for (size_t k = 2; k < face.size(); ++k) result.faces.push_back({face[0], face[k - 1], face[k]});
  return result;
}

MeshData join(const MeshData& first, const MeshData& second) {
  MeshData mesh = first;
  mesh.vertices.insert(mesh.vertices.end(), second.vertices.begin(), second.vertices.end());
  for (std::vector<int> face : second.faces) {
    for (int& v : face) v += first.n_vertices();
    mesh.faces.push_back(std::move(face));
  }
  return mesh;
}

MeshData transformed(const MeshData& mesh, const std::function<Vector3(const Vector3&)>& map) {
  MeshData result = mesh;
  for (Vector3& vertex : result.vertices) vertex = map(vertex);
  return result;
}

MeshData in_unit_size(const MeshData& mesh) {
  const double diagonal = mesh.diagonal();
  return transformed(mesh, [&](const Vector3& x) { return Vector3(x / diagonal); });
}

Positions RigidMotion::apply(const Positions& points) const {
  return (points * rotation.transpose()).rowwise() + translation.transpose();
}

Matrix3 best_rotation(const Matrix3& S) {
  const Eigen::JacobiSVD<Matrix3> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vector3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

RigidMotion best_rigid_motion(const Positions& from, const Positions& to) {
  const Vector3 from_centre = from.colwise().mean().transpose();
  const Vector3 to_centre = to.colwise().mean().transpose();
  const Matrix3 rotation =
      best_rotation((to.rowwise() - to_centre.transpose()).transpose() * (from.rowwise() - from_centre.transpose()));
  return {rotation, to_centre - rotation * from_centre};
}

double Random::uniform(double low, double high) {
  // splitmix64
  state_ += 0x9E3779B97F4A7C15ULL;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  z ^= z >> 31U;
  return low + (high - low) * static_cast<double>(z >> 11U) * 0x1p-53;
}

Vector3 Random::vector(double size) {
  const double x = uniform(-size, size);
  const double y = uniform(-size, size);
  const double z = uniform(-size, size);
  return {x, y, z};
}

RigidMotion Random::rigid_motion(double angle_rad, double translation) {
  const Vector3 axis = vector(1);
  return {rotation_about(axis, angle_rad), vector(translation)};
}

Positions Random::noise(int n, double size) {
  Positions result(n, 3);
  for (int v = 0; v < n; ++v) result.row(v) = vector(size).transpose();
  return result;
}

Matrix3 rotation_about(const Vector3& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
}

MeshData load_off(const std::string& path) {
  std::ifstream file(path);
  std::string header;
  int n_vertices = 0;
  int n_faces = 0;
  int n_edges = 0;
  if (!(file >> header >> n_vertices >> n_faces >> n_edges) || header != "OFF")
    throw std::runtime_error(path + " is not an OFF file");
  MeshData mesh{path.substr(path.find_last_of('/') + 1), {}, {}};
  for (int v = 0; v < n_vertices; ++v) {
    Vector3 p;
    file >> p[0] >> p[1] >> p[2];
    mesh.add_vertex(p);
  }
  for (int f = 0; f < n_faces && file; ++f) {
    int size = 0;
    file >> size;
    std::vector<int> face(static_cast<size_t>(std::clamp(size, 0, 1000)));
    for (int& v : face) file >> v;
    mesh.faces.push_back(std::move(face));
    file.ignore(1000, '\n');
  }
  if (!file || mesh.n_faces() != n_faces) throw std::runtime_error(path + " ends too early");
  return mesh;
}

std::optional<std::string> real_mesh_directory() {
  const char* directory = std::getenv("ARAP_TEST_MESHES");  // NOLINT(concurrency-mt-unsafe): nobody sets it
  if (directory == nullptr || *directory == '\0') return std::nullopt;
  return std::string(directory);
}

}  // namespace arap_test
