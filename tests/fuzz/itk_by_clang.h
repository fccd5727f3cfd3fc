// Included before everything else where clang compiles a source that uses ITK. Debian builds ITK with GCC, and its
// headers then refuse any other compiler; for the one header that looks, clang is GCC here.
#pragma once

#undef __clang__
#undef __GNUC__
#define __GNUC__ 12
#include <itk_compiler_detection.h>
#undef __GNUC__
#define __GNUC__ 4
#define __clang__ 1
