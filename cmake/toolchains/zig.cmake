# SPDX-License-Identifier: GPL-3.0-or-later
# Builds for another platform with the Clang, libc++ and system headers of zig (`pip install ziglang`):
#   cmake --toolchain cmake/toolchains/zig.cmake -DARAP_ZIG=.../ziglang/zig -DARAP_ZIG_TARGET=x86_64-windows-gnu ...
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ARAP_ZIG ARAP_ZIG_TARGET)

string(REGEX MATCH "^([a-z0-9_]+)-([a-z]+)" _ "${ARAP_ZIG_TARGET}")
set(CMAKE_SYSTEM_PROCESSOR ${CMAKE_MATCH_1})
set(systems linux Linux windows Windows macos Darwin)
list(FIND systems "${CMAKE_MATCH_2}" at)
math(EXPR at "${at} + 1")
list(GET systems ${at} CMAKE_SYSTEM_NAME)

set(CMAKE_CXX_COMPILER ${ARAP_ZIG} c++ -target ${ARAP_ZIG_TARGET})
set(CMAKE_CXX_ARCHIVE_CREATE "${ARAP_ZIG} ar qc <TARGET> <OBJECTS>")
set(CMAKE_CXX_ARCHIVE_APPEND "${ARAP_ZIG} ar q <TARGET> <OBJECTS>")
set(CMAKE_CXX_ARCHIVE_FINISH "${ARAP_ZIG} ranlib <TARGET>")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY) # a link would build the C++ library first, which takes minutes
set(CMAKE_OSX_SYSROOT "" CACHE STRING "") # zig has the headers
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
