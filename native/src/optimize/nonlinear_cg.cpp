// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/nonlinear_cg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "optimize/row_grain.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Nearer to the minimum the rounded forces of single precision make the iteration slower, and some 1e-6 from it they
/// end it: what is soft multiplies them.
constexpr double kNearestInSingle = 1e-4;

template <class Rows>
auto flat(Rows& x, int begin, int end) {
  // As one array: the compilers see through that, not through blocks of a matrix.
  using Number = typename Rows::Scalar;
  using Array = Eigen::Array<Number, Eigen::Dynamic, 1>;
  using Map = std::conditional_t<std::is_const_v<Rows>, Eigen::Map<const Array>, Eigen::Map<Array>>;
  return Map(x.data() + std::ptrdiff_t{3} * begin, std::ptrdiff_t{3} * static_cast<std::ptrdiff_t>(end - begin));
}

template <class Number>
Number longest_squared(const Number* begin, const Number* end) {
  Number longest = 0;
  for (const Number* row = begin; row != end; row += 3)
    longest = std::max(longest, row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
  return longest;
}

/// The part of the digits between two distances from the minimizer that are found, in [0, 1]: distances fall at an even
/// rate.
double way_done(double farthest, double distance, double accuracy) {
  if (!(distance < farthest && accuracy > 0 && accuracy < farthest)) return 0;
  return std::clamp(std::log(farthest / distance) / std::log(farthest / accuracy), 0.0, 1.0);
}

int row_count(const Positions& x) { return static_cast<int>(x.rows()); }

}  // namespace

double NonlinearCg::slope_along_direction() const {
  return steps_.with_free_residual([&](const Positions& residual) {
    return parallel_sum<kRows>(steps_.workers(), row_count(residual), [&](int begin, int end) {
      return (flat(direction_, begin, end).cast<double>() * flat(residual, begin, end)).sum();
    });
  });
}

NonlinearCg::Sums NonlinearCg::sum_products(const Positions& residual) {
  const Positions& correction = correction_;
  residual_.resize(residual.rows(), 3);  // memory only where it is not there yet
  direction_.resize(residual.rows(), 3);
  const bool is_fresh = is_fresh_;
  return parallel_reduce<kRows>(
      steps_.workers(), row_count(residual), Sums{},
      [&](int begin, int end) {
        const auto z = flat(correction, begin, end);
        const auto r = flat(residual, begin, end);
        auto last_r = flat(residual_, begin, end);
        Sums part{(z * r).sum(), 0, 0};
        if (!is_fresh) {
          part[1] = (z * last_r.cast<double>()).sum();
          part[2] = (flat(direction_, begin, end).cast<double>() * r).sum();
        }
        last_r = r.cast<float>();
        return part;
      },
      [](const Sums& a, const Sums& b) {
        return Sums{a[0] + b[0], a[1] + b[1], a[2] + b[2]};
      });
}

double NonlinearCg::choose_beta() {
  const Sums sums = steps_.with_free_residual([&](const Positions& residual) { return sum_products(residual); });
  const double z_r = sums[0];
  double beta = is_fresh_ ? 0 : std::max(0.0, (z_r - sums[1]) / z_r_);
  slope_ = z_r + beta * sums[2];
  if (!(slope_ > 0) || !std::isfinite(beta)) {
    beta = 0;
    slope_ = z_r;
  }
  z_r_ = z_r;
  return beta;
}

template <class Update>
double NonlinearCg::move(Pose& pose, double length, const Update& update) {
  pose.positions.resize(start_.rows(), 3);
  const float longest = parallel_reduce<kRows>(
      steps_.workers(), row_count(start_), 0.0F,
      [&](int begin, int end) {
        auto d = flat(direction_, begin, end);
        update(d, begin, end);
        flat(pose.positions, begin, end) = flat(std::as_const(start_), begin, end) + length * d.template cast<double>();
        return longest_squared(d.data(), d.data() + d.size());
      },
      [](float a, float b) { return std::max(a, b); });
  pose.placements = placements_;
  steps_.follow_positions(pose);
  // Squares of lengths of 1e20 and more are too large for single precision.
  step_ = std::isfinite(longest) ? length * std::sqrt(static_cast<double>(longest))
                                 : longest_row(pose.positions - start_, steps_.workers());
  return steps_.fit(pose);
}

double NonlinearCg::try_length(Pose& pose, double length) {
  return move(pose, length, [](const auto&, int, int) {});
}

double NonlinearCg::try_direction(Pose& pose, double length, double beta) {
  const Positions& correction = correction_;
  if (beta > 0)
    return move(pose, length, [&](auto& d, int begin, int end) {
      d = flat(correction, begin, end).template cast<float>() + static_cast<float>(beta) * d;
    });
  return move(pose, length,
              [&](auto& d, int begin, int end) { d = flat(correction, begin, end).template cast<float>(); });
}

