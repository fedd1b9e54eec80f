// SPDX-License-Identifier: GPL-3.0-or-later
#include "tile_solve.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

namespace arap {

namespace {

/// Supernodes with more tiles than this are worth two barriers.
constexpr size_t kSharedTiles = 600;

bool is_shared(const TileSupernode& node) { return tile_count(node.n_tiles, node.n_strips) > kSharedTiles; }

/// visit(column, the unknown that it is) for the columns [begin, end): without indirection where they are the same.
template <class Visit>
void for_unknowns(const TilePlan& plan, int begin, int end, const Visit& visit) {
  if (plan.is_in_order) {
    for (int k = begin; k < end; ++k) visit(k, k);
  } else {
    const int* order = plan.structure.order.data();
    for (int k = begin; k < end; ++k) visit(k, order[k]);
  }
}

}  // namespace

TileFactorization::Workspace::Workspace(const TilePlan& plan)
    : x(size_t{kTile} * static_cast<size_t>(plan.n_places)), largest(plan.n_threads) {
  int n_columns = 0;
  for (const int s : plan.partition.top) n_columns = std::max(n_columns, plan.structure.supernodes[s].n_columns);
  // b1 packed has 3 numbers a column, x1 by panels has 4 and is padded to panels.
  const auto panels = static_cast<size_t>(panel_count(tiles_for(n_columns)));
  for (int t = 0; t < plan.n_threads; ++t) of_thread.emplace_back(kTile * kPanelColumns * panels);
}

TileFactorization::TileFactorization(std::shared_ptr<const TilePlan> plan, const TileKernels& kernels,
                                     AlignedBuffer<float> tiles, const std::vector<char>& is_erased, double scale)
    : plan_(std::move(plan)), kernels_(kernels), tiles_(std::move(tiles)), scale_(scale) {
  const auto& supernodes = plan_->structure.supernodes;
  supernodes_.reserve(supernodes.size());
  for (size_t s = 0; s < supernodes.size(); ++s) {
    const int n_tiles = tiles_for(supernodes[s].n_columns);
    supernodes_.push_back({tiles_.data() + size_t{kTileNumbers} * plan_->tile_offsets[s],
                           plan_->rows.data() + plan_->rows_offsets[s], n_tiles,
                           n_tiles + tiles_for(supernodes[s].n_rows)});
  }
  is_erased_.reserve(plan_->structure.order.size());
  for (const int i : plan_->structure.order) is_erased_.push_back(is_erased[i]);
}

void TileFactorization::solve(Positions& b) const {
  std::unique_ptr<Workspace> work;
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      work = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (work == nullptr) work = std::make_unique<Workspace>(*plan_);
  work->next_forward = 0;
  work->next_backward = 0;
  run_team(plan_->n_threads, [&](const Team& team) { solve_in_team(team, b, *work); });
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(work));
}

void TileFactorization::solve_in_team(const Team& team, Positions& b, Workspace& work) const {
  const int n = plan_->n_columns();
  float* x = work.x.data();
  work.largest[team.rank] = largest_entry(b, team.begin(n), team.end(n));
  team.barrier();
  const double largest = *std::max_element(work.largest.begin(), work.largest.begin() + team.size);
  if (!(largest > 0) || !std::isfinite(largest)) {
    const double value = largest == 0 ? 0 : std::numeric_limits<double>::quiet_NaN();
    for (int i = team.begin(n); i < team.end(n); ++i) b.row(i).setConstant(value);
    return;
  }
  // Powers of two, so that the numbers are the same, in the middle of a float's range.
  const double into = std::exp2(-std::ilogb(largest));
  const double out = scale_ / into;
  const auto n_branches = static_cast<int>(plan_->partition.branches.size());
  for (int i; (i = work.next_forward.fetch_add(1)) < n_branches;) {
    const Branch& branch = plan_->partition.branches[i];
    read_columns(b, into, plan_->structure.supernodes[branch.begin].first_column,
                 plan_->structure.supernodes[branch.end - 1].end_column(), x);
    forward_branch(i, x);
  }
  team.barrier();
  if (!plan_->partition.top.empty()) {
    if (team.rank == 0) {
      for (const int s : plan_->partition.top)
        read_columns(b, into, plan_->structure.supernodes[s].first_column, plan_->structure.supernodes[s].end_column(),
                     x);
      collect_top(x);
    }
    forward_top(team, work);
    backward_top(team, work);
    team.barrier();
    if (team.rank == 0)
      for (const int s : plan_->partition.top)
        write_columns(b, out, plan_->structure.supernodes[s].first_column, plan_->structure.supernodes[s].end_column(),
                      x);
  }
  for (int i; (i = work.next_backward.fetch_add(1)) < n_branches;) {
    const Branch& branch = plan_->partition.branches[i];
    backward_branch(i, x);
    write_columns(b, out, plan_->structure.supernodes[branch.begin].first_column,
                  plan_->structure.supernodes[branch.end - 1].end_column(), x);
  }
}

