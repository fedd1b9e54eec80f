// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/time_budget.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>
#include <vector>

namespace arap_test {
namespace {

using arap::TimeBudget;

/// A solve whose clock goes on only when told to.
class Solve {
 public:
  explicit Solve(double limit_s) : time_(limit_s, [this] { return now_s_; }) {}

  void pass(double seconds) { now_s_ += seconds; }
  void iterate(const std::vector<double>& durations) {
    for (const double duration : durations) {
      pass(duration);
      time_.end_iteration();
    }
  }
  TimeBudget& time() { return time_; }
  [[nodiscard]] bool allows_another() const { return time_.allows_another(); }

 private:
  double now_s_ = 1000;
  TimeBudget time_;
};

TEST(TimeBudget, EndsBeforeTheIterationThatWouldPassTheLimit) {
  Solve solve(12);
  solve.iterate({4});
  EXPECT_TRUE(solve.allows_another()) << "8 of 12";
  solve.iterate({4});
  EXPECT_TRUE(solve.allows_another()) << "12 of 12";
  solve.pass(.5);
  EXPECT_FALSE(solve.allows_another()) << "12.5 of 12";
}

TEST(TimeBudget, EndsAfterOneIterationThatTookMoreThanHalfOfIt) {
  Solve solve(12);
  solve.iterate({6.5});
  EXPECT_FALSE(solve.allows_another());
}

TEST(TimeBudget, EndsWhereTimeIsUpHoweverShortIterationsAre) {
  Solve solve(12);
  solve.pass(12);
  EXPECT_FALSE(solve.allows_another()) << "the first one too";
  solve.time().begin_iteration();
  solve.iterate({0});
  EXPECT_FALSE(solve.allows_another());
}

TEST(TimeBudget, CountsTheLimitFromTheStartAndIterationsFromTheirs) {
  Solve solve(12);
  solve.pass(6);  // a guess is no iteration
  solve.time().begin_iteration();
  solve.iterate({3});
  EXPECT_TRUE(solve.allows_another()) << "12 of 12";
  solve.iterate({3});
  EXPECT_FALSE(solve.allows_another());
}

TEST(TimeBudget, OneSlowIterationCountsLittleWhereverItComes) {
  const std::vector<std::vector<double>> all = {{9, 1}, {1, 9}, {1, 9, 1}, {1, 1, 9, 1, 1}};
  for (const std::vector<double>& durations : all) {
    Solve solve(20);
    solve.iterate(durations);
    EXPECT_TRUE(solve.allows_another()) << "the next one takes 1";
  }
}

TEST(TimeBudget, FollowsIterationsThatHaveBecomeSlow) {
  Solve solve(100);
  solve.iterate({1, 1, 1, 1, 1, 1, 1, 1, 1, 1});
  solve.iterate({26, 26, 26});
  EXPECT_FALSE(solve.allows_another()) << "12 are left, and three of the last five took 26";
}

TEST(TimeBudget, WithoutALimitThereIsAlwaysTime) {
  Solve solve(std::numeric_limits<double>::infinity());
  solve.iterate({1e300, 1e300});
  EXPECT_TRUE(solve.allows_another());
}

TEST(TimeBudget, ItsOwnClockGoesOnWhileNothingIsComputed) {
  const TimeBudget time(1e-3);
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_FALSE(time.allows_another());
}

}  // namespace
}  // namespace arap_test
