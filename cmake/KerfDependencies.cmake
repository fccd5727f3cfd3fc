# All third-party libraries, from Debian 12. Required ones stop the configuration; optional ones turn a feature off, aloud.
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
find_package(CLI11 CONFIG REQUIRED)
find_package(tomlplusplus CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(tl-expected CONFIG REQUIRED)
# 3MF: a zip archive of XML. By pkg-config: libzip's CMake file also asks for its command line tools.
pkg_check_modules(LIBZIP REQUIRED IMPORTED_TARGET libzip)
pkg_check_modules(EXPAT REQUIRED IMPORTED_TARGET expat)
find_package(ZLIB REQUIRED)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
find_package(ITK REQUIRED COMPONENTS ITKCommon ITKIOImageBase ITKIOBMP ITKIOGDCM ITKIOMeta ITKIONIFTI ITKIONRRD ITKIOPNG ITKIOTIFF)
find_path(KERF_GDCM_INCLUDE_DIR gdcmTrace.h PATH_SUFFIXES gdcm-3.0 REQUIRED)  # ITK reads DICOM with it; to silence it and to ask what it states
find_library(KERF_GDCM_COMMON gdcmCommon REQUIRED)
find_library(KERF_GDCM_DSED gdcmDSED REQUIRED)

if(KERF_BUILD_WINDOW)
  find_package(glfw3 CONFIG QUIET)
  set(OpenGL_GL_PREFERENCE GLVND)
  find_package(OpenGL QUIET COMPONENTS OpenGL EGL)
  pkg_check_modules(IMGUI QUIET IMPORTED_TARGET imgui)
  pkg_check_modules(EPOXY QUIET IMPORTED_TARGET epoxy)
  if(NOT (glfw3_FOUND AND OpenGL_EGL_FOUND AND IMGUI_FOUND AND EPOXY_FOUND))
    message(WARNING "GLFW, EGL, Dear ImGui or libepoxy is missing: kerf-sim (window and pictures) is not built. "
                    "Run scripts/setup.")
    set(KERF_BUILD_WINDOW OFF)
  endif()
endif()

if(KERF_BUILD_TESTS)
  find_package(GTest CONFIG REQUIRED)
  find_package(rapidcheck CONFIG QUIET)
  if(NOT rapidcheck_FOUND)
    message(WARNING "RapidCheck is missing: property tests are not built (Debian: librapidcheck-dev)")
  endif()
  # By hand: the lib3MF.pc of Debian 12 asks for a library that lib3mf-dev does not bring.
  find_path(LIB3MF_INCLUDE_DIR Model/COM/NMR_DLLInterfaces.h PATH_SUFFIXES lib3mf)
  find_library(LIB3MF_LIBRARY 3MF)
  if(NOT (LIB3MF_INCLUDE_DIR AND LIB3MF_LIBRARY))
    message(WARNING "lib3mf is missing: nobody else reads the 3MF files of the tests (Debian: lib3mf-dev)")
  endif()
endif()
find_package(benchmark CONFIG QUIET)
if(NOT benchmark_FOUND)
  message(WARNING "Google Benchmark is missing: micro-benchmarks are not built (Debian: libbenchmark-dev)")
endif()
