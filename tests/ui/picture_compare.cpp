#include "tests/ui/picture_compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kerf::test {
namespace {

double linearOf(std::uint8_t v) {
  const double c = v / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

Vec3d labOfLinear(const Vec3d& rgb) {
  static const Eigen::Matrix3d kToXyz{{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
  static const Vec3d kWhite(0.9505, 1, 1.089);
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const Vec3d xyz = (kToXyz * rgb).cwiseQuotient(kWhite);
  const double x = f(xyz[0]), y = f(xyz[1]), z = f(xyz[2]);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

struct Linear {
  int width = 0, height = 0;
  std::vector<Vec3d> pixels;
  const Vec3d& at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
};

Linear linear(const Image& image) {
  static const auto kTable = [] {
    std::array<double, 256> out{};
    for (std::size_t n = 0; n < out.size(); ++n) out[n] = linearOf(static_cast<std::uint8_t>(n));
    return out;
  }();
  Linear out{image.width, image.height, {}};
  for (std::size_t i = 0; i + 3 < image.rgba.size(); i += 4)
    out.pixels.emplace_back(kTable[image.rgba[i]], kTable[image.rgba[i + 1]], kTable[image.rgba[i + 2]]);
  return out;
}

Linear halved(const Linear& image) {
  Linear out{image.width / 2, image.height / 2, {}};
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      out.pixels.push_back(0.25 * (image.at(2 * x, 2 * y) + image.at(2 * x + 1, 2 * y) + image.at(2 * x, 2 * y + 1) +
                                   image.at(2 * x + 1, 2 * y + 1)));
  return out;
}

double meanDifference(const Linear& a, const Linear& b) {
  double sum = 0;
  for (std::size_t n = 0; n < a.pixels.size(); ++n) sum += (labOfLinear(a.pixels[n]) - labOfLinear(b.pixels[n])).norm();
  return sum / static_cast<double>(std::max<std::size_t>(a.pixels.size(), 1));
}

}  // namespace

Vec3d labOf(const std::uint8_t* srgb) { return labOfLinear({linearOf(srgb[0]), linearOf(srgb[1]), linearOf(srgb[2])}); }

double pictureDifference(const Image& a, const Image& b) {
  constexpr double kAnother = 100;
  if (a.width != b.width || a.height != b.height || a.rgba.size() != b.rgba.size() || a.rgba.empty()) return kAnother;
  Linear first = linear(a), second = linear(b);
  double most = 0;
  for (int level = 0; level < 2; ++level) {
    first = halved(first);
    second = halved(second);
    most = std::max(most, meanDifference(first, second));
  }
  return most;
}

}  // namespace kerf::test
