# SPDX-License-Identifier: GPL-3.0-or-later
# Read after CMake's own rules. zig's linker makes dynamic libraries and no bundles; Python loads both.
foreach(_language C CXX)
  set(CMAKE_SHARED_MODULE_CREATE_${_language}_FLAGS -shared)
endforeach()
