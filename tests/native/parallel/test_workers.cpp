// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/workers.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <thread>
#include <vector>

#if defined(__unix__)
#include <sys/wait.h>
#include <unistd.h>
#endif

#include "parallel/parallel.h"

namespace {

using arap::Workers;

/// How often each piece was called.
std::vector<int> calls(const Workers& workers, int n_pieces) {
  std::vector<int> count(n_pieces, 0);
  workers.run(n_pieces, [&](int piece) { ++count[piece]; });
  return count;
}

class WorkersOf : public testing::TestWithParam<int> {};

TEST_P(WorkersOf, EveryPieceIsDoneOnce) {
  const Workers workers(GetParam());
  EXPECT_EQ(workers.threads(), GetParam());
  for (const int n_pieces : {0, 1, 2, 3, 7, 1000})
    for (int k = 0; k < 200; ++k) ASSERT_EQ(calls(workers, n_pieces), std::vector<int>(n_pieces, 1)) << n_pieces;
}

TEST_P(WorkersOf, WhatAPassWroteTheNextOneReads) {
  const Workers workers(GetParam());
  std::vector<int> x(100, 0);
  for (int k = 0; k < 500; ++k) {
    workers.run(100, [&](int piece) { ++x[piece]; });
    workers.run(100, [&](int piece) { x[99 - piece] += k; });
  }
  EXPECT_EQ(x, std::vector<int>(100, 500 + 499 * 500 / 2));
}

TEST_P(WorkersOf, APassMayStartAnother) {
  const Workers workers(GetParam());
  std::array<std::vector<int>, 8> inner;
  workers.run(8, [&](int piece) { inner[piece] = calls(workers, 50); });
  for (const std::vector<int>& count : inner) EXPECT_EQ(count, std::vector<int>(50, 1));
}

TEST_P(WorkersOf, AnExceptionReachesTheCallerAndTheNextPassIsWhole) {
  const Workers workers(GetParam());
  for (int k = 0; k < 20; ++k) {
    const auto fail_in_one = [](int piece) {
      if (piece == 7) throw std::bad_alloc();
    };
    EXPECT_THROW(workers.run(20, fail_in_one), std::bad_alloc);
    EXPECT_EQ(calls(workers, 20), std::vector<int>(20, 1));
  }
}

INSTANTIATE_TEST_SUITE_P(Threads, WorkersOf, testing::Values(1, 2, 3, 8));

TEST(Workers, ServeSeveralCallers) {
  const Workers workers(3);
  std::array<bool, 4> is_right{};
  std::vector<std::thread> callers;
  for (bool& right : is_right)
    callers.emplace_back([workers, &right] {
      right = true;
      for (int k = 0; k < 300; ++k) right = right && calls(workers, 20) == std::vector<int>(20, 1);
    });
  for (std::thread& caller : callers) caller.join();
  for (const bool right : is_right) EXPECT_TRUE(right);
}

TEST(Workers, WorkTogether) {
  // Two pieces that wait for each other: one thread alone would never end.
  const Workers workers(2);
  std::atomic<int> n_there = 0;
  workers.run(2, [&](int) {
    ++n_there;
    while (n_there < 2) std::this_thread::yield();
  });
  EXPECT_EQ(n_there, 2);
}

TEST(Workers, ComeBackFromSleep) {
  const Workers workers(2);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(calls(workers, 10), std::vector<int>(10, 1));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

TEST(Workers, LiveAsLongAsTheLastCopy) {
  auto first = std::make_unique<Workers>(2);
  const Workers copy = *first;
  EXPECT_EQ(calls(*first, 10), std::vector<int>(10, 1));
  first.reset();
  EXPECT_EQ(calls(copy, 10), std::vector<int>(10, 1));
}

TEST(Parallel, WhatAPieceOfABindThrowsArrivesOnce) {
  for (const int threads : {1, 2, 3}) try {
      arap::parallel_for<1>(threads, 100, [](int begin, int) {
        if (begin % 7 == 3) throw std::bad_alloc();
      });
      FAIL() << threads;
    } catch (const std::bad_alloc&) {
      SUCCEED();
    }
}

TEST(Parallel, SeveralCallersMakeTeamsAtOnce) {
  constexpr int kCallers = 4;
  constexpr int kPieces = 50;
  std::vector<std::atomic<int>> done(kPieces);
  std::vector<std::thread> callers;
  for (int caller = 0; caller < kCallers; ++caller)
    callers.emplace_back([&] {
      for (const int threads : {2, 4, 3, 4})
        arap::for_each_piece(threads, kPieces, [&](int piece) { ++done[static_cast<size_t>(piece)]; });
    });
  for (std::thread& caller : callers) caller.join();
  for (const std::atomic<int>& of_piece : done) EXPECT_EQ(of_piece, 4 * kCallers);
}

#if defined(__unix__)
TEST(Workers, AForkedChildWorksAlone) {
  constexpr unsigned kSeconds = 60;
  auto workers = std::make_unique<Workers>(3);
  EXPECT_EQ(calls(*workers, 10), std::vector<int>(10, 1));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // the threads sleep: the child's copy says so for ever
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(kSeconds);  // ends a child that waits for threads which it has not got
    const bool is_right = calls(*workers, 10) == std::vector<int>(10, 1);
    workers.reset();
    _exit(is_right ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(calls(*workers, 10), std::vector<int>(10, 1));
}
#endif

}  // namespace
