# Headers that say what is built: version and libraries now, the commit at every build.
# OpenMesh's CMake package names no version; its header does, as 0xABC00 for A.B.
find_path(openmesh_headers OpenMesh/Core/System/config.h)
mark_as_advanced(openmesh_headers)
if(openmesh_headers)
  file(STRINGS ${openmesh_headers}/OpenMesh/Core/System/config.h openmesh_line REGEX "^#define OM_VERSION 0x")
  string(REGEX REPLACE ".*0x([0-9A-Fa-f])([0-9A-Fa-f]).*" "\\1.\\2" OpenMesh_VERSION "${openmesh_line}")
endif()

set(libraries "")
if(KERF_BUILD_UI)
  set(of_programs "CLI11=${CLI11_VERSION}")
endif()
foreach(pair "CGAL=${CGAL_VERSION}" "OpenVDB=${OpenVDB_VERSION}" "OpenMesh=${OpenMesh_VERSION}" "ITK=${ITK_VERSION}" "Eigen=${Eigen3_VERSION}"
             "TBB=${TBB_VERSION}" "Highway=${HWY_VERSION}" "libzip=${LIBZIP_VERSION}" "Expat=${EXPAT_VERSION}" "Nettle=${NETTLE_VERSION}" "zlib=${ZLIB_VERSION_STRING}"
             "fmt=${fmt_VERSION}" "toml++=${tomlplusplus_VERSION}" "JSON for Modern C++=${nlohmann_json_VERSION}" ${of_programs})
  string(REPLACE "=" ";" parts "${pair}")
  list(GET parts 0 name)
  list(LENGTH parts count)
  if(count LESS 2)
    list(APPEND libraries "${name}")
    continue()
  endif()
  list(GET parts 1 version)
  string(STRIP "${name} ${version}" entry)
  list(APPEND libraries "${entry}")
endforeach()
list(JOIN libraries ", " KERF_LIBRARIES)
set(generated ${CMAKE_BINARY_DIR}/generated/geometry/base)
configure_file(geometry/base/version.h.in ${generated}/version.h @ONLY)
configure_file(geometry/base/libraries.h.in ${generated}/libraries.h @ONLY)

add_custom_target(kerf_commit BYPRODUCTS ${generated}/commit.h
                  COMMAND ${CMAKE_COMMAND} -D SOURCE=${CMAKE_SOURCE_DIR} -D OUTPUT=${generated}/commit.h -P ${CMAKE_SOURCE_DIR}/cmake/KerfCommit.cmake
                  COMMENT "" VERBATIM)
# There from the start, for tools that read sources without building.
execute_process(COMMAND ${CMAKE_COMMAND} -D SOURCE=${CMAKE_SOURCE_DIR} -D OUTPUT=${generated}/commit.h -P ${CMAKE_SOURCE_DIR}/cmake/KerfCommit.cmake)
