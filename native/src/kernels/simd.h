// SPDX-License-Identifier: GPL-3.0-or-later
// SIMD vectors by the vector extensions of GCC and Clang: + - * work lane by lane, and the compiler picks the
// instructions. For kernel sources only, which are compiled once per instruction set. These must not use inline
// functions of other headers, not even of the standard library: the linker keeps one copy of an inline function, and
// that copy may be compiled for an instruction set that the processor lacks. So everything here is in an unnamed
// namespace.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"  // GCC's bug 105593: a warning in this header
#include <immintrin.h>                            // intrinsics are always inlined
#pragma GCC diagnostic pop
#else
#include <immintrin.h>
#endif
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace arap {
namespace {

#if defined(__AVX512F__)
inline constexpr int kVectorBytes = 64;
#elif defined(__AVX__)
inline constexpr int kVectorBytes = 32;
#else
inline constexpr int kVectorBytes = 16;
#endif

template <class Number, int n>
struct VectorOf {
  using Type [[gnu::vector_size(sizeof(Number) * n)]] = Number;
  /// The same in memory, aligned like a number and allowed to alias arrays of numbers.
  using InMemory [[gnu::vector_size(sizeof(Number) * n), gnu::aligned(alignof(Number)), gnu::may_alias]] = Number;
};

template <class Number, int n>
using Vector = typename VectorOf<Number, n>::Type;

template <class Number, int n>
[[gnu::always_inline]] inline Vector<Number, n> load(const Number* p) {
  return *reinterpret_cast<const typename VectorOf<Number, n>::InMemory*>(p);
}

template <class Number, int n>
[[gnu::always_inline]] inline void store(Number* p, Vector<Number, n> v) {
  *reinterpret_cast<typename VectorOf<Number, n>::InMemory*>(p) = v;
}

/// IEEE half precision: 11 binary digits, up to 65504.
struct Half {
  std::uint16_t bits;
};

inline constexpr float kLargestHalf = 65504;

/// F16C converts vectors of halves, as does NEON of 64 bits; every processor with AVX2 has F16C.
#if defined(__F16C__) || defined(__aarch64__)
inline constexpr bool kHasHalf = true;

template <class Number, int n>
[[gnu::always_inline]] inline Vector<float, n> load_as_float(const Number* p) {
  if constexpr (sizeof(Number) == sizeof(float)) {
    return load<float, n>(p);
#if defined(__aarch64__)
  } else {
    static_assert(n == 4);
    return vcvt_f32_f16(vreinterpret_f16_u16(vld1_u16(&p->bits)));
  }
#else
  } else if constexpr (n == 4) {
    return _mm_cvtph_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
  } else if constexpr (n == 8) {
    return _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
  } else {
#if defined(__AVX512F__)
    return _mm512_cvtph_ps(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
#endif
  }
#endif
}

/// Rounds to nearest.
[[gnu::always_inline]] inline void store_four(Half* p, Vector<float, 4> v) {
#if defined(__aarch64__)
  vst1_u16(&p->bits, vreinterpret_u16_f16(vcvt_f16_f32(v)));
#else
  _mm_storel_epi64(reinterpret_cast<__m128i*>(p), _mm_cvtps_ph(v, 0));
#endif
}
#else
inline constexpr bool kHasHalf = false;

template <class Number, int n>
[[gnu::always_inline]] inline Vector<float, n> load_as_float(const Number* p) {
  return load<float, n>(p);
}
#endif

[[gnu::always_inline]] inline void store_four(float* p, Vector<float, 4> v) { store<float, 4>(p, v); }

/// Shuffles each group of four lanes by the same pattern: lane 4 g + i of the result is lane 4 g + p_i of a, or lane
/// 4 g + p_i - 4 of b if p_i >= 4.
template <int n, int p0, int p1, int p2, int p3, class Number = float>
[[gnu::always_inline]] inline Vector<Number, n> shuffle_fours(Vector<Number, n> a, Vector<Number, n> b) {
  constexpr auto kLane = [](int lane) {
    constexpr int kPattern[] = {p0, p1, p2, p3};
    const int p = kPattern[lane % 4];
    return lane / 4 * 4 + (p < 4 ? p : n + p - 4);
  };
  return [&]<int... lane>(std::integer_sequence<int, lane...>) __attribute__((always_inline)) {
    return __builtin_shufflevector(a, b, kLane(lane)...);
  }
  (std::make_integer_sequence<int, n>());
}

/// Repeats lane c of each group of four.
template <int n, int c>
[[gnu::always_inline]] inline Vector<float, n> spread(Vector<float, n> v) {
  return shuffle_fours<n, c, c, c, c>(v, v);
}

/// Transposes 4 x 4 numbers in each group of four lanes.
template <int n, class Number = float>
[[gnu::always_inline]] inline void transpose_fours(Vector<Number, n>& a, Vector<Number, n>& b, Vector<Number, n>& c,
                                                   Vector<Number, n>& d) {
  const Vector<Number, n> ab_low = shuffle_fours<n, 0, 4, 1, 5, Number>(a, b);
  const Vector<Number, n> ab_high = shuffle_fours<n, 2, 6, 3, 7, Number>(a, b);
  const Vector<Number, n> cd_low = shuffle_fours<n, 0, 4, 1, 5, Number>(c, d);
  const Vector<Number, n> cd_high = shuffle_fours<n, 2, 6, 3, 7, Number>(c, d);
  a = shuffle_fours<n, 0, 1, 4, 5, Number>(ab_low, cd_low);
  b = shuffle_fours<n, 2, 3, 6, 7, Number>(ab_low, cd_low);
  c = shuffle_fours<n, 0, 1, 4, 5, Number>(ab_high, cd_high);
  d = shuffle_fours<n, 2, 3, 6, 7, Number>(ab_high, cd_high);
}

/// Repeats the four numbers at p in each group of four.
template <int n>
[[gnu::always_inline]] inline Vector<float, n> repeat_four(const float* p) {
  const Vector<float, 4> v = load<float, 4>(p);
  if constexpr (n == 4) return v;
#if defined(__AVX__)
  if constexpr (n == 8) return _mm256_insertf128_ps(_mm256_castps128_ps256(v), v, 1);
#endif
#if defined(__AVX512F__)
  if constexpr (n == 16) return _mm512_broadcast_f32x4(v);
#endif
}

// Intrinsics join and split vectors: GCC 12 compiles __builtin_shufflevector between different widths to stores and a
// load, which stalls.

/// Concatenates two vectors of n / 2 numbers.
template <int n, class Number>
[[gnu::always_inline]] inline Vector<Number, n> join([[maybe_unused]] Vector<Number, n / 2> low,
                                                     [[maybe_unused]] Vector<Number, n / 2> high) {
#if defined(__AVX__)
  if constexpr (n == 8 && sizeof(Number) == 4) return _mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1);
#endif
#if defined(__AVX512F__)
  if constexpr (n == 16) return _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
  if constexpr (n == 8 && sizeof(Number) == 8) return _mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1);
#endif
}

