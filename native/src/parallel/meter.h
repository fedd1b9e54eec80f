// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <string>
#include <thread>

#include "arap/types.h"

namespace arap {

/// Progress of a part of the work. `progress` must outlive it.
[[nodiscard]] Progress part_of(const Progress& progress, double begin, double end);

/// How far long work is. Any thread says what it has done; the one that made the meter tells the caller's progress
/// every tenth of a second. After the caller has stopped the work, or its progress has thrown, every thread that says
/// something gets that exception.
class Meter {
 public:
  /// @param progress      lives as long as the meter; empty: the meter does nothing
  /// @param when_stopped  the message of Cancelled
  Meter(const Progress& progress, std::string when_stopped);

  /// This part of the whole is done in addition.
  void add(double part);
  /// At least this fraction of the whole is done. Tells it at once.
  void reach(double fraction);
  /// Tells what is done, in the thread that made the meter.
  void tell();

  /// Waits for work beside, and tells meanwhile.
  template <class Future>
  void wait_for(const Future& future) {
    using namespace std::chrono_literals;
    while (progress_ && future.wait_for(50ms) == std::future_status::timeout) add(0);
  }

 private:
  const Progress& progress_;
  std::string when_stopped_;
  std::thread::id caller_;
  std::chrono::steady_clock::time_point last_;  ///< when it was told
  double told_ = 0;
  std::atomic<double> done_ = 0;
  std::atomic<bool> is_stopped_ = false;
  std::exception_ptr reason_;
};

/// A part of the work that a meter measures; none by default.
struct MeterPart {
  Meter* meter = nullptr;
  double size = 0;  ///< of the whole

  /// A fraction of the part is done in addition.
  void add(double fraction) const {
    if (meter != nullptr) meter->add(size * fraction);
  }
  /// Step k of n is done, of a loop whose steps are too short to be told one by one.
  void add_nth(int k, int n) const {
    constexpr int kSteps = 4096;
    if ((k + 1) % kSteps == 0) add(static_cast<double>(kSteps) / n);
    if (k + 1 == n) add(static_cast<double>(n % kSteps) / n);
  }
  void tell() const {
    if (meter != nullptr) meter->tell();
  }
  /// Waits for work beside, and tells meanwhile.
  template <class Future>
  void wait_for(const Future& future) const {
    if (meter != nullptr) meter->wait_for(future);
  }
  [[nodiscard]] MeterPart part(double fraction) const { return {meter, size * fraction}; }
};

}  // namespace arap
