// SPDX-License-Identifier: GPL-3.0-or-later
// Work in a thread of its own: begun, looked at, cancelled, waited for. Nothing of Python.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>

#include "arap/types.h"
#include "parallel/process_id.h"

namespace arap_native {

/// One piece of work. Only the thread itself calls the work; all else is for the thread that made the job.
class Job {
 public:
  using Seconds = std::chrono::duration<double>;

  /// A job that is work(progress). Begin it: whoever waits for it waits for that, too.
  template <typename Work>
  static std::shared_ptr<Job> of(Work work) {
    // A forked child has no thread to wait for, and what that was writing is half written: there it stays as it is.
    return std::shared_ptr<Job>(new Job(std::move(work)), [](Job* ending) {
      if (ending->owner_ == arap::process_id()) delete ending;
    });
  }

  /// Begins the work, once. If no thread can be had, it is done in this one: without_thread(do_it) calls do_it().
  template <typename WithoutThread>
  void begin(const WithoutThread& without_thread) {
    try {
      thread_ = std::thread([this] { task_(); });
    } catch (const std::exception&) {  // no thread, or no memory for one
      without_thread([this] { task_(); });
    }
  }
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  /// Between 0 and 1.
  [[nodiscard]] double fraction() const { return fraction_; }

  /// Whether the work has ended, also by cancel() or an exception. What it worked on is then free.
  [[nodiscard]] bool is_done() const { return wait_for(Seconds(0)); }

  /// Asks the work to stop and does not wait for it.
  void cancel() { is_cancelled_ = true; }

  /// Waits for at most this time; returns is_done().
  [[nodiscard]] bool wait_for(Seconds time) const {
    return is_lost() || end_.wait_for(time) == std::future_status::ready;
  }

  /// Waits until it is done.
  void wait() const {
    if (!is_lost()) end_.wait();
  }

  /// Waits until it is done. Throws what the work threw.
  void finish() const {
    if (is_lost())
      throw std::runtime_error(
          "this job was begun before the process was forked, and only the parent goes on with it: begin it in this "
          "process");
    end_.get();
  }

 private:
  template <typename Work>
  explicit Job(Work work)
      : task_([this, work = std::move(work)]() mutable {
          Work ending = std::move(work);  // what it holds is let go before the job is done
          ending([this](double fraction) {
            fraction_ = fraction;
            return !is_cancelled_;
          });
          fraction_ = 1.0;
        }),
        end_(task_.get_future()) {}

  ~Job() {
    cancel();
    if (thread_.joinable()) thread_.join();
  }

  [[nodiscard]] bool is_lost() const {
    return owner_ != arap::process_id() && end_.wait_for(Seconds(0)) != std::future_status::ready;
  }

  arap::ProcessId owner_ = arap::process_id();
  std::atomic<double> fraction_ = 0.0;
  std::atomic<bool> is_cancelled_ = false;
  std::packaged_task<void()> task_;
  std::shared_future<void> end_;
  std::thread thread_;
};

}  // namespace arap_native
