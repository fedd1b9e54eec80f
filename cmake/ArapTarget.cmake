# SPDX-License-Identifier: GPL-3.0-or-later

# Where builds are by groups of files (CMAKE_UNITY_BUILD), a group is a room: what lies in one folder.
function(arap_group_by_room target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "[.]cpp$")
  foreach(source IN LISTS sources)
    get_filename_component(room ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER ${room} room)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
  endforeach()
endfunction()

# Flags of our own targets. Projects that use the library do not get them.
function(arap_target_flags target)
  set_target_properties(${target} PROPERTIES
    CXX_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    POSITION_INDEPENDENT_CODE ON)
  target_compile_features(${target} PUBLIC cxx_std_20)

  # Sums are rounded as written, on every processor: only the kernels, which state how exact they are, may fuse them.
  if(MSVC)
    if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
      message(FATAL_ERROR "The kernels need the vector extensions of GCC and Clang: on Windows use clang-cl, Clang, or MinGW")
    endif()
    target_compile_options(${target} PRIVATE /clang:-ffp-contract=off)
    target_compile_options(${target} PRIVATE /W4 /permissive- /utf-8)
    target_compile_definitions(${target} PRIVATE _USE_MATH_DEFINES NOMINMAX)
  else()
    target_compile_options(${target} PRIVATE -ffp-contract=off)
    # -Wno-sign-conversion: in Clang -Wconversion also warns about signed indices into std::vector.
    target_compile_options(${target} PRIVATE
      -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual
      -Wold-style-cast -Wcast-qual -Wdouble-promotion)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      # -Wno-maybe-uninitialized: false alarms when GCC inlines Eigen's decompositions of small matrices; and
      # -Wno-subobject-linkage: where it takes a source in a group for a header.
      target_compile_options(${target} PRIVATE
        -Wduplicated-cond -Wduplicated-branches -Wlogical-op -Wno-maybe-uninitialized -Wno-subobject-linkage)
    endif()
  endif()

  if(ARAP_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE $<IF:$<CXX_COMPILER_ID:MSVC>,/WX,-Werror>)
  endif()

  if(ARAP_SANITIZE)
    target_compile_options(${target} PRIVATE
      -fsanitize=${ARAP_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PRIVATE -fsanitize=${ARAP_SANITIZE})
  endif()
endfunction()
