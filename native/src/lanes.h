// SPDX-License-Identifier: GPL-3.0-or-later
// Many small things at once: one component of each in the lanes of a vector. Only for sources that are compiled once
// per instruction set; see simd.h for what that forbids.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>  // intrinsics are always inlined
#endif

#include "simd.h"

namespace arap {
namespace {

template <class Real>
inline constexpr int kLaneCount = kVectorBytes / static_cast<int>(sizeof(Real));

template <class Real>
using Lanes = Vector<Real, kLaneCount<Real>>;

/// Four components of as many things as a vector has lanes.
template <class Real>
struct Four {
  Lanes<Real> v[4];  // NOLINT: std::array has inline functions
  [[gnu::always_inline]] Lanes<Real>& operator[](int i) { return v[i]; }
  [[gnu::always_inline]] const Lanes<Real>& operator[](int i) const { return v[i]; }
};

template <class Real>
struct Three {
  Lanes<Real> v[3];  // NOLINT
  [[gnu::always_inline]] Lanes<Real>& operator[](int i) { return v[i]; }
  [[gnu::always_inline]] const Lanes<Real>& operator[](int i) const { return v[i]; }
};

template <class Real>
[[gnu::always_inline]] inline Lanes<Real> broadcast(Real value) {
  return value - Lanes<Real>{};
}

/// The compilers have no square root of a vector of their own.
template <class Real>
[[gnu::always_inline]] inline Lanes<Real> square_root(const Lanes<Real>& value) {
  constexpr bool kIsSingle = sizeof(Real) == sizeof(float);
#if defined(__AVX512F__)
  if constexpr (kIsSingle)
    return _mm512_sqrt_ps(value);
  else
    return _mm512_sqrt_pd(value);
#elif defined(__AVX__)
  if constexpr (kIsSingle)
    return _mm256_sqrt_ps(value);
  else
    return _mm256_sqrt_pd(value);
#elif defined(__x86_64__)
  if constexpr (kIsSingle)
    return _mm_sqrt_ps(value);
  else
    return _mm_sqrt_pd(value);
#else
  Lanes<Real> result = value;
  for (int k = 0; k < kLaneCount<Real>; ++k)
    if constexpr (kIsSingle)
      result[k] = __builtin_sqrtf(value[k]);
    else
      result[k] = __builtin_sqrt(value[k]);
  return result;
#endif
}

/// What a comparison gives: all bits of a lane, or none.
template <class Real>
using Mask = decltype(Lanes<Real>{} < Lanes<Real>{});

/// Bit k: lane k.
template <class Real>
[[gnu::always_inline]] inline unsigned bits(const Mask<Real>& mask) {
  constexpr bool kIsSingle = sizeof(Real) == sizeof(float);
#if defined(__AVX512F__)
  if constexpr (kIsSingle)
    return _mm512_movepi32_mask(reinterpret_cast<__m512i>(mask));
  else
    return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
#elif defined(__AVX__)
  if constexpr (kIsSingle)
    return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
  else
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#elif defined(__x86_64__)
  if constexpr (kIsSingle)
    return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
  else
    return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(mask)));
#else
  static_cast<void>(kIsSingle);
  unsigned result = 0;
  for (int k = 0; k < kLaneCount<Real>; ++k) result |= mask[k] != 0 ? 1U << k : 0U;
  return result;
#endif
}

template <class Real>
[[gnu::always_inline]] inline bool all(const Mask<Real>& mask) {
  return bits<Real>(mask) == (1U << kLaneCount<Real>)-1;
}

/// Sums many vectors in double.
template <class Real>
class LaneSum {
 public:
  [[gnu::always_inline]] void add(const Lanes<Real>& value) {
    if constexpr (sizeof(Real) == sizeof(double)) {
      low_ += value;
    } else {
      constexpr int kHalf = kLaneCount<Real> / 2;
      [&]<int... lane>(std::integer_sequence<int, lane...>) __attribute__((always_inline)) {
        low_ += __builtin_convertvector(__builtin_shufflevector(value, value, lane...), Lanes<double>);
        high_ += __builtin_convertvector(__builtin_shufflevector(value, value, (kHalf + lane)...), Lanes<double>);
      }
      (std::make_integer_sequence<int, kHalf>());
    }
  }

  [[nodiscard]] double total() const {
    const Lanes<double> both = low_ + high_;
    double sum = 0;
    for (int k = 0; k < kLaneCount<double>; ++k) sum += both[k];
    return sum;
  }

