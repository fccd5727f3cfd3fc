#include "geometry/tool/tool_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {
namespace {

using Point = Eigen::Vector2d;

constexpr const char *kCutting = "#e0b040", *kBody = "#d4d9df", *kInk = "#1d2733", *kDimension = "#2a5c8a";
constexpr double kPageWidth = 720, kPageHeight = 900, kTop = 116, kBottom = 70, kFont = 17;  // px

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

std::string mm(double value) {
  std::string text = fmt::format("{:.2f}", value);
  if (text.back() == '0') text.pop_back();
  return text;
}

// The sheet: y grows upwards in mm, the tip's level is y = 0.
class Sheet {
 public:
  /// Fits `width` x `height` mm between the margins; x = 0 comes at `middle` px.
  Sheet(double width, double height, double room, double middle)
      : scale_(std::min(room / width, (kPageHeight - kTop - kBottom) / height)), middle_(middle) {}

  double scale() const { return scale_; }
  double x(double mm) const { return middle_ + scale_ * mm; }
  double y(double mm) const { return kPageHeight - kBottom - scale_ * mm; }
  void moveTo(double px) { middle_ = px; }

  void polygon(const std::vector<Point>& outline, const char* fill, const char* extra = "") {
    std::string points;
    for (const Point& p : outline) points += fmt::format("{:.2f},{:.2f} ", x(p[0]), y(p[1]));
    body_ += fmt::format("<polygon points=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1.6\" {}/>\n", points, fill,
                         kInk, extra);
  }
  void line(double x0, double y0, double x1, double y1, const char* color, const char* extra = "") {  // px
    body_ += fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" {}/>\n", x0, y0,
                         x1, y1, color, extra);
  }
  void text(double px, double py, const std::string& what, const char* color, const char* anchor, double size = kFont) {
    body_ +=
        fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" fill=\"{}\" text-anchor=\"{}\" font-size=\"{:.0f}\">{}</text>\n",
                    px, py, color, anchor, size, escaped(what));
  }
  void centreLine(double low, double high) {
    line(x(0), y(low) + 14, x(0), y(high) - 14, "#b03030", "stroke-width=\"1\" stroke-dasharray=\"14 4 3 4\"");
  }
  /// Between two points of the drawing, `off` px to the right of the right one; both ends get extension lines.
  void tall(double from_x, double low, double high, double column, const std::string& what) {
    for (const double at : {low, high})
      line(x(from_x) + 4, y(at), column + 6, y(at), kDimension, "stroke-width=\"0.8\"");
    arrow(column, y(low), column, y(high));
    text(column + 8, 0.5 * (y(low) + y(high)) + 6, what, kDimension, "start");
  }
  /// A width at a height of the drawing, its line and number to the left.
  void wide(double low_x, double high_x, double at, double column, const std::string& what) {
    const double level = y(at);
    line(column, level, x(high_x) + 16, level, kDimension, "stroke-width=\"0.8\"");
    for (const double end : {x(low_x), x(high_x)}) {
      const double way = end == x(low_x) ? -1 : 1;
      body_ +=
          fmt::format("<path d=\"M{:.2f} {:.2f} l{:.2f} -4 l0 8 z\" fill=\"{}\"/>\n", end, level, 11 * way, kDimension);
    }
    text(column, level - 5, what, kDimension, "start");
  }
  void breakLine(double low, double high, double at) {
    const double left = x(low) - 8, right = x(high) + 8, level = y(at), step = (right - left) / 6;
    std::string path = fmt::format("M{:.2f} {:.2f}", left, level);
    for (int n = 0; n < 6; ++n) path += fmt::format(" l{:.2f} {}", step, n % 2 ? 7 : -7);
    body_ += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"/>\n", path, kInk);
  }
  std::string finished(const Tool& tool, const std::string& second_line) {
    text(24, 38, tool.name, kInk, "start", 25);
    text(24, 62, second_line, kInk, "start", 15);
    if (tool.iso) {
      text(24, 82, "ISO 6360 " + tool.iso6360, kInk, "start", 15);
      text(24, 101, tool.iso->meaning(), kInk, "start", 12);
    }
    double bar = 10;  // mm: the largest of 10, 5, 2, 1 ... that takes less than a quarter of the sheet
    for (const double next : {5.0, 2.0, 1.0, 0.5, 0.2, 0.1})
      if (scale_ * bar > 0.25 * kPageWidth) bar = next;
    const double left = 24, level = kPageHeight - 24, right = left + scale_ * bar;
    line(left, level, right, level, kInk, "stroke-width=\"3\"");
    for (const double end : {left, right}) line(end, level - 6, end, level + 6, kInk, "stroke-width=\"2\"");
    text(right + 10, level + 6, mm(bar) + " mm", kInk, "start");
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
               "{1:.0f}\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\">\n<title>{2}</title>\n"
               "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
               kPageWidth, kPageHeight, escaped(tool.id)) +
           body_ + "</svg>\n";
  }

 private:
  void arrow(double x0, double y0, double x1, double y1) {  // upright, both ends
    line(x0, y0, x1, y1, kDimension, "stroke-width=\"1.2\"");
    for (const double end : {y0, y1}) {
      const double way = end == std::max(y0, y1) ? -1 : 1;
      body_ +=
          fmt::format("<path d=\"M{:.2f} {:.2f} l-4 {:.2f} l8 0 z\" fill=\"{}\"/>\n", x0, end, 11 * way, kDimension);
    }
  }
  double scale_, middle_;
  std::string body_;
};

