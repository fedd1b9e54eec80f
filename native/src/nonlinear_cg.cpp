// SPDX-License-Identifier: GPL-3.0-or-later
#include "nonlinear_cg.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "parallel.h"

namespace arap {

namespace {

/// Smaller decreases of the energy, as part of E_0, are none.
constexpr double kSmallestDecrease = 1e-14;

/// Rows that a thread takes at once.
constexpr int kRows = 2048;

using Array = Eigen::Map<const Eigen::ArrayXd>;

/// Rows [begin, end) as one array.
Array rows(const Positions& x, int begin, int end) {
  return {x.data() + 3L * begin, 3L * static_cast<std::ptrdiff_t>(end - begin)};
}

int row_count(const Positions& x) { return static_cast<int>(x.rows()); }

double inner_product(int threads, const Positions& a, const Positions& b) {
  return parallel_sum<kRows>(threads, row_count(a),
                             [&](int begin, int end) { return (rows(a, begin, end) * rows(b, begin, end)).sum(); });
}

}  // namespace

double NonlinearCg::choose_direction() {
  using Sums = std::array<double, 3>;
  const Positions& residual = steps_.residual();
  const bool is_fresh = is_fresh_;
  const Sums sums = parallel_reduce<kRows>(
      steps_.threads(), row_count(residual), Sums{},
      [&](int begin, int end) {
        const Array z = rows(correction_, begin, end);
        const Array r = rows(residual, begin, end);
        if (is_fresh) return Sums{(z * r).sum(), 0, 0};
        return Sums{(z * r).sum(), (z * rows(residual_, begin, end)).sum(), (rows(direction_, begin, end) * r).sum()};
      },
      [](const Sums& a, const Sums& b) {
        return Sums{a[0] + b[0], a[1] + b[1], a[2] + b[2]};
      });
  const double z_r = sums[0];
  double beta = is_fresh ? 0 : std::max(0.0, (z_r - sums[1]) / z_r_);
  double slope = z_r + beta * sums[2];
  if (!(slope > 0) || !std::isfinite(beta)) {
    beta = 0;
    slope = z_r;
  }
  update_direction(beta);
  z_r_ = z_r;
  return slope;
}

void NonlinearCg::update_direction(double beta) {
  using Longest = std::array<double, 2>;
  direction_.resize(correction_.rows(), 3);  // memory only where it is not there yet
  const Longest longest = parallel_reduce<kRows>(
      steps_.threads(), row_count(correction_), Longest{},
      [&](int begin, int end) {
        const auto z = correction_.middleRows(begin, end - begin);
        auto d = direction_.middleRows(begin, end - begin);
        if (beta > 0)
          d = z + beta * d;
        else
          d = z;
        return Longest{z.rowwise().squaredNorm().maxCoeff(), d.rowwise().squaredNorm().maxCoeff()};
      },
      [](const Longest& a, const Longest& b) {
        return Longest{std::max(a[0], b[0]), std::max(a[1], b[1])};
      });
  longest_correction_ = std::sqrt(longest[0]);
  longest_direction_ = std::sqrt(longest[1]);
}

double NonlinearCg::try_length(Pose& pose, double length) {
  pose.positions.resize(start_.rows(), 3);
  parallel_for<kRows>(steps_.threads(), row_count(start_), [&](int begin, int end) {
    const int n = end - begin;
    pose.positions.middleRows(begin, n) = start_.middleRows(begin, n) + length * direction_.middleRows(begin, n);
  });
  pose.placements = placements_;
  steps_.follow_positions(pose);
  step_ = std::max(length * longest_direction_, longest_correction_);
  return steps_.fit(pose);
}

double NonlinearCg::iterate(Pose& pose, double energy) {
  constexpr double kLongest = 4;
  constexpr double kShortest = 0.25;
  constexpr double kSecondLook = 0.3;  // relative change of the length that is worth another fit
  steps_.find_correction(pose, correction_);
  double slope = choose_direction();
  start_.swap(pose.positions);
  residual_.swap(steps_.residual());
  placements_ = pose.placements;
  const double rounding = steps_.energy_rounding();

  double length = is_fresh_ ? 1 : length_;
  double reached = try_length(pose, length);
  if (!is_fresh_ || reached > energy + rounding) {
    const double slope_there = inner_product(steps_.threads(), direction_, steps_.residual());
    double better = length * slope / (slope - slope_there);
    if (!(better > 0) || better > kLongest * length) better = kLongest * length;
    if (std::abs(better - length) > kSecondLook * length || reached > energy + rounding) {
      length = better;
      reached = try_length(pose, length);
    }
  }
  is_fresh_ = false;
  if (reached > energy + rounding) {
    length = 1;
    slope = z_r_;
    update_direction(0);
    is_fresh_ = true;
    reached = try_length(pose, length);
  }
  promised_decrease_ = length * slope;
  length_ = std::clamp(length, kShortest, kLongest);
  return reached;
}

IterationReport minimize(LocalGlobal& steps, NonlinearCg& search, Pose& pose, const SolveOptions& options,
                         const Progress& progress) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  IterationReport report;
  steps.start(pose);
  report.energy_before = report.energy_after = steps.fit(pose);
  search.restart();
  const double smallest_decrease = kSmallestDecrease * steps.rest_energy();
  while (report.iterations < options.max_iterations) {
    const double fraction = static_cast<double>(report.iterations) / options.max_iterations;
    if (progress && !progress(fraction)) {
      report.stop_reason = StopReason::kCancelled;
      return report;
    }
    if (options.acceleration == Acceleration::kNone) search.restart();
    const double energy = search.iterate(pose, report.energy_after);
    ++report.iterations;
    report.step = search.step();
    // Where the measured decrease drowns in rounding, the one that the slope promised still has its digits.
    const double measured = report.energy_after - energy;
    const double decrease = measured > 10 * steps.energy_rounding() ? measured : search.promised_decrease();
    report.energy_after = energy;
    if (decrease <= options.energy_tolerance * energy + smallest_decrease && report.step <= options.step_tolerance) {
      report.stop_reason = StopReason::kConverged;
      break;
    }
    if (std::chrono::duration<double>(Clock::now() - start).count() >= options.time_limit_s) {
      report.stop_reason = StopReason::kTimeLimit;
      break;
    }
  }
  steps.finish(pose);
  return report;
}

}  // namespace arap
