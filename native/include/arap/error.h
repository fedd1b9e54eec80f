// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>

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

/// A progress callback stopped a bind or a change of constraints; the object is as it was before the call.
/// Python: arap_native.Cancelled, a RuntimeError.
class Cancelled : public SolverError {
 public:
  using SolverError::SolverError;
};

}  // namespace arap
