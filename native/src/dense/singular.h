// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace arap {

/// As part of the largest pivot or singular value: what is less counts as 0.
constexpr double kSingular = 1e-12;

}  // namespace arap
