// A picture in memory and its PNG file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// 8-bit sRGB with straight alpha, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  ///< 4 * width * height

  const std::uint8_t* at(int x, int y) const {
    return rgba.data() +
           4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  std::uint8_t* at(int x, int y) { return const_cast<std::uint8_t*>(static_cast<const Image*>(this)->at(x, y)); }
};

/// Reads a PNG of at most 4096 pixels a side. Errors: kNotFound, kBadFormat.
Expected<Image> readPng(const std::filesystem::path& path);

/// Writes a PNG by AtomicFile: replaces an existing file completely or not at all.
Expected<void> writePng(const std::filesystem::path& path, const Image& image);

}  // namespace kerf