double TileFactorization::largest_entry(const Positions& b, int begin, int end) {
  // Two sums of maxima that the compiler turns to vectors; 0 * x is NaN where x is not finite.
  const Eigen::Map<const Eigen::ArrayXd> values(b.data() + 3 * static_cast<std::ptrdiff_t>(begin),
                                                3 * static_cast<std::ptrdiff_t>(end - begin));
  return values.size() == 0 ? 0 : values.abs().maxCoeff() + (0 * values).sum();
}

void TileFactorization::read_columns(const Positions& b, double factor, int begin, int end, float* x) const {
  for_unknowns(*plan_, begin, end, [&](int k, int unknown) {
    const double f = is_erased_[k] != 0 ? 0 : factor;
    const double* row = b.data() + 3 * static_cast<std::ptrdiff_t>(unknown);
    float* place = x + 4 * static_cast<std::ptrdiff_t>(k);
    for (int d = 0; d < 3; ++d) place[d] = static_cast<float>(f * row[d]);
    place[3] = 0;
  });
}

void TileFactorization::write_columns(Positions& b, double factor, int begin, int end, const float* x) const {
  for_unknowns(*plan_, begin, end, [&](int k, int unknown) {
    double* row = b.data() + 3 * static_cast<std::ptrdiff_t>(unknown);
    const float* place = x + 4 * static_cast<std::ptrdiff_t>(k);
    for (int d = 0; d < 3; ++d) row[d] = factor * static_cast<double>(place[d]);
  });
}

void TileFactorization::forward_branch(int b, float* x) const {
  const TilePlan::Copies& copies = plan_->copies[b];
  std::fill_n(x + size_t{kTile} * copies.first_place, kTile * copies.columns.size(), 0.0F);
  std::fill_n(x + size_t{kTile} * (plan_->first_padding + 2 * (b + 1)), 2 * kTile, 0.0F);
  const Branch& branch = plan_->partition.branches[b];
  kernels_.forward(supernodes_.data() + branch.begin, supernodes_.data() + branch.end, x);
}

void TileFactorization::backward_branch(int b, float* x) const {
  const TilePlan::Copies& copies = plan_->copies[b];
  for (size_t k = 0; k < copies.columns.size(); ++k)
    std::copy_n(x + size_t{kTile} * copies.columns[k], kTile, x + size_t{kTile} * (copies.first_place + k));
  const Branch& branch = plan_->partition.branches[b];
  kernels_.backward(supernodes_.data() + branch.begin, supernodes_.data() + branch.end, x);
}

void TileFactorization::collect_top(float* x) const {
  std::fill_n(x + size_t{kTile} * plan_->first_padding, 2 * kTile, 0.0F);
  for (const TilePlan::Copies& copies : plan_->copies) {
    const float* from = x + size_t{kTile} * copies.first_place;
    for (const int column : copies.columns)
      for (int d = 0; d < kTile; ++d) x[size_t{kTile} * column + d] += *from++;
  }
}

void TileFactorization::forward_top(const Team& team, Workspace& work) const {
  float* x = work.x.data();
  bool is_together = false;  // everybody is past everything that was done
  for (const int s : plan_->partition.top) {
    const TileSupernode& node = supernodes_[s];
    if (is_shared(node) && team.size > 1) {
      if (!is_together) team.barrier();
      float* packed = work.of_thread[team.rank].data();
      kernels_.pack(node, x, packed);
      team.barrier();
      kernels_.forward_strips(node, team.begin(node.n_strips), team.end(node.n_strips), packed, x);
      team.barrier();
      is_together = true;
    } else {
      if (team.rank == 0) kernels_.forward(&node, &node + 1, x);
      is_together = false;
    }
  }
}

void TileFactorization::backward_top(const Team& team, Workspace& work) const {
  float* x = work.x.data();
  const auto& top = plan_->partition.top;
  bool is_together = is_shared(supernodes_[top.back()]);
  for (auto s = top.rbegin(); s != top.rend(); ++s) {
    const TileSupernode& node = supernodes_[*s];
    if (is_shared(node) && team.size > 1) {
      if (!is_together) team.barrier();
      // Panels in turns: the first ones are longer.
      float* out = work.of_thread[team.rank].data();
      const int n_panels = panel_count(node.n_tiles);
      for (int p = team.rank; p < n_panels; p += team.size)
        kernels_.backward_panel(node, p, x, out + size_t{kTile} * kPanelColumns * p);
      team.barrier();
      for (int p = team.rank; p < n_panels; p += team.size)
        for (int i = 0; i < kTile * panel_width(node.n_tiles, p); ++i)
          std::copy_n(out + size_t{kTile} * (kPanelColumns * p + i), kTile,
                      x + size_t{kTile} * node.rows[kPanelColumns * p + i]);
      team.barrier();
      is_together = true;
    } else {
      if (team.rank == 0) kernels_.backward(&node, &node + 1, x);
      is_together = false;
    }
  }
}

}  // namespace arap
