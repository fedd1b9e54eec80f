// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/smallest_change.h"

#include <utility>

namespace arap {

namespace {

/// What is left of the rows' pull, squared, as a part of the first.
constexpr double kEnough = 1e-24;
constexpr int kMostChanges = 500;

/// The three columns have coefficients of their own.
using Coefficients = Eigen::Array<double, 1, 3>;

Coefficients squares(const Positions& x) { return x.colwise().squaredNorm().array(); }

/// a / b, 0 if there is nothing left to divide.
Coefficients quotient(const Coefficients& a, const Coefficients& b) {
  return (b > 0).select(a / b, Coefficients::Zero());
}

}  // namespace

SmallestChange::SmallestChange(const LinearRows& rows, const std::vector<char>& is_fixed)
    : scales_(rows.weight_vector().array().sqrt()) {
  std::vector<int> number(is_fixed.size(), -1);
  LinearRows scaled;
  for (int r = 0; r < rows.size(); ++r) {
    LinearRow row;
    const auto& [indices, coefficients] = rows.rows[r];
    for (size_t k = 0; k < indices.size(); ++k) {
      if (is_fixed[indices[k]] != 0) continue;
      int& own = number[indices[k]];
      if (own < 0) {
        own = static_cast<int>(unknowns_.size());
        unknowns_.push_back(indices[k]);
      }
      row.indices.push_back(own);
      row.coefficients.push_back(scales_[r] * coefficients[k]);
    }
    scaled.add(std::move(row), 1);
  }
  rows_ = RowMatrix(scaled, static_cast<int>(unknowns_.size()));
}

// CGLS: the iterates begin at 0 and stay in the span of the rows, so the end is the smallest of all that fit as well.
void SmallestChange::close(const Positions& gaps, Positions& x, const Workers& workers) const {
  if (empty()) return;
  Positions left = (gaps.array().colwise() * scales_).matrix();
  Positions change = Positions::Zero(std::ssize(unknowns_), 3);
  Positions pull = change;
  rows_.add_transposed(left, pull, workers);
  Positions direction = pull;
  Positions product;
  Coefficients size = squares(pull);
  const Coefficients enough = kEnough * size;
  for (int step = 0; step < kMostChanges && (size > enough).any(); ++step) {
    rows_.multiply(direction, product, workers);
    const Coefficients length = quotient(size, squares(product));
    change.array() += direction.array().rowwise() * length;
    left.array() -= product.array().rowwise() * length;
    pull.setZero();
    rows_.add_transposed(left, pull, workers);
    const Coefficients next = squares(pull);
    direction = (pull.array() + direction.array().rowwise() * quotient(next, size)).matrix();
    size = next;
  }
  for (size_t k = 0; k < unknowns_.size(); ++k) x.row(unknowns_[k]) += change.row(static_cast<Eigen::Index>(k));
}

}  // namespace arap
