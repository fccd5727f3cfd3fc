# cmake --install: programs, libraries with their headers and a CMake package, assets, manual pages, completion.
#
# From outside: find_package(kerf) gives kerf::kerf, and its parts kerf::geometry, kerf::sim and kerf::preprocess. Static
# libraries: who links them needs the libraries of KerfLibraries.cmake. kerf_volumes.so is loaded
# by whoever reads a volume, from where it was installed or from lib/kerf beside the program.
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/kerf)

set_target_properties(kerf_options PROPERTIES EXPORT_NAME options)
set_target_properties(kerf_geometry PROPERTIES EXPORT_NAME geometry)
set_target_properties(kerf_sim PROPERTIES EXPORT_NAME sim)
set_target_properties(kerf_preprocess PROPERTIES EXPORT_NAME preprocess)
set_target_properties(kerf_library PROPERTIES EXPORT_NAME kerf)

foreach(program kerf kerf-sim kerf-bridge-haply kerf-bridge-simulated kerf-bridge-woody)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} OPTIONAL)  # those that were built
    set(page ${CMAKE_SOURCE_DIR}/bridges/manual/${program}.1)  # kerf and kerf-sim write their own
    if(EXISTS ${page})
      install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
    endif()
  endif()
endforeach()
install(DIRECTORY ${CMAKE_SOURCE_DIR}/assets/ DESTINATION ${CMAKE_INSTALL_DATADIR}/kerf PATTERN desktop EXCLUDE)
if(KERF_BUILD_UI AND KERF_BUILD_WINDOW)  # entry in the menu, icon, file types
  set(desktop ${CMAKE_SOURCE_DIR}/assets/desktop)
  install(FILES ${desktop}/kerf-sim.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
  install(FILES ${desktop}/kerf.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
  install(FILES ${desktop}/kerf-mime.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages RENAME kerf.xml)
  install(FILES ${desktop}/kerf-sim.metainfo.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/metainfo)
endif()
if(KERF_BUILD_UI)  # manual pages and completion of the programs
  install(DIRECTORY ${CMAKE_BINARY_DIR}/share/ DESTINATION ${CMAKE_INSTALL_DATADIR} REGEX "/share/kerf$" EXCLUDE)
endif()
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE ${CMAKE_SOURCE_DIR}/README.md ${CMAKE_SOURCE_DIR}/CHANGELOG.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The object libraries are inside the static ones; their targets only say what else to link.
install(TARGETS kerf_options kerf_geometry kerf_exact kerf_files kerf_run kerf_sim kerf_preprocess kerf_close_exact kerf_library
        EXPORT kerfTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kerfTargets NAMESPACE kerf:: DESTINATION ${package})
install(TARGETS kerf_volumes kerf_slice_trial DESTINATION ${CMAKE_INSTALL_LIBDIR}/kerf)
# All that is installed beside the programs: scripts/install and scripts/package build it.
add_custom_target(kerf_installed DEPENDS kerf_library kerf_volumes kerf_slice_trial)
if(KERF_BUILD_PYTHON)
  add_dependencies(kerf_installed kerf_python)
  # Where Debian's interpreter looks, whatever the prefix is.
  set(modules lib/python3/dist-packages/kerf)
  install(TARGETS kerf_python LIBRARY DESTINATION ${modules})
  install(FILES ${CMAKE_SOURCE_DIR}/python/kerf/__init__.py ${CMAKE_SOURCE_DIR}/python/kerf/__init__.pyi
                ${CMAKE_SOURCE_DIR}/python/kerf/py.typed DESTINATION ${modules})
  install(FILES ${CMAKE_SOURCE_DIR}/python/blender/kerf_import.py DESTINATION ${CMAKE_INSTALL_DATADIR}/kerf/blender)
endif()

# The interface is library/kerf.h: it and what it includes are installed, the other headers are Kerf's own.
function(kerf_reached_headers out)
  set(open library/kerf.h)
  set(known ${open})
  while(open)
    list(POP_FRONT open header)
    file(STRINGS ${CMAKE_SOURCE_DIR}/${header} lines REGEX "^#include \"")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
      if(NOT included IN_LIST known AND EXISTS ${CMAKE_SOURCE_DIR}/${included})
        list(APPEND known ${included})
        list(APPEND open ${included})
      endif()
    endforeach()
  endwhile()
  set(${out} ${known} PARENT_SCOPE)
endfunction()
kerf_reached_headers(headers)
foreach(header IN LISTS headers)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${CMAKE_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kerf/${folder})
endforeach()
install(FILES ${CMAKE_SOURCE_DIR}/library/kerf.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kerf)
install(FILES ${CMAKE_BINARY_DIR}/generated/geometry/base/version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kerf/geometry/base)

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/kerfConfig.cmake.in ${CMAKE_BINARY_DIR}/generated/kerfConfig.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/kerfConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/generated/kerfConfig.cmake ${CMAKE_BINARY_DIR}/generated/kerfConfigVersion.cmake
              ${CMAKE_SOURCE_DIR}/cmake/KerfLibraries.cmake
        DESTINATION ${package})
