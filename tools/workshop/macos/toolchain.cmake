# SPDX-License-Identifier: GPL-3.0-or-later
# CMake's toolchain file for macOS 11 on Apple's processors. The compilers are zig's (zig.py).
set(CMAKE_SYSTEM_NAME Darwin)
set(CMAKE_SYSTEM_VERSION 20)
set(CMAKE_SYSTEM_PROCESSOR arm64)
set(CMAKE_USER_MAKE_RULES_OVERRIDE ${CMAKE_CURRENT_LIST_DIR}/link.cmake)
# Everything is linked statically, so there is nothing to rename when it is installed.
set(CMAKE_INSTALL_NAME_TOOL /bin/false)
# Debian's Boost names a class that C++17 no longer has. Other compilers' libraries have kept it.
set(CMAKE_CXX_FLAGS_INIT -D_LIBCPP_ENABLE_CXX17_REMOVED_UNARY_BINARY_FUNCTION)
set(CMAKE_MODULE_LINKER_FLAGS_INIT -Wl,-dead_strip)
set(CMAKE_FIND_FRAMEWORK NEVER)
set(CMAKE_FIND_ROOT_PATH ${CMAKE_PREFIX_PATH})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
