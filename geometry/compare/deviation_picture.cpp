#include "geometry/compare/deviation_picture.h"

#include <fmt/format.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "geometry/base/xml_text.h"

namespace kerf {
namespace {

using Rgb = std::array<double, 3>;

// ---- Six views, drawn with a depth buffer

struct View {
  const char* name;
  Vec3d right, up;  // of the picture; the viewer stands on the side of right x up
};
const std::array<View, 6> kViews{{{"from +z", {1, 0, 0}, {0, 1, 0}},
                                  {"from -y", {1, 0, 0}, {0, 0, 1}},
                                  {"from +x", {0, 1, 0}, {0, 0, 1}},
                                  {"from -z", {1, 0, 0}, {0, -1, 0}},
                                  {"from +y", {-1, 0, 0}, {0, 0, 1}},
                                  {"from -x", {0, -1, 0}, {0, 0, 1}}}};
constexpr int kTileWidth = 310, kTileHeight = 250, kColumns = 3, kRows = 2, kFine = 2;  // px; samples a px, each way
constexpr double kMargin = 12;                                                          // px

class Canvas {
 public:
  Canvas() : colour_(kWidth * kHeight, Rgb{255, 255, 255}), depth_(kWidth * kHeight, -kFar) {}

  void draw(const Mesh& mesh, const Deviations& deviations, const DeviationScale& scale, const View& view, int tile,
            double px_per_mm) {
    const Vec3d middle = bounds(mesh).center(), towards = view.right.cross(view.up);
    const double x0 = kFine * kTileWidth * (tile % kColumns + 0.5), y0 = kFine * kTileHeight * (tile / kColumns + 0.5);
    const double s = kFine * px_per_mm;
    const auto project = [&](std::uint32_t v) {
      const Vec3d p = mesh.vertices[v] - middle;
      return Vec3d(x0 + s * view.right.dot(p), y0 - s * view.up.dot(p), towards.dot(p));
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& corners = mesh.triangles[t];
      const double slope = std::abs(doubleAreaVector(mesh, t).stableNormalized().dot(towards));
      constexpr double kAmbient = 0.45;
      triangle({project(corners[0]), project(corners[1]), project(corners[2])}, corners, deviations.at_vertex, scale,
               kAmbient + (1 - kAmbient) * slope);
    }
  }

  std::string png() const {
    std::vector<std::uint8_t> rgb;
    rgb.reserve(3 * kWidth * kHeight / (kFine * kFine));
    for (std::size_t y = 0; y < kHeight; y += kFine)
      for (std::size_t x = 0; x < kWidth; x += kFine)
        for (std::size_t k = 0; k < 3; ++k) {
          double sum = 0;
          for (std::size_t n = 0; n < kFine * kFine; ++n) sum += colour_[(y + n / kFine) * kWidth + x + n % kFine][k];
          rgb.push_back(static_cast<std::uint8_t>(std::lround(sum / (kFine * kFine))));
        }
    std::string out;
    stbi_write_png_to_func(
        [](void* to, void* data, int size) {
          static_cast<std::string*>(to)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
        },
        &out, kWidth / kFine, kHeight / kFine, 3, rgb.data(), 3 * kWidth / kFine);
    return out;
  }

 private:
  // Interpolates the deviation, not its colour: so the edge of the band stays sharp.
  void triangle(const std::array<Vec3d, 3>& p, const Triangle& corners, const std::vector<float>& at_vertex,
                const DeviationScale& scale, double light) {
    const double twice = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    if (!(std::abs(twice) > 0)) return;
    const auto range = [&](int axis, std::size_t size) {
      const auto [low, high] = std::minmax({p[0][axis], p[1][axis], p[2][axis]});
      return std::pair(
          static_cast<std::size_t>(std::max(0.0, std::ceil(low - 0.5))),
          static_cast<std::size_t>(std::clamp(std::floor(high - 0.5) + 1, 0.0, static_cast<double>(size))));
    };
    const auto [left, right] = range(0, kWidth);
    const auto [top, bottom] = range(1, kHeight);
    for (std::size_t y = top; y < bottom; ++y)
      for (std::size_t x = left; x < right; ++x) {
        const double px = static_cast<double>(x) + 0.5, py = static_cast<double>(y) + 0.5;
        std::array<double, 3> w;
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3d &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
          w[k] = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / twice;
        }
        if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
        double depth = 0, mm = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          depth += w[k] * p[k][2];
          mm += w[k] * static_cast<double>(at_vertex[corners[k]]);
        }
        const std::size_t at = y * kWidth + x;
        if (depth <= depth_[at]) continue;
        depth_[at] = depth;
        const Rgba8 colour = scale.colour(mm);
        for (std::size_t k = 0; k < 3; ++k) colour_[at][k] = light * colour[k];
      }
  }

