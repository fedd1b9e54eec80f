// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/workers.h"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/processor.h"
#include "parallel/process_id.h"

namespace arap {

namespace {

/// Threads, and where they sleep. A forked child has copies that can be neither joined nor destroyed.
class Crew {
 public:
  std::vector<std::thread> threads;

  /// Waits until is_over(value): spins, then yields, then sleeps until notify_all(). Not by std::atomic::wait(), which
  /// loses wake-ups in a standard library (MinGW's). Reads are sequentially consistent, see serve().
  template <class Value, class IsOver>
  Value wait_for(const std::atomic<Value>& changing, const IsOver& is_over) {
    constexpr int kSpins = 4000;  // the gaps between the passes of an iteration
    constexpr int kYields = 100;
    for (int turn = 0; turn < kSpins + kYields; ++turn) {
      const Value value = changing.load();
      if (is_over(value)) return value;
      if (turn < kSpins)
        pause();
      else
        std::this_thread::yield();
    }
    std::unique_lock lock(mutex_);
    n_asleep_.fetch_add(1);
    Value value = changing.load();
    for (; !is_over(value); value = changing.load()) changed_.wait(lock);
    n_asleep_.fetch_sub(1);
    return value;
  }

  /// Call after each change that may end a wait. Either this sees the sleeper, or it sees the change: each writes
  /// before it reads.
  void notify_all() {
    if (n_asleep_.load() == 0) return;
    { const std::scoped_lock until_it_sleeps(mutex_); }
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<int> n_asleep_ = 0;
};

}  // namespace

class Workers::Pool {
 public:
  explicit Pool(int threads) : shares_(threads) {}
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  ~Pool() {
    if (is_started_ && process_id() != owner_) {
      static_cast<void>(crew_.release());
      return;
    }
    is_ending_.store(true, std::memory_order_relaxed);
    phase_.fetch_add(2);
    crew_->notify_all();
    for (std::thread& thread : crew_->threads) thread.join();
  }

  void run(int n_pieces, const Task& task) {
    FirstFailure failure;
    if (is_busy_.exchange(true, std::memory_order_acquire)) {
      run_alone(n_pieces, task, failure);
    } else {
      if (!is_started_) start();
      if (owner_ == process_id())
        run_together(n_pieces, task, failure);
      else
        run_alone(n_pieces, task, failure);
      is_busy_.store(false, std::memory_order_release);
    }
    failure.rethrow();
  }

 private:
  /// Consecutive pieces, one share for each thread: it finds in its cache what it wrote in the pass before. A thread
  /// that is done with its share helps with the others.
  struct alignas(64) Share {
    std::atomic<int> next = 0;
    int end = 0;
  };

  void run_together(int n_pieces, const Task& task, FirstFailure& failure) {
    task_ = task;
    failure_ = &failure;
    const auto n = static_cast<std::int64_t>(n_pieces);
    const auto n_shares = static_cast<std::int64_t>(shares_.size());
    for (std::int64_t s = 0; s < n_shares; ++s) {
      shares_[s].next.store(static_cast<int>(n * s / n_shares), std::memory_order_relaxed);
      shares_[s].end = static_cast<int>(n * (s + 1) / n_shares);
    }
    phase_.fetch_add(1);
    crew_->notify_all();
    work(0);
    phase_.fetch_add(1);
    crew_->wait_for(n_inside_, [](int n_inside) { return n_inside == 0; });
  }

  static void run_alone(int n_pieces, const Task& task, FirstFailure& failure) {
    for (int piece = 0; piece < n_pieces; ++piece) failure.guard([&] { task.call(task.body, piece); });
  }

  void start() {
    is_started_ = true;
    owner_ = process_id();
    try {
      for (size_t rank = 1; rank < shares_.size(); ++rank) crew_->threads.emplace_back([this, rank] { serve(rank); });
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): no thread or no memory for one
      // The threads that there are do all pieces.
    }
  }

  void work(size_t rank) {
    for (size_t k = 0; k < shares_.size(); ++k) {
      Share& share = shares_[(rank + k) % shares_.size()];
      for (int piece; (piece = share.next.fetch_add(1, std::memory_order_relaxed)) < share.end;)
        failure_->guard([&] { task_.call(task_.body, piece); });
    }
  }

  void serve(size_t rank) {
    const auto is_open = [](unsigned phase) { return phase % 2 == 1; };
    for (unsigned last = 0;;) {
      const unsigned phase =
          crew_->wait_for(phase_, [&](unsigned p) { return (is_open(p) && p != last) || is_ending(); });
      if (is_ending()) return;
      // Either the caller sees that this thread is inside and waits, or this thread sees that the pass is over: each
      // writes before it reads, and the four accesses are sequentially consistent.
      n_inside_.fetch_add(1);
      if (phase_.load() == phase) work(rank);
      if (n_inside_.fetch_sub(1) == 1) crew_->notify_all();
      last = phase;
    }
  }

  [[nodiscard]] bool is_ending() const { return is_ending_.load(std::memory_order_relaxed); }

  // In separate cache lines: claiming threads do not disturb waiting ones.
  alignas(64) std::atomic<unsigned> phase_ = 0;  ///< odd while a pass is open
  alignas(64) std::atomic<int> n_inside_ = 0;    ///< threads that may work on a piece, the caller excluded
  alignas(64) std::atomic<bool> is_busy_ = false;
  std::atomic<bool> is_ending_ = false;
  bool is_started_ = false;
  Task task_{};
  FirstFailure* failure_ = nullptr;  ///< of the pass
  std::vector<Share> shares_;
  std::unique_ptr<Crew> crew_ = std::make_unique<Crew>();
  ProcessId owner_ = 0;  ///< process that has the threads
};

Workers::Workers(int threads) : threads_(threads), pool_(threads > 1 ? std::make_shared<Pool>(threads) : nullptr) {}

void Workers::run_on(Pool& pool, int n_pieces, const Task& task) { pool.run(n_pieces, task); }

}  // namespace arap
