# SPDX-License-Identifier: GPL-3.0-or-later
# The one place for compiler- and platform-specific flags.
add_library(sinew_compiler INTERFACE)

if(MSVC)
  target_compile_options(sinew_compiler INTERFACE /W4 /permissive- /utf-8 /bigobj /wd4127)
  target_compile_definitions(sinew_compiler INTERFACE _USE_MATH_DEFINES NOMINMAX)
else()
  # No function that another object file calls takes a vector of 32 bytes (core/simd/lane_types.inl), so the warning
  # that the calling convention of such vectors has changed does not apply.
  target_compile_options(sinew_compiler INTERFACE -Wall -Wextra -Wpedantic -Wno-psabi)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    # Every 64-bit x86 machine that Blender 4.2 and later runs on has SSE4.2.
    target_compile_options(sinew_compiler INTERFACE -msse4.2)
    # For the single file that asks whether the processor has them.
    set(SINEW_EVERY_PROCESSOR -mno-sse3 -DSINEW_NEEDS_SSE42)
  endif()
  if(WIN32) # strict C++ hides M_PI there, which OpenSubdiv's headers use
    target_compile_definitions(sinew_compiler INTERFACE _USE_MATH_DEFINES)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU) # so that ccache can store what is compiled with precompiled headers
    target_compile_options(sinew_compiler INTERFACE -fpch-preprocess)
  endif()
  # A compiler that fuses a * b + c in one place and not in another would make equal poses give unequal shapes.
  target_compile_options(sinew_compiler INTERFACE -ffp-contract=off)
endif()

if(SINEW_SANITIZE_THREADS AND NOT MSVC)
  target_compile_options(sinew_compiler INTERFACE -fsanitize=thread -g1)
  target_link_options(sinew_compiler INTERFACE -fsanitize=thread)
endif()

# Compiles each file of kernels (native/<room>/<name>, with .h and .inl) for the baseline of all processors and for every
# set of instructions that is named after the file. Fused operations stay off, so all give the same results to the last
# bit.
function(sinew_add_kernels target)
  if(NOT MSVC AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    target_compile_definitions(${target} PUBLIC SINEW_HAVE_WIDE_KERNELS)
    set(baseline "")
    set(avx2 -mavx2)
    set(avx512 -mavx512f -mavx512vl -mavx512dq)
  endif()
  foreach(argument IN LISTS ARGN)
    if(argument MATCHES "/")
      set(kernels ${argument})
      set(instructions baseline)
    else()
      set(instructions ${argument})
    endif()
    if(DEFINED ${instructions} OR instructions STREQUAL baseline)
      string(COMPARE EQUAL ${instructions} avx512 SINEW_EIGHT_LANES)
      set(source ${CMAKE_CURRENT_BINARY_DIR}/${kernels}_${instructions}.cpp)
      configure_file(${CMAKE_CURRENT_FUNCTION_LIST_DIR}/kernels.cpp.in ${source} @ONLY)
      set_source_files_properties(${source} PROPERTIES
        COMPILE_OPTIONS "${${instructions}}" SKIP_PRECOMPILE_HEADERS ON)
      target_sources(${target} PRIVATE ${source})
    endif()
  endforeach()
endfunction()

# CGAL sets the rounding mode, which the compiler must respect. Its exact numbers are those of Boost, which are as fast
# here as those of GMP and need no library in the wheel.
function(sinew_compile_with_cgal target names)
  target_include_directories(${target} SYSTEM PRIVATE ${CGAL_INCLUDE_DIR})
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "${names}")
  set_source_files_properties(${sources} PROPERTIES
    COMPILE_DEFINITIONS CGAL_DISABLE_GMP=1 SKIP_PRECOMPILE_HEADERS ON)
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    # CGAL leaves out a header that libstdc++ brings along, and has templates that nobody calls and Clang would refuse.
    set_source_files_properties(${sources} PROPERTIES
      COMPILE_OPTIONS "-frounding-math;-fdelayed-template-parsing;-include;cfloat")
  elseif(NOT MSVC)
    set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS -frounding-math)
  endif()
endfunction()
