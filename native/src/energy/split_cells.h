// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "energy/cells.h"
#include "parallel/meter.h"

namespace arap {

/// What the cells of an energy are sums of: terms of few vertices each, of which none is negative.
class CellTerms {
 public:
  class Reader {
   public:
    /// Takes what a term of these vertices adds to the rest vector at one of them, in the cell with this home.
    using Use = std::function<void(std::span<const int> vertices, int home, const Vector3& q)>;

    Reader() = default;
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    virtual ~Reader() = default;
    /// All terms of a vertex. Several threads may call it.
    virtual void read(int vertex, const Use& use) const = 0;
  };

  CellTerms() = default;
  CellTerms(const CellTerms&) = delete;
  CellTerms& operator=(const CellTerms&) = delete;
  virtual ~CellTerms() = default;
  /// Takes time and memory as a part of a bind does.
  [[nodiscard]] virtual std::unique_ptr<const Reader> open() const = 0;
};

/// Cells where held vertices cut the others into parts. A cell that has vertices of several parts becomes one of each,
/// with a rotation of its own, so that no part turns another one. A term goes to the cell of its part. What has held
/// vertices only is shared among the cells by how much these have of the surface. So the sum of all stays, and K with
/// it.
struct SplitCells {
  Cells cells;               ///< those that there were, with their numbers, then further ones
  std::vector<int> origins;  ///< of each further one: the cell that it was a part of
};

/// @param parts      (n,) of each vertex, -1 = held. No term has vertices of two parts
/// @param is_member  (n,) of a rigid region, or empty: the home of a further cell is none if it has another vertex of
///                   its part; a cell at home at a held member turns with the region as it is
/// @param meter      is asked now and then
/// @return  null if no cell has vertices of two parts
[[nodiscard]] std::unique_ptr<SplitCells> split_cells(const Cells& cells, const CellTerms& terms, const Positions& rest,
                                                      const std::vector<int>& parts, const std::vector<char>& is_member,
                                                      int threads, const MeterPart& meter = {});

}  // namespace arap
