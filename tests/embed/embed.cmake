# A project of someone else that uses Pliant (tests/embed/consumer), both ways. With find_package it is built
# against an install tree of the libraries of this build, and run. With add_subdirectory its own source is compiled,
# which needs the targets and headers but none of the libraries: building those once more would take minutes.
foreach(way find_package add_subdirectory)
  add_test(NAME embed/${way}
           COMMAND ${CMAKE_COMMAND} -DWAY=${way} -DPLIANT_SOURCE=${CMAKE_CURRENT_SOURCE_DIR}
                   -DPLIANT_BUILD=${CMAKE_CURRENT_BINARY_DIR} -DPLIANT_GL=${PLIANT_GL}
                   -DWORK=${CMAKE_CURRENT_BINARY_DIR}/embed/${way} -DGENERATOR=${CMAKE_GENERATOR}
                   -DCOMPILER=${CMAKE_CXX_COMPILER} -DSANITIZE=${PLIANT_SANITIZE}
                   -P ${CMAKE_CURRENT_SOURCE_DIR}/tests/embed/check.cmake)
  set_tests_properties(embed/${way} PROPERTIES TIMEOUT 300)
endforeach()
