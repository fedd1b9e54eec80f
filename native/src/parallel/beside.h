// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <future>

#include "parallel/workers.h"

namespace arap {

/// Starts act() in a thread of its own, beside the caller's work. With one worker it runs when its result is asked for.
template <class Act>
auto beside(const Workers& workers, const Act& act) {
  return std::async(workers.threads() > 1 ? std::launch::async : std::launch::deferred, act);
}

}  // namespace arap