  static constexpr double kFar = 1e30;
  static constexpr std::size_t kWidth = kFine * kTileWidth * kColumns, kHeight = kFine * kTileHeight * kRows;
  std::vector<Rgb> colour_;
  std::vector<double> depth_;
};

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t n = 0; n < bytes.size(); n += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (n + k < bytes.size() ? static_cast<std::uint8_t>(bytes[n + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += n + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63u];
  }
  return out;
}

// ---- The sheet

constexpr double kWidth = 1000, kLeft = 35, kTop = 78, kChart = 150;  // px
constexpr const char *kInk = "#1d2733", *kFaint = "#5b6673";

std::string text(double x, double y, std::string_view what, const char* colour, const char* anchor, double size) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\" text-anchor=\"{}\" font-size=\"{:.0f}\">{}</text>\n",
                     x, y, colour, anchor, size, xmlText(what));
}

// Lines too long for the sheet end at a "; ".
std::vector<std::string> wrapped(const std::vector<std::string>& lines) {
  constexpr std::size_t kMost = 118;
  std::vector<std::string> out;
  for (std::string line : lines) {
    for (std::size_t at; line.size() > kMost && (at = line.rfind("; ", kMost)) != line.npos; line.erase(0, at + 2))
      out.push_back(line.substr(0, at + 1));
    out.push_back(line);
  }
  return out;
}

std::string hex(const Rgba8& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); }

// Bars in the colours of the scale: chart and legend in one. The outermost bars hold all beyond the range.
std::string histogram(const Deviations& d, const DeviationScale& scale, double top) {
  constexpr int kBars = 81;  // odd: the middle one stands at 0
  const double width = kWidth - 2 * kLeft, bar = width / kBars, mm = 2 * scale.range_mm / (kBars - 2);
  std::vector<double> area(kBars);
  for (std::size_t n = 0; n < d.value.size(); ++n) {
    const double at = static_cast<double>(d.value[n]) / mm + 0.5 * kBars;
    area[static_cast<std::size_t>(std::clamp(at, 0.0, kBars - 0.5))] += static_cast<double>(d.area[n]);
  }
  // The bar of the unchanged surface would flatten the others: it ends at the top.
  double most = 0;
  for (int n = 0; n < kBars; ++n)
    if (n != kBars / 2) most = std::max(most, area[static_cast<std::size_t>(n)]);
  const double middle = area[kBars / 2], bottom = top + kChart;
  const bool is_cut_off = middle > most && most > 0;
  if (!is_cut_off) most = std::max(most, middle);
  const auto x = [&](double value) { return kLeft + width * (0.5 + value / mm / kBars); };
  std::string out =
      fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"#f1f3f5\"/>\n",
                  x(-scale.tolerance_mm), top, x(scale.tolerance_mm) - x(-scale.tolerance_mm), kChart);
  for (int n = 0; n < kBars; ++n) {
    const double high = std::min(1.0, area[static_cast<std::size_t>(n)] / most) * kChart;
    const std::string fill = hex(scale.colour(mm * (n - kBars / 2)));
    const double left = kLeft + bar * n;
    if (high > 0)
      out += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", left,
                         bottom - high, bar, high, fill);
    out += fmt::format("<rect x=\"{:.2f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"14\" fill=\"{}\"/>\n", left,
                       bottom + 3, bar, fill);
  }
  for (int n = -4; n <= 4; ++n) {
    const double value = 0.25 * n * scale.range_mm;
    out += text(x(value), bottom + 33, fmt::format("{}{:g}", n > 0 ? "+" : "", value), kInk, "middle", 13);
  }
  out += text(kLeft, bottom + 52, "material missing", kInk, "start", 13);
  out += text(kWidth / 2, bottom + 52, fmt::format("deviation [mm]; grey: within \u00b1{:g} mm", scale.tolerance_mm),
              kInk, "middle", 13);
  out += text(kWidth - kLeft, bottom + 52, "material too much", kInk, "end", 13);
  return out + text(kLeft, top - 8,
                    is_cut_off ? "area by deviation; the middle bar is cut off at the top" : "area by deviation", kInk,
                    "start", 14);
}

}  // namespace

