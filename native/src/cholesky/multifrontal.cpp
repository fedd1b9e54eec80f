// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/multifrontal.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <memory>

#include "base/aligned_buffer.h"
#include "base/permutation.h"
#include "cholesky/elimination_tree.h"
#include "cholesky/linear_solver.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// A pivot below this part of its diagonal entry is rounding noise: the matrix of a mesh that nothing holds is
/// singular.
constexpr double kLeastPivot = 1e-13;

/// Fronts with more numbers in their columns than this are shared by all threads.
constexpr size_t kSharedFront = 40'000;

/// Update matrix of a supernode for its parent: the lower triangle, column by column.
using Update = std::unique_ptr<double[]>;

/// Memory for one front at a time, which `n_parts` threads may share.
struct Workspace {
  AlignedBuffer<double> values;
  AlignedBuffer<double> inverses;
  AlignedBuffer<double> row_blocks;
  std::vector<double> least_pivot;

  void reserve(size_t n_values, int n_columns, int n_parts) {
    const auto columns = static_cast<size_t>(n_columns);
    const size_t n_blocks = row_block(columns) * static_cast<size_t>(n_parts);
    if (values.size() < n_values) values = AlignedBuffer<double>(n_values);
    if (inverses.size() < kTile * columns) inverses = AlignedBuffer<double>(kTile * columns);
    if (row_blocks.size() < n_blocks) row_blocks = AlignedBuffer<double>(n_blocks);
    if (least_pivot.size() < columns) least_pivot.resize(columns);
  }

  /// Numbers of a row block, to whole cache lines.
  [[nodiscard]] static size_t row_block(size_t n_columns) { return ((kFrontRowBlock + 1) * n_columns + 7) / 8 * 8; }
};

/// Part k of [0, n) begins here, at a multiple of `grain`.
int part_begin(int n, int grain, int k, int n_parts) {
  const int n_grains = (n + grain - 1) / grain;
  return k == n_parts ? n : static_cast<int>(static_cast<std::ptrdiff_t>(n_grains) * k / n_parts) * grain;
}

class Factorizer {
 public:
  Factorizer(const TilePlan& plan, const FrontPlan& fronts, const Workers& workers, const FrontKernels& kernels,
             const SparseMatrix& A, const Scaling& scaling, TileFormat format, std::byte* tiles, const MeterPart& meter)
      : plan_(plan),
        fronts_(fronts),
        workers_(workers),
        kernels_(kernels),
        A_(A),
        scaling_(scaling),
        store_tiles_(format == TileFormat::kHalf ? kernels.store_half_tiles : kernels.store_tiles),
        tile_bytes_(kTileNumbers * (format == TileFormat::kHalf ? sizeof(float) / 2 : sizeof(float))),
        tiles_(tiles),
        updates_(plan.structure.supernodes.size()),
        meter_(meter) {
    for (const Supernode& each : plan.structure.supernodes) whole_work_ += work_of(each);
  }

  /// Returns false if a number is too large for the format.
  bool run() {
    workers_.run(workers_.threads(), [&](int) { failure_.guard([&] { eliminate_subtrees(); }); });
    failure_.guard([&] { eliminate_root_part(); });
    failure_.rethrow();
    if (failure_.has_happened()) fail();
    return fits_;
  }

 private:
  /// Throws the reason why a pivot was not positive.
  [[noreturn]] void fail() const {
    for (int column = 0; column < A_.cols(); ++column)
      for (SparseMatrix::InnerIterator it(A_, column); it; ++it)
        if (scaling_.of_each[column] != 0 && scaling_.of_each[it.row()] != 0 && !std::isfinite(it.value()))
          throw_not_finite(it.row(), column, it.value());
    throw_not_positive_definite();
  }

  [[nodiscard]] const Supernode& node(int s) const { return plan_.structure.supernodes[s]; }
  /// About how long it takes.
  static double work_of(const Supernode& node) {
    constexpr double kAssembly = 100;  // of a row, in operations
    const double n_rows = node.n_columns + node.n_rows;
    return n_rows * (kAssembly + n_rows * node.n_columns);
  }
  void eliminate_subtrees() {
    const auto& subtrees = plan_.partition.subtrees;
    Workspace workspace;
    for (;;) {
      const int b = next_subtree_.fetch_add(1);
      if (b >= std::ssize(subtrees)) return;
      std::vector<int> supernodes;
      for (int s = subtrees[b].begin; s < subtrees[b].end; ++s) supernodes.push_back(s);
      reserve(workspace, supernodes, 1);
      for (const int s : supernodes) {
        if (failure_.has_happened()) return;
        eliminate(s, workspace, Workers(1));
      }
    }
  }

  void eliminate_root_part() {
    Workspace workspace;
    reserve(workspace, plan_.partition.root_part, workers_.threads());
    for (const int s : plan_.partition.root_part) {
      if (failure_.has_happened()) return;
      const FrontSize size(node(s));
      const bool is_shared = static_cast<size_t>(size.n_columns) * static_cast<size_t>(size.n_rows) > kSharedFront;
      eliminate(s, workspace, is_shared ? workers_ : Workers(1));
    }
  }

