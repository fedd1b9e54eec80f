// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.
#include "kernels/front_kernels.h"

#include "kernels/simd.h"
#include "kernels/tile_kernels.h"

// Offsets within a supernode fit in an int.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

namespace arap {
namespace {

constexpr int kLanes = kVectorBytes / static_cast<int>(sizeof(double));
using Doubles = Vector<double, kLanes>;

[[gnu::always_inline]] inline double* at(const Front& front, int row, int column) {
  return front.values + row + static_cast<size_t>(front.stride) * static_cast<size_t>(column);
}

/// The 4 columns of B in C -= A B; strides allow B to be stored transposed.
struct Factor {
  const double* values;
  size_t inner_stride;   ///< from one row of B to the next
  size_t column_stride;  ///< from one column of B to the next
};

/// C -= A B for kVectors vectors of rows, `n_inner` columns of A and 4 columns of C.
template <int kVectors>
[[gnu::always_inline]] inline void subtract_product(const double* a, size_t a_stride, Factor b, int n_inner, double* c,
                                                    size_t c_stride) {
  Doubles sum[4][kVectors] = {};
  for (int k = 0; k < n_inner; ++k) {
    Doubles column[kVectors];
    unroll<kVectors>([&](auto v) __attribute__((always_inline)) { column[v] = load<double, kLanes>(a + v * kLanes); });
    unroll<4>([&](auto j) __attribute__((always_inline)) {
      const double factor = b.values[j * b.column_stride];
      unroll<kVectors>([&](auto v) __attribute__((always_inline)) { sum[j][v] += column[v] * factor; });
    });
    a += a_stride;
    b.values += b.inner_stride;
  }
  unroll<4>([&](auto j) __attribute__((always_inline)) {
    unroll<kVectors>([&](auto v) __attribute__((always_inline)) {
      double* p = c + j * c_stride + v * kLanes;
      store<double, kLanes>(p, load<double, kLanes>(p) - sum[j][v]);
    });
  });
}

/// C -= A B for `n_rows` rows, rounded up to whole vectors.
void subtract_product_of_rows(const double* a, size_t a_stride, Factor b, int n_inner, double* c, size_t c_stride,
                              int n_rows) {
  constexpr int kWide = kLanes == 2 ? 2 : 3;
  int r = 0;
  for (; r + (kWide - 1) * kLanes < n_rows; r += kWide * kLanes)
    subtract_product<kWide>(a + r, a_stride, b, n_inner, c + r, c_stride);
  for (; r < n_rows; r += kLanes) subtract_product<1>(a + r, a_stride, b, n_inner, c + r, c_stride);
}

/// Cholesky factorization of the 4 x 4 block at (j, j) in place, upper triangle 0; and the inverse, row-major.
bool factor_block(const Front& front, int j, const double* least_pivot, double* inverse) {
  for (int c = 0; c < 4; ++c) {
    double pivot = *at(front, j + c, j + c);
    for (int k = 0; k < c; ++k) pivot -= *at(front, j + c, j + k) * *at(front, j + c, j + k);
    if (!(pivot > least_pivot[c])) return false;  // also if it is NaN
    const double root = __builtin_sqrt(pivot);
    *at(front, j + c, j + c) = root;
    for (int r = c + 1; r < 4; ++r) {
      double value = *at(front, j + r, j + c);
      for (int k = 0; k < c; ++k) value -= *at(front, j + r, j + k) * *at(front, j + c, j + k);
      *at(front, j + r, j + c) = value / root;
      *at(front, j + c, j + r) = 0;
    }
  }
  for (int c = 3; c >= 0; --c) {
    for (int r = 0; r < c; ++r) inverse[4 * r + c] = 0;
    inverse[4 * c + c] = 1 / *at(front, j + c, j + c);
    for (int r = c + 1; r < 4; ++r) {
      double value = 0;
      for (int k = c; k < r; ++k) value -= *at(front, j + r, j + k) * inverse[4 * k + c];
      inverse[4 * r + c] = value * inverse[4 * r + r];
    }
  }
  return true;
}

/// Rows [begin, end) of 4 columns times the transposed inverse of their block: C L^-T.
void divide_by_transposed(double* c, size_t stride, const double* inverse, int n_rows) {
  for (int r = 0; r < n_rows; r += kLanes) {
    Doubles column[4];
    unroll<4>([&](auto j) __attribute__((always_inline)) { column[j] = load<double, kLanes>(c + r + j * stride); });
    unroll<4>([&](auto j) __attribute__((always_inline)) {
      Doubles value = column[0] * inverse[4 * j];
      unroll<j>([&](auto k) __attribute__((always_inline)) { value += column[k + 1] * inverse[4 * j + k + 1]; });
      store<double, kLanes>(c + r + j * stride, value);
    });
  }
}

/// The rows of 4 columns times the inverse of their block: C L^-1.
template <int kRows>
[[gnu::always_inline]] inline void divide(double* c, const double* inverse) {
  for (int r = 0; r < kRows; r += kLanes) {
    Doubles column[4];
    unroll<4>([&](auto j) __attribute__((always_inline)) { column[j] = load<double, kLanes>(c + r + j * kRows); });
    unroll<4>([&](auto j) __attribute__((always_inline)) {
      Doubles value = column[j] * inverse[4 * j + j];
      unroll<3 - j>([&](auto k)
                        __attribute__((always_inline)) { value += column[j + 1 + k] * inverse[4 * (j + 1 + k) + j]; });
      store<double, kLanes>(c + r + j * kRows, value);
    });
  }
}

bool factor_panel(const Front& front, int begin, int end, const double* least_pivot) {
  const auto stride = static_cast<size_t>(front.stride);
  for (int j = begin; j < end; j += 4) {
    subtract_product_of_rows(at(front, j, begin), stride, {at(front, j, begin), stride, 1}, j - begin, at(front, j, j),
                             stride, front.n_rows - j);
    double* inverse = front.inverses + 4 * j;
    if (!factor_block(front, j, least_pivot + j, inverse)) return false;
    divide_by_transposed(at(front, j + 4, j), stride, inverse, front.n_rows - j - 4);
  }
  return true;
}

void update_columns(const Front& front, int begin, int end, int target_begin, int target_end) {
  const auto stride = static_cast<size_t>(front.stride);
  for (int j = target_begin; j < target_end; j += 4)
    subtract_product_of_rows(at(front, j, begin), stride, {at(front, j, begin), stride, 1}, end - begin,
                             at(front, j, j), stride, front.n_rows - j);
}

/// Stores strip `strip` of G as tiles.
/// @param rows        (kFrontRowBlock, n_columns), column-major, rows of G from this strip on
/// @param n_own_rows  rows of F21 that are not padding
/// @param carry       (n_columns,) rounding error of the rows of F21 before; updated
template <class Number>
bool store_strip(const Front& front, int strip, int n_own_rows, const double* rows, double* carry, Number* tiles) {
  using Four = Vector<float, 4>;
  using FourDoubles = Vector<double, 4>;
  // Rows of this strip that belong to F21 and carry rounding errors.
  const int first = kTile * strip - front.n_columns;
  const int n_carrying = first < 0 ? 0 : n_own_rows - first < kTile ? n_own_rows - first : kTile;
  Four largest = {};
  const int n_tiles = front.n_columns / kTile;
  const int n_strips = front.n_rows / kTile;
  for (int p = panel_count(n_tiles) - 1; p >= 0; --p) {
    const int s = strip - p * kPanelTiles;
    const int width = panel_width(n_tiles, p);
    if (s >= 0) {
      Number* tile = tiles + strip_offset(width, s) * kTileNumbers;
      const double* columns = rows + p * kPanelColumns * kFrontRowBlock;
      double* lost = carry + p * kPanelColumns;
      for (int t = 0; t < width && t <= s;
           ++t, tile += kTileNumbers, columns += kTile * kFrontRowBlock, lost += kTile) {
        FourDoubles left = load<double, 4>(lost);
        for (int r = 0; r < kTile; ++r) {
          const FourDoubles exact = {columns[r], columns[kFrontRowBlock + r], columns[2 * kFrontRowBlock + r],
                                     columns[3 * kFrontRowBlock + r]};
          const FourDoubles wanted = r < n_carrying ? exact + left : exact;
          const Four value = __builtin_convertvector(wanted, Four);
          store_four(tile + kTile * r, value);
          if constexpr (sizeof(Number) < sizeof(float)) {
            const Four size = value < 0.0F ? -value : value;
            largest = size > largest ? size : largest;
            const Four stored = load_as_float<Number, 4>(tile + kTile * r);
            if (r < n_carrying) left = wanted - __builtin_convertvector(stored, FourDoubles);
          }
        }
        store<double, 4>(lost, left);
      }
    }
    tiles += panel_size(n_tiles, n_strips, p) * kTileNumbers;
  }
  if constexpr (sizeof(Number) < sizeof(float))
    return largest[0] <= kLargestHalf && largest[1] <= kLargestHalf && largest[2] <= kLargestHalf &&
           largest[3] <= kLargestHalf;
  return true;
}

/// G L11 = [I; -L21]: each row of G is an independent triangular solve, from the last column to the first.
template <class Number>
bool store_tiles(const Front& front, int n_own, int n_own_rows, int begin, int end, double* workspace, void* tiles) {
  static_assert(kFrontRowBlock % kLanes == 0);
  bool fits = true;
  double* carry = workspace + static_cast<size_t>(kFrontRowBlock) * static_cast<size_t>(front.n_columns);
  for (int c = 0; c < front.n_columns; ++c) carry[c] = 0;
  const auto stride = static_cast<size_t>(front.stride);
  for (int row = begin; row < end; row += kFrontRowBlock) {
    // Rows of L11^-1 end at the diagonal.
    const int n_columns = row + kFrontRowBlock < front.n_columns ? row + kFrontRowBlock : front.n_columns;
    for (int c = 0; c < n_columns; ++c) {
      for (int r = 0; r < kFrontRowBlock; ++r) {
        const bool is_in_triangle = row + r < front.n_columns;
        const double identity = row + r == c ? 1 : 0;
        workspace[c * kFrontRowBlock + r] = is_in_triangle ? identity : -*at(front, row + r, c);
      }
    }
    for (int j = n_columns - 4; j >= 0; j -= 4) {
      double* c = workspace + j * kFrontRowBlock;
      subtract_product<kFrontRowBlock / kLanes>(c + 4 * kFrontRowBlock, kFrontRowBlock,
                                                {at(front, j + 4, j), 1, stride}, n_columns - j - 4, c, kFrontRowBlock);
      divide<kFrontRowBlock>(c, front.inverses + 4 * j);
    }
    for (int c = n_own; c < n_columns; ++c)
      for (int r = 0; r < kFrontRowBlock; ++r) workspace[c * kFrontRowBlock + r] = 0;
    const int last = row + kFrontRowBlock < end ? row + kFrontRowBlock : end;
    for (int r = row; r < last; r += kTile)
      fits &= store_strip(front, r / kTile, n_own_rows, workspace + (r - row), carry, static_cast<Number*>(tiles));
  }
  return fits;
}

}  // namespace

namespace ARAP_ISA_NAMESPACE {

FrontKernels front_kernels();  // declared again in kernels.cpp
FrontKernels front_kernels() {
  FrontKernels result{factor_panel, update_columns, store_tiles<float>, nullptr};
  if constexpr (kHasHalf) result.store_half_tiles = store_tiles<Half>;
  return result;
}

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