/// The lower or upper half of a vector.
template <int n, bool is_upper>
[[gnu::always_inline]] inline Vector<float, n / 2> half([[maybe_unused]] Vector<float, n> v) {
  if constexpr (n == 4) return __builtin_shufflevector(v, v, 2 * is_upper, 2 * is_upper + 1);
#if defined(__AVX__)
  if constexpr (n == 8) return _mm256_extractf128_ps(v, is_upper);
#endif
#if defined(__AVX512F__)
  if constexpr (n == 16) return _mm512_extractf32x8_ps(v, is_upper);
#endif
}

/// Concatenates at(0), at(1), ... of four numbers each.
template <int n, int first = 0, class At>
[[gnu::always_inline]] inline Vector<float, n> join_fours(const At& at) {
  if constexpr (n == 4)
    return at(std::integral_constant<int, first>());
  else
    return join<n, float>(join_fours<n / 2, first>(at), join_fours<n / 2, first + n / 8>(at));
}

/// Group g of four lanes.
template <int n, int g, class Number = float>
[[gnu::always_inline]] inline Vector<Number, 4> four([[maybe_unused]] Vector<Number, n> v) {
  if constexpr (n == 4) return v;
#if defined(__AVX__)
  if constexpr (n == 8 && sizeof(Number) == 4) return _mm256_extractf128_ps(v, g);
#endif
#if defined(__AVX512F__)
  if constexpr (n == 16) return _mm512_extractf32x4_ps(v, g);
  if constexpr (n == 8 && sizeof(Number) == 8) return _mm512_extractf64x4_pd(v, g);
#endif
}

/// The sum of the groups of four.
template <int n>
[[gnu::always_inline]] inline Vector<float, 4> sum_of_fours(Vector<float, n> v) {
  if constexpr (n == 4)
    return v;
  else
    return sum_of_fours<n / 2>(half<n, false>(v) + half<n, true>(v));
}

/// Calls body(0), ..., body(n - 1) with constant arguments.
template <int n, class Body>
[[gnu::always_inline]] inline void unroll(const Body& body) {
  [&]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
    (body(std::integral_constant<int, i>()), ...);
  }
  (std::make_integer_sequence<int, n>());
}

}  // namespace
}  // namespace arap
