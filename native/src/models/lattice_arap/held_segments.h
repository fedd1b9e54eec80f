// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "arap/constraints.h"
#include "constraints/linear_rows.h"
#include "lattice/lattice.h"

namespace arap {

/// What segments mean for a lattice: the centres x of the eight octants of each cube of a core go where the segment's
/// targets say. Softly, as hard vertices are held: sum_x omega |phi_x c - t_x|^2.
class HeldSegments {
 public:
  HeldSegments() = default;
  /// Throws InvalidInput for a segment that passes through nothing.
  /// @param first_target  row of the set's targets where those of the segments begin
  HeldSegments(const Lattice& lattice, const std::vector<Segment>& segments, int first_target);

  /// Rows over control points.
  [[nodiscard]] const LinearRows& rows() const { return rows_; }
  /// Their targets, (n_rows, 3), from those of the set.
  [[nodiscard]] Positions targets(const Positions& of_set) const;
  /// For each row a target of the set that it is about.
  [[nodiscard]] std::vector<int> sources() const;

 private:
  struct Held {
    int first_target;
    Eigen::RowVector3d place;  ///< from the head, in lengths of the segment
  };

  LinearRows rows_;
  std::vector<Held> held_;  ///< of each row
};

}  // namespace arap
