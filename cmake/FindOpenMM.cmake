# OpenMM with the headers of its Reference platform. Defines the target OpenMM::OpenMM.
find_path(OpenMM_INCLUDE_DIR openmm/reference/ReferenceConstraints.h)
find_library(OpenMM_LIBRARY OpenMM)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenMM REQUIRED_VARS OpenMM_LIBRARY OpenMM_INCLUDE_DIR)
mark_as_advanced(OpenMM_INCLUDE_DIR OpenMM_LIBRARY)

if(OpenMM_FOUND AND NOT TARGET OpenMM::OpenMM)
  add_library(OpenMM::OpenMM UNKNOWN IMPORTED)
  set_target_properties(OpenMM::OpenMM PROPERTIES
    IMPORTED_LOCATION ${OpenMM_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OpenMM_INCLUDE_DIR})
endif()
