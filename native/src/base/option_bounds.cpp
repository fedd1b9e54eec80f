// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/option_bounds.h"

#include "arap/error.h"
#include "base/format_message.h"

namespace arap {

void require_between(const char* option, double value, double least, double most, const char* exception) {
  if (!(value >= least && value <= most))
    throw InvalidInput(text(option, " = ", value, ", must be >= ", least, " and <= ", most, exception));
}

void require_threads(int threads) {
  constexpr int kMostThreads = 1024;
  if (threads < 0 || threads > kMostThreads)
    throw InvalidInput(text("threads = ", threads, ", must be 0 (as many as pay) to ", kMostThreads));
}

}  // namespace arap