double NonlinearCg::iterate(Pose& pose, double energy, Acceleration acceleration) {
  constexpr double kLongest = 4;
  constexpr double kShortest = 0.25;
  constexpr int kMostShorter = 8;
  constexpr double kLeastShare = 1e-3;
  constexpr double kSecondLook = 0.3;  // relative change of the length that is worth another fit
  if (acceleration == Acceleration::kNone) is_fresh_ = true;
  steps_.find_correction(pose, correction_);
  const double beta = choose_beta();
  steps_.begin_step(pose);
  start_.swap(pose.positions);
  placements_ = pose.placements;
  const double rounding = steps_.energy_rounding(energy);

  double length = is_fresh_ ? 1 : length_;
  double reached = try_direction(pose, length, beta);
  const auto is_worse = [&] { return !(reached <= energy + rounding); };  // or no number
  if (!is_fresh_ || is_worse()) {
    double better = length * slope_ / (slope_ - slope_along_direction());
    if (!(better > 0) || better > kLongest * length) better = kLongest * length;
    if (std::abs(better - length) > kSecondLook * length || is_worse()) {
      length = better;
      reached = try_length(pose, length);
    }
  }
  is_fresh_ = is_worse();
  if (is_worse()) {
    length = 1;
    slope_ = z_r_;
    reached = try_direction(pose, length, 0);
  }
  // The plain step raises nothing but where volumes are kept, the factor is far from the matrix, or numbers end.
  for (int shorter = 0; is_worse() && shorter < kMostShorter; ++shorter) {
    // To the lowest point of the parabola through the slope and what was reached: half of it, or far less where
    // volumes are torn.
    const double promised = length * slope_;
    const double share = promised / (2 * (reached - energy + promised));
    length *= share > kLeastShare ? std::min(share, 0.5) : kLeastShare;
    if (shorter + 1 == kMostShorter) length = 0;
    reached = try_length(pose, length);
  }
  // A fit turns rigid regions, which no direction says.
  step_ = steps_.step_with_turns(pose, step_);
  // What the slope promised, not what was measured: that drowns in rounding first.
  distance_.add(step_, length * slope_);
  length_ = std::clamp(length, kShortest, kLongest);
  return reached;
}

bool NonlinearCg::is_soft_within(double accuracy, const Pose& pose, const SoftDirections::MayGoOn& may_go_on) {
  constexpr double kTurned = 0.3;  // they are others there
  constexpr double kTurnedALittle = 0.1;
  constexpr double kSafety = 5;  // of a soft direction a few global steps find a part
  if (longest_correction() <= steps_.movement_rounding()) return true;  // as at rest
  const auto is_within = [&] {
    const double distance = soft_.distance();
    return kSafety * distance <= accuracy || soft_rounding_.is_lost(distance);
  };
  const double turned = soft_.turned();
  if (turned <= kTurned && is_within()) return true;
  if (turned <= kTurnedALittle || !soft_.find(pose, may_go_on)) return false;
  soft_rounding_ = {};
  return is_within();
}

bool ends_in_double(double accuracy) {
  constexpr double kRoundedToFloat = 1 - 1e-6;  // what somebody keeps as a float may be a little less than it says
  return accuracy < kRoundedToFloat * kNearestInSingle;
}

bool needs_double(double distance, double accuracy) { return distance <= kNearestInSingle && ends_in_double(accuracy); }

IterationReport minimize(LocalGlobal& steps, NonlinearCg& search, Pose& pose, const SolveOptions& options,
                         const Progress& progress, TimeBudget& time, std::optional<double> step_before,
                         const std::function<void()>& on_first_fit) {
  IterationReport report;
  steps.start(pose);
  report.energy_before = report.energy_after = steps.fit(pose);
  if (step_before) step_before = steps.step_with_turns(pose, *step_before);
  on_first_fit();
  double farthest = 0;  // from the minimizer, so far
  double fraction = 0;
  int n_still = 0;
  const auto is_cancelled = [&] {
    fraction = std::max({fraction, static_cast<double>(report.iterations) / options.max_iterations,
                         way_done(farthest, search.distance(), options.accuracy)});
    if (!progress || progress(fraction)) return false;
    report.stop_reason = StopReason::kCancelled;
    return true;
  };
  const auto count_iteration = [&](double step) {
    ++report.iterations;
    report.step = step;
    if (std::isfinite(search.distance())) farthest = std::max(farthest, search.distance());
    time.end_iteration();
  };
  if (step_before) {
    if (is_cancelled()) return report;
    count_iteration(*step_before);
  } else {
    time.begin_iteration();
  }
  const bool finds_soft = options.acceleration == Acceleration::kConjugateGradients && steps.fit_keeps_unknowns();
  const auto may_go_on = [&] { return time.allows_another() && !is_cancelled(); };
  // Once a number is not finite, no step makes it so again.
  while (std::isfinite(report.energy_after) && report.iterations < options.max_iterations) {
    if (report.iterations > 0 && !time.allows_another()) {
      report.stop_reason = StopReason::kTimeLimit;
      break;
    }
    if (is_cancelled()) return report;
    report.energy_after = search.iterate(pose, report.energy_after, options.acceleration);
    count_iteration(search.step());
    // One still step may only be short; after two, numbers are at their end, as if handles are a million times the
    // mesh's size away.
    n_still = search.step() <= steps.movement_rounding() ? n_still + 1 : 0;
    const bool is_stuck = options.accuracy > 0 && n_still == 2;
    if ((is_stuck || needs_double(search.distance(), options.accuracy)) && steps.go_on_in_double(pose)) {
      n_still = 0;
      // Single precision knows all energies of a model with the same small error.
      const double in_single = report.energy_after;
      report.energy_after = steps.fit(pose);
      report.energy_before += report.energy_after - in_single;
      continue;
    }
    // A short step may only be a short length, and what is soft moves by short steps.
    const bool is_near = search.distance() <= options.accuracy && search.longest_correction() <= options.accuracy;
    if (is_stuck || (is_near && (!finds_soft || search.is_soft_within(options.accuracy, pose, may_go_on)))) {
      report.stop_reason = StopReason::kConverged;
      break;
    }
    if (report.stop_reason == StopReason::kCancelled) return report;
  }
  if (std::isfinite(report.energy_after)) steps.finish(pose);
  fraction = 1;
  static_cast<void>(is_cancelled());
  return report;
}

}  // namespace arap
