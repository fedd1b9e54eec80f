// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace arap {

/// The stored numbers of one supernode.
///
/// Stored is G = [L11^-1; -L21 L11^-1] of the supernode's columns L = [L11; L21]. So elimination is one product,
/// [y1; change of b2] = G b1, and back substitution its transpose, x1 = G^T [y1; x2]: without dependences within the
/// supernode. Both use the same rounded G, so the whole solve is symmetric and positive definite whatever the rounding.
///
/// G is padded with zeros to multiples of 4 and cut into tiles of 4 x 4, row-major; a row of tiles is a strip. Panels
/// of kPanelTiles columns of tiles are stored from right to left, as elimination in place needs them. A panel begins at
/// its diagonal: its first strips are a triangle (strip i has i + 1 tiles), the others have all its tiles. Strips are
/// stored one after the other: elimination reads G from the first number to the last, back substitution backwards.
struct TileSupernode {
  const void* tiles;  ///< in the kernels' format
  /// (4 n_strips,) places in x, of 4 floats each (x, y, z, 0): own columns, padding, rows, padding. Places of padding
  /// hold 0.
  const int* rows;
  int n_tiles;   ///< for the columns
  int n_strips;  ///< for columns and rows
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

/// Number of tiles before a strip of a panel; strips count from the panel's first one.
[[nodiscard]] constexpr size_t strip_offset(int width, int strip) {
  const auto w = static_cast<size_t>(width);
  const auto s = static_cast<size_t>(strip);
  return s < w ? s * (s + 1) / 2 : w * (w + 1) / 2 + (s - w) * w;
}

[[nodiscard]] constexpr size_t panel_size(int n_tiles, int n_strips, int panel) {
  return strip_offset(panel_width(n_tiles, panel), n_strips - panel * kPanelTiles);
}

/// Number of tiles before a panel: those of the panels to its right.
[[nodiscard]] constexpr size_t panel_offset(int n_tiles, int n_strips, int panel) {
  size_t offset = 0;
  for (int p = panel + 1; p < panel_count(n_tiles); ++p) offset += panel_size(n_tiles, n_strips, p);
  return offset;
}

[[nodiscard]] constexpr size_t tile_count(int n_tiles, int n_strips) { return panel_offset(n_tiles, n_strips, -1); }

/// Number format of tiles. Halves make a solve faster, which is bound by memory bandwidth, but give two or three digits
/// instead of six.
enum class TileFormat { kFloat, kHalf };

/// Products with G for three right-hand sides, in one format.
struct TileKernels {
  size_t number_bytes;

  /// x[k] = (factor scaling[k] b[k], 0) for n rows of b (n, 3). Returns the largest absolute value; not finite if one
  /// is not.
  float (*read)(const double* b, const float* scaling, double factor, int n, float* x);
  /// b[k] = factor scaling[k] x[k] without the fourth component.
  void (*write)(const float* x, const float* scaling, double factor, int n, double* b);

  /// Elimination with the supernodes of [begin, end), in ascending order: b1 becomes y1, b2 changes.
  void (*forward)(const TileSupernode* begin, const TileSupernode* end, float* x);
  /// Back substitution with the supernodes of [begin, end), in descending order: y1 becomes x1.
  void (*backward)(const TileSupernode* begin, const TileSupernode* end, float* x);

  // The same in parts, for several threads at one supernode. pack() must end before any thread writes to x.
  /// @param packed  (3, 4 n_tiles) output: b1 by components
  void (*pack)(const TileSupernode& node, const float* x, float* packed);
  /// Writes only the rows of the strips [begin, end).
  void (*forward_strips)(const TileSupernode& node, int begin, int end, const float* packed, float* x);
  /// Sets `out` (4 kPanelTiles, 4) to x1 of the columns of one panel; does not write to x.
  void (*backward_panel)(const TileSupernode& node, int panel, const float* x, float* out);
};

}  // namespace arap
