// SPDX-License-Identifier: GPL-3.0-or-later
#include "block_ldlt.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "arap/error.h"
#include "multifrontal.h"
#include "nested_dissection.h"
#include "tile_solve.h"

namespace arap {

namespace {

/// FNV-1a over the positions of the entries.
std::uint64_t hash_pattern(const SparseMatrix& A) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  const auto add = [&](int value) { hash = (hash ^ static_cast<unsigned>(value)) * 0x100000001b3U; };
  for (Eigen::Index i = 0; i <= A.outerSize(); ++i) add(A.outerIndexPtr()[i]);
  for (Eigen::Index k = 0; k < A.nonZeros(); ++k) add(A.innerIndexPtr()[k]);
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
      pattern_hash_(hash_pattern(pattern)),
      plan_(make_plan(pattern, n_threads)),
      front_plan_(std::make_unique<const FrontPlan>(pattern, *plan_)) {}

BlockLdlt::~BlockLdlt() = default;

std::unique_ptr<Factorization> BlockLdlt::factorize(const SparseMatrix& A, const std::vector<char>& is_erased) const {
  if (hash_pattern(A) != pattern_hash_)
    throw SolverError("the matrix has another pattern than the one that its solver was made for");
  const double scale = scale_for(A, is_erased);
  AlignedBuffer<float> tiles(size_t{kTileNumbers} * plan_->tile_offsets.back());
  factorize_multifrontal(*plan_, *front_plan_, kernels(isa_).front, A, is_erased, scale, tiles.data());
  return std::make_unique<TileFactorization>(plan_, kernels(isa_).tile, std::move(tiles), is_erased, scale);
}

}  // namespace arap
