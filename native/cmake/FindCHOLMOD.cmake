# SPDX-License-Identifier: GPL-3.0-or-later
# CHOLMOD (SuiteSparse 5 and later) as the imported target CHOLMOD::CHOLMOD.
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY NAMES cholmod libcholmod)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CHOLMOD REQUIRED_VARS CHOLMOD_LIBRARY CHOLMOD_INCLUDE_DIR)

if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD UNKNOWN IMPORTED)
  set_target_properties(CHOLMOD::CHOLMOD PROPERTIES
    IMPORTED_LOCATION "${CHOLMOD_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR}")
  find_library(CHOLMOD_blas_LIBRARY NAMES openblas libopenblas blas)
  foreach(_name suitesparseconfig amd colamd camd ccolamd blas)
    find_library(CHOLMOD_${_name}_LIBRARY NAMES ${_name} lib${_name})
    if(CHOLMOD_${_name}_LIBRARY)
      set_property(TARGET CHOLMOD::CHOLMOD APPEND PROPERTY
        INTERFACE_LINK_LIBRARIES "${CHOLMOD_${_name}_LIBRARY}")
    endif()
  endforeach()
endif()
