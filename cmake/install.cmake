# What `cmake --install` writes, and find_package(pliant) reads: the libraries pliant::core, openmp, gl, render and
# backends; the headers below include/pliant, which is an include directory of them (#include "engine/..."); the
# program and its scenes. Component `library` is all that a consumer needs. Included last by CMakeLists.txt.
option(PLIANT_INSTALL "Write install rules" ${PROJECT_IS_TOP_LEVEL})
if(NOT PLIANT_INSTALL)
  return()
endif()
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(pliant_headers ${CMAKE_INSTALL_INCLUDEDIR}/pliant)
set(pliant_package ${CMAKE_INSTALL_LIBDIR}/cmake/pliant)

set(pliant_libraries core openmp backends)
if(PLIANT_GL)
  list(APPEND pliant_libraries glad gl render)
endif()
set(pliant_targets "")
foreach(library ${pliant_libraries})
  set_target_properties(pliant_${library} PROPERTIES EXPORT_NAME ${library})
  list(APPEND pliant_targets pliant_${library})
endforeach()
install(TARGETS ${pliant_targets} EXPORT pliant_targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
        INCLUDES DESTINATION ${pliant_headers})
install(EXPORT pliant_targets NAMESPACE pliant:: DESTINATION ${pliant_package} COMPONENT library)

# The headers of pliant::core, and the kernels as C++ reads them.
foreach(folder core device scene model plan solver render)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/engine/${folder} DESTINATION ${pliant_headers}/engine
          COMPONENT library OPTIONAL FILES_MATCHING PATTERN "*.h")
endforeach()
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/kernels ${CMAKE_CURRENT_BINARY_DIR}/generated/kernels
        DESTINATION ${pliant_headers} COMPONENT library
        FILES_MATCHING PATTERN "*.h" PATTERN "*.decl" PATTERN "*.inc")

configure_package_config_file(${CMAKE_CURRENT_SOURCE_DIR}/cmake/pliant-config.cmake.in
                              ${CMAKE_CURRENT_BINARY_DIR}/pliant-config.cmake INSTALL_DESTINATION ${pliant_package})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/pliant-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pliant-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/pliant-config-version.cmake
        DESTINATION ${pliant_package} COMPONENT library)
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)

if(TARGET pliant)
  install(TARGETS pliant RUNTIME COMPONENT program)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/pliant
          COMPONENT program FILES_MATCHING PATTERN "*.toml" PATTERN "*.obj")
endif()

if(PLIANT_TESTS AND PROJECT_IS_TOP_LEVEL)
  include(${CMAKE_CURRENT_SOURCE_DIR}/tests/embed/embed.cmake)
endif()
