// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.
#include "kernels/tile_kernels.h"

#include "kernels/simd.h"

// Offsets within a supernode fit in an int.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

namespace arap {
namespace {

/// A vector holds kGroups rows of a tile; a tile has kVectors vectors.
constexpr int kLanes = kVectorBytes / static_cast<int>(sizeof(float));
constexpr int kGroups = kLanes / kTile;
constexpr int kVectors = kTile / kGroups;
using Floats = Vector<float, kLanes>;
using Four = Vector<float, 4>;

/// Right-hand sides; a place in x has one component more.
constexpr int kSides = 3;

/// Prefetch distance; a strip of a full panel has 512 bytes.
constexpr int kPrefetchBytes = 2048;

[[gnu::always_inline]] inline float* place(float* x, int row) { return x + size_t{kTile} * static_cast<size_t>(row); }
[[gnu::always_inline]] inline const float* place(const float* x, int row) {
  return x + size_t{kTile} * static_cast<size_t>(row);
}

/// packed[side * stride + column] for the columns at rows[0 .. 4 width).
[[gnu::always_inline]] inline void pack_columns(const int* rows, int width, const float* x, float* packed, int stride) {
  for (int t = 0; t < width; ++t) {
    Four a = load<float, 4>(place(x, rows[4 * t]));
    Four b = load<float, 4>(place(x, rows[4 * t + 1]));
    Four c = load<float, 4>(place(x, rows[4 * t + 2]));
    Four d = load<float, 4>(place(x, rows[4 * t + 3]));
    transpose_fours<4>(a, b, c, d);
    store<float, 4>(packed + 4 * t, a);
    store<float, 4>(packed + stride + 4 * t, b);
    store<float, 4>(packed + 2 * stride + 4 * t, c);
  }
}

/// The packed columns as the products need them: in registers if there are enough.
template <int width>
struct Columns {
  Columns(const float* packed, int side_stride) : memory(packed), stride(side_stride) {
    if constexpr (kInRegisters)
      unroll<width * kSides>([&](auto i) __attribute__((always_inline)) {
        values[i] = repeat_four<kLanes>(packed + i % kSides * stride + i / kSides * kTile);
      });
  }

  template <int tile, int side>
  [[gnu::always_inline]] [[nodiscard]] Floats get() const {
    if constexpr (kInRegisters)
      return values[tile * kSides + side];
    else
      return repeat_four<kLanes>(memory + side * stride + tile * kTile);
  }