std::vector<Point> mirrored(const RevolvedProfile& profile) {
  const std::vector<Point> right = profile.polyline(0.002);
  std::vector<Point> outline = right;
  for (auto p = right.rbegin(); p != right.rend(); ++p)
    if ((*p)[0] > 0) outline.push_back({-(*p)[0], (*p)[1]});
  return outline;
}

std::string drawRevolved(const Tool& tool) {
  const RevolvedProfile& head = *tool.head;
  const double L = head.highest(), D = 2 * head.largestRadius();
  double top = L, widest = 0.5 * D;
  for (const RevolvedProfile& body : tool.body_outlines) top = std::max(top, body.highest());
  const double shown = std::min(top, L + std::clamp(0.6 * L, 3.0, 14.0));
  for (const RevolvedProfile& body : tool.body_outlines)
    if (body.lowest() < shown) widest = std::max(widest, body.largestRadius());
  Sheet sheet(2 * widest, shown, 300, 360);
  for (const RevolvedProfile& body : tool.body_outlines)
    if (body.lowest() < shown)
      sheet.polygon(mirrored(body.highest() > shown ? body.clipped(body.lowest(), shown) : body), kBody);
  sheet.polygon(mirrored(*tool.cutting), kCutting);
  if (shown < top) {
    const double radius = tool.body_outlines.back().radiusAt(shown);
    sheet.breakLine(-radius, radius, shown);
  }
  sheet.centreLine(0, shown);

  const double right = sheet.x(widest) + 34;
  sheet.tall(head.radiusAt(L), 0, L, right, mm(L));
  const RevolvedProfile& cut = *tool.cutting;
  if (cut.lowest() > 0 || cut.highest() < L)
    sheet.tall(0.5 * D, cut.lowest(), cut.highest(), right + 70, mm(cut.highest() - cut.lowest()) + " cuts");
  // Diameters: the head where it is widest, its tip and top where they differ, neck and shank.
  const double left = 40;
  double widest_at = 0;
  std::vector<std::pair<double, double>> widths;  // height, diameter
  for (const auto& piece : head.pieces()) {
    for (const Point& p : {piece.from, piece.to})
      if (2 * p[0] > D - 1e-9) widest_at = p[1];
    if (piece.arc_radius > 0 && !piece.is_hollow && std::abs(2 * (piece.center[0] + piece.arc_radius) - D) < 1e-9 &&
        piece.center[1] >= piece.from[1] && piece.center[1] <= piece.to[1])
      widest_at = piece.center[1];
  }
  widths.emplace_back(widest_at, D);
  if (const double end = 2 * head.pieces().front().to[0]; head.pieces().front().to[1] == 0 && end < D - 1e-9)
    widths.emplace_back(0, end);
  if (const double end = 2 * head.pieces().back().from[0]; end < D - 1e-9 && end > 0.01) widths.emplace_back(L, end);
  for (const RevolvedProfile& body : tool.body_outlines)
    for (const auto& piece : body.pieces())
      if (piece.from[0] == piece.to[0] && piece.to[1] > L && piece.from[1] < shown)
        widths.emplace_back(0.5 * (std::max(L, piece.from[1]) + std::min(shown, piece.to[1])), 2 * piece.from[0]);
  std::sort(widths.begin(), widths.end());
  double lowest = -1e9;  // numbers keep their distance from each other
  for (auto& [height, diameter] : widths) {
    const double at = std::max(height, lowest + 24 / sheet.scale());
    lowest = height = at;
  }
  for (const auto& [height, diameter] : widths)
    sheet.wide(-0.5 * diameter, 0.5 * diameter, std::min(height, shown), left, "⌀ " + mm(diameter));
  if (const auto& tip = head.pieces().front(); tip.arc_radius > 0 && tip.center[0] == 0 && tip.arc_radius < 0.5 * D)
    sheet.text(sheet.x(0.7 * tip.arc_radius) + 12, sheet.y(0) + 22, "R " + mm(tip.arc_radius), kDimension, "start");
  const std::string what = tool.kind == ToolKind::kBlade
                               ? fmt::format("{}, disc, kerf {} mm, set {} mm per side", tool.id, mm(tool.kerfWidth()),
                                             mm(tool.set_per_side_mm))
                               : fmt::format("{}, {}, cuts with {}", tool.id, tool.shape,
                                             tool.cuts_side && tool.cuts_end ? "side and end"
                                             : tool.cuts_end                 ? "its end"
                                                                             : "its side");
  return sheet.finished(tool, what);
}

