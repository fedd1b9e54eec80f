// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/soft_directions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dense/small_matrices.h"
#include "geometry/rotation_vectors.h"
#include "optimize/row_grain.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// The rows of a range of vertices in a column.
auto range_of(Eigen::MatrixXf& columns, int begin, int end) {
  return columns.middleRows(std::ptrdiff_t{3} * begin, std::ptrdiff_t{3} * (end - begin));
}
auto range_of(const Eigen::MatrixXf& columns, int begin, int end) {
  return columns.middleRows(std::ptrdiff_t{3} * begin, std::ptrdiff_t{3} * (end - begin));
}

auto flat(const Positions& x, int begin, int end) {
  return Eigen::Map<const Eigen::VectorXd>(x.data() + std::ptrdiff_t{3} * begin, std::ptrdiff_t{3} * (end - begin));
}

/// By what cells are turned to see what becomes of it: far above rounding, and so little that it is linear.
double test_angle(bool is_in_double) { return is_in_double ? 1e-4 : 1e-3; }

/// What is softer than this is held by nothing but rounding.
double least_stiffness(bool is_in_double) { return is_in_double ? 1e-7 : 1e-5; }

}  // namespace

bool SoftDirections::find(const Pose& pose, const MayGoOn& may_go_on) {
  constexpr double kOtherPose = 0.3;
  Pose fitted = pose;
  steps_.read_rotations(fitted.rotations);
  if (is_whole_ || n_tried_ == 0 || turned_from(fitted.rotations) > kOtherPose) begin(fitted.rotations);
  const Positions force = steps_.residual();
  const Positions free_force = steps_.with_free_residual([](const Positions& residual) { return residual; });
  // One at least, so that a search goes on whatever the time is.
  do {
    try_turn(n_tried_++, fitted, force, free_force);
  } while (n_tried_ < kTurns && may_go_on());
  static_cast<void>(steps_.fit(fitted));
  if (n_tried_ < kTurns) return false;
  if (n_ > 0) choose();
  is_whole_ = true;
  return true;
}

void SoftDirections::begin(Rotations rotations) {
  forget();
  n_ = 0;
  columns_.resize(3 * steps_.rest().rows(), kTurns);
  stiffness_ = norm_ = Eigen::MatrixXd::Zero(kTurns, kTurns);
  rotations_ = std::move(rotations);
}

void SoftDirections::try_turn(int turn, const Pose& pose, const Positions& force, const Positions& free_force) {
  constexpr double kNothing = 1e-6;  // of the angle
  const double angle = test_angle(steps_.is_in_double());
  const Vector3 axis = angle * Vector3::Unit(turn % 3);
  const int coordinate = turn / 3 - 1;
  LocalGlobal::Response response = steps_.respond(pose, force, [&](int unknown) {
    return rotation_by(coordinate < 0 ? axis : Vector3(steps_.rest()(unknown, coordinate) * axis));
  });
  const Positions& step = response.step;
  if (!(longest_row(step, steps_.workers()) > kNothing * angle)) return;
  Pose moved = pose;
  moved.positions += step;
  steps_.follow_positions(moved);
  static_cast<void>(steps_.fit(moved));
  const Positions work =
      steps_.with_free_residual([&](const Positions& residual) { return Positions(free_force - residual); });
  const int n = n_++;
  parallel_for<kRows>(steps_.workers(), static_cast<int>(step.rows()), [&](int begin, int end) {
    range_of(columns_, begin, end).col(n) = (flat(step, begin, end) / angle).cast<float>();
  });
  stiffness_.col(n).head(n_) = products(n_, work) / angle;
  norm_.col(n).head(n_) = products(n_, response.force) / angle;
}

