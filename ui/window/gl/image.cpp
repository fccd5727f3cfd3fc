#include "ui/window/gl/image.h"

#include <fmt/format.h>
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "geometry/base/atomic_file.h"

namespace kerf {
Expected<Image> readPng(const std::filesystem::path& path) {
  constexpr int kMost = 4096;
  int width = 0, height = 0, channels = 0;
  const auto wrong = [&](Error::Code code, std::string found) {
    return fail({.code = code, .file = path.string(), .found = std::move(found), .expected = "a PNG picture"});
  };
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return wrong(Error::Code::kNotFound, "no such file");
  if (!stbi_info(path.c_str(), &width, &height, &channels)) return wrong(Error::Code::kBadFormat, "no picture");
  if (width > kMost || height > kMost)
    return wrong(Error::Code::kBadFormat, fmt::format("{} x {} pixels", width, height));

  stbi_uc* const pixels = stbi_load(path.c_str(), &width, &height, &channels, 4);
  if (!pixels) return wrong(Error::Code::kBadFormat, "a truncated or damaged picture");
  Image out{width, height, {}};
  out.rgba.assign(pixels, pixels + 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  stbi_image_free(pixels);
  return out;
}

Expected<void> writePng(const std::filesystem::path& path, const Image& image) {
  KERF_TRY(file, AtomicFile::create(path));
  const auto write = [](void* to, void* data, int size) {
    static_cast<std::ostream*>(to)->write(static_cast<const char*>(data), size);
  };
  if (!stbi_write_png_to_func(write, &file.stream(), image.width, image.height, 4, image.rgba.data(), 4 * image.width))
    return fail({.code = Error::Code::kWriteFailed, .file = path.string(), .found = "cannot encode the picture"});
  return file.commit();
}

}  // namespace kerf
