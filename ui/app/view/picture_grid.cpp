#include "ui/app/view/picture_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

// Rounds up to 1, 2 or 5 times a power of ten.
double roundedUp(double mm) {
  const double power = std::pow(10, std::floor(std::log10(mm)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= mm) return factor * power;
  return 10 * power;
}

std::string pictureNameOf(const Vec3d& direction) {
  constexpr double kAlong = 1 - 1e-9;  // cosine
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(direction[axis]) > kAlong) return (direction[axis] < 0 ? "-" : "") + std::string(1, "xyz"[axis]);
  return {};
}

// @param middle  coordinate at the middle of the picture, mm.   @param direction  1: pixels grow with mm; -1: they
// fall.
std::vector<PictureGrid::Line> pictureLines(double middle, double step, double mm_per_pixel, int pixels,
                                            int direction) {
  const double half = 0.5 * pixels * mm_per_pixel;
  std::vector<PictureGrid::Line> out;
  for (double n = std::ceil((middle - half) / step); n * step <= middle + half; ++n) {
    const double mm = n == 0 ? 0 : n * step;  // not -0
    out.push_back({mm, 0.5 * pixels + direction * (mm - middle) / mm_per_pixel});
  }
  return out;
}

}  // namespace

PictureGrid pictureGrid(const Camera& camera, int width, int height, const Eigen::Matrix3d& drawn_from_scan) {
  constexpr double kLeastPixels = 50, kMostLines = 24;
  const double mm = camera.mmPerPixel(height);
  const Vec3d right = camera.right(), up = camera.up();

  PictureGrid out;
  out.step_mm = roundedUp(mm * std::max(kLeastPixels, std::max(width, height) / kMostLines));
  out.right = pictureLines(camera.target.dot(right), out.step_mm, mm, width, 1);
  out.up = pictureLines(camera.target.dot(up), out.step_mm, mm, height, -1);
  out.right_name = pictureNameOf(drawn_from_scan.transpose() * right);
  out.up_name = pictureNameOf(drawn_from_scan.transpose() * up);
  return out;
}

std::string numberAt(const PictureGrid& grid, const PictureGrid::Line& line) {
  constexpr double kRounding = 1e-9;
  const double decimals = std::ceil(-std::log10(grid.step_mm) - kRounding);
  return fmt::format("{:.{}f}", line.mm, static_cast<int>(std::max(0.0, decimals)));
}

}  // namespace kerf
