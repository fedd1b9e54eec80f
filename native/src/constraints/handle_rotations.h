// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "arap/options.h"
#include "constraints/prepared_constraints.h"

namespace arap {

/// How connected groups of constrained vertices, and of soft rows that share unknowns, have turned between two sets of
/// targets. Turns are rotation vectors: the axis times the angle in radian.
class HandleRotations {
 public:
  HandleRotations(const PreparedModel& model, const PreparedConstraints& constraints);

  /// How far a solve's start is to turn with each row of its targets, (n_targets, 3); no rows: not at all.
  /// From rest by the rotations that are given, or estimated; from the previous pose where handles turned far.
  /// @param last_targets  of the previous pose; no rows: unknown
  /// @param rotations     of each row, or empty
  [[nodiscard]] Positions of_start(InitialGuess guess, const Positions& last_targets, const Positions& previous,
                                   const Positions& targets, std::span<const Matrix3> rotations) const;

  /// How far each row has turned since rest, (n_targets, 3), by the rotations that are given, or estimated.
  /// @param last  (n_targets, 3) that they go on from, by whole turns more or less: see go_on_from(). No rows: each
  ///              turns the short way
  [[nodiscard]] Positions from_rest(const Positions& targets, std::span<const Matrix3> rotations,
                                    const Positions& last = {}) const;

  /// The connected group of each row, counted from 0; -1: a patch.
  [[nodiscard]] const std::vector<int>& group_of_row() const { return group_of_row_; }

 private:
  using Told = std::vector<std::optional<Matrix3>>;  ///< of each group
  /// A group turns as its targets fit best. One that tells no turn (a point, a line) and patches take the mean of the
  /// other groups' of their part, or else do not turn. Where none at all tells one, all take the turn that fits all
  /// targets best.
  [[nodiscard]] Positions estimate(const Positions& from, const Positions& to, const Positions& last) const;
  /// The same, but no rows where no group tells a turn by more than `angle` radian.
  [[nodiscard]] Positions estimate_beyond(double angle, const Positions& from, const Positions& to) const;
  /// The turn R with to_k = R from_k + s_k t, as well as it can be, s_k the sum of row k: 1 of a place. Empty where
  /// places lie on a line or are one, as fewer than three always do.
  [[nodiscard]] std::optional<Matrix3> best_rotation(const Positions& from, const Positions& to,
                                                     const std::vector<int>& rows) const;
  /// Of the row's coefficients, without rounding about 0.
  [[nodiscard]] double sum_of(int row) const;
  [[nodiscard]] Told ask_groups(const Positions& from, const Positions& to) const;
  [[nodiscard]] Positions of_rows(const Told& told, const Positions& last) const;

  const PreparedModel& model_;
  const PreparedConstraints& constraints_;
  std::vector<int> group_of_row_;
  std::vector<double> weight_of_row_;
  std::vector<int> part_of_row_;
  std::vector<std::vector<int>> rows_of_group_;  ///< as many as tell how it turns
};

}  // namespace arap
