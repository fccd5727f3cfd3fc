#include "geometry/tool/drawing_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/base/xml_text.h"

namespace kerf::internal {
namespace {

using SheetPoint = Sheet::Point;

std::vector<SheetPoint> mirrored(const RevolvedProfile& profile) {
  const std::vector<SheetPoint> right = profile.polyline(0.002);
  std::vector<SheetPoint> outline = right;
  for (auto p = right.rbegin(); p != right.rend(); ++p)
    if ((*p)[0] > 0) outline.push_back({-(*p)[0], (*p)[1]});
  return outline;
}

using Width = std::pair<double, double>;  // height, diameter

double heightOfWidest(const RevolvedProfile& head) {
  const double D = 2 * head.largestRadius();
  double widest_at = 0;
  for (const auto& piece : head.pieces()) {
    for (const SheetPoint& p : {piece.from, piece.to})
      if (2 * p[0] > D - 1e-9) widest_at = p[1];
    if (piece.arc_radius > 0 && !piece.is_hollow && std::abs(2 * (piece.center[0] + piece.arc_radius) - D) < 1e-9 &&
        piece.center[1] >= piece.from[1] && piece.center[1] <= piece.to[1])
      widest_at = piece.center[1];
  }
  return widest_at;
}

// Diameters worth stating: the head where it is widest, its tip and top where they differ, neck and shank. By height.
std::vector<Width> statedWidths(const Tool& tool, double shown) {
  const RevolvedProfile& head = *tool.head;
  const double L = head.highest(), D = 2 * head.largestRadius();
  std::vector<Width> widths{{heightOfWidest(head), D}};
  if (const double end = 2 * head.pieces().front().to[0]; head.pieces().front().to[1] == 0 && end < D - 1e-9)
    widths.emplace_back(0, end);
  if (const double end = 2 * head.pieces().back().from[0]; end < D - 1e-9 && end > 0.01) widths.emplace_back(L, end);
  for (const RevolvedProfile& body : tool.body_outlines)
    for (const auto& piece : body.pieces())
      if (piece.from[0] == piece.to[0] && piece.to[1] > L && piece.from[1] < shown)
        widths.emplace_back(0.5 * (std::max(L, piece.from[1]) + std::min(shown, piece.to[1])), 2 * piece.from[0]);
  std::sort(widths.begin(), widths.end());
  return widths;
}

// Lifts numbers that would overlap.
void keepApart(std::vector<Width>& widths, double distance) {
  double lowest = -1e9;
  for (auto& [height, diameter] : widths) {
    const double at = std::max(height, lowest + distance);
    lowest = height = at;
  }
}

}  // namespace

std::string mm(double value) {
  std::string text = fmt::format("{:.2f}", value);
  if (text.back() == '0') text.pop_back();
  return text;
}

Sheet::Sheet(double width, double height, double most_width, double middle)
    : scale_(std::min(most_width / width, (kPageHeight - kTop - kBottom) / height)), middle_(middle) {}

void Sheet::polygon(const std::vector<SheetPoint>& outline, const char* fill, const char* extra) {
  std::string points;
  for (const SheetPoint& p : outline) points += fmt::format("{:.2f},{:.2f} ", x(p[0]), y(p[1]));
  body_ += fmt::format("<polygon points=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1.6\" {}/>\n", points, fill,
                       kInk, extra);
}

void Sheet::line(double x0, double y0, double x1, double y1, const char* color, const char* extra) {  // px
  body_ += fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" {}/>\n", x0, y0, x1,
                       y1, color, extra);
}

void Sheet::text(double px, double py, const std::string& what, const char* color, const char* anchor, double size) {
  body_ +=
      fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" fill=\"{}\" text-anchor=\"{}\" font-size=\"{:.0f}\">{}</text>\n", px,
                  py, color, anchor, size, xmlText(what));
}

void Sheet::centreLine(double low, double high) {
  line(x(0), y(low) + 14, x(0), y(high) - 14, "#b03030", "stroke-width=\"1\" stroke-dasharray=\"14 4 3 4\"");
}

void Sheet::tall(double from_x, double low, double high, double column, const std::string& what) {
  for (const double at : {low, high}) line(x(from_x) + 4, y(at), column + 6, y(at), kDimension, "stroke-width=\"0.8\"");
  arrow(column, y(low), column, y(high));
  text(column + 8, 0.5 * (y(low) + y(high)) + 6, what, kDimension, "start");
}

void Sheet::wide(double low_x, double high_x, double at, double column, const std::string& what) {
  const double level = y(at);
  line(column, level, x(high_x) + 16, level, kDimension, "stroke-width=\"0.8\"");
  for (const double end : {x(low_x), x(high_x)}) {
    const double way = end == x(low_x) ? -1 : 1;
    body_ +=
        fmt::format("<path d=\"M{:.2f} {:.2f} l{:.2f} -4 l0 8 z\" fill=\"{}\"/>\n", end, level, 11 * way, kDimension);
  }
  text(column, level - 5, what, kDimension, "start");
}

