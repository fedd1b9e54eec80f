// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <future>
#include <system_error>
#include <vector>

#include "parallel/workers.h"

namespace arap {

/// Number of threads for a mesh of n vertices: `requested`, or by size if that is 0.
[[nodiscard]] int choose_threads(int requested, int n_vertices);

/// Calls body(piece) for [0, n_pieces) on OpenMP's threads; for the long loops of a bind. Rethrows the first exception,
/// after which no piece is started.
void for_each_piece(int threads, int n_pieces, const std::function<void(int piece)>& body);

/// The same on Workers, for the short passes of an iteration.
template <class Body>
void for_each_piece(const Workers& workers, int n_pieces, const Body& body) {
  workers.run(n_pieces, body);
}

/// Calls body(begin, end) for consecutive ranges of [0, n) in parallel. The ranges do not depend on the number of
/// threads.
/// @param threads  here and below: their number, or Workers
template <class Threads, class Body>
void parallel_for_ranges(const Threads& threads, int n, int range, const Body& body) {
  for_each_piece(threads, (n + range - 1) / range, [&](int r) { body(r * range, std::min(n, (r + 1) * range)); });
}

template <int kRange = 512, class Threads, class Body>
void parallel_for(const Threads& threads, int n, const Body& body) {
  parallel_for_ranges(threads, n, kRange, body);
}

/// Copies a dense matrix; resizes `to`.
template <int kRange = 4096, class Threads, class Rows>
void copy_rows(const Threads& threads, const Rows& from, Rows& to) {
  to.resize(from.rows(), from.cols());
  parallel_for<kRange>(threads, static_cast<int>(from.rows()), [&](int begin, int end) {
    to.middleRows(begin, end - begin) = from.middleRows(begin, end - begin);
  });
}

/// Joins the results of body(begin, end) over ranges of [0, n) in order: the same for every number of threads.
template <int kRange = 512, class Threads, class Value, class Body, class Join>
[[nodiscard]] Value parallel_reduce(const Threads& threads, int n, const Value& neutral, const Body& body,
                                    const Join& join, int range = kRange) {
  std::vector<Value> partial(((n + range - 1) / range), neutral);
  parallel_for_ranges(threads, n, range, [&](int begin, int end) { partial[begin / range] = body(begin, end); });
  Value result = neutral;
  for (const Value& value : partial) result = join(result, value);
  return result;
}

/// Splits [0, n) into one consecutive range per thread, for work that needs a table of its own on each thread.
class Shares {
 public:
  Shares(int threads, int n) : count_(std::clamp(threads, 1, n / kLeast + 1)), n_(n) {}

  [[nodiscard]] int count() const { return count_; }

  /// Calls body(share, begin, end) for each share in parallel.
  template <class Body>
  void for_each(const Body& body) const {
    for_each_piece(count_, count_, [&](int share) { body(share, begin(share), begin(share + 1)); });
  }

 private:
  static constexpr int kLeast = 4096;

  [[nodiscard]] int begin(int share) const { return static_cast<int>(static_cast<std::int64_t>(n_) * share / count_); }

  int count_;
  int n_;
};

/// Sum of body(begin, end) over ranges of [0, n).
template <int kRange = 512, class Threads, class Body>
[[nodiscard]] double parallel_sum(const Threads& threads, int n, const Body& body, int range = kRange) {
  return parallel_reduce<kRange>(
      threads, n, 0.0, body, [](double a, double b) { return a + b; }, range);
}

/// Whether body(begin, end) is true for all ranges of [0, n).
template <int kRange = 512, class Threads, class Body>
[[nodiscard]] bool parallel_all(const Threads& threads, int n, const Body& body) {
  // char instead of bool: threads must not write to bits of one byte.
  return parallel_reduce<kRange>(
             threads, n, char{1}, [&](int begin, int end) { return static_cast<char>(body(begin, end)); },
             [](char a, char b) { return static_cast<char>(a & b); }) != 0;
}

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
