// SPDX-License-Identifier: GPL-3.0-or-later
#include "tile_solve.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

namespace arap {

namespace {

/// Supernodes with more tiles than this, some microseconds of work, are worth two barriers: cheap as long as every
/// thread has its core, a time slice each where it does not.
constexpr size_t kSharedTiles = 6000;

bool is_shared(const TileSupernode& node) { return tile_count(node.n_tiles, node.n_strips) > kSharedTiles; }

/// Rows of b on their way from or to another order.
constexpr int kRows = 64;
using Rows = std::array<double, size_t{3} * kRows>;

/// Numbers below the range of a float become 0, as long as this lives: far from where b is not 0 there would be many of
/// them, and processors are slow with them.
class FlushToZero {
 public:
  FlushToZero() { set(before_ | kFlush); }
  FlushToZero(const FlushToZero&) = delete;
  FlushToZero& operator=(const FlushToZero&) = delete;
  ~FlushToZero() { set(before_); }

 private:
#if defined(__SSE__)
  static constexpr unsigned kFlush = 0x8040;  // of results, and of operands
  static unsigned get() { return __builtin_ia32_stmxcsr(); }
  static void set(unsigned mode) { __builtin_ia32_ldmxcsr(mode); }
#else
  static constexpr unsigned kFlush = 0;
  static unsigned get() { return 0; }
  static void set(unsigned /*mode*/) {}
#endif
  unsigned before_ = get();
};

}  // namespace

TileFactorization::Workspace::Workspace(const TilePlan& plan)
    : x(size_t{kTile} * static_cast<size_t>(plan.n_places)), largest(plan.n_threads) {
  int n_columns = 0;
  for (const int s : plan.partition.top) n_columns = std::max(n_columns, plan.structure.supernodes[s].n_columns);
  // b1 packed has 3 numbers a column, x1 by panels has 4 and is padded to panels.
  const auto panels = static_cast<size_t>(panel_count(tiles_for(n_columns)));
  for (int t = 0; t < plan.n_threads; ++t) of_thread.emplace_back(size_t{kTile} * kPanelColumns * panels);
}

TileFactorization::TileFactorization(std::shared_ptr<const TilePlan> plan, const TileKernels& kernels,
                                     AlignedBuffer<std::byte> tiles, const Scaling& scaling)
    : plan_(std::move(plan)), kernels_(kernels), tiles_(std::move(tiles)), scale_(scaling.of_all) {
  const auto& supernodes = plan_->structure.supernodes;
  supernodes_.reserve(supernodes.size());
  for (size_t s = 0; s < supernodes.size(); ++s) {
    const int n_tiles = tiles_for(supernodes[s].n_columns);
    supernodes_.push_back({tiles_.data() + kernels_.number_bytes * kTileNumbers * plan_->tile_offsets[s],
                           plan_->rows.data() + plan_->rows_offsets[s], n_tiles,
                           n_tiles + tiles_for(supernodes[s].n_rows)});
  }
  scaling_.reserve(plan_->structure.order.size());
  for (const int i : plan_->structure.order) scaling_.push_back(scaling.of_each[i]);
}

void TileFactorization::solve(Positions& b) const {
  using Clock = std::chrono::steady_clock;
  std::unique_ptr<Workspace> work;
  int n_threads = 1;
  {
    const std::lock_guard lock(mutex_);
    n_threads = pace_.choose(plan_->n_threads);
    if (!idle_.empty()) {
      work = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (work == nullptr) work = std::make_unique<Workspace>(*plan_);
  work->next_forward = 0;
  work->next_backward = 0;
  const Clock::time_point start = Clock::now();
  run_team(n_threads, [&](const Team& team) { solve_in_team(team, b, *work); });
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const std::lock_guard lock(mutex_);
  pace_.record(n_threads, seconds);
  idle_.push_back(std::move(work));
}

void TileFactorization::solve_in_team(const Team& team, Positions& b, Workspace& work) const {
  const FlushToZero mode;
  // Nearly every b is in the middle of a float's range as it is. Others get there by powers of two, so that the digits
  // are the same.
  constexpr double kSmallest = 0x1p-40;
  constexpr double kLargest = 0x1p40;
  double into = scale_;
  const double reached = eliminate_branches(team, b, into, work);
  if (!(reached >= kSmallest && reached <= kLargest)) {
    const double largest = start_again(team, b, work);
    if (!(largest > 0) || !std::isfinite(largest)) {
      const double value = largest == 0 ? 0 : std::numeric_limits<double>::quiet_NaN();
      const int n = plan_->n_columns();
      for (int i = team.begin(n); i < team.end(n); ++i) b.row(i).setConstant(value);
      return;
    }
    into = std::exp2(-std::ilogb(largest));
    eliminate_branches(team, b, into, work);
  }
  const double out = scale_ * (scale_ / into);
  solve_top(team, b, out, work);
  const auto n_branches = static_cast<int>(plan_->partition.branches.size());
  for (int i; (i = work.next_backward.fetch_add(1)) < n_branches;) {
    const Branch& branch = plan_->partition.branches[i];
    backward_branch(i, work.x.data());
    write_columns(b, out, branch.begin, branch.end, work.x.data());
  }
}

double TileFactorization::eliminate_branches(const Team& team, const Positions& b, double factor,
                                             Workspace& work) const {
  float* x = work.x.data();
  double largest = 0;
  // A sum tells of the largest one as well as a maximum does, and of a NaN better.
  if (team.rank == 0)
    for (const int s : plan_->partition.top) largest += static_cast<double>(read_columns(b, factor, s, s + 1, x));
  const auto n_branches = static_cast<int>(plan_->partition.branches.size());
  for (int i; (i = work.next_forward.fetch_add(1)) < n_branches;) {
    const Branch& branch = plan_->partition.branches[i];
    largest += static_cast<double>(read_columns(b, factor, branch.begin, branch.end, x));
    forward_branch(i, x);
  }
  work.largest[team.rank] = largest;
  team.barrier();
  return std::accumulate(work.largest.begin(), work.largest.begin() + team.size, 0.0);
}

double TileFactorization::start_again(const Team& team, const Positions& b, Workspace& work) const {
  team.barrier();  // everybody has seen `largest`
  work.next_forward = 0;
  const int n = plan_->n_columns();
  const Eigen::Map<const Eigen::ArrayXd> values(b.data() + 3 * static_cast<std::ptrdiff_t>(team.begin(n)),
                                                3 * static_cast<std::ptrdiff_t>(team.end(n) - team.begin(n)));
  // 0 * x is NaN where x is not finite.
  work.largest[team.rank] = values.size() == 0 ? 0 : values.abs().maxCoeff() + (0 * values).sum();
  team.barrier();
  const double largest = std::accumulate(work.largest.begin(), work.largest.begin() + team.size, 0.0);
  team.barrier();
  return largest;
}

void TileFactorization::solve_top(const Team& team, Positions& b, double factor, Workspace& work) const {
  const auto& top = plan_->partition.top;
  if (top.empty()) return;
  float* x = work.x.data();
  if (team.rank == 0) collect_top(x);
  forward_top(team, work);
  backward_top(team, work);
  team.barrier();
  if (team.rank == 0)
    for (const int s : top) write_columns(b, factor, s, s + 1, x);
}

float TileFactorization::read_columns(const Positions& b, double factor, int first, int last, float* x) const {
  const int begin = plan_->structure.supernodes[first].first_column;
  const int end = plan_->structure.supernodes[last - 1].end_column();
  const float* scaling = scaling_.data();
  if (plan_->is_in_order)
    return kernels_.read(b.data() + 3 * static_cast<std::ptrdiff_t>(begin), scaling + begin, factor, end - begin,
                         x + 4 * static_cast<std::ptrdiff_t>(begin));
  float largest = 0;
  Rows rows;
  for (int k = begin; k < end; k += kRows) {
    const int n = std::min(kRows, end - k);
    for (int i = 0; i < n; ++i)
      std::copy_n(b.data() + 3 * static_cast<std::ptrdiff_t>(plan_->structure.order[k + i]), 3,
                  rows.data() + size_t{3} * i);
    largest += kernels_.read(rows.data(), scaling + k, factor, n, x + 4 * static_cast<std::ptrdiff_t>(k));
  }
  return largest;
}

void TileFactorization::write_columns(Positions& b, double factor, int first, int last, const float* x) const {
  const int begin = plan_->structure.supernodes[first].first_column;
  const int end = plan_->structure.supernodes[last - 1].end_column();
  const float* scaling = scaling_.data();
  if (plan_->is_in_order) {
    kernels_.write(x + 4 * static_cast<std::ptrdiff_t>(begin), scaling + begin, factor, end - begin,
                   b.data() + 3 * static_cast<std::ptrdiff_t>(begin));
    return;
  }
  Rows rows;
  for (int k = begin; k < end; k += kRows) {
    const int n = std::min(kRows, end - k);
    kernels_.write(x + 4 * static_cast<std::ptrdiff_t>(k), scaling + k, factor, n, rows.data());
    for (int i = 0; i < n; ++i)
      std::copy_n(rows.data() + size_t{3} * i, 3,
                  b.data() + 3 * static_cast<std::ptrdiff_t>(plan_->structure.order[k + i]));
  }
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
  for (size_t k = top.size(); k-- > 0;) {
    const TileSupernode& node = supernodes_[top[k]];
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
