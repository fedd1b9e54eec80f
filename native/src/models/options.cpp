// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/options.h"

#include <cmath>

#include "arap/error.h"
#include "base/format_message.h"
#include "base/option_bounds.h"

namespace arap {

void Options::validate() const {
  // Below this no two vertices of a mesh in single precision share a node.
  constexpr double kSmallestRadius = 1e-6;
  require_between("rigidity_radius", rigidity_radius, kSmallestRadius, 1);
  require_threads(threads);
}

void SolveOptions::validate() const {
  if (max_iterations < 1) throw InvalidInput(text("max_iterations = ", max_iterations, ", must be >= 1"));
  if (!(accuracy >= 0) || std::isinf(accuracy))
    throw InvalidInput(text("accuracy = ", accuracy, ", must be finite and >= 0"));
  if (!(time_limit_s > 0)) throw InvalidInput(text("time_limit_s = ", time_limit_s, ", must be > 0"));
}

}  // namespace arap
