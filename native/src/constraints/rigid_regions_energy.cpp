// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/QR>

#include "constraints/rigid_regions.h"

namespace arap {

namespace {

/// s with <[w]x, A> = -<w, s> for every w.
Vector3 twist(const Matrix3& A) { return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)}; }

}  // namespace

// R makes H = S R^T symmetric, S = sum_j p'_j (p_j - c)^T. Vertices that move by d_j turn it by the w of
//     (tr(H) I - H) w = sum_j R (p_j - c) x d_j,
// and a turn by w changes the energy by -<[w]x R, Q> = <w, twist(Q R^T)>.
Positions RigidRegions::turn_cells(const Positions& positions, Rotations& rotations) const {
  Positions gradient = Positions::Zero(positions.rows(), 3);
  const RegionTargets places{positions, Positions(0, 3)};
  for (const Region& region : regions_) {
    Matrix3 Q = Matrix3::Zero();
    for (const int c : region.cells)
      for (int k = energy_->cell_offsets[c]; k < energy_->cell_offsets[c + 1]; ++k)
        Q += positions.row(energy_->cell_vertices[k]).transpose() * energy_->q.row(k);
    // Held at all of its vertices.
    Region held;
    for (const int v : region.members) {
      held.anchors.push_back({rest(v), v, -1});
      held.center += rest(v) / static_cast<double>(region.members.size());
    }
    find_anchor_rank(held);
    Placement placement;
    place(held, -Q, places, placement);
    const Matrix3& R = placement.rotation;
    for (const int c : region.cells) rotations[c] = Eigen::Quaterniond(R);

    Matrix3 H = Matrix3::Zero();
    for (const int v : region.members) H += positions.row(v).transpose() * (R * (rest(v) - held.center)).transpose();
    const Matrix3 resistance = H.trace() * Matrix3::Identity() - H;
    const Vector3 torque = resistance.completeOrthogonalDecomposition().solve(twist(Q * R.transpose()));
    for (const int v : region.members) gradient.row(v) = torque.cross(R * (rest(v) - held.center)).transpose();
  }
  return gradient;
}

}  // namespace arap
