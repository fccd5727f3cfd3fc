// What a program was built from: for --version, and for reports of what went wrong.
#pragma once

#include <string>

namespace kerf {

/// The commit of the sources, "0123456789ab", with "+" behind it when files differed from that commit. "unknown" when
/// the sources were no git checkout.
std::string buildCommit();

/// Libraries by others and their versions, as found when Kerf was configured: "CGAL 5.5.1, OpenVDB 10.0.1, ...".
std::string libraryVersions();

/// What --version prints: "PROGRAM VERSION (commit COMMIT)", then the libraries.
/// @param more  libraries of the program alone, "GLFW 3.3.8, ..."; may be empty.
std::string versionText(const std::string& program, const std::string& more = {});

}  // namespace kerf
