#include "geometry/tool/tool_doubt.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "geometry/tool/tool_ways.h"

namespace kerf {
namespace {

// A mesh tool turns about its axis. If it is long in another direction, or lies beside its axis, the axis is probably
// wrong.
std::string doubtAboutAxis(const Mesh& mesh) {
  constexpr double kMostOff = 0.25;
  const SurfaceSpread spread = spreadOf(mesh);
  const double degrees = std::acos(std::min(1.0, std::abs(spread.longest[2]))) * 180 / std::numbers::pi;
  if (spread.isSlender() && degrees > kMostDegreesOff)
    return fmt::format(
        "the mesh is longest {:.0f} degrees off its axis: check that `axis` points from the tip to the shank", degrees);
  const double off = spread.middle.head<2>().norm();
  if (off > kMostOff * std::max(spread.extents[1], 0.1))
    return fmt::format("the middle of the mesh is {:.2f} mm off its axis: check that `tip` is on the axis", off);
  return {};
}

constexpr double kLeastFilled = 0.4;  // of its solid of revolution, by the mesh

std::string doubtAboutTurning(const Tool& tool) {
  if (tool.unturned_mm3 >= kLeastFilled * tool.turned_mm3) return {};
  return fmt::format(
      "turned about its axis, the cutting part fills {:.1f} times its mesh: check `axis` and `tip`; describe a tool "
      "that does not turn as a blade",
      tool.turned_mm3 / tool.unturned_mm3);
}

// A bur is round about its axis, also in a contra-angle.
bool isBurInHandpiece(const Tool& tool) {
  return !tool.body_turns && tool.unturned_mm3 >= kLeastFilled * tool.turned_mm3;
}

// Inches read as mm, or mm read as inches: no bur, but a length that a tool may have.
std::string doubtAboutUnit(const Tool& tool) {
  constexpr double kShort = 5, kLong = 150;  // mm
  const double longest = bounds(*tool.mesh).size().maxCoeff();
  if (longest >= kShort && longest <= kLong) return {};
  const std::string units = unitsOfABur(longest / tool.mm_per_unit);
  return units.empty() ? "" : fmt::format("the mesh is {:.3g} mm long: {}", longest, units);
}

// The size in a name or id, as "016" in 856-016: 1.6. 0: none.
double sizeInName(const std::string& name) {
  const auto isDigit = [&](std::size_t at) { return at < name.size() && name[at] >= '0' && name[at] <= '9'; };
  double size = 0;
  for (std::size_t at = 0; at < name.size(); ++at) {
    std::size_t end = at;
    while (isDigit(end)) ++end;
    if (end == at + 3 && name[at] == '0') size = 0.1 * (10 * (name[at + 1] - '0') + (name[at + 2] - '0'));
    at = std::max(at, end);
  }
  return size;
}

// Radii instead of diameters.
std::string doubtAboutRadii(const Tool& tool) {
  constexpr double kRounding = 0.051;  // mm: a size counts tenths
  const double in_id = sizeInName(tool.id), size = in_id > 0 ? in_id : sizeInName(tool.name);
  const double head = tool.head_diameter_mm;
  if (const bool is_half = std::abs(2 * head - size) < kRounding;
      size > 0.2 && (is_half || std::abs(0.5 * head - size) < kRounding))
    return fmt::format("the head is {:.3g} mm wide, but by its {} {:.1f} mm, {}", head, in_id > 0 ? "id" : "name", size,
                       is_half ? "twice as much: write diameters, not radii" : "half as much: check head_diameter");
  if (tool.shape != "profile") return {};
  for (const RevolvedProfile::Piece& piece : tool.head->pieces()) {
    const Eigen::Vector2d way = (piece.to - piece.from).cwiseAbs();
    constexpr double kSame = 0.01;
    if (piece.arc_radius > 0 && std::abs(way[0] - way[1]) < kSame * way[1] &&
        std::abs(piece.arc_radius - 2 * way[1]) < kSame * way[1])
      return fmt::format(
          "the arc of {:.3g} mm rounds an edge of {:.3g} mm: write the radius of an arc, not its diameter",
          piece.arc_radius, way[1]);
  }
  return {};
}

std::string doubtAboutShank(const Tool& tool) {
  constexpr std::array<double, 3> kShanks = {1.6, 2.35, 3.0};  // mm, ISO 1797
  constexpr double kRounding = 0.0501;
  const double shank = tool.shank_diameter_mm;
  if (shank <= 0) return {};
  if (shank < tool.neck_diameter_mm)
    return fmt::format("the shank, {:.3g} mm, is thinner than the neck, {:.3g} mm", shank, tool.neck_diameter_mm);
  if (std::any_of(kShanks.begin(), kShanks.end(), [&](double s) { return std::abs(s - shank) <= kRounding; }))
    return {};
  return fmt::format("a shank of {:.3g} mm fits no handpiece: FG is 1.6, RA and HP are 2.35, others 3.0 mm", shank);
}

std::string doubtAboutWidth(const Tool& tool) {
  constexpr double kWideHead = 8;  // mm; the rack's widest has 4
  if (tool.head_diameter_mm < kWideHead) return {};
  return fmt::format(
      "a head {:.3g} mm wide is unusual: ISO 6360 counts in tenths of a millimetre, so that 016 is 1.6 mm",
      tool.head_diameter_mm);
}

}  // namespace

std::string doubtAbout(const Tool& tool) {
  std::vector<std::string> doubts;
  if (tool.mesh)
    doubts = {isBurInHandpiece(tool) ? "" : doubtAboutAxis(*tool.mesh), doubtAboutUnit(tool), doubtAboutTurning(tool)};
  else if (tool.kind == ToolKind::kBur)
    doubts = {doubtAboutWidth(tool), doubtAboutRadii(tool), doubtAboutShank(tool)};
  else
    doubts = {doubtAboutShank(tool)};
  std::erase(doubts, "");
  return fmt::format("{}", fmt::join(doubts, "; "));
}

std::string unitsOfABur(double length) {
  constexpr double kShortest = 10 - 1e-6, kLongest = 60 + 1e-6;  // mm, and rounding
  constexpr std::pair<double, const char*> kUnits[] = {{1, "mm"}, {10, "cm"}, {25.4, "inches"}, {1000, "metres"}};
  std::string out;
  for (const auto& [factor, name] : kUnits)
    if (const double made = factor * length; made >= kShortest && made <= kLongest)
      out +=
          fmt::format("{}mm_per_unit = {} ({}) makes it {:.3g} mm long", out.empty() ? "" : ", ", factor, name, made);
  return out;
}

}  // namespace kerf
