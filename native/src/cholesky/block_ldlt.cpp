// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/block_ldlt.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "arap/error.h"
#include "base/available_memory.h"
#include "base/permutation.h"
#include "cholesky/elimination_tree.h"
#include "cholesky/multifrontal.h"
#include "cholesky/tile_solve.h"
#include "ordering/nested_dissection.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Hash of the set of entries (new_index[row], new_index[column]): the same for every numbering of the unknowns.
std::uint64_t hash_pattern(const SparseMatrix& A, const std::vector<int>& new_index, int threads) {
  return parallel_reduce(
      threads, static_cast<int>(A.outerSize()), std::uint64_t{0},
      [&](int begin, int end) {
        std::uint64_t hash = 0;
        for (int column = begin; column < end; ++column) {
          const std::uint64_t high = static_cast<std::uint64_t>(new_index[column]) << 32U;
          for (SparseMatrix::InnerIterator it(A, column); it; ++it) {
            // splitmix64 [Steele, Lea, Flood 2014]; the sum makes the hash independent of the order of the entries.
            std::uint64_t bits = (high | static_cast<std::uint64_t>(new_index[it.row()])) + 0x9e3779b97f4a7c15U;
            bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
            bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
            hash += bits ^ (bits >> 31U);
          }
        }
        return hash;
      },
      [](std::uint64_t a, std::uint64_t b) { return a + b; });
}

/// Whether the rounded factor M is a good enough preconditioner: energies <x, A x> of solutions x = M^-1 b are right to
/// 10 %. Tests a rough right-hand side and the smoothest one, which suffers most: a force on everything.
bool is_close(const Factorization& factor, const SparseMatrix& A, const std::vector<char>& is_erased,
              const Workers& workers) {
  constexpr double kFarOff = 0.1;
  const auto n = static_cast<int>(A.rows());
  Positions x(n, 3);
  parallel_for(workers, n, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const std::uint32_t bits = static_cast<std::uint32_t>(i) * 2654435761U;  // Knuth's multiplicative hash
      const double force = is_erased[i] != 0 ? 0 : A.coeff(i, i);
      x.row(i) << force, (bits >> 31U) != 0 ? force : -force, force * i / n;
    }
  });
  factor.solve(x);
  Positions force;
  multiply(A, x, force, workers);
  for (int i = 0; i < n; ++i)
    if (is_erased[i] != 0) force.row(i).setZero();
  const Eigen::RowVector3d energy = x.cwiseProduct(force).colwise().sum();
  x = force;
  factor.solve(x);
  const Eigen::RowVector3d energy_again = x.cwiseProduct(force).colwise().sum();
  // No division: all rows may be erased. NaN is not close.
  return ((energy_again - energy).array().abs() <= kFarOff * energy.array()).all();
}

std::shared_ptr<const TilePlan> make_plan(const SparseMatrix& pattern, int n_threads, const TileKernels& tile_kernels,
                                          const MeterPart& meter) {
  std::vector<int> ordering = nested_dissection(pattern, n_threads, meter.part(0.8), tile_kernels.number_bytes);
  SupernodalStructure structure = make_supernodes(pattern, std::move(ordering));
  meter.add(0.1);
  auto plan = std::make_shared<const TilePlan>(std::move(structure), n_threads);
  meter.add(0.1);
  return plan;
}

}  // namespace

BlockLdlt::BlockLdlt(const SparseMatrix& pattern, const Workers& workers, Isa isa, TileFormat format,
                     const MeterPart& meter)
    : workers_(workers),
      isa_(isa),
      format_(kernels(isa).half_tile.number_bytes > 0 ? format : TileFormat::kFloat),
      plan_(make_plan(pattern, workers.threads(), tile_kernels(format_), meter)),
      new_index_(inverse_permutation(plan_->structure.ordering)),
      pattern_hash_(hash_pattern(pattern, new_index_, workers.threads())) {}

BlockLdlt::~BlockLdlt() = default;

const TileKernels& BlockLdlt::tile_kernels(TileFormat format) const {
  return format == TileFormat::kHalf ? kernels(isa_).half_tile : kernels(isa_).tile;
}

const std::vector<int>* BlockLdlt::ordering() const {
  return plan_->has_identity_ordering ? nullptr : &plan_->structure.ordering;
}

void BlockLdlt::renumber(const SparseMatrix& pattern) {
  if (plan_->has_identity_ordering) return;
  auto plan = std::make_shared<TilePlan>(*plan_);
  std::iota(plan->structure.ordering.begin(), plan->structure.ordering.end(), 0);
  plan->has_identity_ordering = true;
  require_pattern(pattern, plan->structure.ordering);
  front_plan_ = std::make_unique<const FrontPlan>(pattern, *plan);
  new_index_ = plan->structure.ordering;
  plan_ = std::move(plan);
}

const FrontPlan& BlockLdlt::front_plan(const SparseMatrix& A) const {
  const std::scoped_lock lock(mutex_);
  if (front_plan_ == nullptr) front_plan_ = std::make_unique<const FrontPlan>(A, *plan_);
  return *front_plan_;
}

void BlockLdlt::require_pattern(const SparseMatrix& A, const std::vector<int>& new_index) const {
  const bool has_size = A.rows() == A.cols() && A.rows() == std::ssize(new_index);
  if (!has_size || hash_pattern(A, new_index, plan_->n_threads) != pattern_hash_)
    throw SolverError("the matrix has another pattern than the one that its solver was made for");
}

std::unique_ptr<Factorization> BlockLdlt::factorize(const SparseMatrix& A, const std::vector<char>& is_erased,
                                                    const MeterPart& meter) const {
  require_pattern(A, new_index_);
  const Scaling scaling(A, is_erased);
  // It shows at the end only whether halves are good enough. Until then the meter is not at its end: there may be more.
  const double part_of_halves = format_ == TileFormat::kHalf ? 0.9 : 0.0;
  if (format_ == TileFormat::kHalf) {
    auto factor = factorize_as(TileFormat::kHalf, A, scaling, meter.part(part_of_halves));
    if (factor != nullptr && is_close(*factor, A, is_erased, workers_)) {
      meter.add(1 - part_of_halves);
      return factor;
    }
  }
  return factorize_as(TileFormat::kFloat, A, scaling, meter.part(1 - part_of_halves));
}

std::unique_ptr<Factorization> BlockLdlt::factorize_as(TileFormat format, const SparseMatrix& A, const Scaling& scaling,
                                                       const MeterPart& meter) const {
  const TileKernels& of_tiles = tile_kernels(format);
  require_memory(factorization_bytes(*plan_, of_tiles.number_bytes), "the factor of this mesh");
  AlignedBuffer<std::byte> tiles(of_tiles.number_bytes * kTileNumbers * plan_->tile_offsets.back());
  if (!factorize_multifrontal(*plan_, front_plan(A), workers_, kernels(isa_).front, A, scaling, format, tiles.data(),
                              meter))
    return nullptr;
  return std::make_unique<TileFactorization>(plan_, workers_, of_tiles, std::move(tiles), scaling);
}

}  // namespace arap
