# SPDX-License-Identifier: GPL-3.0-or-later

# Compiles the kernel sources once for each instruction set of the architecture, each time in a namespace of its own,
# into `target`. The library chooses one of them at run time (isa.h).
function(arap_add_kernels target)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 12)
    message(FATAL_ERROR "GCC ${CMAKE_CXX_COMPILER_VERSION} lacks __builtin_shufflevector: install GCC 12 or later, or Clang")
  endif()
  set(isas baseline)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
    list(APPEND isas avx2 avx512)
    set(flags_avx2 -mavx2 -mfma -mf16c)
    set(flags_avx512 -mavx512f -mavx512dq -mavx512vl -mfma -mf16c)
    target_compile_definitions(${target} PRIVATE ARAP_HAS_X86_KERNELS)
  endif()
  foreach(isa IN LISTS isas)
    set(kernels ${target}_kernels_${isa})
    add_library(${kernels} OBJECT ${ARGN})
    arap_target_flags(${kernels})
    set_target_properties(${kernels} PROPERTIES UNITY_BUILD OFF) # each has lanes of its own
    target_include_directories(${kernels} PRIVATE ${PROJECT_SOURCE_DIR}/native/src)
    target_compile_definitions(${kernels} PRIVATE ARAP_ISA_NAMESPACE=${isa})
    # -O3 in every build type: kernels need inlining to be of use. -Wno-psabi: GCC warns about passing vectors wider
    # than the instruction set's, but none is passed between sources.
    set(flags -O3 -ffp-contract=fast)
    if(ARAP_SANITIZE)
      # Checks of each address in unrolled loops take minutes to optimize. What is read and written is checked anyway.
      set(flags -O1 -ffp-contract=fast -fno-sanitize=null,pointer-overflow)
    endif()
    if(MSVC)
      list(TRANSFORM flags PREPEND /clang:)
    endif()
    target_compile_options(${kernels} PRIVATE ${flags_${isa}} ${flags} -Wno-psabi)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${kernels}>)
  endforeach()
endfunction()
