# SPDX-License-Identifier: GPL-3.0-or-later
# The one place for compiler- and platform-specific flags.
add_library(sinew_compiler INTERFACE)

if(MSVC)
  target_compile_options(sinew_compiler INTERFACE /W4 /permissive- /utf-8 /bigobj /wd4127)
  target_compile_definitions(sinew_compiler INTERFACE _USE_MATH_DEFINES NOMINMAX)
else()
  target_compile_options(sinew_compiler INTERFACE -Wall -Wextra -Wpedantic)
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
