# SPDX-License-Identifier: GPL-3.0-or-later

# Compiles the same kernel sources once for each instruction set of the architecture, each in a namespace of its own,
# into `target`. Which of them runs is decided at run time (isa.h).
function(arap_add_kernels target)
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
    target_include_directories(${kernels} PRIVATE ${PROJECT_SOURCE_DIR}/native/src)
    target_compile_definitions(${kernels} PRIVATE ARAP_ISA_NAMESPACE=${isa})
    # Kernels are slow to the point of uselessness without inlining, whatever the build type.
    # Vectors wider than the instruction set's never leave a source, so it does not matter how they would be passed.
    target_compile_options(${kernels} PRIVATE ${flags_${isa}} -O3 -ffp-contract=fast -Wno-psabi)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${kernels}>)
  endforeach()
endfunction()
