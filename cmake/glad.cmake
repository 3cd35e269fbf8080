# GL functions by glad 2, generated offline from the specification that the package ships: one table of functions a
# context (--mx), because two implementations may live in one process.
find_program(GLAD_PROGRAM glad)
if(NOT GLAD_PROGRAM)
  message(FATAL_ERROR "glad 2 is missing: apt install python3-glad, or configure with -DPLIANT_GL=OFF")
endif()
set(glad_out ${CMAKE_CURRENT_BINARY_DIR}/glad)
if(NOT EXISTS ${glad_out}/src/gl.c)
  execute_process(COMMAND ${GLAD_PROGRAM} --quiet --reproducible --api gl:core=4.3
                          --extensions GL_KHR_debug,GL_ARB_buffer_storage,GL_ARB_get_program_binary
                          --out-path ${glad_out} c --mx RESULT_VARIABLE glad_result)
  if(NOT glad_result EQUAL 0)
    message(FATAL_ERROR "glad could not write the OpenGL loader")
  endif()
endif()
add_library(pliant_glad STATIC ${glad_out}/src/gl.c)
target_include_directories(pliant_glad SYSTEM PUBLIC $<BUILD_INTERFACE:${glad_out}/include>)
