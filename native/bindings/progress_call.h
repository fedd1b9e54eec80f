// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <utility>

#include "arap/types.h"
#include "arrays.h"
#include "gil.h"

namespace arap_native {

namespace py = pybind11;

/// Calls a Python callback from work that runs without the GIL, and lets Ctrl-C through, also without a callback.
class ProgressCall {
 public:
  explicit ProgressCall(py::object callback) : callback_(std::move(callback)) {
    if (!callback_.is_none() && PyCallable_Check(callback_.ptr()) == 0)
      throw py::type_error("progress is of type " + type_name(callback_) + ", expected a callable or None");
  }

  /// For the library. A reference: copies of a Python object need the GIL.
  arap::Progress function() {
    return [this](double fraction) { return call(fraction); };
  }

 private:
  bool call(double fraction) {
    if (callback_.ptr() == Py_None && !is_signal_check_due()) return true;
    PyGILState_STATE gil{};
    const int answer = outlive_python([&] {
      gil = PyGILState_Ensure();
      return ask(fraction);
    });
    if (answer >= 0) {
      PyGILState_Release(gil);
      return answer != 0;
    }
    const py::error_already_set error;
    PyGILState_Release(gil);
    throw py::error_already_set(error);
  }

  /// Whether to go on: 1 or 0; -1 with a Python error set.
  [[nodiscard]] int ask(double fraction) const {
    if (PyErr_CheckSignals() != 0) return -1;
    if (callback_.ptr() == Py_None) return 1;
    PyObject* answer = PyObject_CallFunction(callback_.ptr(), "d", fraction);
    if (answer == nullptr) return -1;
    const int go_on = answer == Py_None ? 1 : PyObject_IsTrue(answer);
    Py_DECREF(answer);
    return go_on;
  }

  /// Seldom: waiting for the GIL can take longer than a step of the work.
  bool is_signal_check_due() {
    constexpr std::chrono::milliseconds kInterval{100};
    const auto now = std::chrono::steady_clock::now();
    if (now - last_signal_check_ < kInterval) return false;
    last_signal_check_ = now;
    return true;
  }

  py::object callback_;
  std::chrono::steady_clock::time_point last_signal_check_ = std::chrono::steady_clock::now();
};

}  // namespace arap_native
