# For each kernels/<name>.decl a header <generated>/kernels/<name>.h; all.h includes them, all.inc lists them.
# Every file under shaders/ is embedded as text. Adding a kernel touches nothing here.
set(PLIANT_GENERATED ${CMAKE_CURRENT_BINARY_DIR}/generated)
file(GLOB declarations CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/kernels/*.decl)
set(all_includes "#pragma once\n")
set(all_names "")
foreach(declaration ${declarations})
  get_filename_component(kernel ${declaration} NAME_WE)
  file(CONFIGURE OUTPUT ${PLIANT_GENERATED}/kernels/${kernel}.h CONTENT
"// From kernels/${kernel}.decl.
#pragma once
#define PLIANT_DECL \"kernels/${kernel}.decl\"
#include \"kernels/expand.h\"
#undef PLIANT_DECL
" @ONLY)
  string(APPEND all_includes "#include \"kernels/${kernel}.h\"\n")
  string(APPEND all_names "PLIANT_KERNEL(${kernel})\n")
endforeach()
file(CONFIGURE OUTPUT ${PLIANT_GENERATED}/kernels/all.h CONTENT "${all_includes}" @ONLY)
file(CONFIGURE OUTPUT ${PLIANT_GENERATED}/kernels/all.inc CONTENT "${all_names}" @ONLY)
add_custom_target(pliant_kernel_headers)

file(GLOB_RECURSE shader_files CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/shaders/*)
set(PLIANT_SHADER_SOURCE ${PLIANT_GENERATED}/shaders.cpp)
add_custom_command(
  OUTPUT ${PLIANT_SHADER_SOURCE}
  COMMAND ${CMAKE_COMMAND} -DROOT=${CMAKE_CURRENT_SOURCE_DIR}/shaders -DOUT=${PLIANT_SHADER_SOURCE} -P
          ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed.cmake
  DEPENDS ${shader_files} ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed.cmake
  COMMENT "Embedding shaders")
