# How code is compiled that libFuzzer watches: under the address and undefined-behaviour sanitizers, telling which
# blocks run and what is compared. The rooms that read bytes of others are; the rooms behind them only compute with
# numbers, and are those of every build.
set(watched_compile_options)
set(watched_link_options)
if(TANOR_FUZZ)
  set(sanitizers -fsanitize=address,undefined,float-cast-overflow)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(coverage -fsanitize-coverage=trace-pc,trace-cmp)  # tests/fuzz/gcc_coverage.cpp hands them on
  else()
    set(coverage -fsanitize=fuzzer-no-link)
  endif()
  # Eigen allocates otherwise under the address sanitizer, where the rooms that are not watched do not follow.
  set(watched_compile_options ${sanitizers} ${coverage} -DEIGEN_MALLOC_ALREADY_ALIGNED=1 -O1 -g1 -fno-sanitize-recover=all -fno-omit-frame-pointer)
  set(watched_link_options ${sanitizers})
  foreach(room base system simulation host)
    file(GLOB watched src/${room}/*.cpp)
    set_source_files_properties(${watched} PROPERTIES COMPILE_OPTIONS "${watched_compile_options}")
  endforeach()
  # GCC's alarms at the stack of a formula are false: it takes the first slot that a pointer in a loop had for all.
  file(GLOB watched src/system/*.cpp)
  set_source_files_properties(${watched} PROPERTIES
    COMPILE_OPTIONS "${watched_compile_options};-fno-sanitize=object-size")
  target_compile_options(tanor_scene PRIVATE ${watched_compile_options})
endif()
