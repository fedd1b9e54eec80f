// SPDX-License-Identifier: GPL-3.0-or-later
// The GIL, for work that goes on without it.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <thread>
#include <type_traits>

#ifdef __GLIBCXX__
#include <cxxabi.h>
#endif

namespace arap_native {

namespace py = pybind11;

/// Does what needs the GIL in a thread that may outlive the interpreter (a daemon thread while Python exits). Such a
/// thread has nothing left to do; it sleeps until the process ends, as Python 3.14 has it. Earlier ones unwind its
/// stack where it wants the GIL, which is terminate() where C++ destructors are on the stack: `work` has none, pure C
/// API.
template <typename Work>
std::invoke_result_t<Work> outlive_python(const Work& work) {
  const auto sleep_until_the_end = [] {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  };
  if (Py_IsInitialized() == 0) sleep_until_the_end();
#ifdef __GLIBCXX__
  try {
    return work();
  } catch (const abi::__forced_unwind&) {
    sleep_until_the_end();
    throw;  // never reached; libstdc++ asks for it
  }
#else
  return work();
#endif
}

/// The GIL is released while this lives.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  ~WithoutGil() {
    outlive_python([this] { PyEval_RestoreThread(state_); });
  }
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

 private:
  PyThreadState* state_;
};

}  // namespace arap_native
