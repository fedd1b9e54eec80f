// SPDX-License-Identifier: GPL-3.0-or-later
// Two loops, one right and one with a race: shows that the thread sanitizer sees races between OpenMP threads, and
// that it knows OpenMP's own barriers. Argument "race" takes the second.
#include <cstddef>
#include <cstdio>
#include <string_view>
#include <vector>

int main(int argc, char** argv) {
  const bool has_race = argc > 1 && std::string_view(argv[1]) == "race";
  std::vector<int> values(10000, 1);
  const int n = static_cast<int>(values.size());
  int shared = 0;
#pragma omp parallel for num_threads(2)
  for (int i = 0; i < n; ++i) {
    values[static_cast<size_t>(i)] += i;
    if (has_race) shared += values[static_cast<size_t>(i)];
  }
  for (const int value : values) shared += value;
  std::printf("%d\n", shared);
  return 0;
}
