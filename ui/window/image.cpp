#include "ui/window/image.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace kerf {
namespace {

using Vec2 = Eigen::Vector2d;

/// A stroke font of what a length needs. A glyph is a chain of points "xy" on a grid 4 wide and 6 high, y upwards;
/// a blank lifts the pen.
std::string_view strokes(char c) {
  switch (c) {
    case '0':
      return "10 30 41 45 36 16 05 01 10";
    case '1':
      return "05 26 20";
    case '2':
      return "05 16 36 45 44 00 40";
    case '3':
      return "05 16 36 45 44 33 13  33 42 41 30 10 01";
    case '4':
      return "30 36 02 42";
    case '5':
      return "46 06 04 34 43 41 30 10 01";
    case '6':
      return "45 36 16 05 01 10 30 41 42 33 03";
    case '7':
      return "06 46 10";
    case '8':
      return "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33";
    case '9':
      return "01 10 30 41 45 36 16 05 04 13 43";
    case '.':
      return "10 10";
    case 'm':
      return "00 04  03 14 24 33 30  33 44 54 63 60";
    default:
      return "";
  }
}
double advance(char c) { return c == 'm' ? 8 : c == '.' ? 3 : c == ' ' ? 3 : 6; }

double distanceToSegment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 ab = b - a;
  const double t = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

/// Blends ink over a pixel, `coverage` in [0, 1].
void ink(Image& image, int x, int y, double coverage) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height || coverage <= 0) return;
  std::uint8_t* pixel = image.at(x, y);
  constexpr double kInk[3] = {58, 62, 68};
  const double old_alpha = pixel[3] / 255.0, alpha = coverage + old_alpha * (1 - coverage);
  for (int k = 0; k < 3; ++k)
    pixel[k] =
        static_cast<std::uint8_t>(std::lround((kInk[k] * coverage + pixel[k] * old_alpha * (1 - coverage)) / alpha));
  pixel[3] = static_cast<std::uint8_t>(std::lround(255 * alpha));
}

void drawSegment(Image& image, const Vec2& a, const Vec2& b, double width) {
  const double reach = 0.5 * width + 1;
  const Vec2 low = a.cwiseMin(b).array() - reach, high = a.cwiseMax(b).array() + reach;
  for (int y = static_cast<int>(std::floor(low.y())); y <= static_cast<int>(std::ceil(high.y())); ++y)
    for (int x = static_cast<int>(std::floor(low.x())); x <= static_cast<int>(std::ceil(high.x())); ++x)
      ink(image, x, y, std::clamp(0.5 * width + 0.5 - distanceToSegment({x + 0.5, y + 0.5}, a, b), 0.0, 1.0));
}

void drawText(Image& image, std::string_view text, Vec2 at, double unit, double width) {
  for (const char c : text) {
    const std::string_view path = strokes(c);
    const auto point = [&](std::size_t i) {
      return Vec2(at.x() + unit * (path[i] - '0'), at.y() - unit * (path[i + 1] - '0'));
    };
    for (std::size_t i = 0; i + 4 < path.size(); i += path[i + 2] == ' ' && path[i + 3] == ' ' ? 4 : 3)
      if (path[i + 3] != ' ') drawSegment(image, point(i), point(i + 3), width);
    at.x() += unit * advance(c);
  }
}

}  // namespace

void drawScaleBar(Image& image, double length_mm, double mm_per_pixel) {
  const double unit = std::max(1.2, image.height / 400.0), width = std::max(1.3, 0.9 * unit);
  const double right = image.width - 10 * unit, y = image.height - 9 * unit, left = right - length_mm / mm_per_pixel;
  const std::string text = fmt::format("{:g} mm", length_mm);

  double text_width = -2;
  for (const char c : text) text_width += advance(c);

  drawSegment(image, {left, y}, {right, y}, width);
  drawSegment(image, {left, y - 2 * unit}, {left, y + 2 * unit}, width);
  drawSegment(image, {right, y - 2 * unit}, {right, y + 2 * unit}, width);
  drawText(image, text, {0.5 * (left + right) - 0.5 * unit * text_width, y - 5 * unit}, unit, width);
}

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
  if (!pixels) return wrong(Error::Code::kBadFormat, "a picture that is cut short or damaged");
  Image out{width, height, {}};
  out.rgba.assign(pixels, pixels + 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  stbi_image_free(pixels);
  return out;
}

Expected<void> writePng(const std::filesystem::path& path, const Image& image) {
  const auto failed = [&](std::string found) {
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .place = {},
                 .found = std::move(found),
                 .expected = {},
                 .hint = "a folder that exists and may be written to"});
  };

  std::vector<std::uint8_t> png;
  const auto collect = [](void* to, void* data, int size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    auto& all = *static_cast<std::vector<std::uint8_t>*>(to);
    all.insert(all.end(), bytes, bytes + size);
  };
  if (!stbi_write_png_to_func(collect, &png, image.width, image.height, 4, image.rgba.data(), 4 * image.width))
    return failed("the picture could not be encoded");

  std::string beside = path.string() + ".XXXXXX";
  const int file = mkstemp(beside.data());
  if (file < 0) return failed(fmt::format("can not write here ({})", std::strerror(errno)));

  bool ok = fchmod(file, 0644) == 0;
  for (std::size_t done = 0; ok && done < png.size();) {
    const ssize_t n = write(file, png.data() + done, png.size() - done);
    if (n < 0 && errno == EINTR) continue;
    ok = n > 0;
    done += ok ? static_cast<std::size_t>(n) : 0;
  }

  ok = ok && fsync(file) == 0;
  int reason = errno;
  close(file);
  if (ok && std::rename(beside.c_str(), path.c_str()) == 0) return {};
  if (ok) reason = errno;
  unlink(beside.c_str());
  return failed(fmt::format("writing failed ({})", std::strerror(reason)));
}

}  // namespace kerf
