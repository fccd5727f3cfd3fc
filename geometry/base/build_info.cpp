#include "geometry/base/build_info.h"

#include "geometry/base/commit.h"
#include "geometry/base/libraries.h"
#include "geometry/base/version.h"

namespace kerf {

std::string buildCommit() { return kCommit; }

std::string libraryVersions() { return kLibraries; }

std::string versionText(const std::string& program, const std::string& more) {
  std::string out = program + " " + kVersion + " (commit " + buildCommit() + ")\nwith " + libraryVersions();
  if (!more.empty()) out += ", " + more;
  return out;
}

}  // namespace kerf