  void reserve(Workspace& workspace, const std::vector<int>& supernodes, int n_parts) const {
    size_t n_values = 0;
    int n_columns = 0;
    for (const int s : supernodes) {
      n_values = std::max(n_values, FrontSize(node(s)).n_values());
      n_columns = std::max(n_columns, FrontSize(node(s)).n_columns);
    }
    workspace.reserve(n_values, n_columns, n_parts);
  }

  /// Adds up the front of supernode s.
  Front assemble(int s, Workspace& workspace) {
    const FrontSize size(node(s));
    const Front front{workspace.values.data(), size.stride, size.n_columns, size.n_rows, workspace.inverses.data()};
    std::fill_n(front.values, size.n_values(), 0.0);
    add_entries(s, front, workspace.least_pivot);
    for (int child = fronts_.first_child[s]; child >= 0; child = fronts_.next_sibling[child]) add_update(child, front);
    const size_t n = node(s).n_rows;
    if (n > 0) updates_[s] = std::make_unique_for_overwrite<double[]>(n * (n + 1) / 2);
    return front;
  }

  void add_entries(int s, const Front& front, std::vector<double>& least_pivot) const {
    const auto stride = static_cast<size_t>(front.stride);
    const double* values = A_.valuePtr();
    const int* rows = A_.innerIndexPtr();
    for (int c = 0; c < front.n_columns; ++c) {
      double* column = front.values + stride * static_cast<size_t>(c);
      least_pivot[c] = 0;
      const int global = node(s).first_column + c;
      const double scale =
          c < node(s).n_columns
              ? scaling_.of_all * static_cast<double>(scaling_.of_each[plan_.structure.ordering[global]])
              : 0;
      if (scale == 0) {
        column[c] = 1;
        continue;
      }
      for (int e = fronts_.entry_offsets[global]; e < fronts_.entry_offsets[global + 1]; ++e) {
        const FrontPlan::Entry entry = fronts_.entries[e];
        const double other = scaling_.of_all * static_cast<double>(scaling_.of_each[rows[entry.source]]);
        if (other != 0) column[entry.row] = scale * values[entry.source] * other;
      }
      least_pivot[c] = kLeastPivot * column[c];
    }
  }

  void add_update(int child, const Front& front) {
    const auto stride = static_cast<size_t>(front.stride);
    const int n = node(child).n_rows;
    const int* rows = fronts_.parent_rows.data() + node(child).rows_offset;
    const double* update = updates_[child].get();
    for (int j = 0; j < n; ++j) {
      double* column = front.values + stride * static_cast<size_t>(rows[j]);
      for (int i = j; i < n; ++i) column[rows[i]] += *update++;
    }
    updates_[child].reset();
  }

  /// Copies the columns [begin, end) of the update matrix of s out of its front.
  void take_update(int s, const Front& front, int begin, int end) {
    const size_t n = node(s).n_rows;
    for (size_t j = begin; j < static_cast<size_t>(end); ++j) {
      const size_t stored = j * n - j * (j - 1) / 2;  // numbers in the columns before
      const double* column = front.values + (front.n_columns + j) * front.stride + front.n_columns;
      std::copy(column + j, column + n, updates_[s].get() + stored);
    }
  }

  void eliminate(int s, Workspace& workspace, const Workers& workers) {
    const Front front = assemble(s, workspace);
    const int n_parts = workers.threads();
    const int columns = n_parts > 1 ? 16 : front.n_rows;  // that a thread updates at once
    for (int begin = 0; begin < front.n_columns; begin += kFrontPanel) {
      const int end = std::min(begin + kFrontPanel, front.n_columns);
      meter_.add(work_of(node(s)) / whole_work_ * (end - begin) / front.n_columns);
      if (!kernels_.factor_panel(front, begin, end, workspace.least_pivot.data())) {
        failure_.note();
        return;
      }
      workers.run((front.n_rows - end + columns - 1) / columns, [&](int k) {
        const int first = end + columns * k;
        kernels_.update_columns(front, begin, end, first, std::min(first + columns, front.n_rows));
      });
    }
    workers.run(n_parts, [&](int k) {
      const int n = node(s).n_rows;
      take_update(s, front, part_begin(n, 1, k, n_parts), part_begin(n, 1, k + 1, n_parts));
      double* row_block = workspace.row_blocks.data() + k * Workspace::row_block(front.n_columns);
      if (!store_tiles_(front, node(s).n_columns, n, part_begin(front.n_rows, kFrontRowBlock, k, n_parts),
                        part_begin(front.n_rows, kFrontRowBlock, k + 1, n_parts), row_block,
                        tiles_ + tile_bytes_ * plan_.tile_offsets[s]))
        fits_ = false;
    });
  }

