#include "ui/window/gl/picture_legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace kerf {
namespace {

using Vec2 = Eigen::Vector2d;

/// A stroke font for lengths, axes and legends. A glyph is a chain of points "xy" on a grid 4 wide and 6 high, y
/// upwards ('/' and '.' lie below the line); a blank lifts the pen.
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
    case '-':
      return "03 33";
    case 'B':
      return "03 00 20 31 32 23 03 06 26 35 34 23";
    case 'T':
      return "06 46  26 20";
    case 'a':
      return "34 30  33 24 14 03 01 10 20 31";
    case 'b':
      return "06 00  03 14 24 33 31 20 10 01";
    case 'c':
      return "33 24 14 03 01 10 20 31";
    case 'd':
      return "36 30  33 24 14 03 01 10 20 31";
    case 'e':
      return "02 32 33 24 14 03 01 10 20 31";
    case 'f':
      return "10 15 26 36  04 24";
    case 'g':
      return "34 14 03 01 10 30  34 3/ 2. 0.";
    case 'h':
      return "06 00  03 14 24 33 30";
    case 'i':
      return "04 00  06 06";
    case 'l':
      return "06 00";
    case 'm':
      return "00 04  03 14 24 33 30  33 44 54 63 60";
    case 'n':
      return "04 00  03 14 24 33 30";
    case 'o':
      return "10 20 31 33 24 14 03 01 10";
    case 'p':
      return "04 0.  03 14 24 33 31 20 10 01";
    case 'r':
      return "04 00  03 14 24";
    case 's':
      return "33 24 14 03 12 22 31 20 10 01";
    case 't':
      return "16 11 20 30  04 24";
    case 'u':
      return "04 01 10 20 31  34 30";
    case 'v':
      return "04 20 44";
    case 'w':
      return "04 10 23 30 44";
    case 'x':
      return "04 30  00 34";
    case 'y':
      return "04 10  34 0.";
    case 'z':
      return "04 34 00 30";
    default:
      return "";
  }
}

double advance(char c) {
  if (c == 'm') return 8;
  if (c == '.' || c == ' ') return 3;
  if (c == 'i' || c == 'l') return 2;
  if (c == 'f' || c == 'r' || c == 't') return 4;
  const bool is_narrow = (c >= 'a' && c <= 'u') || c == 'x' || c == 'y' || c == 'z' || c == '-' || c == 'B';
  return is_narrow ? 5 : 6;
}

// Width from the first stroke to the last.
double widthOf(std::string_view text) {
  double out = -2;
  for (const char c : text) out += advance(c);
  return out;
}

double distanceToSegment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 ab = b - a;
  const double t = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

constexpr Rgba8 kInk{58, 62, 68, 255}, kPlate{255, 255, 255, 255};
constexpr double kPlateCoverage = 0.85;

/// Blends a colour over a pixel, `coverage` in [0, 1].
void ink(Image& image, int x, int y, double coverage, const Rgba8& colour = kInk) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height || coverage <= 0) return;
  std::uint8_t* pixel = image.at(x, y);
  const double old_alpha = pixel[3] / 255.0, alpha = coverage + old_alpha * (1 - coverage);
  for (std::size_t k = 0; k < 3; ++k)
    pixel[k] =
        static_cast<std::uint8_t>(std::lround((colour[k] * coverage + pixel[k] * old_alpha * (1 - coverage)) / alpha));
  pixel[3] = static_cast<std::uint8_t>(std::lround(255 * alpha));
}

void drawSegment(Image& image, const Vec2& a, const Vec2& b, double width) {
  const double reach = 0.5 * width + 1;
  const Vec2 low = a.cwiseMin(b).array() - reach, high = a.cwiseMax(b).array() + reach;
  for (int y = static_cast<int>(std::floor(low.y())); y <= static_cast<int>(std::ceil(high.y())); ++y)
    for (int x = static_cast<int>(std::floor(low.x())); x <= static_cast<int>(std::ceil(high.x())); ++x)
      ink(image, x, y, std::clamp(0.5 * width + 0.5 - distanceToSegment({x + 0.5, y + 0.5}, a, b), 0.0, 1.0));
}

void fill(Image& image, const Vec2& low, const Vec2& high, double coverage, const Rgba8& colour) {
  for (int y = static_cast<int>(std::lround(low.y())); y < static_cast<int>(std::lround(high.y())); ++y)
    for (int x = static_cast<int>(std::lround(low.x())); x < static_cast<int>(std::lround(high.x())); ++x)
      ink(image, x, y, coverage, colour);
}

/// @param at  the lower left corner.
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

// Size of text: follows the height of the picture.
struct Pen {
  double unit, width;
  explicit Pen(const Image& image) : unit(std::max(1.2, image.height / 400.0)), width(std::max(1.3, 0.9 * unit)) {}
};

constexpr double kPlateMargin = 1.5;  // of the pen's units, around the text

void drawOnPlate(Image& image, std::string_view text, const Vec2& at, const Pen& pen) {
  const Vec2 size(pen.unit * widthOf(text), 6 * pen.unit), margin = Vec2::Constant(kPlateMargin * pen.unit);
  fill(image, Vec2(at.x(), at.y() - size.y()) - margin, Vec2(at.x() + size.x(), at.y()) + margin, kPlateCoverage,
       kPlate);
  drawText(image, text, at, pen.unit, pen.width);
}

