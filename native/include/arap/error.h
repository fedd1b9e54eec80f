// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <new>
#include <stdexcept>
#include <string>

namespace arap {

/// The caller's input is wrong; the message names the field, the place and what to do. Python: ValueError.
class InvalidInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The input is valid but cannot be solved (for example a singular system). Python: RuntimeError.
class SolverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A progress callback stopped the work; the object is as it was before the call. No SolverError: nothing has failed,
/// and what is done about failures must not be done about this. Python: arap_native.Cancelled, a RuntimeError.
class Cancelled : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The memory that a mesh needs is not there; said before it is taken, and the object is as it was before the call.
/// Where an allocation fails that nobody has foreseen, it is a plain std::bad_alloc. Python: MemoryError.
class NotEnoughMemory : public std::bad_alloc {
 public:
  explicit NotEnoughMemory(const std::string& message) : message_(message) {}
  [[nodiscard]] const char* what() const noexcept override { return message_.what(); }

 private:
  std::runtime_error message_;  // unlike those of a string, its copies never fail
};

}  // namespace arap
