// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/held_segments.h"

#include "arap/error.h"
#include "base/format_message.h"
#include "lattice/segment_core.h"
#include "models/lattice_arap/held_vertices.h"

namespace arap {

HeldSegments::HeldSegments(const Lattice& lattice, const std::vector<Segment>& segments, int first_target) {
  constexpr int kOctants = 8;
  const double weight = 2 * kHardStrength * lattice.cube_size() / kOctants;
  for (size_t s = 0; s < segments.size(); ++s) {
    const Segment& segment = segments[s];
    const double length = (segment.tail - segment.head).norm();
    const std::vector<int> core = segment_core(lattice, segment);
    if (core.empty())
      throw InvalidInput(text(
          "segment ", s, " passes through nothing that is inside of the mesh; move it into the mesh or leave it out"));
    for (const int piece : core) {
      const Lattice::ControlPoints& points = lattice.control_points(piece);
      for (int octant = 0; octant < kOctants; ++octant) {
        const Eigen::Vector3i side(octant >> 2, octant >> 1 & 1, octant & 1);
        const Eigen::Vector3d in_cube = 0.5 * side.cast<double>() + Eigen::Vector3d::Constant(0.25);
        const Lattice::Weights phi = Lattice::weights_at(in_cube);
        rows_.add({{points.begin(), points.end()}, {phi.begin(), phi.end()}}, weight);
        // B-splines meet positions, so this is where the control points at rest say that the octant is.
        const Eigen::RowVector3d place = rows_.rows.back().of(lattice.rest());
        held_.push_back({first_target, (place - segment.head.transpose()) / length});
      }
    }
    first_target += Segment::kTargets;
  }
}

Positions HeldSegments::targets(const Positions& of_set) const {
  Positions result(rows_.size(), 3);
  for (Eigen::Index r = 0; r < result.rows(); ++r) {
    const auto& [first, place] = held_[r];
    const Eigen::RowVector3d head = of_set.row(first);
    result.row(r) = head + place * (of_set.middleRows(first + 1, 3).rowwise() - head);
  }
  return result;
}

std::vector<int> HeldSegments::sources() const {
  std::vector<int> result;
  result.reserve(held_.size());
  for (const Held& held : held_) result.push_back(held.first_target);
  return result;
}

}  // namespace arap
