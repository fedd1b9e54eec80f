// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/tile_border.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "base/available_memory.h"
#include "base/permutation.h"
#include "base/processor.h"
#include "cholesky/tile_solve.h"

namespace arap {

namespace {

/// Rows of a block at most.
constexpr int kBlockRows = 64;

/// Values that a thread takes at once in a solve: some 50 microseconds of work.
constexpr size_t kPieceValues = 50'000;

/// Triples whose products with all others a thread takes at once.
constexpr int kProductTriples = 16;

/// What is taken out of y may be so large, that floats can hold it.
constexpr double kLargest = 0x1p60;

Eigen::Index index(int n) { return n; }

}  // namespace

// Here, since a border knows the factorization.
std::unique_ptr<Border> TileFactorization::border(const SparseMatrix& columns, const MeterPart& meter) const {
  return std::make_unique<TileBorder>(*this, columns, meter);
}

TileBorder::TileBorder(const TileFactorization& factor, const SparseMatrix& columns, const MeterPart& meter)
    : factor_(factor) {
  std::vector<int> new_index = inverse_permutation(factor.plan().structure.ordering);
  sort_columns(columns, new_index);
  find_paths(columns, new_index);
  make_blocks();
  // Each thread has a vector of its own.
  std::mutex mutex;
  std::vector<std::unique_ptr<AlignedBuffer<float>>> idle;
  const auto n_triples = static_cast<int>(of_triple_.size());
  std::vector<float> largest(n_triples, 0.0F);
  factor.workers().run(n_triples, [&](int t) {
    std::unique_ptr<AlignedBuffer<float>> x;
    {
      const std::scoped_lock lock(mutex);
      if (!idle.empty()) {
        x = std::move(idle.back());
        idle.pop_back();
      }
    }
    if (x == nullptr) {
      x = std::make_unique<AlignedBuffer<float>>(size_t{kTile} * static_cast<size_t>(factor.plan().n_places));
      std::fill_n(x->data(), x->size(), 0.0F);
    }
    largest[t] = eliminate(t, columns, new_index, x->data());
    meter.add(1.0 / n_triples);
    const std::scoped_lock lock(mutex);
    idle.push_back(std::move(x));
  });
  for (const float of_one : largest) largest_ = std::max(largest_, of_one);
  of_triple_ = {};
}

// Columns with neighbouring entries in the factor's ordering are neighbours on the surface.
void TileBorder::sort_columns(const SparseMatrix& columns, const std::vector<int>& new_index) {
  const auto n = static_cast<int>(columns.cols());
  std::vector<int> place(n, -1);
  scales_ = Eigen::VectorXd::Ones(n);
  for (int c = 0; c < n; ++c) {
    const int begin = columns.outerIndexPtr()[c];
    const int end = columns.outerIndexPtr()[c + 1];
    if (begin < end) place[c] = new_index[columns.innerIndexPtr()[begin + (end - begin) / 2]];
  }
  sorted_.resize(n);
  std::iota(sorted_.begin(), sorted_.end(), 0);
  std::stable_sort(sorted_.begin(), sorted_.end(), [&](int a, int b) { return place[a] < place[b]; });
  for (int c = 0; c < n; ++c) {
    double largest = 0;
    for (SparseMatrix::InnerIterator it(columns, sorted_[c]); it; ++it)
      largest = std::max(largest, std::abs(it.value() * factor_.scale(new_index[it.row()])));
    if (largest > 0 && std::isfinite(largest)) scales_[c] = std::exp2(-std::ilogb(largest));
  }
}

void TileBorder::find_paths(const SparseMatrix& columns, const std::vector<int>& new_index) {
  const auto& supernodes = factor_.plan().structure.supernodes;
  std::vector<int> supernode_of(new_index.size());
  for (int s = 0; s < std::ssize(supernodes); ++s)
    std::fill_n(supernode_of.begin() + supernodes[s].first_column, supernodes[s].n_columns, s);
  std::vector<int> last_triple(supernodes.size(), -1);
  triple_offsets_.assign(supernodes.size() + 1, 0);
  const auto n_triples = static_cast<int>((sorted_.size() + 2) / 3);
  of_triple_.resize(n_triples);
  for (int t = 0; t < n_triples; ++t) {
    std::vector<int>& path = of_triple_[t].path;
    for (size_t c = size_t{3} * t; c < std::min(sorted_.size(), size_t{3} * (t + 1)); ++c)
      for (SparseMatrix::InnerIterator it(columns, sorted_[c]); it; ++it)
        for (int s = supernode_of[new_index[it.row()]]; s >= 0 && last_triple[s] != t; s = supernodes[s].parent) {
          last_triple[s] = t;
          path.push_back(s);
        }
    std::sort(path.begin(), path.end());
    for (const int s : path) of_triple_[t].place.push_back(triple_offsets_[s + 1]++);
  }
  std::partial_sum(triple_offsets_.begin(), triple_offsets_.end(), triple_offsets_.begin());
  triples_.resize(triple_offsets_.back());
  for (int t = 0; t < n_triples; ++t)
    for (size_t k = 0; k < of_triple_[t].path.size(); ++k)
      triples_[triple_offsets_[of_triple_[t].path[k]] + of_triple_[t].place[k]] = t;
}

void TileBorder::make_blocks() {
  const auto& supernodes = factor_.plan().structure.supernodes;
  size_t n_values = 0;
  size_t of_piece = kPieceValues;
  for (int s = 0; s < std::ssize(supernodes); ++s) {
    if (triple_count(s) == 0) continue;
    for (int c = 0; c < supernodes[s].n_columns; c += kBlockRows) {
      if (of_piece >= kPieceValues) {
        pieces_.push_back(static_cast<int>(blocks_.size()));
        of_piece = 0;
      }
      const int n_rows = std::min(kBlockRows, supernodes[s].n_columns - c);
      blocks_.push_back({s, supernodes[s].first_column + c, n_rows, n_values});
      const size_t size = size_t{3} * static_cast<size_t>(triple_count(s)) * static_cast<size_t>(n_rows);
      n_values += size;
      of_piece += size;
    }
  }
  pieces_.push_back(static_cast<int>(blocks_.size()));
  require_memory(static_cast<double>(n_values * sizeof(float)), "what holds the patches of this mesh");
  values_ = AlignedBuffer<float>(n_values);
}

float TileBorder::eliminate(int triple, const SparseMatrix& columns, const std::vector<int>& new_index, float* x) {
  const size_t first = size_t{3} * static_cast<size_t>(triple);
  for (size_t c = first; c < std::min(sorted_.size(), first + 3); ++c)
    for (SparseMatrix::InnerIterator it(columns, sorted_[c]); it; ++it) {
      const int column = new_index[it.row()];
      x[size_t{kTile} * column + c - first] =
          static_cast<float>(scales_[static_cast<Eigen::Index>(c)] * factor_.scale(column) * it.value());
    }
  float largest = 0;
  const auto& [path, place] = of_triple_[triple];
  factor_.eliminate_along(path, x);
  for (size_t k = 0; k < path.size(); ++k) {
    const Supernode& node = factor_.plan().structure.supernodes[path[k]];
    auto block = std::lower_bound(blocks_.begin(), blocks_.end(), path[k],
                                  [](const Block& b, int s) { return b.supernode < s; });
    const size_t stride = size_t{3} * static_cast<size_t>(triple_count(path[k]));
    float* out = values_.data() + block->values + size_t{3} * static_cast<size_t>(place[k]);
    float* from = x + size_t{kTile} * node.first_column;
    for (int c = 0; c < node.n_columns; ++c, out += stride, from += kTile) {
      for (int d = 0; d < 3; ++d) largest = std::max(largest, std::abs(out[d] = from[d]));
      std::fill_n(from, kTile, 0.0F);
    }
  }
  return largest;
}

void TileBorder::add_products(int first_triple, int last_triple, Eigen::MatrixXd& sorted) const {
  for (const Block& block : blocks_) {
    const int* triples = triples_of(block.supernode);
    const int* end = triples + triple_count(block.supernode);
    const int* first = std::lower_bound(triples, end, first_triple);
    const int* last = std::lower_bound(first, end, last_triple);
    if (first == last) continue;
    // These with themselves and with later ones.
    const Eigen::MatrixXd values = values_of(block).bottomRows(3 * (end - first)).cast<double>();
    const Eigen::MatrixXd products = values * values.topRows(3 * (last - first)).transpose();
    for (const int* a = first; a != last; ++a)
      for (const int* b = first; b != end; ++b)
        sorted.block<3, 3>(index(3 * *b), index(3 * *a)) += products.block<3, 3>(3 * (b - first), 3 * (a - first));
  }
}

Eigen::MatrixXd TileBorder::products() const {
  const auto n = static_cast<int>(sorted_.size());
  const int n_triples = (n + 2) / 3;
  Eigen::MatrixXd sorted = Eigen::MatrixXd::Zero(index(3 * n_triples), index(3 * n_triples));
  factor_.workers().run((n_triples + kProductTriples - 1) / kProductTriples, [&](int k) {
    add_products(k * kProductTriples, std::min(n_triples, (k + 1) * kProductTriples), sorted);
  });
  Eigen::MatrixXd result(n, n);
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b)
      result(sorted_[a], sorted_[b]) = result(sorted_[b], sorted_[a]) = sorted(b, a) / (scales_[a] * scales_[b]);
  return result;
}

