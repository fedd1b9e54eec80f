// SPDX-License-Identifier: GPL-3.0-or-later
// Doubles side by side in a vector register, on the vector extensions of GCC and Clang. Only for sources that are
// compiled once per instruction set. Everything is in an unnamed namespace and no inline function of the standard
// library is called: a function that two of those sources share would be linked once, in the version of either.
#pragma once

namespace arap {
namespace {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

using Doubles [[gnu::vector_size(8 * kLanes)]] = double;
using Mask = decltype(Doubles{} < Doubles{});

inline Doubles load(const double* from) {
  Doubles result;
  __builtin_memcpy(&result, from, sizeof result);
  return result;
}

inline Doubles broadcast(double value) { return value - Doubles{}; }

inline Doubles select(const Mask& mask, const Doubles& yes, const Doubles& no) { return mask ? yes : no; }

inline bool all(const Mask& mask) {
  for (int k = 0; k < kLanes; ++k)
    if (mask[k] == 0) return false;
  return true;
}

inline bool is_lane(const Mask& mask, int k) { return mask[k] != 0; }

inline Doubles square_root(const Doubles& value) {
  Doubles result = value;
  for (int k = 0; k < kLanes; ++k) result[k] = __builtin_sqrt(value[k]);
  return result;
}

/// Four components of kLanes things.
struct Four {
  Doubles v[4];  // NOLINT: std::array has inline functions
  Doubles& operator[](int i) { return v[i]; }
  const Doubles& operator[](int i) const { return v[i]; }
};

/// The rows row(0) .. row(kLanes - 1) of four doubles, transposed.
template <class Row>
inline Four transpose_rows(const Row& row) {
#if defined(__AVX__) || defined(__AVX512F__)
  using Quad = double __attribute__((vector_size(32)));
  const auto four = [&](int k) {
    Quad value;
    __builtin_memcpy(&value, row(k), sizeof value);
    return value;
  };
#endif
#if defined(__AVX512F__)
  // Rows k and k + 4 side by side; then 4x4 transposes within both halves at once.
  const auto pair = [&](int k) { return __builtin_shufflevector(four(k), four(k + 4), 0, 1, 2, 3, 4, 5, 6, 7); };
  const Doubles a = pair(0);
  const Doubles b = pair(1);
  const Doubles c = pair(2);
  const Doubles d = pair(3);
  const Doubles ab_even = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
  const Doubles ab_odd = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  const Doubles cd_even = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
  const Doubles cd_odd = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
  return {{__builtin_shufflevector(ab_even, cd_even, 0, 1, 8, 9, 4, 5, 12, 13),
           __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 8, 9, 4, 5, 12, 13),
           __builtin_shufflevector(ab_even, cd_even, 2, 3, 10, 11, 6, 7, 14, 15),
           __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 10, 11, 6, 7, 14, 15)}};
#elif defined(__AVX__)
  const Quad a = four(0);
  const Quad b = four(1);
  const Quad c = four(2);
  const Quad d = four(3);
  const Quad ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Quad ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Quad cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Quad cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return {{__builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5), __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5),
           __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7), __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7)}};
#else
  Four result{};
  for (int component = 0; component < 4; ++component)
    for (int k = 0; k < kLanes; ++k) result[component][k] = row(k)[component];
  return result;
#endif
}

/// Rows of four doubles at indices[0] .. indices[kLanes - 1].
inline Four gather_rows(const double* rows, const int* indices) {
  return transpose_rows([&](int k) { return rows + 4 * static_cast<long>(indices[k]); });
}

/// kLanes consecutive rows of four doubles.
inline Four load_rows(const double* rows) {
  return transpose_rows([&](int k) { return rows + 4L * k; });
}

}  // namespace
}  // namespace arap
