// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

// Compiler flags decide how Eigen gets memory: -march=native and the like align it more, the address sanitizer has it
// done by hand. The library frees what its caller has allocated and the other way round, and the linker keeps one copy
// of Eigen's functions for both, so both must be compiled alike. A namespace carries this into the symbols: where they
// are not, linking fails with undefined references to arap::compile_library_and_caller_alike_eigen_...
#define ARAP_COMPILED_AS(alignment, by_malloc) compile_library_and_caller_alike_eigen_##alignment##_##by_malloc
#define ARAP_COMPILED_AS_VALUES(alignment, by_malloc) ARAP_COMPILED_AS(alignment, by_malloc)
#define ARAP_COMPILED_ALIKE ARAP_COMPILED_AS_VALUES(EIGEN_DEFAULT_ALIGN_BYTES, EIGEN_MALLOC_ALREADY_ALIGNED)

namespace arap {

/// (n, 3) points or vectors, row-major like a C-ordered numpy array.
using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

/// Called from the calling thread with the fraction done, in [0, 1]; returns false to stop the work.
/// It must not call the object that is at work, which is in between two states. An exception thrown by it passes
/// through and leaves that object as it was. Empty: not called.
using Progress = std::function<bool(double fraction)>;

}  // namespace arap
