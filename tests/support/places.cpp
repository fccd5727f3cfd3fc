#include "tests/support/places.h"

namespace kerf {

const char* const kSourceFolder = KERF_SOURCE_DIR;
const char* const kProgramFolder = KERF_BIN_DIR;

}  // namespace kerf
