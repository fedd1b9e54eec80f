// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "cholesky/linear_solver.h"
#include "cholesky/tile_plan.h"
#include "kernels/isa.h"
#include "kernels/tile_kernels.h"

namespace arap {

struct FrontPlan;
struct Scaling;

/// Block LDL^T for three right-hand sides, for any sparse symmetric positive definite matrix.
///
/// At construction, from the pattern: order (nested_dissection.h), elimination tree, supernodes, plan of the solve.
/// Factorizing is multifrontal and in double (multifrontal.h); erased rows become those of the identity, so a change of
/// them keeps all of that. What is kept of the factor are tiles of halves or floats (tile_kernels.h), a fourth or half
/// as much to read: a solve does nothing but read them, twice. Its result has an error of about 1e-3 or 1e-6, more for
/// badly conditioned matrices; users iterate x += solve(b - A x), see linear_solver.h.
class BlockLdlt final : public LinearSolver {
 public:
  /// @param pattern    symmetric, stored whole, with its diagonal
  /// @param workers    of solves; as many threads factorize. Results depend on how many in the last digits
  /// @param format     of tiles, where the instruction set has it and the matrix is conditioned well enough for it
  explicit BlockLdlt(const SparseMatrix& pattern, const Workers& workers, Isa isa = choose_isa(),
                     TileFormat format = TileFormat::kHalf);

  [[nodiscard]] std::unique_ptr<Factorization> factorize(const SparseMatrix& A,
                                                         const std::vector<char>& is_erased) const override;

  [[nodiscard]] const std::vector<int>* order() const override;
  void renumber(const SparseMatrix& pattern) override;

  ~BlockLdlt() override;
  BlockLdlt(const BlockLdlt&) = delete;
  BlockLdlt& operator=(const BlockLdlt&) = delete;

  [[nodiscard]] const TilePlan& plan() const { return *plan_; }

 private:
  void require_pattern(const SparseMatrix& A, const std::vector<int>& new_index) const;

  /// Made for the pattern of A when it is first needed: a model that numbers its unknowns anew makes only one.
  [[nodiscard]] const FrontPlan& front_plan(const SparseMatrix& A) const;

  /// Null where a number does not fit in the format.
  [[nodiscard]] std::unique_ptr<Factorization> factorize_as(TileFormat format, const SparseMatrix& A,
                                                            const Scaling& scaling) const;

  Workers workers_;
  Isa isa_;
  TileFormat format_;
  std::shared_ptr<const TilePlan> plan_;
  std::vector<int> new_index_;  ///< the inverse of the plan's order
  std::uint64_t pattern_hash_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<const FrontPlan> front_plan_;
};

}  // namespace arap
