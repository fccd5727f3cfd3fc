# What kerf::geometry, kerf::preprocess and kerf::sim link: Kerf's own build reads it, and find_package(kerf) from outside.
if(POLICY CMP0167)  # CMake 3.30 and newer: Boost's own CMake files, here and in the files of OpenVDB and CGAL
  cmake_policy(SET CMP0167 NEW)
  set(CMAKE_POLICY_DEFAULT_CMP0167 NEW)
endif()
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(TBB CONFIG REQUIRED)  # before OpenVDB, whose own FindTBB could pick another one
list(APPEND CMAKE_MODULE_PATH /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB)
find_package(OpenVDB REQUIRED)
find_package(Boost REQUIRED)  # headers only: the lock-free queue
find_package(Eigen3 CONFIG REQUIRED)  # CONFIG: CGAL brings a find module of its own without the target
set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)
find_package(CGAL REQUIRED)

include(CGAL_Eigen3_support)
include(CGAL_TBB_support)
find_package(OpenMesh CONFIG REQUIRED)
find_package(tomlplusplus CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(tl-expected CONFIG REQUIRED)
# 3MF: a zip archive of XML. By pkg-config: libzip's CMake file also asks for its command line tools.
pkg_check_modules(LIBZIP REQUIRED IMPORTED_TARGET libzip)
pkg_check_modules(EXPAT REQUIRED IMPORTED_TARGET expat)
pkg_check_modules(STB REQUIRED IMPORTED_TARGET stb)  # textures: JPEG, PNG
pkg_check_modules(NETTLE REQUIRED IMPORTED_TARGET nettle)  # SHA-256
find_package(ZLIB REQUIRED)
pkg_check_modules(FREETYPE REQUIRED IMPORTED_TARGET freetype2)  # labels
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(HIDAPI REQUIRED IMPORTED_TARGET hidapi-hidraw)  # devices that are plugged in
unset(CMAKE_POLICY_DEFAULT_CMP0167)
