# SuiteSparseQR of the same package as CHOLMOD, on which it stands.
# Defines the target SPQR::SPQR.
find_package(CHOLMOD QUIET)
find_path(SPQR_INCLUDE_DIR SuiteSparseQR.hpp PATH_SUFFIXES suitesparse)
find_library(SPQR_LIBRARY spqr)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(SPQR REQUIRED_VARS SPQR_LIBRARY SPQR_INCLUDE_DIR CHOLMOD_FOUND)
mark_as_advanced(SPQR_INCLUDE_DIR SPQR_LIBRARY)

if(SPQR_FOUND AND NOT TARGET SPQR::SPQR)
  add_library(SPQR::SPQR UNKNOWN IMPORTED)
  set_target_properties(SPQR::SPQR PROPERTIES
    IMPORTED_LOCATION ${SPQR_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${SPQR_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES CHOLMOD::CHOLMOD)
endif()
