// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/openmp.h"

#include "parallel/process_id.h"

namespace arap {

int openmp_threads(int wanted) {
  if (wanted <= 1) return 1;
  // The runtime's threads belong to the process that first had a region.
  static const ProcessId first = process_id();
  return process_id() == first ? wanted : 1;
}

}  // namespace arap
