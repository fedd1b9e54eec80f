// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "support/meshes.h"

namespace arap_test {

/// Vertices that turn and grow as one, and where they go.
struct PoissonHandle {
  std::vector<int> vertices;
  Positions targets;               ///< of each vertex
  Vector3 turn = Vector3::Zero();  ///< rotation vector
  double scale = 1;

  [[nodiscard]] Matrix3 rotation() const;
};

/// Poisson editing as plainly as it is written down: gradients of triangles, areas, dense matrices, all in double. It
/// shares only array types with the library. No triangle may be degenerate.
class DensePoisson {
 public:
  explicit DensePoisson(const MeshData& mesh);

  /// (n, n_handles) harmonic weights.
  [[nodiscard]] Eigen::MatrixXd harmonic_weights(const std::vector<PoissonHandle>& handles) const;
  /// (n, n_handles) weights by 1 / distance along the edges of triangles.
  [[nodiscard]] Eigen::MatrixXd geodesic_weights(const std::vector<PoissonHandle>& handles) const;

  [[nodiscard]] Positions solve(const std::vector<PoissonHandle>& handles, const Eigen::MatrixXd& weights) const;

  /// The field x with L x = b at free vertices and these values at those of handles.
  [[nodiscard]] Positions with_values(const std::vector<PoissonHandle>& handles, const Positions& values,
                                      const Positions& b) const;

 private:
  struct Triangle {
    std::array<int, 3> vertices;
    int face;
    double area;                           ///< times the share of the triangle in its face
    Eigen::Matrix<double, 3, 3> gradient;  ///< of the function that is 1 at a corner: a column each
  };
  [[nodiscard]] std::vector<double> distances(const std::vector<int>& sources) const;

  std::vector<std::vector<int>> faces_;
  Positions rest_;
  std::vector<Triangle> triangles_;
  Eigen::MatrixXd L_;
};

}  // namespace arap_test
