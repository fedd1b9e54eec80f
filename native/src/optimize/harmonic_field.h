// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "constraints/prepared_constraints.h"

namespace arap {

/// A harmonic field of vectors at the unknowns.
struct HarmonicField {
  Positions values;  ///< (n, 3); with rigid regions, members have the value of their unknown
  double range;      ///< the largest difference of a value from the mean of its part
};

/// Spreads what the targets have over the unknowns: the field w with K w = 0 which meets constraints as strongly as
/// positions do. In parts without constraints it is 0.
/// @param of_targets  (n_targets, 3)
/// @param accuracy    of the values, as a part of the range
[[nodiscard]] HarmonicField interpolate_harmonically(const PreparedModel& model, const PreparedConstraints& constraints,
                                                     const Positions& of_targets, double accuracy);

}  // namespace arap