  static constexpr bool kInRegisters = kLanes == 16;
  Floats values[kInRegisters ? width * kSides : 1] = {};
  const float* memory;
  int stride;
};

/// Prefetches the stream, once per cache line.
template <int tile, class Number>
[[gnu::always_inline]] inline void prefetch(const Number* tiles, int bytes_ahead) {
  constexpr int kTilesOfLine = 64 / (kTileNumbers * static_cast<int>(sizeof(Number)));
  if constexpr (tile % kTilesOfLine == 0)
    __builtin_prefetch(reinterpret_cast<const char*>(tiles + tile * kTileNumbers) + bytes_ahead);
}

/// The products of `count` tiles side by side with the columns: 4 rows (x, y, z, 0).
template <int count, int width, class Number>
[[gnu::always_inline]] inline void multiply_strip(const Number* tiles, const Columns<width>& columns, Four* result) {
  Floats sum[kVectors][kSides] = {};
  unroll<count>([&](auto t) __attribute__((always_inline)) {
    prefetch<t>(tiles, kPrefetchBytes);
    unroll<kVectors>([&](auto v) __attribute__((always_inline)) {
      const Floats w = load_as_float<Number, kLanes>(tiles + t * kTileNumbers + v * kLanes);
      sum[v][0] += w * columns.template get<t, 0>();
      sum[v][1] += w * columns.template get<t, 1>();
      sum[v][2] += w * columns.template get<t, 2>();
    });
  });
  unroll<kVectors>([&](auto v) __attribute__((always_inline)) {
    // Each group of four lanes is a row times four columns: sum over the columns, for the three sides at once.
    const Floats zero = {};
    const Floats xy = shuffle_fours<kLanes, 0, 4, 1, 5>(sum[v][0], sum[v][1]) +
                      shuffle_fours<kLanes, 2, 6, 3, 7>(sum[v][0], sum[v][1]);
    const Floats z =
        shuffle_fours<kLanes, 0, 4, 1, 5>(sum[v][2], zero) + shuffle_fours<kLanes, 2, 6, 3, 7>(sum[v][2], zero);
    const Floats rows = shuffle_fours<kLanes, 0, 1, 4, 5>(xy, z) + shuffle_fours<kLanes, 2, 3, 6, 7>(xy, z);
    unroll<kGroups>([&](auto g) __attribute__((always_inline)) { result[v * kGroups + g] = four<kLanes, g>(rows); });
  });
}

/// Strips [begin, end) of a panel: strips of the triangle set their rows, the others add to them.
/// @param tiles, rows  of the panel's first strip
template <int width, class Number>
void forward_panel(const Number* tiles, const int* rows, int begin, int end, const float* packed, int stride,
                   float* x) {
  const Columns<width> columns(packed, stride);
  unroll<width>([&](auto i) __attribute__((always_inline)) {
    if (i < begin || i >= end) return;
    Four result[kTile];
    multiply_strip<i + 1>(tiles + strip_offset(width, i) * kTileNumbers, columns, result);
    unroll<kTile>([&](auto r)
                      __attribute__((always_inline)) { store<float, 4>(place(x, rows[4 * i + r]), result[r]); });
  });
  const int first = begin > width ? begin : width;
  const Number* strip = tiles + strip_offset(width, first) * kTileNumbers;
  for (int s = first; s < end; ++s, strip += width * kTileNumbers) {
    Four result[kTile];
    multiply_strip<width>(strip, columns, result);
    unroll<kTile>([&](auto r) __attribute__((always_inline)) {
      float* p = place(x, rows[4 * s + r]);
      store<float, 4>(p, load<float, 4>(p) + result[r]);
    });
  }
}

/// Adds to sum[tile][side] the products of one strip's tiles [first, first + count) and its rows of x.
template <int first, int count, int available, class Number>
[[gnu::always_inline]] inline void multiply_transposed_strip(const Number* tiles, const int* rows, const float* x,
                                                             Floats (*sum)[kSides]) {
  unroll<kVectors>([&](auto v) __attribute__((always_inline)) {
    const Floats values = join_fours<kLanes>([&](auto g) __attribute__((always_inline)) {
      return load<float, 4>(place(x, rows[v * kGroups + g]));
    });
    const Floats x0 = spread<kLanes, 0>(values);
    const Floats x1 = spread<kLanes, 1>(values);
    const Floats x2 = spread<kLanes, 2>(values);
    unroll<(first + count <= available ? count
            : available > first        ? available - first
                                       : 0)>([&](auto t) __attribute__((always_inline)) {
      if constexpr (v == 0) prefetch<first + t>(tiles, -kPrefetchBytes);
      const Floats w = load_as_float<Number, kLanes>(tiles + (first + t) * kTileNumbers + v * kLanes);
      sum[t][0] += w * x0;
      sum[t][1] += w * x1;
      sum[t][2] += w * x2;
    });
  });
}

/// Columns of the tiles [first, first + count) of a panel; out (4 count, 4).
template <int width, int first, int count, class Number>
[[gnu::always_inline]] inline void backward_tiles(const Number* tiles, const int* rows, int n_strips, const float* x,
                                                  float* out) {
  Floats sum[count][kSides] = {};
  const Number* strip = tiles + strip_offset(width, n_strips) * kTileNumbers;
  for (int s = n_strips - 1; s >= width; --s) {
    strip -= width * kTileNumbers;
    multiply_transposed_strip<first, count, width>(strip, rows + 4 * s, x, sum);
  }
  unroll<width>([&](auto k) __attribute__((always_inline)) {
    constexpr int kStrip = width - 1 - k;
    if constexpr (kStrip >= first)
      multiply_transposed_strip<first, count, kStrip + 1>(tiles + strip_offset(width, kStrip) * kTileNumbers,
                                                          rows + 4 * kStrip, x, sum);
  });
  unroll<count>([&](auto t) __attribute__((always_inline)) {
    Four a = sum_of_fours<kLanes>(sum[t][0]);
    Four b = sum_of_fours<kLanes>(sum[t][1]);
    Four c = sum_of_fours<kLanes>(sum[t][2]);
    Four d = {};
    transpose_fours<4>(a, b, c, d);
    store<float, 4>(out + 16 * t, a);
    store<float, 4>(out + 16 * t + 4, b);
    store<float, 4>(out + 16 * t + 8, c);
    store<float, 4>(out + 16 * t + 12, d);
  });
}

/// @param tiles, rows  of the panel's first strip
template <int width, class Number>
void backward_panel_of(const Number* tiles, const int* rows, int n_strips, const float* x, float* out) {
  // Three sums per tile: 8 tiles fit in the 32 registers of AVX-512, 4 in the 16 of the others.
  constexpr int kAtOnce = kLanes == 16 ? 8 : 4;
  if constexpr (width > kAtOnce) {
    backward_tiles<width, kAtOnce, width - kAtOnce>(tiles, rows, n_strips, x, out + 16 * kAtOnce);
    backward_tiles<width, 0, kAtOnce>(tiles, rows, n_strips, x, out);
  } else {
    backward_tiles<width, 0, width>(tiles, rows, n_strips, x, out);
  }
}

/// Calls call(width) with the width as a constant.
template <class Call>
[[gnu::always_inline]] inline void with_width(int width, const Call& call) {
  static_assert(kPanelTiles == 8);
  switch (width) {
    case 1:
      return call(std::integral_constant<int, 1>());
    case 2:
      return call(std::integral_constant<int, 2>());
    case 3:
      return call(std::integral_constant<int, 3>());
    case 4:
      return call(std::integral_constant<int, 4>());
    case 5:
      return call(std::integral_constant<int, 5>());
    case 6:
      return call(std::integral_constant<int, 6>());
    case 7:
      return call(std::integral_constant<int, 7>());
    default:
      return call(std::integral_constant<int, 8>());
  }
}

/// Calls call(panel, its width, its first tile) from right to left.
template <class Number, class Call>
[[gnu::always_inline]] inline void for_panels_in_stream_order(const TileSupernode& node, const Call& call) {
  const auto* tiles = static_cast<const Number*>(node.tiles);
  for (int p = panel_count(node.n_tiles) - 1; p >= 0; --p) {
    call(p, panel_width(node.n_tiles, p), tiles);
    tiles += panel_size(node.n_tiles, node.n_strips, p) * kTileNumbers;
  }
}

template <class Number>
void forward(const TileSupernode* begin, const TileSupernode* end, float* x) {
  alignas(64) float packed[kSides * kPanelColumns];
  for (const TileSupernode* node = begin; node != end; ++node) {
    for_panels_in_stream_order<Number>(
        *node, [&](int p, int width, const Number* tiles) __attribute__((always_inline)) {
          const int* rows = node->rows + p * kPanelColumns;
          pack_columns(rows, width, x, packed, kPanelColumns);
          with_width(
              width, [&](auto w) __attribute__((always_inline)) {
                forward_panel<w>(tiles, rows, 0, node->n_strips - p * kPanelTiles, packed, kPanelColumns, x);
              });
        });
  }
}

template <class Number>
void backward_panel(const TileSupernode& node, int panel, const float* x, float* out) {
  const auto* tiles =
      static_cast<const Number*>(node.tiles) + panel_offset(node.n_tiles, node.n_strips, panel) * kTileNumbers;
  with_width(
      panel_width(node.n_tiles, panel), [&](auto w) __attribute__((always_inline)) {
        backward_panel_of<w>(tiles, node.rows + panel * kPanelColumns, node.n_strips - panel * kPanelTiles, x, out);
      });
}

template <class Number>
void backward(const TileSupernode* begin, const TileSupernode* end, float* x) {
  alignas(64) float out[kPanelColumns * kTile];
  for (const TileSupernode* node = end; node != begin;) {
    --node;
    for (int p = 0; p < panel_count(node->n_tiles); ++p) {
      backward_panel<Number>(*node, p, x, out);
      const int* rows = node->rows + p * kPanelColumns;
      // Padding gets 0: its columns of G are 0.
      for (int i = 0; i < panel_width(node->n_tiles, p) * kTile; ++i)
        store<float, 4>(place(x, rows[i]), load<float, 4>(out + 4 * i));
    }
  }
}

void pack(const TileSupernode& node, const float* x, float* packed) {
  pack_columns(node.rows, node.n_tiles, x, packed, kTile * node.n_tiles);
}

template <class Number>
void forward_strips(const TileSupernode& node, int begin, int end, const float* packed, float* x) {
  for_panels_in_stream_order<Number>(
      node, [&](int p, int width, const Number* tiles) __attribute__((always_inline)) {
        const int first = begin > p * kPanelTiles ? begin - p * kPanelTiles : 0;
        const int last = end - p * kPanelTiles;
        if (first >= last) return;
        with_width(
            width, [&](auto w) __attribute__((always_inline)) {
              forward_panel<w>(tiles, node.rows + p * kPanelColumns, first, last, packed + p * kPanelColumns,
                               kTile * node.n_tiles, x);
            });
      });
}

/// (factor b[0], factor b[1], factor b[2], 0).
/// @param has_next  b[3] may be read
[[gnu::always_inline]] inline Four to_place(const double* b, double factor, [[maybe_unused]] bool has_next) {
#if defined(__AVX__)
  using Doubles = Vector<double, 4>;
  Doubles row = {b[0], b[1], b[2], 0};
  if (has_next) row = load<double, 4>(b) * Doubles{1, 1, 1, 0};
  return __builtin_convertvector(row * factor, Four);
#else
  return Four{static_cast<float>(factor * b[0]), static_cast<float>(factor * b[1]), static_cast<float>(factor * b[2]),
              0};
#endif
}

float read(const double* b, const float* scaling, double factor, int n, float* x) {
  using Bits = Vector<int, 4>;
  constexpr Bits kNoSign = {0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff};
  // Positive floats sort like their bits; infinity and NaN are the largest.
  Bits largest = {};
  for (int k = 0; k < n; ++k, b += 3, x += 4) {
    const Four value = to_place(b, factor * static_cast<double>(scaling[k]), k + 1 < n);
    const Bits size = reinterpret_cast<Bits>(value) & kNoSign;
    largest = size > largest ? size : largest;
    store<float, 4>(x, value);
  }
  const int x_y = largest[0] > largest[1] ? largest[0] : largest[1];
  return __builtin_bit_cast(float, x_y > largest[2] ? x_y : largest[2]);
}

void write(const float* x, const float* scaling, double factor, int n, double* b) {
  for (int k = 0; k < n; ++k, b += 3, x += 4) {
    const double f = factor * static_cast<double>(scaling[k]);
#if defined(__AVX__)
    // The next row overwrites the fourth number.
    if (k + 1 < n) {
      store<double, 4>(b, __builtin_convertvector(load<float, 4>(x), Vector<double, 4>) * f);
      continue;
    }
#endif
    for (int d = 0; d < 3; ++d) b[d] = f * static_cast<double>(x[d]);
  }
}

template <class Number>
TileKernels kernels_for() {
  return {sizeof(Number),        read, write, forward<Number>, backward<Number>, pack, forward_strips<Number>,
          backward_panel<Number>};
}

}  // namespace

namespace ARAP_ISA_NAMESPACE {

TileKernels tile_kernels();  // declared again in kernels.cpp
TileKernels tile_kernels() { return kernels_for<float>(); }

TileKernels half_tile_kernels();
TileKernels half_tile_kernels() {
  if constexpr (kHasHalf) return kernels_for<Half>();
  return {};
}

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