 private:
  Lanes<double> low_{};
  Lanes<double> high_{};
};

/// Lane 4 g + i of the result is lane 4 g + p_i of a, or of b where p_i is 4 and more.
template <class Real, int p0, int p1, int p2, int p3>
[[gnu::always_inline]] inline Lanes<Real> pick_in_fours(const Lanes<Real>& a, const Lanes<Real>& b) {
  constexpr auto kLane = [](int lane) {
    const int p = lane % 4 == 0 ? p0 : lane % 4 == 1 ? p1 : lane % 4 == 2 ? p2 : p3;
    return lane / 4 * 4 + (p < 4 ? p : kLaneCount<Real> + p - 4);
  };
  return [&]<int... lane>(std::integer_sequence<int, lane...>) __attribute__((always_inline)) {
    return __builtin_shufflevector(a, b, kLane(lane)...);
  }
  (std::make_integer_sequence<int, kLaneCount<Real>>());
}

/// 4 x 4 transposes, in each group of four lanes.
template <class Real>
[[gnu::always_inline]] inline Four<Real> transpose_fours(const Four<Real>& rows) {
  const Lanes<Real> ab_low = pick_in_fours<Real, 0, 4, 1, 5>(rows[0], rows[1]);
  const Lanes<Real> ab_high = pick_in_fours<Real, 2, 6, 3, 7>(rows[0], rows[1]);
  const Lanes<Real> cd_low = pick_in_fours<Real, 0, 4, 1, 5>(rows[2], rows[3]);
  const Lanes<Real> cd_high = pick_in_fours<Real, 2, 6, 3, 7>(rows[2], rows[3]);
  return {{pick_in_fours<Real, 0, 1, 4, 5>(ab_low, cd_low), pick_in_fours<Real, 2, 3, 6, 7>(ab_low, cd_low),
           pick_in_fours<Real, 0, 1, 4, 5>(ab_high, cd_high), pick_in_fours<Real, 2, 3, 6, 7>(ab_high, cd_high)}};
}

/// The fours at(first), at(first + 4), ... side by side, n numbers in all.
template <class Real, int n, class At>
[[gnu::always_inline]] inline Vector<Real, n> join(const At& at, int first) {
  if constexpr (n == 4) {
    return at(first);
  } else {
    const Vector<Real, n / 2> low = join<Real, n / 2>(at, first);
    const Vector<Real, n / 2> high = join<Real, n / 2>(at, first + n / 2);
    return [&]<int... lane>(std::integer_sequence<int, lane...>) __attribute__((always_inline)) {
      return __builtin_shufflevector(low, high, lane...);
    }
    (std::make_integer_sequence<int, n>());
  }
}

/// The four components of the rows at(0), at(1), ..., one a lane.
/// @param at  at(k): Vector<Real, 4>
template <class Real, class At>
[[gnu::always_inline]] inline Four<Real> components(const At& at) {
  constexpr int kCount = kLaneCount<Real>;
  if constexpr (kCount >= 4) {
    return transpose_fours<Real>(
        {{join<Real, kCount>(at, 0), join<Real, kCount>(at, 1), join<Real, kCount>(at, 2), join<Real, kCount>(at, 3)}});
  } else {
    Four<Real> result{};
    for (int k = 0; k < kCount; ++k) {
      const Vector<Real, 4> row = at(k);
      for (int i = 0; i < 4; ++i) result[i][k] = row[i];
    }
    return result;
  }
}

/// The way back: put(k, row) for each lane.
template <class Real, class Put>
[[gnu::always_inline]] inline void for_each_row(const Four<Real>& components, const Put& put) {
  constexpr int kCount = kLaneCount<Real>;
  if constexpr (kCount >= 4) {
    const Four<Real> rows = transpose_fours<Real>(components);
    unroll<kCount / 4>([&](auto group) __attribute__((always_inline)) {
      for (int i = 0; i < 4; ++i) {
        const Lanes<Real>& r = rows[i];
        put(4 * group + i, __builtin_shufflevector(r, r, 4 * group, 4 * group + 1, 4 * group + 2, 4 * group + 3));
      }
    });
  } else {
    for (int k = 0; k < kCount; ++k)
      put(k, Vector<Real, 4>{components[0][k], components[1][k], components[2][k], components[3][k]});
  }
}

}  // namespace
}  // namespace arap