struct GridNumber {
  std::string text;
  double left = 0;  // of its first stroke, pixels
};

// The numbers between two pixels. Where plates would touch, only every second, fifth, tenth ... line has its number,
// independent of the picture's position.
std::vector<GridNumber> numbersAlong(const PictureGrid& grid, double from, double to, const Pen& pen) {
  const double margin = kPlateMargin * pen.unit;
  std::vector<GridNumber> out;
  bool touch = true;
  for (double tens = 1; touch; tens *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      out.clear();
      touch = false;
      double end = from;  // of the previous plate
      for (const PictureGrid::Line& line : grid.right) {
        if (std::fmod(std::round(line.mm / grid.step_mm), factor * tens) != 0) continue;
        const std::string text = numberAt(grid, line);
        const double width = pen.unit * widthOf(text), left = line.pixel - 0.5 * width;
        if (left - 2 * margin <= from || left + width >= to) continue;
        touch |= left - 2 * margin <= end;
        out.push_back({text, left});
        end = left + width + margin;
      }
      if (!touch) break;
    }
  }
  return out;
}

}  // namespace

void drawScaleBar(Image& image, double length_mm, double mm_per_pixel) {
  const auto [unit, width] = Pen(image);
  const double right = image.width - 10 * unit, y = image.height - 9 * unit, left = right - length_mm / mm_per_pixel;
  const std::string text = fmt::format("{:g} mm", length_mm);

  drawSegment(image, {left, y}, {right, y}, width);
  drawSegment(image, {left, y - 2 * unit}, {left, y + 2 * unit}, width);
  drawSegment(image, {right, y - 2 * unit}, {right, y + 2 * unit}, width);
  drawText(image, text, {0.5 * (left + right) - 0.5 * unit * widthOf(text), y - 5 * unit}, unit, width);
}

void drawGrid(Image& image, const PictureGrid& grid) {
  constexpr double kLine = 0.25, kAxis = 0.6;  // of ink: stronger through the scan's origin
  const Pen pen(image);
  const auto strength = [](const PictureGrid::Line& line) { return line.mm == 0 ? kAxis : kLine; };
  for (const PictureGrid::Line& line : grid.right)
    fill(image, {std::floor(line.pixel), 0}, {std::floor(line.pixel) + 1, image.height}, strength(line), kInk);
  for (const PictureGrid::Line& line : grid.up)
    fill(image, {0, std::floor(line.pixel)}, {image.width, std::floor(line.pixel) + 1}, strength(line), kInk);

  // The corner is reserved for the names of the axes.
  const double edge = 3 * pen.unit, margin = kPlateMargin * pen.unit, name_at = edge + 14 * pen.unit;
  const auto named = [](const std::string& name) { return name.empty() ? std::string("mm") : name + " mm"; };
  const std::string right_name = named(grid.right_name);
  drawOnPlate(image, right_name, {name_at, edge + 6 * pen.unit}, pen);
  drawOnPlate(image, named(grid.up_name), {edge, edge + 18 * pen.unit}, pen);

  const double corner = name_at + pen.unit * widthOf(right_name) + margin;
  for (const GridNumber& number : numbersAlong(grid, corner, image.width - edge, pen))
    drawOnPlate(image, number.text, {number.left, edge + 6 * pen.unit}, pen);
  for (const PictureGrid::Line& line : grid.up) {
    const double base = line.pixel + 3 * pen.unit;
    if (base > 32 * pen.unit && base < image.height - edge) drawOnPlate(image, numberAt(grid, line), {edge, base}, pen);
  }
}

void drawLegend(Image& image, const MapLegend& legend) {
  const Pen pen(image);
  const double edge = 8 * pen.unit, bar = 6 * pen.unit, line = 9 * pen.unit;
  const double width = pen.unit * std::max({100.0, widthOf(legend.title), widthOf(legend.low + legend.high) + 12,
                                            legend.ticks.empty() ? 0.0 : 2.5 * widthOf(legend.high)});
  const double bottom = image.height - edge, margin = 3 * pen.unit;
  fill(image, {edge - margin, bottom - 2 * line - bar - margin}, {edge + width + margin, bottom + margin},
       kPlateCoverage, kPlate);

  drawText(image, legend.title, {edge, bottom - line - bar - 2 * pen.unit}, pen.unit, pen.width);
  for (int x = 0; x < static_cast<int>(width); ++x)
    fill(image, {edge + x, bottom - line - bar}, {edge + x + 1, bottom - line}, 1, legend.colourAt((x + 0.5) / width));
  drawText(image, legend.low, {edge, bottom}, pen.unit, pen.width);
  for (const MapLegend::Tick& tick : legend.ticks)
    drawText(image, tick.text, {edge + width * tick.share - 0.5 * pen.unit * widthOf(tick.text), bottom}, pen.unit,
             pen.width);
  drawText(image, legend.high, {edge + width - pen.unit * widthOf(legend.high), bottom}, pen.unit, pen.width);
}

bool canBeDrawn(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c == ' ' || !strokes(c).empty(); });
}

}  // namespace kerf
