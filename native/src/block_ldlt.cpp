// SPDX-License-Identifier: GPL-3.0-or-later
#include "block_ldlt.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "arap/error.h"
#include "elimination_tree.h"
#include "multifrontal.h"
#include "nested_dissection.h"
#include "tile_solve.h"

namespace arap {

namespace {

/// Of the set of entries, whatever the unknowns are called: new_index[i] is the column of unknown i.
std::uint64_t hash_pattern(const SparseMatrix& A, const std::vector<int>& new_index) {
  std::uint64_t hash = static_cast<std::uint64_t>(A.rows());
  for (int column = 0; column < A.outerSize(); ++column) {
    const std::uint64_t high = static_cast<std::uint64_t>(new_index[column]) << 32U;
    for (SparseMatrix::InnerIterator it(A, column); it; ++it) {
      // Steele, Lea and Flood's mixing of 64 bits; a sum does not ask for an order.
      std::uint64_t bits = (high | static_cast<std::uint64_t>(new_index[it.row()])) + 0x9e3779b97f4a7c15U;
      bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
      bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
      hash += bits ^ (bits >> 31U);
    }
  }
  return hash;
}

/// A power of two that brings the largest diagonal entry near 1, so that no number leaves the range of a float.
double scale_for(const SparseMatrix& A, const std::vector<char>& is_erased) {
  const Eigen::VectorXd diagonal = A.diagonal();
  double largest = 0;
  for (Eigen::Index i = 0; i < diagonal.size(); ++i)
    if (is_erased[i] == 0) largest = std::max(largest, diagonal[i]);
  return largest > 0 && std::isfinite(largest) ? std::exp2(-std::ilogb(largest)) : 1;
}

std::shared_ptr<const TilePlan> make_plan(const SparseMatrix& pattern, int n_threads) {
  return std::make_shared<const TilePlan>(make_supernodes(pattern, nested_dissection(pattern)), n_threads);
}

}  // namespace

BlockLdlt::BlockLdlt(const SparseMatrix& pattern, int n_threads, Isa isa)
    : isa_(isa),
      plan_(make_plan(pattern, n_threads)),
      new_index_(inverse_permutation(plan_->structure.order)),
      pattern_hash_(hash_pattern(pattern, new_index_)),
      front_plan_(std::make_unique<const FrontPlan>(pattern, *plan_)) {}

BlockLdlt::~BlockLdlt() = default;

const std::vector<int>* BlockLdlt::order() const { return plan_->is_in_order ? nullptr : &plan_->structure.order; }

void BlockLdlt::renumber(const SparseMatrix& pattern) {
  if (plan_->is_in_order) return;
  auto plan = std::make_shared<TilePlan>(*plan_);
  std::iota(plan->structure.order.begin(), plan->structure.order.end(), 0);
  plan->is_in_order = true;
  require_pattern(pattern, plan->structure.order);
  front_plan_ = std::make_unique<const FrontPlan>(pattern, *plan);
  new_index_ = plan->structure.order;
  plan_ = std::move(plan);
}

void BlockLdlt::require_pattern(const SparseMatrix& A, const std::vector<int>& new_index) const {
  const bool has_size = A.rows() == A.cols() && A.rows() == std::ssize(new_index);
  if (!has_size || hash_pattern(A, new_index) != pattern_hash_)
    throw SolverError("the matrix has another pattern than the one that its solver was made for");
}

std::unique_ptr<Factorization> BlockLdlt::factorize(const SparseMatrix& A, const std::vector<char>& is_erased) const {
  require_pattern(A, new_index_);
  const double scale = scale_for(A, is_erased);
  AlignedBuffer<float> tiles(size_t{kTileNumbers} * plan_->tile_offsets.back());
  factorize_multifrontal(*plan_, *front_plan_, kernels(isa_).front, A, is_erased, scale, tiles.data());
  return std::make_unique<TileFactorization>(plan_, kernels(isa_).tile, std::move(tiles), is_erased, scale);
}

}  // namespace arap
