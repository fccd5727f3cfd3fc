// The words after a command: numbers in their ranges, files, and errors for wrong words.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "geometry/base/error.h"

namespace kerf {

using AppWords = std::span<const std::string>;

/// Error kBadValue.
tl::unexpected<Error> wrongWord(std::string found, std::string expected, std::string hint = {});
/// Word n as a number.   @param name  as in the usage.   Error kBadValue: missing, no number, or out of range.
Expected<double> numberOf(AppWords words, std::size_t n, const char* name, double low, double high);
/// The same; `fallback` if the word is missing.
Expected<double> numberOr(AppWords words, std::size_t n, double fallback, const char* name, double low, double high);
/// The first word, "on" or "off"; without one the opposite of `now`.
Expected<bool> onOrOff(AppWords words, bool now);
/// The first word.
Expected<std::filesystem::path> pathOf(AppWords words);

}  // namespace kerf
