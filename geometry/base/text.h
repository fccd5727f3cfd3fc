// Untrusted text: reading without blocking or excess memory, printing without terminal commands.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "geometry/base/error.h"

namespace kerf {

/// The bytes of a small file. Errors: kNotFound; kUnreadable for a folder, pipe or device, or with the system's reason;
/// kBadFormat above `most_bytes`.
Expected<std::string> readSmallFile(const std::filesystem::path& file, std::size_t most_bytes);

/// Bytes of the well-formed UTF-8 character (RFC 3629) at `at`; 0 if none.
std::size_t utf8Length(std::string_view bytes, std::size_t at);

/// For a terminal: control characters (C0, DEL, C1), and bytes that are no UTF-8, as \x1b.
/// @param keeps_lines  line feeds and tabs stay.
std::string printable(std::string_view text, bool keeps_lines = false);

/// fmt::print() of printable text, for all output of both programs.
template <class... Args>
void printText(std::FILE* to, fmt::format_string<Args...> format, Args&&... args) {
  std::fputs(printable(fmt::format(format, std::forward<Args>(args)...), true).c_str(), to);
}
template <class... Args>
void printText(fmt::format_string<Args...> format, Args&&... args) {
  printText(stdout, format, std::forward<Args>(args)...);
}

}  // namespace kerf
