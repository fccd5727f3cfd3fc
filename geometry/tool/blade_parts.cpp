#include "geometry/tool/blade_parts.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf::internal {

void readToothedBlade(TomlTable& top, Tool& tool) {
  tool.blade_width_mm = top.number("width", 0.2, 50);
  tool.blade_length_mm = top.number("length", 1, 150);
  tool.tooth_pitch_mm = top.number("tooth_pitch", 0.1, 10);
}

void readEdgeDepth(TomlTable& top, Tool& tool) { tool.edge_depth_mm = top.numberOr("edge_depth", 0.5, 0.05, 10); }

double gulletDepth(const Tool& tool) { return std::min(tool.edge_depth_mm, 0.6 * tool.tooth_pitch_mm); }

std::string finishedBladeSheet(Sheet& sheet, const Tool& tool, const std::string& numbers) {
  const double half = 0.5 * tool.thickness_mm, kerf = 0.5 * tool.kerfWidth(), k = 90 / tool.kerfWidth();
  const double middle = 630, edge = Sheet::kPageHeight - Sheet::kBottom - 60, back = edge - 260, tooth = edge - 70;
  const auto box = [&](double r, double low, double high, const char* fill) {
    const auto px = [&](double mm_x, double py) {
      return Sheet::Point((middle + k * mm_x - sheet.x(0)) / sheet.scale(), (sheet.y(0) - py) / sheet.scale());
    };
    sheet.polygon({px(-r, low), px(r, low), px(r, high), px(-r, high)}, fill);
  };
  box(half, tooth, back, Sheet::kBody);
  box(kerf, edge, tooth, Sheet::kCutting);
  sheet.text(middle, back - 30, "thickness " + mm(tool.thickness_mm), Sheet::kDimension, "middle");
  sheet.text(middle, edge + 26, "kerf " + mm(tool.kerfWidth()), Sheet::kDimension, "middle");
  sheet.text(middle, edge + 46, "section, not to scale", Sheet::kInk, "middle", 12);

  return sheet.finished(tool, fmt::format("{}, {} blade, {}, teeth every {} mm", tool.id, tool.motion->name, numbers,
                                          mm(tool.tooth_pitch_mm)));
}

}  // namespace kerf::internal
