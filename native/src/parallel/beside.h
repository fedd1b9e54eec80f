// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <future>
#include <system_error>

#include "parallel/workers.h"

namespace arap {

/// Starts act() in a thread of its own, beside the caller's work. With one worker, or if the system has no more
/// threads, it runs when its result is asked for.
template <class Act>
auto beside(const Workers& workers, const Act& act) {
  if (workers.threads() > 1) {
    try {
      return std::async(std::launch::async, act);
    } catch (const std::system_error&) {  // NOLINT(bugprone-empty-catch): deferred
    }
  }
  return std::async(std::launch::deferred, act);
}

}  // namespace arap