Rgba8 DeviationScale::colour(double mm) const {
  if (std::isnan(mm)) return {94, 88, 75, 255};
  if (std::abs(mm) <= tolerance_mm) return {214, 214, 214, 255};
  constexpr std::array<std::array<Rgb, 3>, 2> kStops{
      {{{{146, 197, 222}, {33, 102, 172}, {5, 48, 97}}}, {{{244, 165, 130}, {178, 24, 43}, {103, 0, 31}}}}};
  const auto& stops = kStops[mm > 0];
  const double at = 2 * std::clamp((std::abs(mm) - tolerance_mm) / (range_mm - tolerance_mm), 0.0, 1.0);
  const std::size_t low = at < 1 ? 0 : 1;
  const double part = at - static_cast<double>(low);
  Rgba8 out{0, 0, 0, 255};
  for (std::size_t k = 0; k < 3; ++k)
    out[k] = static_cast<std::uint8_t>(std::lround(stops[low][k] + part * (stops[low + 1][k] - stops[low][k])));
  return out;
}

DeviationScale DeviationScale::of(const Comparison& comparison, double tolerance_mm) {
  constexpr double kPart = 0.99;
  double most = 2 * tolerance_mm;
  for (const Deviations* d : {&comparison.of_first, &comparison.of_second}) {
    std::vector<std::pair<float, float>> all;
    for (std::size_t n = 0; n < d->value.size(); ++n) all.emplace_back(std::abs(d->value[n]), d->area[n]);
    std::sort(all.begin(), all.end());
    double below = 0;
    for (const auto& [mm, area] : all)
      if ((below += static_cast<double>(area)) >= kPart * d->area_mm2) {
        most = std::max(most, static_cast<double>(mm));
        break;
      }
  }
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double times : {1.0, 2.0, 5.0})
    if (times * power >= most * (1 - 1e-9)) return {tolerance_mm, times * power};
  return {tolerance_mm, 10 * power};
}

std::vector<Rgba8> vertexColours(const Deviations& deviations, const DeviationScale& scale) {
  std::vector<Rgba8> out;
  out.reserve(deviations.at_vertex.size());
  for (const float mm : deviations.at_vertex) out.push_back(scale.colour(static_cast<double>(mm)));
  return out;
}

std::string drawDeviations(const Mesh& mesh, const Deviations& deviations, const DeviationScale& scale,
                           const DeviationPicture& picture) {
  double px_per_mm = 1e9;
  for (const View& view : kViews) {
    const Vec3d size = bounds(mesh).size();
    const auto fit = [&](const Vec3d& axis, double px) {
      px_per_mm = std::min(px_per_mm, (px - 2 * kMargin) / std::max(1e-9, std::abs(axis.dot(size))));
    };
    fit(view.right, kTileWidth);
    fit(view.up, kTileHeight);
  }
  Canvas canvas;
  for (std::size_t n = 0; n < kViews.size(); ++n)
    canvas.draw(mesh, deviations, scale, kViews[n], static_cast<int>(n), px_per_mm);

  constexpr double kViewsHeight = kTileHeight * kRows, kLine = 19;
  const double chart = kTop + kViewsHeight + 30, lines = chart + kChart + 84;
  const std::vector<std::string> words = wrapped(picture.lines);
  const double height = lines + kLine * static_cast<double>(words.size());
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\">\n<title>{2}</title>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      kWidth, height, xmlText(picture.title));
  out += text(kLeft, 32, picture.title, kInk, "start", 20) + text(kLeft, 54, picture.subtitle, kFaint, "start", 13);
  out +=
      fmt::format("<image x=\"{:.0f}\" y=\"{:.0f}\" width=\"{}\" height=\"{}\" href=\"data:image/png;base64,{}\"/>\n",
                  kLeft, kTop, kTileWidth * kColumns, kTileHeight * kRows, base64(canvas.png()));
  for (std::size_t n = 0; n < kViews.size(); ++n)
    out += text(kLeft + kTileWidth * static_cast<double>(n % kColumns) + 8,
                kTop + kTileHeight * static_cast<double>(n / kColumns) + 14, kViews[n].name, kFaint, "start", 12);
  out += histogram(deviations, scale, chart);
  for (std::size_t n = 0; n < words.size(); ++n)
    out += text(kLeft, lines + kLine * static_cast<double>(n), words[n], kInk, "start", 14);
  return out + "</svg>\n";
}

}  // namespace kerf
