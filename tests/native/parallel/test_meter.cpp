// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/meter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

#include "arap/error.h"
#include "parallel/usable_cpus.h"

namespace {

using arap::Meter;
using arap::Progress;

TEST(Meter, TellsWhatAllThreadsHaveDoneInTheCallersOne) {
  std::vector<double> told;
  const std::thread::id caller = std::this_thread::get_id();
  const Progress progress = [&](double fraction) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    told.push_back(fraction);
    return true;
  };
  Meter meter(progress, "");
  meter.tell();
  std::thread other([&] { meter.add(0.25); });
  other.join();
  meter.add(0.25);
  meter.tell();
  meter.reach(0.4);  // more is done already
  meter.reach(0.75);
  meter.add(0.5);
  meter.tell();
  EXPECT_EQ(told, (std::vector{0.0, 0.5, 0.5, 0.75, 1.0}));
}

TEST(Meter, TellsWhileItWaits) {
  std::promise<void> end;
  const std::future<void> ended = end.get_future();
  int n_calls = 0;
  const Progress progress = [&](double) {
    if (++n_calls == 2) end.set_value();
    return true;
  };
  Meter meter(progress, "");
  meter.wait_for(ended);  // would not end
  EXPECT_EQ(n_calls, 2);
}

TEST(Meter, EveryThreadLearnsWhyTheWorkIsStopped) {
  const Progress refuse = [](double) { return false; };
  const Progress fail = [](double) -> bool { throw std::domain_error("from the callback"); };
  Meter refused(refuse, "stopped");
  Meter failed(fail, "stopped");
  EXPECT_THROW(refused.tell(), arap::Cancelled);
  EXPECT_THROW(failed.tell(), std::domain_error);
  std::thread other([&] {
    EXPECT_THROW(refused.add(0.1), arap::Cancelled);
    EXPECT_THROW(failed.add(0.1), std::domain_error);
  });
  other.join();
}

TEST(Meter, WithoutProgressDoesNothing) {
  const Progress none;
  Meter meter(none, "");
  EXPECT_NO_THROW(meter.reach(0.5));
  EXPECT_NO_THROW(arap::MeterPart().add(0.5));
}

TEST(UsableCpus, AQuotaCountsInWholeCpus) {
  EXPECT_EQ(arap::cpus_of_quota("200000 100000"), 2);
  EXPECT_EQ(arap::cpus_of_quota("150000 100000"), 2);
  EXPECT_EQ(arap::cpus_of_quota("1000 100000"), 1);
  for (const char* all : {"max 100000", "", "100000", "-1 100000", "100000 0"})
    EXPECT_EQ(arap::cpus_of_quota(all), std::nullopt) << all;
  EXPECT_GE(arap::usable_cpus(), 1);
}

}  // namespace
