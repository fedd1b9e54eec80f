// SPDX-License-Identifier: GPL-3.0-or-later
#include "job_handle.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "docstrings.h"
#include "signature.h"

namespace arap_native {

void Jobs::add(const std::shared_ptr<Job>& job, const py::object& kept) {
  const auto done =
      std::partition(entries_.begin(), entries_.end(), [](const Entry& entry) { return !entry.job->is_done(); });
  // Let go at the end: what Python then calls may begin a job, so the list must be whole.
  const std::vector<Entry> ended(std::make_move_iterator(done), std::make_move_iterator(entries_.end()));
  entries_.erase(done, entries_.end());
  entries_.push_back({job, kept});
}

void Jobs::close() {
  is_closed_ = true;
  const std::vector<Entry> under_way = std::exchange(entries_, {});
  for (const Entry& entry : under_way) entry.job->cancel();
  const WithoutGil no_gil;
  for (const Entry& entry : under_way) entry.job->wait();
}

bool JobHandle::wait(double timeout_s) {
  using Clock = std::chrono::steady_clock;
  constexpr double kSignalCheckS = 0.1;
  if (!(timeout_s >= 0))
    throw py::value_error(py::str("timeout_s = {}, must be 0 or more").format(timeout_s).cast<std::string>());
  const auto waited_for = [this](double seconds) {
    const WithoutGil no_gil;
    return job_->wait_for(Job::Seconds(seconds));
  };
  const auto start = Clock::now();
  for (;;) {
    const double left = timeout_s - Job::Seconds(Clock::now() - start).count();
    if (waited_for(std::clamp(left, 0.0, kSignalCheckS))) return true;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (left <= kSignalCheckS) return false;
  }
}

py::object JobHandle::result() {
  wait(std::numeric_limits<double>::infinity());
  job_->finish();
  if (result_) return result_;
  // Taken before the call: that takes the work's result apart, so it is not for a second one.
  const auto make_result = std::exchange(make_result_, nullptr);
  if (!make_result)
    throw std::runtime_error(
        "the result of this job is not there, because an earlier call of result() has failed or has not ended: "
        "begin the job again");
  return result_ = make_result();
}

std::string JobHandle::repr() const {
  return is_done() ? "<Job: done>" : py::str("<Job: {:.0%}>").format(fraction()).cast<std::string>();
}

void bind_job(py::module_& m) {
  py::class_<JobHandle> type(m, "Job", docstrings::Job);
  def_property(
      type, "fraction", [](const JobHandle& job) { return job.fraction(); }, docstrings::Job_fraction);
  def_property(
      type, "is_done", [](const JobHandle& job) { return job.is_done(); }, docstrings::Job_is_done);
  def(type, docstrings::Job_cancel, [](JobHandle& job) { job.cancel(); });
  def(type, docstrings::Job_wait, [](JobHandle& job, double timeout_s) { return job.wait(timeout_s); });
  def(type, docstrings::Job_result, [](JobHandle& job) { return job.result(); });
  def(type, "__repr__(self)", [](const JobHandle& job) { return job.repr(); });
}

}  // namespace arap_native
