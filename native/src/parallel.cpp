// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel.h"

#include "first_failure.h"
#include "openmp.h"

namespace arap {

void for_each_piece(int threads, int n_pieces, const std::function<void(int piece)>& body) {
  const int n_threads = openmp_threads(std::min(threads, n_pieces));
  FirstFailure failure;
#pragma omp parallel for num_threads(n_threads) if (n_threads > 1) schedule(static)
  for (int piece = 0; piece < n_pieces; ++piece) failure.guard([&] { body(piece); });
  failure.rethrow();
}

}  // namespace arap
