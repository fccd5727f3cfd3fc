# One interface target carries the rules every Kerf target is compiled by.
find_program(KERF_CCACHE ccache)
if(KERF_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # pch_defines,time_macros: without them ccache refuses to cache anything that uses a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${KERF_CCACHE})
endif()

add_library(kerf_options INTERFACE)
add_library(kerf::options ALIAS kerf_options)
# Headers are included from the root: the source tree, or include/kerf where they are installed.
target_include_directories(kerf_options INTERFACE
  $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/generated> $<INSTALL_INTERFACE:include/kerf>)
target_compile_features(kerf_options INTERFACE cxx_std_20)
# -ffp-contract=off: the same input gives the same bits, whether or not the compiler likes fused multiply-add.
target_compile_options(kerf_options INTERFACE
  $<BUILD_INTERFACE:-Wall> $<BUILD_INTERFACE:-Wextra> $<BUILD_INTERFACE:-Wpedantic> $<BUILD_INTERFACE:-Wshadow> $<BUILD_INTERFACE:-Wno-psabi>
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
