// SHA-256 (FIPS 180-4), by Nettle: identifies equal files and buffers. Not used for secrets.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "geometry/base/error.h"

namespace kerf {

/// 64 lower-case hexadecimal digits. @cost 0.6 ns a byte where the processor has SHA instructions, else 4.5.
std::string sha256(std::span<const std::byte> bytes);
Expected<std::string> sha256OfFile(const std::filesystem::path& path);
/// Fails if the file's hash differs: damaged, truncated, or edited by hand.
/// @param hint  remedy.
Expected<void> requireSha256(const std::filesystem::path& path, const std::string& expected, const std::string& hint);

}  // namespace kerf
