// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/tile_solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "base/processor.h"

namespace arap {

namespace {

/// Supernodes with more tiles than this, some microseconds of work, are shared by all threads.
constexpr size_t kSharedTiles = 6000;

/// Parts of a shared supernode.
constexpr int kPiecesPerThread = 4;

bool is_shared(const TileSupernode& node) { return tile_count(node.n_tiles, node.n_strips) > kSharedTiles; }

/// Rows of b that are permuted at a time.
constexpr int kRows = 64;
using Rows = std::array<double, size_t{3} * kRows>;

}  // namespace

TileFactorization::Workspace::Workspace(const TilePlan& plan)
    : x(size_t{kTile} * static_cast<size_t>(plan.n_places)), largest(plan.partition.subtrees.size() + 1) {
  int n_columns = 0;
  for (const int s : plan.partition.root_part) n_columns = std::max(n_columns, plan.structure.supernodes[s].n_columns);
  // b1 packed has 3 numbers a column, x1 by panels has 4 and is padded to panels.
  const auto panels = static_cast<size_t>(panel_count(tiles_for(n_columns)));
  packed = AlignedBuffer<float>(size_t{kTile} * kPanelColumns * panels);
}

TileFactorization::TileFactorization(std::shared_ptr<const TilePlan> plan, Workers workers, const TileKernels& kernels,
                                     AlignedBuffer<std::byte> tiles, const Scaling& scaling)
    : plan_(std::move(plan)),
      workers_(std::move(workers)),
      kernels_(kernels),
      tiles_(std::move(tiles)),
      scale_(scaling.of_all) {
  const auto& supernodes = plan_->structure.supernodes;
  supernodes_.reserve(supernodes.size());
  for (size_t s = 0; s < supernodes.size(); ++s) {
    const int n_tiles = tiles_for(supernodes[s].n_columns);
    supernodes_.push_back({tiles_.data() + kernels_.number_bytes * kTileNumbers * plan_->tile_offsets[s],
                           plan_->rows.data() + plan_->rows_offsets[s], n_tiles,
                           n_tiles + tiles_for(supernodes[s].n_rows)});
  }
  scaling_.reserve(plan_->structure.ordering.size());
  for (const int i : plan_->structure.ordering) scaling_.push_back(scaling.of_each[i]);
}

void TileFactorization::solve(const Positions& b, const Change& change, Positions& x) const {
  std::unique_ptr<Workspace> work;
  {
    const std::scoped_lock lock(mutex_);
    if (!idle_.empty()) {
      work = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (work == nullptr) work = std::make_unique<Workspace>(*plan_);
  x.resize(b.rows(), 3);
  solve_with(b, change, x, *work);
  const std::scoped_lock lock(mutex_);
  idle_.push_back(std::move(work));
}

void TileFactorization::solve_with(const Positions& b, const Change& change, Positions& x, Workspace& work) const {
  // Nearly every b fits well in the range of a float. Others are scaled by powers of two, which keep the digits.
  constexpr double kSmallest = 0x1p-40;
  constexpr double kLargestReached = 0x1p40;
  double into = scale_;
  const double reached = eliminate_subtrees(b, into, work);
  if (!(reached >= kSmallest && reached <= kLargestReached)) {
    // 0 * x is NaN if x is not finite.
    const double largest = b.size() == 0 ? 0 : b.cwiseAbs().maxCoeff() + (0 * b).sum();
    if ((largest == 0 && !change) || !std::isfinite(largest)) {
      x.setConstant(largest == 0 ? 0 : std::numeric_limits<double>::quiet_NaN());
      return;
    }
    into = largest == 0 ? 0 : std::exp2(-std::ilogb(largest));
    static_cast<void>(eliminate_subtrees(b, into, work));
  }
  eliminate_root_part(work);
  if (change) into = scale_ * change(work.x.data(), into / scale_);
  substitute_root_part(work);
  substitute_subtrees(x, scale_ * (scale_ / into), work);
}

double TileFactorization::eliminate_subtrees(const Positions& b, double factor, Workspace& work) const {
  const auto n_subtrees = static_cast<int>(plan_->partition.subtrees.size());
  workers_.run(n_subtrees, [&](int i) {
    const FlushToZero mode;
    const Subtree& subtree = plan_->partition.subtrees[i];
    work.largest[i] = static_cast<double>(read_columns(b, factor, subtree.begin, subtree.end, work.x.data()));
    forward_subtree(i, work.x.data());
  });
  double& of_root_part = work.largest[n_subtrees] = 0;
  for (const int s : plan_->partition.root_part)
    of_root_part += static_cast<double>(read_columns(b, factor, s, s + 1, work.x.data()));
  // A sum instead of the maximum: it keeps NaN.
  return std::accumulate(work.largest.begin(), work.largest.end(), 0.0);
}

void TileFactorization::eliminate_root_part(Workspace& work) const {
  const FlushToZero mode;
  float* x = work.x.data();
  std::fill_n(x + size_t{kTile} * plan_->first_padding, 2 * kTile, 0.0F);
  for (const TilePlan::Copies& copies : plan_->copies) collect(copies, x);
  for (const int s : plan_->partition.root_part) {
    const TileSupernode& node = supernodes_[s];
    if (is_shared(node) && workers_.threads() > 1)
      forward_shared(node, work);
    else
      kernels_.forward(&node, &node + 1, x);
  }
}

void TileFactorization::substitute_root_part(Workspace& work) const {
  const FlushToZero mode;
  float* x = work.x.data();
  const auto& root_part = plan_->partition.root_part;
  for (size_t k = root_part.size(); k-- > 0;) {
    const TileSupernode& node = supernodes_[root_part[k]];
    if (is_shared(node) && workers_.threads() > 1)
      backward_shared(node, work);
    else
      kernels_.backward(&node, &node + 1, x);
  }
}

void TileFactorization::substitute_subtrees(Positions& x, double factor, Workspace& work) const {
  for (const int s : plan_->partition.root_part) write_columns(x, factor, s, s + 1, work.x.data());
  workers_.run(static_cast<int>(plan_->partition.subtrees.size()), [&](int i) {
    const FlushToZero mode;
    const Subtree& subtree = plan_->partition.subtrees[i];
    backward_subtree(i, work.x.data());
    write_columns(x, factor, subtree.begin, subtree.end, work.x.data());
  });
}

float TileFactorization::read_columns(const Positions& b, double factor, int first, int last, float* x) const {
  const int begin = plan_->structure.supernodes[first].first_column;
  const int end = plan_->structure.supernodes[last - 1].end_column();
  const float* scaling = scaling_.data();
  if (plan_->has_identity_ordering)
    return kernels_.read(b.data() + 3 * static_cast<std::ptrdiff_t>(begin), scaling + begin, factor, end - begin,
                         x + 4 * static_cast<std::ptrdiff_t>(begin));
  float largest = 0;
  Rows rows;
  for (int k = begin; k < end; k += kRows) {
    const int n = std::min(kRows, end - k);
    for (int i = 0; i < n; ++i)
      std::copy_n(b.data() + 3 * static_cast<std::ptrdiff_t>(plan_->structure.ordering[k + i]), 3,
                  rows.data() + size_t{3} * i);
    largest += kernels_.read(rows.data(), scaling + k, factor, n, x + 4 * static_cast<std::ptrdiff_t>(k));
  }
  return largest;
}

void TileFactorization::write_columns(Positions& result, double factor, int first, int last, const float* x) const {
  const int begin = plan_->structure.supernodes[first].first_column;
  const int end = plan_->structure.supernodes[last - 1].end_column();
  const float* scaling = scaling_.data();
  if (plan_->has_identity_ordering) {
    kernels_.write(x + 4 * static_cast<std::ptrdiff_t>(begin), scaling + begin, factor, end - begin,
                   result.data() + 3 * static_cast<std::ptrdiff_t>(begin));
    return;
  }
  Rows rows;
  for (int k = begin; k < end; k += kRows) {
    const int n = std::min(kRows, end - k);
    kernels_.write(x + 4 * static_cast<std::ptrdiff_t>(k), scaling + k, factor, n, rows.data());
    for (int i = 0; i < n; ++i)
      std::copy_n(rows.data() + size_t{3} * i, 3,
                  result.data() + 3 * static_cast<std::ptrdiff_t>(plan_->structure.ordering[k + i]));
  }
}

void TileFactorization::forward_subtree(int index, float* x) const {
  const TilePlan::Copies& copies = plan_->copies[index];
  std::fill_n(x + size_t{kTile} * copies.first_place, kTile * copies.columns.size(), 0.0F);
  std::fill_n(x + size_t{kTile} * (plan_->first_padding + 2 * (index + 1)), 2 * kTile, 0.0F);
  const Subtree& subtree = plan_->partition.subtrees[index];
  kernels_.forward(supernodes_.data() + subtree.begin, supernodes_.data() + subtree.end, x);
}

void TileFactorization::backward_subtree(int index, float* x) const {
  const TilePlan::Copies& copies = plan_->copies[index];
  for (size_t k = 0; k < copies.columns.size(); ++k)
    std::copy_n(x + size_t{kTile} * copies.columns[k], kTile, x + size_t{kTile} * (copies.first_place + k));
  const Subtree& subtree = plan_->partition.subtrees[index];
  kernels_.backward(supernodes_.data() + subtree.begin, supernodes_.data() + subtree.end, x);
}

void TileFactorization::collect(const TilePlan::Copies& copies, float* x) {
  const float* from = x + size_t{kTile} * copies.first_place;
  for (const int column : copies.columns)
    for (int d = 0; d < kTile; ++d) x[size_t{kTile} * column + d] += *from++;
}

void TileFactorization::eliminate_along(std::span<const int> path, float* x) const {
  const FlushToZero mode;
  const auto from = [&](int s) { return std::lower_bound(path.begin(), path.end(), s); };
  const auto& subtrees = plan_->partition.subtrees;
  for (size_t i = 0; i < subtrees.size(); ++i) {
    const auto end = from(subtrees[i].end);
    auto next = from(subtrees[i].begin);
    if (next == end) continue;
    while (next != end) {
      const auto first = next++;
      while (next != end && *next == *(next - 1) + 1) ++next;
      kernels_.forward(supernodes_.data() + *first, supernodes_.data() + *(next - 1) + 1, x);
    }
    const TilePlan::Copies& copies = plan_->copies[i];
    collect(copies, x);
    std::fill_n(x + size_t{kTile} * copies.first_place, kTile * copies.columns.size(), 0.0F);
  }
  for (const int s : plan_->partition.root_part)
    if (std::binary_search(path.begin(), path.end(), s)) kernels_.forward(&supernodes_[s], &supernodes_[s] + 1, x);
}

void TileFactorization::forward_shared(const TileSupernode& node, Workspace& work) const {
  float* x = work.x.data();
  kernels_.pack(node, x, work.packed.data());
  const int pieces = std::min(node.n_strips, kPiecesPerThread * workers_.threads());
  workers_.run(pieces, [&](int piece) {
    const FlushToZero mode;
    const auto begin_of = [&](int p) { return static_cast<int>(std::int64_t{node.n_strips} * p / pieces); };
    kernels_.forward_strips(node, begin_of(piece), begin_of(piece + 1), work.packed.data(), x);
  });
}

void TileFactorization::backward_shared(const TileSupernode& node, Workspace& work) const {
  float* x = work.x.data();
  float* out = work.packed.data();
  workers_.run(panel_count(node.n_tiles), [&](int p) {
    const FlushToZero mode;
    kernels_.backward_panel(node, p, x, out + size_t{kTile} * kPanelColumns * p);
  });
  for (int c = 0; c < kTile * node.n_tiles; ++c)
    std::copy_n(out + size_t{kTile} * c, kTile, x + size_t{kTile} * node.rows[c]);
}

}  // namespace arap
