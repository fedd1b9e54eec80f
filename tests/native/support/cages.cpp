// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/cages.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace arap_test {

namespace {

using Real = long double;
using Wide = Eigen::Matrix<Real, 3, 1>;

double solid_angle(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double below = a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), below);
}

/// Calls visit(triangle, weight) for the triangles of the fan from the first corner of each face.
template <class Visit>
void for_each_triangle(const MeshData& mesh, const Visit& visit) {
  for (const std::vector<int>& face : mesh.faces)
    for (size_t k = 1; k + 1 < face.size(); ++k)
      visit(mesh.vertices[face[0]], mesh.vertices[face[k]], mesh.vertices[face[k + 1]]);
}

/// Distance to the planes of all triangles at most, but not beyond them: a bound from below of that to the faces.
bool is_near_a_face(const MeshData& cage, const Vector3& point, double distance) {
  bool is_near = false;
  for_each_triangle(cage, [&](const Vector3& a, const Vector3& b, const Vector3& c) {
    const Vector3 normal = (b - a).cross(c - a).normalized();
    const double radius = std::max({(a - point).norm(), (b - point).norm(), (c - point).norm()});
    is_near |= std::abs(normal.dot(point - a)) < distance && radius < 2 * ((b - a).norm() + (c - a).norm());
  });
  return is_near;
}

/// By barycentric coordinates: the hats at the corners are (a, b, c).
struct Part {
  Vector3 a;
  Vector3 b;
  Vector3 c;
};

template <class Visit>
void cut(const Part& part, int levels, const Visit& visit) {
  if (levels == 0) return visit(part);
  const Vector3 ab = (part.a + part.b) / 2;
  const Vector3 bc = (part.b + part.c) / 2;
  const Vector3 ca = (part.c + part.a) / 2;
  for (const Part& next : {Part{part.a, ab, ca}, Part{ab, part.b, bc}, Part{ca, bc, part.c}, Part{ab, bc, ca}})
    cut(next, levels - 1, visit);
}

Vector3 vertex(const arap::Cage& cage, int v) { return cage.vertices().row(v).transpose(); }

}  // namespace

MeshData l_cage(double length) {
  // From the inner edge all fans of the caps are within them.
  MeshData with_caps = prism({{.5, .5}, {.5, length}, {0, length}, {0, 0}, {length, 0}, {length, .5}}, 1, 1);
  for (std::vector<int>& face : with_caps.faces)
    if (face.size() > 4) std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  MeshData mesh = triangulate(with_caps);
  mesh.name = "L";
  return mesh;
}

std::vector<MeshData> all_cages() {
  std::vector<MeshData> cages{tetrahedron(),
                              icosphere(1),
                              bumpy_sphere(1),
                              cube(),
                              quad_sphere(2),
                              box({3, 2, 1}, {3, 2, 1}, Faces::kQuads),
                              bar(1, Faces::kTriangles),
                              l_cage()};
  // Triangles and quads, the latter bent.
  MeshData mixed = cube();
  mixed.name = "half cube";
  const std::vector<int> quad = mixed.faces.back();
  mixed.faces.back() = {quad[0], quad[1], quad[2]};
  mixed.faces.push_back({quad[0], quad[2], quad[3]});
  mixed.vertices[0] += Vector3(.1, -.05, .08);
  cages.push_back(mixed);
  return cages;
}

bool has_bent_quads(const MeshData& mesh) {
  return std::any_of(mesh.faces.begin(), mesh.faces.end(), [&](const std::vector<int>& face) {
    if (face.size() != 4) return false;
    const auto edge = [&](int k) { return Vector3(mesh.vertices[face[k]] - mesh.vertices[face[0]]); };
    return std::abs(edge(1).cross(edge(2)).dot(edge(3))) > 1e-9;
  });
}

MeshData flipped(const MeshData& mesh) {
  MeshData result = mesh;
  for (std::vector<int>& face : result.faces) std::reverse(face.begin(), face.end());
  return result;
}

Positions bent(const MeshData& cage) {
  return cage.positions() + Random(9).noise(cage.n_vertices(), .1 * cage.diagonal());
}

double winding(const MeshData& cage, const Vector3& point) {
  double sum = 0;
  for_each_triangle(cage, [&](const Vector3& a, const Vector3& b, const Vector3& c) {
    sum += solid_angle(a - point, b - point, c - point);
  });
  return sum / (4 * std::numbers::pi);
}

Positions points_inside(const MeshData& cage, int n, std::uint64_t seed) {
  const Positions vertices = cage.positions();
  const Vector3 low = vertices.colwise().minCoeff();
  const Vector3 high = vertices.colwise().maxCoeff();
  Random random(seed);
  Positions points(n, 3);
  for (int found = 0; found < n;) {
    const Vector3 x = (low + high) / 2 + (random.vector(.5).array() * (high - low).array()).matrix();
    if (std::abs(winding(cage, x) - 1) > 1e-6 || is_near_a_face(cage, x, .02 * cage.diagonal())) continue;
    points.row(found++) = x.transpose();
  }
  return points;
}

Quadrature integrate(const arap::Cage& cage, int levels,
                     const std::function<double(const Vector3& place, const Vector3& normal)>& kernel) {
  Quadrature result{Eigen::VectorXd::Zero(cage.n_vertices()), Eigen::VectorXd::Zero(cage.n_triangles())};
  for (int t = 0; t < cage.n_triangles(); ++t) {
    const arap::CageTriangle& triangle = cage.triangle(t);
    Matrix3 corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = vertex(cage, triangle.vertices[k]);
    const Vector3 twice_area = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
    const Vector3 normal = twice_area.normalized();
    const double weight = triangle.share * twice_area.norm() / 2 / std::pow(4.0, levels) / 3;
    const auto add = [&](const Vector3& hats) {
      const double value = weight * kernel(corners * hats, normal);
      for (int k = 0; k < 3; ++k) result.hats[triangle.vertices[k]] += value * hats[k];
      result.wholes[t] += value;
    };
    cut({Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()}, levels, [&](const Part& part) {
      add((part.a + part.b) / 2);
      add((part.b + part.c) / 2);
      add((part.c + part.a) / 2);
    });
  }
  return result;
}

Eigen::VectorXd printed_mean_values(const arap::Cage& cage, const Vector3& point) {
  Eigen::Matrix<Real, Eigen::Dynamic, 1> weights = Eigen::Matrix<Real, Eigen::Dynamic, 1>::Zero(cage.n_vertices());
  for (const arap::CageTriangle& triangle : cage.triangles()) {
    Wide u[3];       // NOLINT: as in CageTriangle
    Real d[3];       // NOLINT
    Wide across[3];  // NOLINT
    for (int k = 0; k < 3; ++k) {
      u[k] = vertex(cage, triangle.vertices[k]).cast<Real>() - point.cast<Real>();
      d[k] = u[k].norm();
      u[k] /= d[k];
    }
    Wide m = Wide::Zero();
    for (int k = 0; k < 3; ++k) {
      const Wide& next = u[(k + 1) % 3];
      const Wide& last = u[(k + 2) % 3];
      across[k] = next.cross(last);
      m += std::atan2(across[k].norm(), next.dot(last)) / 2 * across[k].normalized();
    }
    const Real determinant = u[0].dot(across[0]);
    for (int k = 0; k < 3; ++k)
      weights[triangle.vertices[k]] += static_cast<Real>(triangle.share) * m.dot(across[k]) / (d[k] * determinant);
  }
  return (weights / weights.sum()).cast<double>();
}

}  // namespace arap_test
