// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace arap {

// The child of a fork has all objects of its parent, but of its threads only the one that forked.
#if defined(__unix__) || defined(__APPLE__)
using ProcessId = pid_t;
inline ProcessId process_id() { return getpid(); }
#else
using ProcessId = int;
inline ProcessId process_id() { return 0; }
#endif

}  // namespace arap