void Sheet::breakLine(double low, double high, double at) {
  const double left = x(low) - 8, right = x(high) + 8, level = y(at), step = (right - left) / 6;
  std::string path = fmt::format("M{:.2f} {:.2f}", left, level);
  for (int n = 0; n < 6; ++n) path += fmt::format(" l{:.2f} {}", step, n % 2 ? 7 : -7);
  body_ += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"/>\n", path, kInk);
}

std::string Sheet::finished(const Tool& tool, const std::string& second_line) {
  text(24, 38, tool.name, kInk, "start", 25);
  text(24, 62, second_line, kInk, "start", 15);
  if (tool.iso) {
    text(24, 82, "ISO 6360 " + tool.iso6360, kInk, "start", 15);
    text(24, 101, tool.iso->meaning(), kInk, "start", 12);
  }
  scaleBar();
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
             "{1:.0f}\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\">\n<title>{2}</title>\n"
             "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
             kPageWidth, kPageHeight, xmlText(tool.id)) +
         body_ + "</svg>\n";
}

// The largest of 10, 5, 2, 1 ... mm that takes less than a quarter of the sheet.
void Sheet::scaleBar() {
  double bar = 10;  // mm
  for (const double next : {5.0, 2.0, 1.0, 0.5, 0.2, 0.1})
    if (scale_ * bar > 0.25 * kPageWidth) bar = next;
  const double left = 24, level = kPageHeight - 24, right = left + scale_ * bar;
  line(left, level, right, level, kInk, "stroke-width=\"3\"");
  for (const double end : {left, right}) line(end, level - 6, end, level + 6, kInk, "stroke-width=\"2\"");
  text(right + 10, level + 6, mm(bar) + " mm", kInk, "start");
}

void Sheet::arrow(double x0, double y0, double x1, double y1) {
  line(x0, y0, x1, y1, kDimension, "stroke-width=\"1.2\"");
  for (const double end : {y0, y1}) {
    const double way = end == std::max(y0, y1) ? -1 : 1;
    body_ += fmt::format("<path d=\"M{:.2f} {:.2f} l-4 {:.2f} l8 0 z\" fill=\"{}\"/>\n", x0, end, 11 * way, kDimension);
  }
}

std::string drawRevolved(const Tool& tool, const std::string& second_line) {
  const RevolvedProfile &head = *tool.head, &cut = *tool.cutting;
  const double L = head.highest(), D = 2 * head.largestRadius();

  // Neck and shank are cut short.
  double top = L, widest = 0.5 * D;
  for (const RevolvedProfile& body : tool.body_outlines) top = std::max(top, body.highest());
  const double shown = std::min(top, L + std::clamp(0.6 * L, 3.0, 14.0));
  for (const RevolvedProfile& body : tool.body_outlines)
    if (body.lowest() < shown) widest = std::max(widest, body.largestRadius());

  Sheet sheet(2 * widest, shown, 300, 360);
  for (const RevolvedProfile& body : tool.body_outlines)
    if (body.lowest() < shown)
      sheet.polygon(mirrored(body.highest() > shown ? body.clipped(body.lowest(), shown) : body), Sheet::kBody);
  sheet.polygon(mirrored(cut), Sheet::kCutting);
  if (shown < top) {
    const double radius = tool.body_outlines.back().radiusAt(shown);
    sheet.breakLine(-radius, radius, shown);
  }
  sheet.centreLine(0, shown);

  // Heights to the right, diameters to the left.
  const double right = sheet.x(widest) + 34, left = 40;
  sheet.tall(head.radiusAt(L), 0, L, right, mm(L));
  if (cut.lowest() > 0 || cut.highest() < L)
    sheet.tall(0.5 * D, cut.lowest(), cut.highest(), right + 70, mm(cut.highest() - cut.lowest()) + " cuts");
  std::vector<Width> widths = statedWidths(tool, shown);
  keepApart(widths, 24 / sheet.scale());
  for (const auto& [height, diameter] : widths)
    sheet.wide(-0.5 * diameter, 0.5 * diameter, std::min(height, shown), left, "⌀ " + mm(diameter));

  if (const auto& tip = head.pieces().front(); tip.arc_radius > 0 && tip.center[0] == 0 && tip.arc_radius < 0.5 * D)
    sheet.text(sheet.x(0.7 * tip.arc_radius) + 12, sheet.y(0) + 22, "R " + mm(tip.arc_radius), Sheet::kDimension,
               "start");
  return sheet.finished(tool, second_line);
}

}  // namespace kerf::internal
