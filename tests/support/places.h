// Folders that tests read. No macros: their values in each command of the compiler would keep ccache from finding in
// one checkout what another has compiled.
#pragma once

namespace kerf {

extern const char* const kSourceFolder;   ///< root of the source tree
extern const char* const kProgramFolder;  ///< of the built programs

}  // namespace kerf
