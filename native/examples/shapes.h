// SPDX-License-Identifier: GPL-3.0-or-later
// What the examples share: a mesh made on the spot, its volume, a turn, and ends that are held.
#pragma once

#include <arap/constraints.h>
#include <arap/mesh.h>
#include <arap/types.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

namespace examples {

inline double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// About `axis`, of unit length.
inline arap::Matrix3 turn(double degrees, const arap::Vector3& axis) {
  return Eigen::AngleAxisd(radians(degrees), axis).toRotationMatrix();
}

/// A closed tube from x = 0 to 6, of radius 0.5: quads, and a polygon at each end.
inline arap::PolygonMesh tube(int rings = 61, int around = 24) {
  arap::Positions positions(rings * around, 3);
  std::vector<int> corners;
  for (int ring = 0; ring < rings; ++ring) {
    for (int k = 0; k < around; ++k) {
      const int v = ring * around + k;
      const double angle = radians(360. * k / around);
      positions.row(v) << 6. * ring / (rings - 1), 0.5 * std::cos(angle), 0.5 * std::sin(angle);
      const int beside = ring * around + (k + 1) % around;
      if (ring + 1 < rings) corners.insert(corners.end(), {v, beside, beside + around, v + around});
    }
  }
  std::vector<int> sizes(corners.size() / 4, 4);
  for (int k = around - 1; k >= 0; --k) corners.push_back(k);
  for (int k = 0; k < around; ++k) corners.push_back((rings - 1) * around + k);
  sizes.insert(sizes.end(), 2, around);
  return {std::move(positions), std::move(corners), std::move(sizes)};
}

/// Of what is inside of faces that are oriented outwards, with the vertices of `mesh` at `positions`.
inline double volume(const arap::PolygonMesh& mesh, const arap::Positions& positions) {
  double sum = 0;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    for (size_t k = 2; k < face.size(); ++k) {
      const arap::Vector3 a = positions.row(face[0]);
      const arap::Vector3 b = positions.row(face[k - 1]);
      const arap::Vector3 c = positions.row(face[k]);
      sum += a.dot(b.cross(c)) / 6;
    }
  }
  return sum;
}

/// The vertices between two places along x.
inline std::vector<int> between(const arap::Positions& positions, double from, double to) {
  std::vector<int> vertices;
  for (int v = 0; v < positions.rows(); ++v)
    if (positions(v, 0) > from && positions(v, 0) < to) vertices.push_back(v);
  return vertices;
}

/// What is held of a shape from x = 0 to 6: a pin at the lower end, a handle at the upper one.
struct HeldEnds {
  std::vector<int> pins;
  std::vector<int> handle;

  explicit HeldEnds(const arap::Positions& rest) : pins(between(rest, -1, 0.3)), handle(between(rest, 5.7, 7)) {}

  [[nodiscard]] arap::ConstraintSet constraints() const {
    arap::ConstraintSet set;
    set.vertices = pins;
    set.vertices.insert(set.vertices.end(), handle.begin(), handle.end());
    return set;
  }

  /// Where they go if the pin stays and the handle moves by a linear map about a centre.
  [[nodiscard]] arap::Positions targets(const arap::Positions& rest, const arap::Matrix3& motion,
                                        const arap::Vector3& centre = {0, 0, 0}) const {
    arap::Positions rows(static_cast<Eigen::Index>(pins.size() + handle.size()), 3);
    Eigen::Index row = 0;
    for (const int v : pins) rows.row(row++) = rest.row(v);
    for (const int v : handle) rows.row(row++) = (motion * (rest.row(v).transpose() - centre) + centre).transpose();
    return rows;
  }
};

}  // namespace examples
