# Debian's SuiteSparse ships no package files: finds CHOLMOD's header and library.
# Defines the target CHOLMOD::CHOLMOD, and CHOLMOD_HAS_GPL: whether it contains its modules under the GPL (Supernodal,
# MatrixOps, Modify), as Debian's does. One that was compiled with -DNGPL has none.
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY cholmod)
find_library(SUITESPARSECONFIG_LIBRARY suitesparseconfig)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CHOLMOD REQUIRED_VARS CHOLMOD_LIBRARY SUITESPARSECONFIG_LIBRARY CHOLMOD_INCLUDE_DIR)
if(CHOLMOD_FOUND)
  include(CheckLibraryExists)
  set(CMAKE_REQUIRED_QUIET ON)
  check_library_exists(${CHOLMOD_LIBRARY} cholmod_analyze "" CHOLMOD_LINKS)
  check_library_exists(${CHOLMOD_LIBRARY} cholmod_super_symbolic "" CHOLMOD_LINKS_SUPERNODAL)
  unset(CMAKE_REQUIRED_QUIET)
  # A static one does not link alone: nothing is known then, and the worse is said.
  set(CHOLMOD_HAS_GPL ON)
  if(CHOLMOD_LINKS AND NOT CHOLMOD_LINKS_SUPERNODAL)
    set(CHOLMOD_HAS_GPL OFF)
  endif()
endif()
mark_as_advanced(CHOLMOD_INCLUDE_DIR CHOLMOD_LIBRARY SUITESPARSECONFIG_LIBRARY)

if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD UNKNOWN IMPORTED)
  set_target_properties(CHOLMOD::CHOLMOD PROPERTIES
    IMPORTED_LOCATION ${CHOLMOD_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${CHOLMOD_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES ${SUITESPARSECONFIG_LIBRARY})
endif()