Eigen::MatrixX3d TileBorder::products_with(const float* y, double factor) const {
  const auto n = static_cast<int>(sorted_.size());
  const auto n_pieces = static_cast<int>(pieces_.size()) - 1;
  // Added up in order: the same for any number of threads.
  std::vector<Eigen::MatrixX3d> sums(n_pieces);
  factor_.workers().run(n_pieces, [&](int piece) {
    Eigen::MatrixX3d sum = Eigen::MatrixX3d::Zero(index(3 * ((n + 2) / 3)), 3);
    Eigen::MatrixX3d memory(sum.rows(), 3);
    for (int k = pieces_[piece]; k < pieces_[piece + 1]; ++k) {
      const Block& block = blocks_[k];
      const auto values = values_of(block);
      auto of_block = memory.topRows(values.rows());
      of_block.setZero();
      for (int r = 0; r < block.n_rows; ++r) {
        const float* of_row = y + size_t{kTile} * (block.first + r);
        for (int d = 0; d < 3; ++d) of_block.col(d) += static_cast<double>(of_row[d]) * values.col(r).cast<double>();
      }
      const int* triples = triples_of(block.supernode);
      for (int t = 0; t < triple_count(block.supernode); ++t)
        sum.middleRows<3>(index(3 * triples[t])) += of_block.middleRows<3>(index(3 * t));
    }
    sums[piece] = std::move(sum);
  });
  Eigen::MatrixX3d result = Eigen::MatrixX3d::Zero(n, 3);
  for (const Eigen::MatrixX3d& sum : sums) result += sum.topRows(n) / factor;
  return result;
}

