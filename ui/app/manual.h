// Manual pages and shell completion, made from the same tables as --help: the commands and options of a program.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// A file of a program's manual: where it lies below share/, and what is in it.
struct ManualFile {
  std::filesystem::path path;  ///< "man/man1/kerf-cut.1"
  std::string text;
};

/// One manual page for the program and one for each of its commands, and completion for bash, zsh and fish.
/// Hidden options and commands (those without a group) are left out, as --help leaves them out.
/// @param app  with all commands and options; not parsed yet.  @param version  stands at the foot of each page.
std::vector<ManualFile> manualOf(const CLI::App& app, const std::string& version);

/// Writes them below a folder, which is made. Error: a file can not be written.
Expected<void> writeManual(const std::vector<ManualFile>& files, const std::filesystem::path& share);

/// Whether the command line is "PROGRAM --write-manual FOLDER": a request of the build, not of a user.
bool isManualRequest(int argc, const char* const* argv);

/// Does what such a command line asks. Returns the exit code, with the error on standard error.
int answerManualRequest(const CLI::App& app, const char* folder);

}  // namespace kerf