std::string drawBlade(const Tool& tool) {
  const bool is_sagittal = tool.motion == BladeMotion::kSagittal;
  const double W = tool.blade_width_mm, L = tool.blade_length_mm;
  const double low_x = is_sagittal ? -0.5 * tool.sweptWidth() : 0, high_x = is_sagittal ? -low_x : W;
  const double shown = std::min(L, std::max(12.0, 3 * (high_x - low_x)));
  Sheet sheet(high_x - low_x, shown, 230, 0);
  sheet.moveTo(150 - sheet.scale() * low_x);
  const double depth = std::min(tool.edge_depth_mm, 0.6 * tool.tooth_pitch_mm);
  std::vector<Point> blade, teeth;
  if (is_sagittal) {
    const double side = 0.5 * W;
    const auto arc = [&](double x) { return L - std::sqrt(L * L - x * x); };
    const double base = arc(side) + depth;
    const int count = std::max(1, static_cast<int>(std::floor(W / tool.tooth_pitch_mm + 1e-9)));
    teeth.emplace_back(-side, base);
    for (int n = 0; n < count; ++n) {
      const double a = side * (2.0 * n / count - 1), b = side * (2.0 * (n + 1) / count - 1);
      teeth.emplace_back(0.5 * (a + b), arc(0.5 * (a + b)));
      teeth.emplace_back(b, base);
    }
    blade = {{-side, base}, {side, base}, {side, shown}, {-side, shown}};
    std::vector<Point> swept;  // envelope of the teeth, dashed
    for (int n = 0; n <= 40; ++n) {
      const double x = low_x * (1 - n / 20.0);
      swept.emplace_back(x, arc(x));
    }
    const double corner = arc(high_x) + tool.edge_depth_mm;
    swept.emplace_back(high_x, corner);
    swept.emplace_back(low_x, corner);
    sheet.polygon(swept, "#f7ead0", "stroke-dasharray=\"5 4\"");
  } else {
    teeth.emplace_back(depth, 0);
    for (int n = 0; (n + 1) * tool.tooth_pitch_mm <= shown + 1e-9; ++n) {
      teeth.emplace_back(0, (n + 0.3) * tool.tooth_pitch_mm);
      teeth.emplace_back(depth, (n + 1) * tool.tooth_pitch_mm);
    }
    blade = {{depth, 0}, {W, 0}, {W, shown}, {depth, shown}};
  }
  sheet.polygon(blade, kBody);
  sheet.polygon(teeth, kCutting);
  if (is_sagittal) sheet.centreLine(0, shown);
  const double column = sheet.x(high_x) + 30;
  sheet.tall(is_sagittal ? 0.5 * W : W, 0, shown, column,
             shown < L ? fmt::format("{} of {}", mm(shown), mm(L)) : mm(L));
  if (shown < L) sheet.breakLine(low_x, high_x, shown);
  sheet.wide(is_sagittal ? -0.5 * W : 0, is_sagittal ? 0.5 * W : W, 0.75 * shown, 24, "width " + mm(W));
  if (is_sagittal) sheet.wide(low_x, high_x, 0.02 * shown, 24, "sweeps " + mm(tool.sweptWidth()));

  // Cross-section ten times as large: the blade's thickness, the teeth's kerf.
  const double half = 0.5 * tool.thickness_mm, kerf = 0.5 * tool.kerfWidth(), k = 90 / tool.kerfWidth();
  const double middle = 630, edge = kPageHeight - kBottom - 60, back = edge - 260, tooth = edge - 70;
  const auto box = [&](double r, double low, double high, const char* fill) {
    const auto px = [&](double mm_x, double py) {
      return Point((middle + k * mm_x - sheet.x(0)) / sheet.scale(), (sheet.y(0) - py) / sheet.scale());
    };
    sheet.polygon({px(-r, low), px(r, low), px(r, high), px(-r, high)}, fill);
  };
  box(half, tooth, back, kBody);
  box(kerf, edge, tooth, kCutting);
  sheet.text(middle, back - 30, "thickness " + mm(tool.thickness_mm), kDimension, "middle");
  sheet.text(middle, edge + 26, "kerf " + mm(tool.kerfWidth()), kDimension, "middle");
  sheet.text(middle, edge + 46, "section, not to scale", kInk, "middle", 12);
  std::string second = fmt::format("{}, {} blade, ", tool.id, motionName(tool.motion));
  second += is_sagittal ? fmt::format("swing {} degrees, ", mm(tool.swing_deg))
                        : fmt::format("stroke {} mm, ", mm(tool.stroke_mm));
  return sheet.finished(tool, second + fmt::format("teeth every {} mm", mm(tool.tooth_pitch_mm)));
}

