// SPDX-License-Identifier: GPL-3.0-or-later
// Structure-of-arrays vectors: lane k holds a component of the k-th of many small objects. For kernel sources only, see
// simd.h.
#pragma once

#include "kernels/simd.h"

namespace arap {
namespace {

template <class Real>
inline constexpr int kLaneCount = kVectorBytes / static_cast<int>(sizeof(Real));

template <class Real>
using Lanes = Vector<Real, kLaneCount<Real>>;

/// Four components of one object per lane.
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

/// Compilers have no built-in square root of vectors.
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
#elif defined(__aarch64__)
  if constexpr (kIsSingle)
    return vsqrtq_f32(value);
  else
    return vsqrtq_f64(value);
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

/// Result of a comparison: all bits of a lane set, or none.
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
#elif defined(__aarch64__)
  // Each lane keeps its bit; the lanes are added.
  if constexpr (kIsSingle)
    return vaddvq_u32(reinterpret_cast<uint32x4_t>(mask & Mask<Real>{1, 2, 4, 8}));
  else
    return static_cast<unsigned>(vaddvq_u64(reinterpret_cast<uint64x2_t>(mask & Mask<Real>{1, 2})));
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
      low_ += __builtin_convertvector(half<kLaneCount<float>, false>(value), Lanes<double>);
      high_ += __builtin_convertvector(half<kLaneCount<float>, true>(value), Lanes<double>);
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

/// Transposes 4 x 4 numbers in each group of four lanes.
template <class Real>
[[gnu::always_inline]] inline Four<Real> transposed(Four<Real> rows) {
  transpose_fours<kLaneCount<Real>, Real>(rows[0], rows[1], rows[2], rows[3]);
  return rows;
}

/// Concatenates at(first), at(first + 4), ... of four numbers each, n numbers in all.
template <class Real, int n, class At>
[[gnu::always_inline]] inline Vector<Real, n> every_fourth(const At& at, int first) {
  if constexpr (n == 4)
    return at(first);
  else
    return join<n, Real>(every_fourth<Real, n / 2>(at, first), every_fourth<Real, n / 2>(at, first + n / 2));
}

/// The four components of the rows at(0), at(1), ...; row k in lane k.
/// @param at  at(k): Vector<Real, 4>
template <class Real, class At>
[[gnu::always_inline]] inline Four<Real> components(const At& at) {
  constexpr int kCount = kLaneCount<Real>;
  if constexpr (kCount >= 4) {
    return transposed<Real>({{every_fourth<Real, kCount>(at, 0), every_fourth<Real, kCount>(at, 1),
                              every_fourth<Real, kCount>(at, 2), every_fourth<Real, kCount>(at, 3)}});
  } else {
    Four<Real> result{};
    for (int k = 0; k < kCount; ++k) {
      const Vector<Real, 4> row = at(k);
      for (int i = 0; i < 4; ++i) result[i][k] = row[i];
    }
    return result;
  }
}

/// The inverse of components(): calls put(k, row) for each lane.
template <class Real, class Put>
[[gnu::always_inline]] inline void for_each_row(const Four<Real>& components, const Put& put) {
  constexpr int kCount = kLaneCount<Real>;
  if constexpr (kCount >= 4) {
    const Four<Real> rows = transposed<Real>(components);
    unroll<kCount / 4>([&](auto group) __attribute__((always_inline)) {
      for (int i = 0; i < 4; ++i) put(4 * group + i, four<kCount, group, Real>(rows[i]));
    });
  } else {
    for (int k = 0; k < kCount; ++k)
      put(k, Vector<Real, 4>{components[0][k], components[1][k], components[2][k], components[3][k]});
  }
}

}  // namespace
}  // namespace arap
