// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace arap {

/// Rows that a thread takes at once.
constexpr int kRows = 2048;

}  // namespace arap
