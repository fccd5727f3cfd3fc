// Included first where clang compiles a source that uses ITK. Debian builds ITK with GCC, and its headers reject any
// other compiler. For the one header with this check, clang poses as GCC.
#pragma once

#undef __clang__
#undef __GNUC__
#define __GNUC__ 12
#include <itk_compiler_detection.h>
#undef __GNUC__
#define __GNUC__ 4
#define __clang__ 1