void SoftDirections::choose() {
  constexpr double kOfOthers = 1e-4;  // a column that is more of the others than this adds rounding
  constexpr double kStiff = 0.5;      // steps meet these soon enough
  const Eigen::MatrixXd norm = norm_.topLeftCorner(n_, n_).selfadjointView<Eigen::Upper>();
  const Eigen::MatrixXd stiffness = stiffness_.topLeftCorner(n_, n_).selfadjointView<Eigen::Upper>();
  const Eigen::VectorXd scale = norm.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * norm * scale.asDiagonal();
  const SymmetricEigen spread = symmetric_eigen(scaled);
  const Eigen::Index n_spread = (spread.values.array() > kOfOthers).count();
  const Eigen::MatrixXd basis = scale.asDiagonal() * spread.vectors.rightCols(n_spread) *
                                spread.values.tail(n_spread).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd in_basis = basis.transpose() * stiffness * basis;
  const SymmetricEigen ritz = symmetric_eigen(in_basis);
  const double least = least_stiffness(steps_.is_in_double());
  // Beyond a saddle the energy falls: as far as it would rise.
  const auto is_soft = [&](double value) { return value < kStiff && std::abs(value) > least; };
  Eigen::MatrixXf chosen(n_, n_spread);
  compliance_.resize(n_spread);
  Eigen::Index n_soft = 0;
  for (Eigen::Index k = 0; k < n_spread; ++k) {
    if (!is_soft(ritz.values[k])) continue;
    compliance_[n_soft] = 1 / std::abs(ritz.values[k]);
    chosen.col(n_soft++) = (basis * ritz.vectors.col(k)).cast<float>();
  }
  compliance_.conservativeResize(n_soft);
  parallel_for<kRows>(steps_.workers(), static_cast<int>(steps_.rest().rows()), [&](int begin, int end) {
    auto rows = range_of(columns_, begin, end);
    rows.leftCols(n_soft) = (rows.leftCols(n_) * chosen.leftCols(n_soft)).eval();
  });
  n_ = static_cast<int>(n_soft);
}

double SoftDirections::turned() const {
  if (!is_whole_) return std::numeric_limits<double>::infinity();
  Rotations rotations;
  steps_.read_rotations(rotations);
  return turned_from(rotations);
}

double SoftDirections::turned_from(const Rotations& rotations) const {
  const auto n = static_cast<int>(rotations.size());
  const double sum = parallel_sum<kRows>(steps_.workers(), n, [&](int begin, int end) {
    double part = 0;
    for (int c = begin; c < end; ++c) part += 1 - std::pow(rotations[c].dot(rotations_[c]), 2);
    return part;
  });
  return 2 * std::sqrt(std::max(0.0, sum) / std::max(1, n));
}

Eigen::VectorXd SoftDirections::products(int n_columns, const Positions& residual) const {
  return parallel_reduce<kRows>(
      steps_.workers(), static_cast<int>(residual.rows()), Eigen::VectorXd(Eigen::VectorXd::Zero(n_columns)),
      [&](int begin, int end) -> Eigen::VectorXd {
        // In double: the stiffness of a free motion is a difference of such products, and next to nothing.
        const auto part = flat(residual, begin, end);
        Eigen::VectorXd sums(n_columns);
        for (int k = 0; k < n_columns; ++k) sums[k] = range_of(columns_, begin, end).col(k).cast<double>().dot(part);
        return sums;
      },
      [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) -> Eigen::VectorXd { return a + b; });
}

double SoftDirections::distance() const {
  if (n_ == 0) return 0;
  const Eigen::VectorXd forces =
      steps_.with_free_residual([&](const Positions& residual) { return products(n_, residual); });
  const Eigen::VectorXf lengths = compliance_.cwiseProduct(forces).cast<float>();
  const float squared = parallel_reduce<kRows>(
      steps_.workers(), static_cast<int>(steps_.rest().rows()), 0.0F,
      [&](int begin, int end) {
        const Eigen::VectorXf part = range_of(columns_, begin, end).leftCols(n_) * lengths;
        return part.reshaped(3, end - begin).colwise().squaredNorm().maxCoeff();
      },
      [](float a, float b) { return std::max(a, b); });
  return std::sqrt(static_cast<double>(squared));
}

}  // namespace arap
