# One interface target carries the rules every Kerf target is compiled by.
find_program(KERF_CCACHE ccache)
if(KERF_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # pch_defines,time_macros: without them ccache refuses to cache anything that uses a precompiled header. The folder of
  # the tree is left out of the key, so that a second checkout finds what the first compiled (not for a debugger, which
  # would look for sources in the first).
  set(ccache CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_BASEDIR=${CMAKE_SOURCE_DIR})
  if(NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
    list(APPEND ccache CCACHE_NOHASHDIR=1)
  endif()
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env ${ccache} ${KERF_CCACHE})
endif()

add_library(kerf_options INTERFACE)
add_library(kerf::options ALIAS kerf_options)
# Headers are included from the root: the source tree, or include/kerf where they are installed.
target_include_directories(kerf_options INTERFACE
  $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/generated> $<INSTALL_INTERFACE:include/kerf> $<INSTALL_INTERFACE:include>)
target_compile_features(kerf_options INTERFACE cxx_std_20)
# -ffp-contract=off: the same input gives the same bits, whether or not the compiler likes fused multiply-add.
# In a unity build a local name may be that of a function of another source.
set(shadow -Wshadow)
if(KERF_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(shadow -Wshadow=local)
endif()
target_compile_options(kerf_options INTERFACE
  $<BUILD_INTERFACE:-Wall> $<BUILD_INTERFACE:-Wextra> $<BUILD_INTERFACE:-Wpedantic> $<BUILD_INTERFACE:${shadow}> $<BUILD_INTERFACE:-Wno-psabi>
  -ffp-contract=off
  $<BUILD_INTERFACE:$<$<BOOL:${KERF_WERROR}>:-Werror>>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(kerf_options INTERFACE $<BUILD_INTERFACE:-fpch-preprocess>)
endif()
if(KERF_SANITIZE)
  target_compile_options(kerf_options INTERFACE -fsanitize=${KERF_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(kerf_options INTERFACE -fsanitize=${KERF_SANITIZE})
  if(KERF_NO_SANITIZE)
    target_compile_options(kerf_options INTERFACE -fno-sanitize=${KERF_NO_SANITIZE})
  endif()
endif()
if(KERF_FUZZ)  # coverage for libFuzzer everywhere; its main() only in the harnesses
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "KERF_FUZZ needs clang and its libFuzzer: cmake --preset fuzz (scripts/setup --fuzz installs both)")
  endif()
  target_compile_options(kerf_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# kerf_glue(TARGET): its own sources only call libraries. What counts is how long they take to compile: less at -O1.
function(kerf_glue target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# kerf_sources(TARGET [PARTS n] FILES...): sources of this folder. With KERF_UNITY the compiler sees them as n units:
# names in their anonymous namespaces must differ. A source with compile options of its own stays a unit.
function(kerf_sources target)
  cmake_parse_arguments(ARG "" "PARTS" "" ${ARGN})
  set(files ${ARG_UNPARSED_ARGUMENTS})
  target_sources(${target} PRIVATE ${files})
  kerf_unity(${target} "${ARG_PARTS}" ${files})
endfunction()

# kerf_folders(TARGET PARTS N FOLDERS...): the same for all sources of folders, so that a new file needs no line here.
function(kerf_folders target)
  cmake_parse_arguments(ARG "" "PARTS" "" ${ARGN})
  set(files "")
  foreach(folder IN LISTS ARG_UNPARSED_ARGUMENTS)
    file(GLOB found CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} ${folder}/*.cpp)
    list(APPEND files ${found})
  endforeach()
  kerf_sources(${target} PARTS ${ARG_PARTS} ${files})
endfunction()

# kerf_unity(TARGET PARTS FILES...): the same for sources that the target has.
function(kerf_unity target parts)
  if(NOT parts)
    set(parts 1)
  endif()
  file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  string(MAKE_C_IDENTIFIER "${folder}" group)
  list(LENGTH ARGN count)
  set(at 0)
  foreach(file IN LISTS ARGN)
    math(EXPR part "${at} * ${parts} / ${count}")
    set_source_files_properties(${file} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${group}_${part})
    math(EXPR at "${at} + 1")
  endforeach()
  if(KERF_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # it takes a source that is included for a header
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${KERF_UNITY} UNITY_BUILD_MODE GROUP)
endfunction()
