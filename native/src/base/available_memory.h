// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>

namespace arap {

/// Bytes that this process may still take: by its own limit, by those of its control groups (a container's), and of the
/// machine. The largest number where nothing is known of them.
/// @param root  of the file system; tests have one of their own
[[nodiscard]] size_t available_memory(const std::string& root = "/");

/// Throws NotEnoughMemory if that is less than `bytes`.
/// @param what  needs them, for the message
void require_memory(double bytes, const std::string& what);

/// Returns to the system what the allocator keeps of freed memory, for after large work. Some milliseconds.
void return_freed_memory();

}  // namespace arap
