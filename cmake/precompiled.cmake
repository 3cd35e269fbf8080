# Headers of others, compiled once a target: most of a build is spent reading them. A file includes what it uses all
# the same; -DPLIANT_PRECOMPILE=OFF builds without.
option(PLIANT_PRECOMPILE "Precompile the headers of other libraries" ${PROJECT_IS_TOP_LEVEL})
if(PLIANT_PRECOMPILE AND PLIANT_CCACHE)
  # ccache finds files that read precompiled headers only when told so.
  set(ccache_for_precompiled ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${PLIANT_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${ccache_for_precompiled})
endif()
set(pliant_std_headers <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional> <map>
                       <memory> <optional> <set> <span> <string> <unordered_map> <vector>)

function(pliant_precompile target)
  if(NOT PLIANT_PRECOMPILE)
    return()
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 forgets which headers are the system's and warns of their own strings (PR 105329, PR 105651).
    target_compile_options(${target} PRIVATE -fpch-preprocess -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow
                                             -Wno-stringop-overread)
  endif()
  target_precompile_headers(${target} PRIVATE ${pliant_std_headers} ${ARGN})
endfunction()
