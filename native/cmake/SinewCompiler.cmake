# SPDX-License-Identifier: GPL-3.0-or-later
# The one place for compiler- and platform-specific flags.
add_library(sinew_compiler INTERFACE)

if(MSVC)
  target_compile_options(sinew_compiler INTERFACE /W4 /permissive- /utf-8 /bigobj /wd4127)
  target_compile_definitions(sinew_compiler INTERFACE _USE_MATH_DEFINES NOMINMAX)
else()
  # Vectors of 32 bytes never cross a call between objects (solvers/lanes.inl), so their ABI is no matter.
  target_compile_options(sinew_compiler INTERFACE -Wall -Wextra -Wpedantic -Wno-psabi)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    # Every 64-bit x86 machine that Blender 4.2 and later runs on has SSE4.2.
    target_compile_options(sinew_compiler INTERFACE -msse4.2)
  endif()
  # Contracting a*b+c differently in two call sites would make equal poses give unequal shapes.
  target_compile_options(sinew_compiler INTERFACE -ffp-contract=off)
endif()

if(SINEW_SANITIZE)
  if(MSVC)
    target_compile_options(sinew_compiler INTERFACE /fsanitize=address)
  else()
    target_compile_options(sinew_compiler INTERFACE
      -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -g1)
    target_link_options(sinew_compiler INTERFACE -fsanitize=address,undefined)
  endif()
endif()

# Sources named *_avx2.cpp and *_avx512.cpp run on processors that have these instructions, in place of their plain
# twins. No fused operations: all give the same results to the last bit.
function(sinew_compile_for_wide_processors target)
  if(NOT MSVC AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    get_target_property(sources ${target} SOURCES)
    set(avx2 -mavx2)
    set(avx512 -mavx512f -mavx512vl -mavx512dq)
    foreach(instructions IN ITEMS avx2 avx512)
      set(those ${sources})
      list(FILTER those INCLUDE REGEX "_${instructions}\\.cpp$")
      set_source_files_properties(${those} PROPERTIES COMPILE_OPTIONS "${${instructions}};-mno-fma")
    endforeach()
    target_compile_definitions(${target} PRIVATE SINEW_HAVE_AVX2)
  endif()
endfunction()

# CGAL counts on the rounding mode that it sets. Its exact numbers are Boost's: as quick here as GMP's, and nothing
# that a wheel has to carry.
function(sinew_compile_with_cgal target names)
  target_include_directories(${target} SYSTEM PRIVATE ${CGAL_INCLUDE_DIR})
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "${names}")
  set_source_files_properties(${sources} PROPERTIES COMPILE_DEFINITIONS CGAL_DISABLE_GMP=1)
  if(NOT MSVC)
    set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS -frounding-math)
  endif()
endfunction()
