// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace arap {

/// The bounds of options: every number of every class of options goes through these. They throw InvalidInput that names
/// the option, its value and the bounds.

/// @param exception  what else it may be, for the message
void require_between(const char* option, double value, double least, double most, const char* exception = "");

/// More threads than any machine has would take minutes to start, or end the process.
void require_threads(int threads);

}  // namespace arap
