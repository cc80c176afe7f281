# SPDX-License-Identifier: GPL-3.0-or-later
# OpenSubdiv's CPU library as the imported target OpenSubdiv::osdCPU. Its own CMake files cannot be used: those of
# Debian name static libraries that the package does not hold.
find_path(OpenSubdiv_INCLUDE_DIR opensubdiv/far/topologyRefiner.h)
find_library(OpenSubdiv_LIBRARY NAMES osdCPU osdCPU_static)
if(OpenSubdiv_INCLUDE_DIR)
  file(STRINGS ${OpenSubdiv_INCLUDE_DIR}/opensubdiv/version.h _version REGEX "define OPENSUBDIV_VERSION ")
  string(REGEX REPLACE ".*v([0-9]+)_([0-9]+)_([0-9]+).*" "\\1.\\2.\\3" OpenSubdiv_VERSION "${_version}")
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenSubdiv REQUIRED_VARS OpenSubdiv_LIBRARY OpenSubdiv_INCLUDE_DIR
  VERSION_VAR OpenSubdiv_VERSION)

if(OpenSubdiv_FOUND AND NOT TARGET OpenSubdiv::osdCPU)
  add_library(OpenSubdiv::osdCPU UNKNOWN IMPORTED)
  set_target_properties(OpenSubdiv::osdCPU PROPERTIES
    IMPORTED_LOCATION "${OpenSubdiv_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenSubdiv_INCLUDE_DIR}")
endif()
