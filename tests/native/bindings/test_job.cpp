// SPDX-License-Identifier: GPL-3.0-or-later
#include "job.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>

#if defined(__unix__)
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace {

using arap_native::Job;
using Seconds = Job::Seconds;

template <typename Work>
std::shared_ptr<Job> begin(Work work) {
  auto job = Job::of(std::move(work));
  job->begin([](const auto& do_it) { do_it(); });
  return job;
}

/// Works until it is cancelled; says so by an exception as the library does.
void work_for_ever(const arap::Progress& progress) {
  while (progress(0.5)) std::this_thread::yield();
  throw std::runtime_error("cancelled");
}

TEST(Job, WorksInAnotherThreadAndTellsHowFar) {
  std::thread::id worker;
  std::atomic<bool> may_end = false;
  const auto job = begin([&](const arap::Progress& progress) {
    worker = std::this_thread::get_id();
    EXPECT_TRUE(progress(0.25));
    while (!may_end) std::this_thread::yield();
  });
  while (job->fraction() == 0.0) std::this_thread::yield();
  EXPECT_EQ(job->fraction(), 0.25);
  EXPECT_FALSE(job->wait_for(Seconds(0.001)));
  EXPECT_FALSE(job->is_done());
  may_end = true;
  job->finish();
  EXPECT_TRUE(job->is_done());
  EXPECT_EQ(job->fraction(), 1.0);
  EXPECT_NE(worker, std::this_thread::get_id());
}

TEST(Job, FinishThrowsWhatTheWorkThrew) {
  const auto job = begin([](const arap::Progress&) { throw std::invalid_argument("no mesh"); });
  job->wait();
  EXPECT_TRUE(job->is_done());
  EXPECT_THROW(job->finish(), std::invalid_argument);
  EXPECT_THROW(job->finish(), std::invalid_argument);
}

TEST(Job, CancelIsHeard) {
  const auto job = begin(work_for_ever);
  job->cancel();
  EXPECT_THROW(job->finish(), std::runtime_error);
}

TEST(Job, ItsEndCancelsAndWaits) {
  std::atomic<bool> has_ended = false;
  auto job = begin([&](const arap::Progress& progress) {
    while (progress(0.5)) std::this_thread::yield();
    has_ended = true;
  });
  job.reset();
  EXPECT_TRUE(has_ended);
}

TEST(Job, LetsGoOfWhatItWorkedOnBeforeItIsDone) {
  const auto held = std::make_shared<int>();
  const auto job = begin([copy = held](const arap::Progress&) {});
  job->wait();
  EXPECT_EQ(held.use_count(), 1);
  const auto failed = begin([copy = held](const arap::Progress&) { throw std::runtime_error("no"); });
  failed->wait();
  EXPECT_EQ(held.use_count(), 1);
}

#if defined(__unix__)
TEST(Job, AForkedChildHasLostIt) {
  constexpr unsigned kSeconds = 60;
  auto done = begin([](const arap::Progress&) {});
  done->wait();
  auto job = begin(work_for_ever);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(kSeconds);  // ends a child that waits for a thread which it has not got
    bool is_right = job->is_done() && job->wait_for(Seconds(1));
    job->wait();
    done->finish();
    try {
      job->finish();
      is_right = false;
    } catch (const std::runtime_error&) {  // NOLINT(bugprone-empty-catch): what it has to throw
    }
    job.reset();
    done.reset();
    _exit(is_right ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_FALSE(job->is_done());
}
#endif

}  // namespace
