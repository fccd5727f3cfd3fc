// Manual pages and shell completion from the tables of --help: the commands and options of a program.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/program/help_page.h"

namespace kerf {

/// A file of a program's manual: its path below share/ and its text.
struct ManualFile {
  std::filesystem::path path;  ///< "man/man1/kerf-cut.1"
  std::string text;
};

/// A manual page for the program and for each of its commands, and completion for bash, zsh and fish. Like --help,
/// omits hidden options and commands (those without a group).
/// @param app  with all commands and options; not parsed yet.  @param version  for the foot of each page.
/// @param topics  pages of section 7; completion offers them after the command `help`.
std::vector<ManualFile> manualOf(const CLI::App& app, const std::string& version,
                                 std::span<const HelpPage> topics = {});

/// Writes the files below a folder, which it creates. Error: a file cannot be written.
Expected<void> writeManual(const std::vector<ManualFile>& files, const std::filesystem::path& share);

/// Whether the command line is "PROGRAM --write-manual FOLDER": a request of the build, not of a user.
bool isManualRequest(int argc, const char* const* argv);

/// Writes the manual to `folder`. Returns the exit code, with the error on standard error.
int answerManualRequest(const CLI::App& app, const char* folder, std::span<const HelpPage> topics = {});

}  // namespace kerf