// Every triangle from the side, those towards the eye last: the shadow of the solid with its facets.
std::string drawMesh(const Tool& tool) {
  const Mesh& mesh = *tool.mesh;
  Box3 box = bounds(mesh);
  Sheet sheet(box.size()[0], box.max[2], 480, 0);
  sheet.moveTo(60 - sheet.scale() * box.min[0]);
  std::vector<std::size_t> order;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (doubleAreaVector(mesh, t)[1] < 0) order.push_back(t);  // seen from -y
  const auto depth = [&](std::size_t t) { return mesh.corner(t, 0)[1] + mesh.corner(t, 1)[1] + mesh.corner(t, 2)[1]; };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return std::pair(-depth(a), a) < std::pair(-depth(b), b); });
  for (const std::size_t t : order) {
    std::vector<Point> outline;
    double highest = 0;
    for (int k = 0; k < 3; ++k) {
      outline.emplace_back(mesh.corner(t, k)[0], mesh.corner(t, k)[2]);
      highest = std::max(highest, mesh.corner(t, k)[2]);
    }
    sheet.polygon(outline, highest <= tool.cut_below_mm + 1e-9 ? kCutting : kBody, "stroke-opacity=\"0.25\"");
  }
  const double right = sheet.x(box.max[0]) + 24;
  sheet.tall(0, 0, box.max[2], right, mm(box.max[2]));
  sheet.tall(0, 0, tool.cut_below_mm, right + 70, mm(tool.cut_below_mm) + " cuts");
  return sheet.finished(tool, fmt::format("{}, mesh of {} triangles", tool.id, mesh.triangles.size()));
}

}  // namespace

std::string toolDrawing(const Tool& tool) {
  if (tool.mesh) return drawMesh(tool);
  return tool.head ? drawRevolved(tool) : drawBlade(tool);
}

}  // namespace kerf
