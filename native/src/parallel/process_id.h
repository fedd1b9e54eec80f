// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace arap {

// Detects forks: a forked child has copies of all objects, but only the thread that forked.
#if defined(__unix__) || defined(__APPLE__)
using ProcessId = pid_t;
inline ProcessId process_id() { return getpid(); }
#else
using ProcessId = int;
inline ProcessId process_id() { return 0; }
#endif

}  // namespace arap
