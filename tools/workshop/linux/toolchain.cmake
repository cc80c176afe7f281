# SPDX-License-Identifier: GPL-3.0-or-later
# CMake's toolchain file for Linux on x86-64 with a C library as old as Blender's. The compilers are zig's (zig.py).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
# As for macOS, and a header that CGAL includes where the machine has one.
set(CMAKE_CXX_FLAGS_INIT
  "-D_LIBCPP_ENABLE_CXX17_REMOVED_UNARY_BINARY_FUNCTION -I${CMAKE_CURRENT_LIST_DIR}/include")
set(CMAKE_MODULE_LINKER_FLAGS_INIT
  "-Wl,--gc-sections -Wl,-z,undefs -Wl,--version-script=${CMAKE_CURRENT_LIST_DIR}/exports.map -x c ${CMAKE_CURRENT_LIST_DIR}/division.c -x none")
set(CMAKE_FIND_ROOT_PATH ${CMAKE_PREFIX_PATH})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
