# Libraries without which the program is built all the same, and says what it cannot write. Sets has_zlib, has_hdf5, has_zip
# and program_libraries; the modules of src/program/formats link HDF5 and libzip.
find_package(ZLIB QUIET)
# Debian's HDF5 without MPI lies in folders of its own; tools that could tell more are slow and pull in MPI.
find_path(HDF5_SERIAL_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(HDF5_SERIAL_LIBRARY NAMES hdf5_serial hdf5)
find_path(ZIP_INCLUDE_DIR zip.h)
find_library(ZIP_LIBRARY zip)
mark_as_advanced(HDF5_SERIAL_INCLUDE_DIR HDF5_SERIAL_LIBRARY ZIP_INCLUDE_DIR ZIP_LIBRARY)

need_for(has_zlib TANOR_ZLIB "Compressed results" zlib1g-dev ZLIB_FOUND)
need_for(has_hdf5 TANOR_H5MD "Trajectories in H5MD" libhdf5-dev HDF5_SERIAL_INCLUDE_DIR HDF5_SERIAL_LIBRARY)
need_for(has_zip TANOR_NPZ "Trajectories in NPZ" libzip-dev ZIP_INCLUDE_DIR ZIP_LIBRARY)
set(program_libraries)
if(has_zlib)
  list(APPEND program_libraries ZLIB::ZLIB)
endif()
