// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace arap {

/// The numbers of one supernode, as a solve streams through them.
///
/// With L = [L11; L21] the supernode's columns of the factor, stored is G = [L11^-1; -L21 L11^-1]. Then elimination is
/// one product, [y1; change of b2] = G b1, and back substitution its transpose, x1 = G^T [y1; x2]: there is no
/// dependence inside of a supernode, and the rounded G used in both makes the whole solve symmetric and positive
/// definite whatever the rounding.
///
/// G is padded with zeros to multiples of 4 and cut in tiles of 4 x 4, row-major; four rows of tiles are a strip.
/// Panels of kPanelTiles tiles side by side go from right to left, as elimination needs them in place. A panel begins
/// at its diagonal: its first strips are a triangle (strip i has i + 1 tiles), the others have all its tiles. Strip
/// after strip, so one pass reads G from the first number to the last, and the other one back.
struct TileSupernode {
  const void* tiles;  ///< of the format that the kernels are for
  /// 4 * n_strips places in x, of 4 floats each (x, y, z, 0): own columns, padding, rows, padding. Padding is a place
  /// that holds 0.
  const int* rows;
  int n_tiles;   ///< that the columns take
  int n_strips;  ///< that columns and rows take
};

inline constexpr int kTile = 4;
inline constexpr int kTileNumbers = kTile * kTile;
inline constexpr int kPanelTiles = 8;
inline constexpr int kPanelColumns = kPanelTiles * kTile;

[[nodiscard]] constexpr int panel_count(int n_tiles) { return (n_tiles + kPanelTiles - 1) / kPanelTiles; }

[[nodiscard]] constexpr int panel_width(int n_tiles, int panel) {
  const int left = n_tiles - panel * kPanelTiles;
  return left < kPanelTiles ? left : kPanelTiles;
}

/// Tiles before a strip of a panel; strips count from the panel's first one.
[[nodiscard]] constexpr size_t strip_offset(int width, int strip) {
  const auto w = static_cast<size_t>(width);
  const auto s = static_cast<size_t>(strip);
  return s < w ? s * (s + 1) / 2 : w * (w + 1) / 2 + (s - w) * w;
}

[[nodiscard]] constexpr size_t panel_size(int n_tiles, int n_strips, int panel) {
  return strip_offset(panel_width(n_tiles, panel), n_strips - panel * kPanelTiles);
}

/// Tiles of the panels to the right, which come first.
[[nodiscard]] constexpr size_t panel_offset(int n_tiles, int n_strips, int panel) {
  size_t offset = 0;
  for (int p = panel + 1; p < panel_count(n_tiles); ++p) offset += panel_size(n_tiles, n_strips, p);
  return offset;
}

[[nodiscard]] constexpr size_t tile_count(int n_tiles, int n_strips) { return panel_offset(n_tiles, n_strips, -1); }

/// How the numbers of tiles are stored. Halves are half as much to read, and reading is what a solve does; but they
/// make it right to two or three digits only, where floats give six.
enum class TileFormat { kFloat, kHalf };

/// Products with G for three right-hand sides. There is a set of them for each format that the processor converts.
struct TileKernels {
  size_t number_bytes;

  /// x[k] = (factor scaling[k] b[k], 0) for n rows of b (n, 3). Returns the largest absolute value, not
  /// finite if one is not.
  float (*read)(const double* b, const float* scaling, double factor, int n, float* x);
  /// b[k] = factor scaling[k] x[k] without the fourth.
  void (*write)(const float* x, const float* scaling, double factor, int n, double* b);

  /// Elimination with the supernodes of [begin, end), in ascending order: b1 becomes y1, b2 changes.
  void (*forward)(const TileSupernode* begin, const TileSupernode* end, float* x);
  /// Back substitution with the supernodes of [begin, end), in descending order: y1 becomes x1.
  void (*backward)(const TileSupernode* begin, const TileSupernode* end, float* x);

  // The same in parts, for several threads at one supernode. All pack b1 before any writes to x.
  /// @param packed  (3, 4 n_tiles), set: b1 by components
  void (*pack)(const TileSupernode& node, const float* x, float* packed);
  /// Writes the rows of the strips [begin, end) alone.
  void (*forward_strips)(const TileSupernode& node, int begin, int end, const float* packed, float* x);
  /// Sets `out` (4 kPanelTiles, 4) to the columns of one panel of x1; reads x alone.
  void (*backward_panel)(const TileSupernode& node, int panel, const float* x, float* out);
};

}  // namespace arap
