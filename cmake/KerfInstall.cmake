# cmake --install: programs, libraries with their headers and a CMake package, assets, manual pages, completion.
#
# From outside: find_package(kerf) gives kerf::geometry and kerf::sim, find_package(kerf COMPONENTS preprocess) also
# kerf::preprocess. Static libraries: who links them needs the libraries of KerfLibraries.cmake. kerf_volumes.so is loaded
# by whoever reads a volume, from where it was installed or from lib/kerf beside the program.
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/kerf)

set_target_properties(kerf_options PROPERTIES EXPORT_NAME options)
set_target_properties(kerf_geometry PROPERTIES EXPORT_NAME geometry)
set_target_properties(kerf_sim PROPERTIES EXPORT_NAME sim)
set_target_properties(kerf_preprocess PROPERTIES EXPORT_NAME preprocess)

foreach(program kerf kerf-sim kerf-bridge-haply kerf-bridge-simulated kerf-bridge-woody)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} OPTIONAL)  # those that were built
  endif()
endforeach()
install(DIRECTORY ${CMAKE_SOURCE_DIR}/assets/ DESTINATION ${CMAKE_INSTALL_DATADIR}/kerf)
if(KERF_BUILD_UI)  # manual pages and completion of the programs
  install(DIRECTORY ${CMAKE_BINARY_DIR}/share/ DESTINATION ${CMAKE_INSTALL_DATADIR})
endif()
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE ${CMAKE_SOURCE_DIR}/README.md ${CMAKE_SOURCE_DIR}/CHANGELOG.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The object libraries are inside the static ones; their targets only say what else to link.
install(TARGETS kerf_options kerf_geometry kerf_exact kerf_files kerf_run kerf_sim EXPORT kerfTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kerfTargets NAMESPACE kerf:: DESTINATION ${package})
install(TARGETS kerf_volumes LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/kerf)
install(TARGETS kerf_preprocess kerf_close_exact EXPORT kerfPreprocessTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kerfPreprocessTargets NAMESPACE kerf:: DESTINATION ${package})

# Headers of vectorised loops, and those that name a type of OpenVDB, TBB or toml++, are Kerf's own.
install(DIRECTORY ${CMAKE_SOURCE_DIR}/geometry ${CMAKE_SOURCE_DIR}/preprocess ${CMAKE_SOURCE_DIR}/sim
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kerf
        FILES_MATCHING PATTERN "*.h" PATTERN "toml_reader.h" EXCLUDE PATTERN "vdb_bricks.h" EXCLUDE PATTERN "vdb_writer.h" EXCLUDE
                       PATTERN "cropped_bricks.h" EXCLUDE PATTERN "mesh_field.h" EXCLUDE PATTERN "paint_materials.h" EXCLUDE PATTERN "itk_reader.h" EXCLUDE)
install(FILES ${CMAKE_BINARY_DIR}/generated/geometry/base/version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kerf/geometry/base)

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/kerfConfig.cmake.in ${CMAKE_BINARY_DIR}/generated/kerfConfig.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/kerfConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/generated/kerfConfig.cmake ${CMAKE_BINARY_DIR}/generated/kerfConfigVersion.cmake
              ${CMAKE_SOURCE_DIR}/cmake/KerfLibraries.cmake
        DESTINATION ${package})
