# SPDX-License-Identifier: GPL-3.0-or-later
# CMake's toolchain file for Windows 10 on x86-64. The compilers are zig's (zig.py).
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_VERSION 10)
set(CMAKE_SYSTEM_PROCESSOR AMD64)
# oneTBB's resource, the number of its version, is left empty: it is for a DLL.
set(CMAKE_RC_COMPILER /usr/bin/touch)
set(CMAKE_RC_COMPILE_OBJECT "<CMAKE_RC_COMPILER> <OBJECT>")
# As for macOS; and Eigen takes Clang for an old GCC here, for which it wraps vectors and lacks AVX-512.
set(CMAKE_CXX_FLAGS_INIT
  "-D_LIBCPP_ENABLE_CXX17_REMOVED_UNARY_BINARY_FUNCTION -U__GXX_ABI_VERSION -D__GXX_ABI_VERSION=1004")
set(CMAKE_FIND_ROOT_PATH ${CMAKE_PREFIX_PATH})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
