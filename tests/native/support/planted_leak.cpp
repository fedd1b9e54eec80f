// SPDX-License-Identifier: GPL-3.0-or-later
// planted_leak        a loop of two threads whose memory is freed
// planted_leak leak   one that loses it: what the address sanitizer has to find in spite of OpenMP's runtime below it
#include <omp.h>

#include <memory>
#include <vector>

int main(int n_arguments, char** /*arguments*/) {
  const bool is_leaking = n_arguments > 1;
#pragma omp parallel num_threads(2)
  {
    auto numbers = std::make_unique<std::vector<int>>(1000, omp_get_thread_num());
    if (is_leaking) static_cast<void>(numbers.release());
  }
  return 0;
}
