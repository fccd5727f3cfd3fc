#include "geometry/tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace kerf {
namespace {

using Piece = RevolvedProfile::Piece;

// Integral of r(z)^2 over [a, b] inside one piece.
double squareIntegral(const Piece& piece, double a, double b) {
  if (piece.arc_radius > 0) {
    const double c = piece.center[0], q = piece.arc_radius * piece.arc_radius;
    const auto primitive = [&](double z) {  // of (c + sqrt(q - u^2))^2, u = z - centre
      const double u = std::clamp(z - piece.center[1], -piece.arc_radius, piece.arc_radius);
      const double root = std::sqrt(std::max(0.0, q - u * u));
      return c * c * u + c * (u * root + q * std::asin(u / piece.arc_radius)) + q * u - u * u * u / 3;
    };
    return primitive(b) - primitive(a);
  }
  const double slope = (piece.to[0] - piece.from[0]) / (piece.to[1] - piece.from[1]);
  const double ra = piece.from[0] + slope * (a - piece.from[1]), rb = piece.from[0] + slope * (b - piece.from[1]);
  return (b - a) * (ra * ra + ra * rb + rb * rb) / 3;
}

// Height in the rising part of a piece where it gets as wide as r: from there on it cuts wider than what came before.
double heightOfRadius(const Piece& piece, double r) {
  if (piece.arc_radius > 0) {
    const double dr = r - piece.center[0];
    if (dr <= 0) return piece.from[1];
    return piece.center[1] - std::sqrt(std::max(0.0, piece.arc_radius * piece.arc_radius - dr * dr));
  }
  return piece.from[1] + (r - piece.from[0]) / (piece.to[0] - piece.from[0]) * (piece.to[1] - piece.from[1]);
}

double revolvedPlunge(const RevolvedProfile& head, double depth) {
  double sum = 0, widest = 0, z = head.lowest();
  const double top = head.lowest() + depth;
  for (const Piece& piece : head.pieces()) {
    if (piece.from[1] >= top) break;
    if (piece.to[1] <= piece.from[1]) {  // a step
      widest = std::max({widest, piece.from[0], piece.to[0]});
      continue;
    }
    const double end = std::min(piece.to[1], top);
    // The rising part [z, peak], then the falling one, where the widest so far has passed already.
    const bool is_arc = piece.arc_radius > 0;
    const double peak = is_arc                        ? std::clamp(piece.center[1], piece.from[1], piece.to[1])
                        : piece.to[0] > piece.from[0] ? piece.to[1]
                                                      : piece.from[1];
    const double peak_radius =
        is_arc ? piece.center[0] + std::sqrt(std::max(0.0, piece.arc_radius * piece.arc_radius -
                                                               (peak - piece.center[1]) * (peak - piece.center[1])))
               : std::max(piece.from[0], piece.to[0]);
    if (peak > piece.from[1] && peak_radius > widest) {
      const double meets = std::clamp(heightOfRadius(piece, widest), z, std::min(peak, end));
      const double rises_to = std::min(peak, end);
      sum += widest * widest * (meets - z) + squareIntegral(piece, meets, rises_to);
      z = rises_to;
    }
    if (end >= peak) widest = std::max(widest, peak_radius);
    sum += widest * widest * (end - z);
    z = end;
  }
  return std::numbers::pi * (sum + widest * widest * (top - z));
}

}  // namespace

double plungeVolume(const Tool& tool, double depth_mm) {
  if (!(depth_mm > 0)) return 0;
  if (tool.kind == ToolKind::kBlade) return tool.kerfWidth() * (tool.blade_length_mm + tool.stroke_mm) * depth_mm;
  return revolvedPlunge(*tool.head, depth_mm);
}

std::string describe(const Tool& tool) {
  std::string text = fmt::format("{}: {}\n", tool.id, tool.name);
  if (!tool.description.empty()) text += fmt::format("  {}\n", tool.description);
  if (tool.kind == ToolKind::kBur) {
    text += fmt::format("  bur, head {:.3g} mm wide, {:.3g} mm long\n", tool.head_diameter_mm, tool.head_length_mm);
    if (!tool.iso6360.empty()) text += fmt::format("  ISO 6360 {}\n", tool.iso6360);
  } else {
    text += fmt::format("  blade {:.3g} mm thick, set {:.3g} mm per side: kerf {:.3g} mm\n", tool.thickness_mm,
                        tool.set_per_side_mm, tool.kerfWidth());
    text +=
        fmt::format("  {:.3g} mm long, {:.3g} mm wide, stroke {:.3g} mm, teeth every {:.3g} mm, {:.3g} mm deep edge\n",
                    tool.blade_length_mm, tool.blade_width_mm, tool.stroke_mm, tool.tooth_pitch_mm, tool.edge_depth_mm);
  }
  const Vec3d cut = tool.cut->bounds().size();
  text += fmt::format("  cutting part {:.2f} x {:.2f} x {:.2f} mm", cut[0], cut[1], cut[2]);
  if (tool.body) {
    const Box3 body = tool.body->bounds();
    text += fmt::format("; body up to {:.2f} mm above the tip", body.max[2]);
  }
  return text;
}

std::string toJson(const Tool& tool) {
  nlohmann::json j{{"id", tool.id},
                   {"name", tool.name},
                   {"description", tool.description},
                   {"kind", tool.kind == ToolKind::kBur ? "bur" : "blade"}};
  if (tool.kind == ToolKind::kBur) {
    j["iso6360"] = tool.iso6360;
    j["head_diameter_mm"] = tool.head_diameter_mm;
    j["head_length_mm"] = tool.head_length_mm;
  } else {
    j["thickness_mm"] = tool.thickness_mm;
    j["set_per_side_mm"] = tool.set_per_side_mm;
    j["kerf_mm"] = tool.kerfWidth();
    j["length_mm"] = tool.blade_length_mm;
    j["width_mm"] = tool.blade_width_mm;
    j["stroke_mm"] = tool.stroke_mm;
    j["tooth_pitch_mm"] = tool.tooth_pitch_mm;
    j["edge_depth_mm"] = tool.edge_depth_mm;
  }
  const auto box = [](const Box3& b) {
    return nlohmann::json{{"min", {b.min[0], b.min[1], b.min[2]}}, {"max", {b.max[0], b.max[1], b.max[2]}}};
  };
  j["cut_bounds_mm"] = box(tool.cut->bounds());
  if (tool.body) j["body_bounds_mm"] = box(tool.body->bounds());
  const Vec3d& d = tool.plunge_direction;
  j["plunge_direction"] = {d[0], d[1], d[2]};
  return j.dump(2);
}

}  // namespace kerf
