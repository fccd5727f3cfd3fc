// Sources and libraries of a build: for --version and bug reports.
#pragma once

#include <string>

namespace kerf {

/// The commit of the sources, "0123456789ab", with a "+" suffix if files differed from that commit. "unknown" without a
/// git checkout.
std::string buildCommit();

/// Libraries by others and their versions, as found by CMake: "CGAL 5.5.1, OpenVDB 10.0.1, ...".
std::string libraryVersions();

/// Output of --version: "PROGRAM VERSION (commit COMMIT)", then the libraries.
/// @param more  libraries of the program alone, "GLFW 3.3.8, ..."; may be empty.
std::string versionText(const std::string& program, const std::string& more = {});

}  // namespace kerf
