// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arap/types.h"
#include "gil.h"
#include "job.h"

namespace arap_native {

namespace py = pybind11;

/// The jobs under way, and what must live as long as each. A job that nobody asks for any more ends by itself.
class Jobs {
 public:
  void check_open() const {
    if (is_closed_) throw std::runtime_error("Python is about to exit: no job can be begun");
  }

  /// @param kept  lives until the job is done
  void add(const std::shared_ptr<Job>& job, const py::object& kept);

  /// Ends all. For Python's exit: what they use would go away below them.
  void close();

 private:
  struct Entry {
    std::shared_ptr<Job> job;
    py::object kept;
  };
  std::vector<Entry> entries_;
  bool is_closed_ = false;
};

/// A Job for Python. Only the thread that calls it touches Python.
class JobHandle {
 public:
  /// @param result  makes the result once the job is done; called once
  JobHandle(std::shared_ptr<Job> job, std::function<py::object()> result)
      : job_(std::move(job)), make_result_(std::move(result)) {}
  ~JobHandle() { job_->cancel(); }
  JobHandle(const JobHandle&) = delete;
  JobHandle& operator=(const JobHandle&) = delete;

  [[nodiscard]] double fraction() const { return job_->fraction(); }
  [[nodiscard]] bool is_done() const { return job_->is_done(); }
  void cancel() { job_->cancel(); }

  bool wait(double timeout_s);
  py::object result();
  [[nodiscard]] std::string repr() const;

 private:
  std::shared_ptr<Job> job_;
  std::function<py::object()> make_result_;
  py::object result_;
};

/// Begins a job. Its result is to_python(work(progress)), and only to_python has the GIL. `kept` lives until it is
/// done.
template <typename Work, typename ToPython>
std::unique_ptr<JobHandle> begin_job(Jobs& jobs, Work work, ToPython to_python, const py::object& kept = py::none()) {
  using Result = std::invoke_result_t<Work&, const arap::Progress&>;
  jobs.check_open();
  const auto result = std::make_shared<std::optional<Result>>();
  const auto job = Job::of(
      [work = std::move(work), result](const arap::Progress& progress) mutable { result->emplace(work(progress)); });
  auto handle = std::make_unique<JobHandle>(
      job, [result, to_python = std::move(to_python)]() mutable { return to_python(std::move(**result)); });
  // Before the work begins: if it is done in this thread, another one may close all meanwhile.
  jobs.add(job, kept);
  job->begin([](const auto& do_it) {
    const WithoutGil no_gil;
    do_it();
  });
  return handle;
}

/// Adds Job to the module.
void bind_job(py::module_& m);

}  // namespace arap_native
