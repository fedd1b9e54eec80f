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
/// Construction computes from the pattern: ordering (nested_dissection.h), elimination tree, supernodes, solve plan.
/// factorize() is multifrontal and in double (multifrontal.h). Erased rows become rows of the identity, so the plan
/// serves every set of them. The factor is stored as tiles of half or single precision (tile_kernels.h): a solve is
/// bound by memory bandwidth, and they are a quarter or half of the data. The relative error of a solve is about 1e-3
/// or 1e-6, more for badly conditioned matrices; linear_solver.h says how to iterate.
class BlockLdlt final : public LinearSolver {
 public:
  /// @param pattern    symmetric, stored whole, with its diagonal
  /// @param workers    of factorize() and of solves. The last digits depend on their number
  /// @param format     of tiles; kFloat is used if the instruction set lacks halves or the matrix is too badly
  ///                   conditioned for them
  explicit BlockLdlt(const SparseMatrix& pattern, const Workers& workers, Isa isa = choose_isa(),
                     TileFormat format = TileFormat::kHalf, const MeterPart& meter = {});

  [[nodiscard]] std::unique_ptr<Factorization> factorize(const SparseMatrix& A, const std::vector<char>& is_erased,
                                                         const MeterPart& meter = {}) const override;

  [[nodiscard]] const std::vector<int>* ordering() const override;
  void renumber(const SparseMatrix& pattern) override;

  ~BlockLdlt() override;
  BlockLdlt(const BlockLdlt&) = delete;
  BlockLdlt& operator=(const BlockLdlt&) = delete;

  [[nodiscard]] const TilePlan& plan() const { return *plan_; }

 private:
  void require_pattern(const SparseMatrix& A, const std::vector<int>& new_index) const;

  /// Made when first needed: after renumber(), so that a model makes only one.
  [[nodiscard]] const FrontPlan& front_plan(const SparseMatrix& A) const;

  [[nodiscard]] const TileKernels& tile_kernels(TileFormat format) const;

  /// Null if a number is too large for the format.
  [[nodiscard]] std::unique_ptr<Factorization> factorize_as(TileFormat format, const SparseMatrix& A,
                                                            const Scaling& scaling, const MeterPart& meter) const;

  Workers workers_;
  Isa isa_;
  TileFormat format_;
  std::shared_ptr<const TilePlan> plan_;
  std::vector<int> new_index_;  ///< inverse of the plan's ordering
  std::uint64_t pattern_hash_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<const FrontPlan> front_plan_;
};

}  // namespace arap