void TileBorder::take_out(const Eigen::MatrixX3d& by, double factor, double to_factor, float* y) const {
  if (to_factor != factor) {
    const double change = factor == 0 ? 0 : to_factor / factor;
    for (size_t k = 0; k < size_t{kTile} * static_cast<size_t>(factor_.plan().n_columns()); ++k)
      y[k] = static_cast<float>(change * static_cast<double>(y[k]));
  }
  factor_.workers().run(static_cast<int>(pieces_.size()) - 1, [&](int piece) {
    const FlushToZero mode;
    Eigen::MatrixX3d memory(by.rows(), 3);
    for (int k = pieces_[piece]; k < pieces_[piece + 1]; ++k) {
      const Block& block = blocks_[k];
      const auto values = values_of(block);
      auto of_block = memory.topRows(values.rows());
      const int* triples = triples_of(block.supernode);
      for (int t = 0; t < triple_count(block.supernode); ++t)
        of_block.middleRows<3>(index(3 * t)) = to_factor * by.middleRows<3>(index(3 * triples[t]));
      for (int r = 0; r < block.n_rows; ++r) {
        float* of_row = y + size_t{kTile} * (block.first + r);
        for (int d = 0; d < 3; ++d)
          of_row[d] =
              static_cast<float>(static_cast<double>(of_row[d]) - values.col(r).cast<double>().dot(of_block.col(d)));
      }
    }
  });
}

void TileBorder::solve(const Choose& choose, Positions& x) const {
  const auto n = static_cast<int>(sorted_.size());
  factor_.solve(
      x,
      [&](float* y, double factor) {
        Eigen::MatrixX3d products = Eigen::MatrixX3d::Zero(n, 3);
        if (factor != 0) {
          const Eigen::MatrixX3d sorted = products_with(y, factor);
          for (int c = 0; c < n; ++c) products.row(sorted_[c]) = sorted.row(c) / scales_[c];
        }
        const Eigen::MatrixX3d chosen = choose(products);
        Eigen::MatrixX3d by = Eigen::MatrixX3d::Zero(index(3 * ((n + 2) / 3)), 3);
        for (int c = 0; c < n; ++c) by.row(c) = chosen.row(sorted_[c]) / scales_[c];
        // Nearly always they add up as they are. Else the smaller of them does not matter.
        const double size = by.cwiseAbs().maxCoeff() * static_cast<double>(largest_);
        const bool is_too_large = factor * size > kLargest;
        const bool is_alone = factor == 0 && size > 0;
        const double to_factor = is_too_large || is_alone ? std::exp2(-std::ilogb(size)) : (factor == 0 ? 1 : factor);
        take_out(by, factor, to_factor, y);
        return to_factor;
      },
      x);
}

}  // namespace arap
