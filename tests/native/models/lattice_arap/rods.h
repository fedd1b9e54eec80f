// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "arap/lattice_arap.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {

/// Few cubes, which are enough for what does not hang on their number.
inline arap::LatticeOptions coarse() {
  arap::LatticeOptions options;
  options.cube_size = .08;
  return options;
}

inline arap::SolveResult solve_once(const MeshData& mesh, const Task& task,
                                    const arap::LatticeOptions& options = coarse()) {
  arap::LatticeArap solver(mesh.mesh(), options);
  solver.set_constraints(task.constraints);
  return solver.solve(task.targets, to_accuracy(1e-6));
}

inline double furthest(const Positions& a, const Positions& b) { return (a - b).rowwise().norm().maxCoeff(); }

inline double volume(const MeshData& mesh, const Positions& points) {
  double sum = 0;
  for (const std::vector<int>& face : triangulate(mesh).faces)
    sum +=
        points.row(face[0]).dot(Eigen::RowVector3d(points.row(face[1])).cross(Eigen::RowVector3d(points.row(face[2]))));
  return sum / 6;
}

/// A rod of diameter 1 and length 6 along z.
inline constexpr int kAround = 24;
inline constexpr int kAlong = 72;
inline MeshData rod(int n_around = kAround, int n_along = kAlong) {
  return transformed(cylinder(n_around, n_along), [](const Vector3& x) { return Vector3(x[0], x[1], 3 * x[2]); });
}

inline RigidMotion twist(double part) { return {rotation_about(Vector3(0, 0, 1), part * 3.14159265), Vector3::Zero()}; }

/// The thinnest ring's area, over its area at rest.
inline double thinnest(const MeshData& mesh, const Positions& points) {
  double least = 1;
  for (int ring = 6; ring <= kAlong - 6; ++ring) {
    const auto area = [&](const Positions& x) {
      std::vector<int> around;
      for (int v = 0; v < mesh.n_vertices(); ++v)
        if (std::abs(mesh.vertices[v][2] - (-3 + 6.0 * ring / kAlong)) < 1e-9) around.push_back(v);
      std::sort(around.begin(), around.end(), [&](int a, int b) {
        return std::atan2(mesh.vertices[a][1], mesh.vertices[a][0]) <
               std::atan2(mesh.vertices[b][1], mesh.vertices[b][0]);
      });
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (size_t k = 0; k < around.size(); ++k)
        sum += Eigen::RowVector3d(x.row(around[k])).cross(Eigen::RowVector3d(x.row(around[(k + 1) % around.size()])));
      return sum.norm();
    };
    least = std::min(least, area(points) / area(mesh.positions()));
  }
  return least;
}

}  // namespace arap_test