  const TilePlan& plan_;
  const FrontPlan& fronts_;
  const Workers& workers_;
  const FrontKernels& kernels_;
  const SparseMatrix& A_;
  const Scaling& scaling_;
  decltype(FrontKernels::store_tiles) store_tiles_;
  size_t tile_bytes_;
  std::byte* tiles_;
  std::vector<Update> updates_;  ///< of each supernode, until its parent has added it
  MeterPart meter_;
  double whole_work_ = 0;
  std::atomic<int> next_subtree_ = 0;
  FirstFailure failure_;  ///< without an exception: a pivot was not positive
  std::atomic<bool> fits_ = true;
};

}  // namespace

FrontSize::FrontSize(const Supernode& node)
    : n_columns(kTile * tiles_for(node.n_columns)),
      n_rows(n_columns + kTile * tiles_for(node.n_rows)),
      stride(n_rows + kFrontSlack) {}

double factorization_bytes(const TilePlan& plan, size_t tile_number_bytes) {
  const auto& supernodes = plan.structure.supernodes;
  const auto update_size = [](const Supernode& node) { return .5 * node.n_rows * (node.n_rows + 1.); };
  double kept = 0;     // numbers of update matrices that wait for their parents
  double most = 0;     // of these
  double largest = 0;  // front
  std::vector<double> of_children(supernodes.size(), 0);
  for (size_t s = 0; s < supernodes.size(); ++s) {
    const double own = update_size(supernodes[s]);
    kept += own - of_children[s];
    most = std::max(most, kept);
    largest = std::max(largest, static_cast<double>(FrontSize(supernodes[s]).n_values()));
    if (supernodes[s].parent >= 0) of_children[supernodes[s].parent] += own;
  }
  const auto n_tiles = static_cast<double>(plan.tile_offsets.back());
  return sizeof(double) * (most + largest) + static_cast<double>(tile_number_bytes * kTileNumbers) * n_tiles;
}

FrontPlan::FrontPlan(const SparseMatrix& pattern, const TilePlan& plan) {
  const SupernodalStructure& structure = plan.structure;
  const std::vector<int> new_index = inverse_permutation(structure.ordering);
  const auto& supernodes = structure.supernodes;
  std::vector<int> front_row(structure.ordering.size());
  entry_offsets.reserve(structure.ordering.size() + 1);
  entries.reserve((pattern.nonZeros() + pattern.rows()) / 2);
  entry_offsets.push_back(0);
  first_child.assign(supernodes.size(), -1);
  next_sibling.assign(supernodes.size(), -1);
  parent_rows.resize(structure.rows.size());
  for (int s = 0; s < std::ssize(supernodes); ++s) {
    const Supernode& node = supernodes[s];
    const int* rows = structure.rows_of(node);
    for (int c = 0; c < node.n_columns; ++c) front_row[node.first_column + c] = c;
    for (int r = 0; r < node.n_rows; ++r) front_row[rows[r]] = kTile * tiles_for(node.n_columns) + r;
    for (int c = node.first_column; c < node.end_column(); ++c) {
      const int old = structure.ordering[c];
      for (int k = pattern.outerIndexPtr()[old]; k < pattern.outerIndexPtr()[old + 1]; ++k) {
        const int row = new_index[pattern.innerIndexPtr()[k]];
        if (row >= c) entries.push_back({k, front_row[row]});
      }
      entry_offsets.push_back(static_cast<int>(entries.size()));
    }
    for (int child = first_child[s]; child >= 0; child = next_sibling[child]) {
      const size_t offset = supernodes[child].rows_offset;
      for (int r = 0; r < supernodes[child].n_rows; ++r)
        parent_rows[offset + r] = front_row[structure.rows[offset + r]];
    }
    if (node.parent < 0) continue;
    next_sibling[s] = first_child[node.parent];
    first_child[node.parent] = s;
  }
}

Scaling::Scaling(const SparseMatrix& A, const std::vector<char>& is_erased) : of_each(is_erased.size(), 0) {
  const Eigen::VectorXd diagonal = A.diagonal();
  const auto is_scale = [&](Eigen::Index i) { return diagonal[i] > 0 && std::isfinite(diagonal[i]); };
  double largest = 0;
  for (Eigen::Index i = 0; i < diagonal.size(); ++i)
    if (is_erased[i] == 0 && is_scale(i)) largest = std::max(largest, diagonal[i]);
  if (largest == 0) largest = 1;
  of_all = std::exp2(-std::ilogb(largest) / 2);
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    if (is_erased[i] != 0) continue;
    // Entries that are not positive fail later, as pivots.
    const int exponent = is_scale(i) ? std::ilogb(diagonal[i]) + 2 * std::ilogb(of_all) : 0;
    of_each[i] = static_cast<float>(std::exp2(std::min(-exponent / 2, 100)));
  }
}

bool factorize_multifrontal(const TilePlan& plan, const FrontPlan& fronts, const Workers& workers,
                            const FrontKernels& kernels, const SparseMatrix& A, const Scaling& scaling,
                            TileFormat format, std::byte* tiles, const MeterPart& meter) {
  return Factorizer(plan, fronts, workers, kernels, A, scaling, format, tiles, meter).run();
}

}  // namespace arap
