#include "geometry/tool/tool.h"

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
    const double c = piece.center[0], q = piece.arc_radius * piece.arc_radius, side = piece.is_hollow ? -1 : 1;
    const auto primitive = [&](double z) {  // of (c +- sqrt(q - u^2))^2, u = z - centre
      const double u = std::clamp(z - piece.center[1], -piece.arc_radius, piece.arc_radius);
      const double root = std::sqrt(std::max(0.0, q - u * u));
      return c * c * u + side * c * (u * root + q * std::asin(u / piece.arc_radius)) + q * u - u * u * u / 3;
    };
    return primitive(b) - primitive(a);
  }
  const double ra = piece.radiusAt(a), rb = piece.radiusAt(b);
  return (b - a) * (ra * ra + ra * rb + rb * rb) / 3;
}

// The part of a piece in which it gets wider upwards, as heights; empty if first >= second.
std::pair<double, double> risingPart(const Piece& piece) {
  if (piece.arc_radius > 0) {
    const double middle = std::clamp(piece.center[1], piece.from[1], piece.to[1]);
    return piece.is_hollow ? std::pair(middle, piece.to[1]) : std::pair(piece.from[1], middle);
  }
  return {piece.from[1], piece.to[0] > piece.from[0] ? piece.to[1] : piece.from[1]};
}

// Height in the rising part of a piece where it gets as wide as r: from there on it cuts wider than what came before.
double heightOfRadius(const Piece& piece, double r) {
  if (piece.arc_radius > 0) {
    const double dr = r - piece.center[0], q = piece.arc_radius * piece.arc_radius;
    const double off = std::sqrt(std::max(0.0, q - dr * dr));
    if (piece.is_hollow) return dr <= -piece.arc_radius ? piece.center[1] : piece.center[1] + off;
    return dr <= 0 ? piece.from[1] : piece.center[1] - off;
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
    widest = std::max(widest, piece.from[0]);
    const auto [rise, peak] = risingPart(piece);
    const double rises_to = std::min(peak, end);
    if (rises_to > rise && piece.radiusAt(rises_to) > widest) {
      const double meets = std::clamp(heightOfRadius(piece, widest), rise, rises_to);
      sum += widest * widest * (meets - z) + squareIntegral(piece, meets, rises_to);
      widest = piece.radiusAt(rises_to);
      z = rises_to;
    }
    sum += widest * widest * (end - z);
    z = end;
  }
  return std::numbers::pi * (sum + widest * widest * (top - z));
}

// What a circle of radius r cuts out of a half-plane `offset` away from its centre when it is pushed in along the
// normal: 2 x integral over 0 <= x <= limit of max(0, sqrt(r^2 - x^2) - offset).
double pushedCircle(double r, double offset, double limit) {
  if (offset >= r) return 0;
  const double end = std::min(limit, offset > 0 ? std::sqrt(r * r - offset * offset) : r);
  return end * std::sqrt(std::max(0.0, r * r - end * end)) + r * r * std::asin(std::min(1.0, end / r)) -
         2 * offset * end;
}

// Integral of f over [a, b], Gauss-Legendre in five points, halved until it holds still.
template <class F>
double integral(const F& f, double a, double b, double accuracy, int depth = 0) {
  static constexpr double kAt[] = {0, 0.5384693101056831, 0.9061798459386640};
  static constexpr double kWeight[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const auto rule = [&](double low, double high) {
    const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    double sum = kWeight[0] * f(middle);
    for (int n = 1; n < 3; ++n) sum += kWeight[n] * (f(middle - kAt[n] * half) + f(middle + kAt[n] * half));
    return sum * half;
  };
  const double middle = 0.5 * (a + b), whole = rule(a, b), halves = rule(a, middle) + rule(middle, b);
  if (std::abs(whole - halves) <= accuracy || depth > 40) return halves;
  return integral(f, a, middle, 0.5 * accuracy, depth + 1) + integral(f, middle, b, 0.5 * accuracy, depth + 1);
}

double sidewaysPlunge(const RevolvedProfile& head, double depth) {
  const double offset = head.largestRadius() - depth;  // of the half-plane, seen from the axis when it is all in
  const double accuracy = 1e-11 * depth * head.largestRadius() * (head.highest() - head.lowest());
  double sum = 0;
  for (const Piece& piece : head.pieces())
    if (piece.to[1] > piece.from[1])
      sum += integral(
          [&](double z) {
            const double r = piece.radiusAt(z);
            return pushedCircle(r, offset, r);
          },
          piece.from[1], piece.to[1], accuracy);
  return sum;
}

// Columns of a plunge along -z: how far the lowest triangle of the part below `top` has gone in, by a picture of
// heights from below.
double meshPlunge(const Mesh& mesh, double top, double depth) {
  constexpr int kCells = 1200;
  Box3 part;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec3d a = mesh.corner(t, k), b = mesh.corner(t, (k + 1) % 3);
      if (a[2] <= top) part.add(a);
      if ((a[2] < top) != (b[2] < top)) part.add(Vec3d(a + (top - a[2]) / (b[2] - a[2]) * (b - a)));
    }
  if (part.isEmpty()) return 0;
  const double cell = std::max(part.size()[0], part.size()[1]) / kCells;
  if (!(cell > 0)) return 0;
  std::vector<double> lowest(static_cast<std::size_t>(kCells) * kCells, std::numeric_limits<double>::infinity());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d a = mesh.corner(t, 0), u = mesh.corner(t, 1) - a, v = mesh.corner(t, 2) - a;
    const double twice = u[0] * v[1] - u[1] * v[0];
    if (twice >= 0 || std::min({a[2], a[2] + u[2], a[2] + v[2]}) > top) continue;  // seen from below it is turned away
    const auto range = [&](int axis) {
      const double low = a[axis] + std::min({0.0, u[axis], v[axis]}),
                   high = a[axis] + std::max({0.0, u[axis], v[axis]});
      return std::pair(std::clamp(static_cast<int>((low - part.min[axis]) / cell), 0, kCells),
                       std::clamp(static_cast<int>((high - part.min[axis]) / cell) + 1, 0, kCells));
    };
    const auto [i0, i1] = range(0);
    const auto [j0, j1] = range(1);
    for (int i = i0; i < i1; ++i)
      for (int j = j0; j < j1; ++j) {
        const double x = part.min[0] + (i + 0.5) * cell - a[0], y = part.min[1] + (j + 0.5) * cell - a[1];
        const double s = (x * v[1] - y * v[0]) / twice, r = (u[0] * y - u[1] * x) / twice;
        if (s < 0 || r < 0 || s + r > 1) continue;
        double& z = lowest[static_cast<std::size_t>(i) * kCells + static_cast<std::size_t>(j)];
        z = std::min(z, a[2] + s * u[2] + r * v[2]);
      }
  }
  double sum = 0;
  for (const double z : lowest)
    if (z < top) sum += std::max(0.0, depth - z);
  return sum * cell * cell;
}

}  // namespace

const char* kindName(ToolKind kind) {
  switch (kind) {
    case ToolKind::kBur:
      return "bur";
    case ToolKind::kBlade:
      return "blade";
    case ToolKind::kMesh:
      return "mesh";
  }
  return "";
}

const char* motionName(BladeMotion motion) {
  switch (motion) {
    case BladeMotion::kReciprocating:
      return "reciprocating";
    case BladeMotion::kPiezo:
      return "piezo";
    case BladeMotion::kSagittal:
      return "sagittal";
    case BladeMotion::kSpin:
      return "spin";
  }
  return "";
}

double Tool::sweptWidth() const {
  return blade_width_mm + 2 * blade_length_mm * std::sin(0.5 * swing_deg * std::numbers::pi / 180);
}

double Tool::finest() const {
  if (kind == ToolKind::kBlade) return kerfWidth();
  if (kind == ToolKind::kMesh) return cut->bounds().size().minCoeff();
  return std::min(head_diameter_mm, cutting->highest() - cutting->lowest());
}

double plungeVolume(const Tool& tool, double depth_mm, double window_mm) {
  if (!(depth_mm > 0)) return 0;
  if (tool.kind == ToolKind::kMesh) return meshPlunge(*tool.mesh, tool.cut_below_mm, depth_mm);
  if (tool.kind == ToolKind::kBur)
    return tool.cuts_end ? revolvedPlunge(*tool.cutting, depth_mm) : sidewaysPlunge(*tool.cutting, depth_mm);
  switch (tool.motion) {
    case BladeMotion::kReciprocating:
    case BladeMotion::kPiezo:
      return tool.kerfWidth() * std::min(window_mm, tool.blade_length_mm + tool.stroke_mm) * depth_mm;
    case BladeMotion::kSagittal:
      return tool.kerfWidth() * pushedCircle(tool.blade_length_mm, tool.blade_length_mm - depth_mm,
                                             0.5 * std::min(window_mm, tool.sweptWidth()));
    case BladeMotion::kSpin:
      break;
  }
  const double radius = 0.5 * tool.head_diameter_mm;
  return tool.kerfWidth() * pushedCircle(radius, radius - depth_mm, 0.5 * std::min(window_mm, tool.head_diameter_mm));
}

std::string describe(const Tool& tool) {
  std::string text = fmt::format("{}: {}\n", tool.id, tool.name);
  if (!tool.description.empty()) text += fmt::format("  {}\n", tool.description);
  if (tool.kind == ToolKind::kBur) {
    text += fmt::format("  bur, {}, head {:.3g} mm wide, {:.3g} mm long", tool.shape, tool.head_diameter_mm,
                        tool.head_length_mm);
    if (!tool.cuts_side || !tool.cuts_end)
      text += fmt::format("; only its {} cuts, from {:.3g} to {:.3g} mm above the tip", tool.cuts_end ? "end" : "side",
                          tool.cutting->lowest(), tool.cutting->highest());
    text += "\n";
    if (tool.iso) text += fmt::format("  ISO 6360 {}: {}\n", tool.iso6360, tool.iso->meaning());
  } else if (tool.kind == ToolKind::kMesh) {
    text += fmt::format("  mesh of {} triangles, cuts up to {:.3g} mm above its tip\n", tool.mesh->triangles.size(),
                        tool.cut_below_mm);
  } else {
    text += fmt::format("  {} blade {:.3g} mm thick, set {:.3g} mm per side: kerf {:.3g} mm\n", motionName(tool.motion),
                        tool.thickness_mm, tool.set_per_side_mm, tool.kerfWidth());
    if (tool.motion == BladeMotion::kSpin) {
      text += fmt::format("  disc of {:.3g} mm\n", tool.head_diameter_mm);
    } else {
      text += fmt::format("  {:.3g} mm long, {:.3g} mm wide, ", tool.blade_length_mm, tool.blade_width_mm);
      text += tool.motion == BladeMotion::kSagittal
                  ? fmt::format("swings by {:.3g} degrees: {:.3g} mm at the tip", tool.swing_deg, tool.sweptWidth())
                  : fmt::format("stroke {:.3g} mm", tool.stroke_mm);
      text += fmt::format(", teeth every {:.3g} mm, {:.3g} mm deep edge\n", tool.tooth_pitch_mm, tool.edge_depth_mm);
    }
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
  nlohmann::json j{
      {"id", tool.id}, {"name", tool.name}, {"description", tool.description}, {"kind", kindName(tool.kind)}};
  if (tool.kind == ToolKind::kBur) {
    j["shape"] = tool.shape;
    j["iso6360"] = tool.iso6360;
    if (tool.iso)
      j["iso6360_parts"] = {{"material", tool.iso->material},
                            {"shank", tool.iso->shank},
                            {"shape", tool.iso->shape},
                            {"execution", tool.iso->execution},
                            {"head_diameter_mm", tool.iso->diameterMm()},
                            {"meaning", tool.iso->meaning()}};
    j["head_diameter_mm"] = tool.head_diameter_mm;
    j["head_length_mm"] = tool.head_length_mm;
    j["cuts"] = nlohmann::json::array();
    if (tool.cuts_side) j["cuts"].push_back("side");
    if (tool.cuts_end) j["cuts"].push_back("end");
    j["cuts_from_mm"] = tool.cutting->lowest();
    j["cuts_to_mm"] = tool.cutting->highest();
  } else if (tool.kind == ToolKind::kMesh) {
    j["mesh_file"] = tool.mesh_file.string();
    j["triangles"] = tool.mesh->triangles.size();
    j["cuts_to_mm"] = tool.cut_below_mm;
  } else {
    j["motion"] = motionName(tool.motion);
    j["thickness_mm"] = tool.thickness_mm;
    j["set_per_side_mm"] = tool.set_per_side_mm;
    j["kerf_mm"] = tool.kerfWidth();
    if (tool.motion == BladeMotion::kSpin) {
      j["diameter_mm"] = tool.head_diameter_mm;
    } else {
      j["length_mm"] = tool.blade_length_mm;
      j["width_mm"] = tool.blade_width_mm;
      j["tooth_pitch_mm"] = tool.tooth_pitch_mm;
      j["edge_depth_mm"] = tool.edge_depth_mm;
      if (tool.motion == BladeMotion::kSagittal) {
        j["swing_deg"] = tool.swing_deg;
        j["swept_width_mm"] = tool.sweptWidth();
      } else {
        j["stroke_mm"] = tool.stroke_mm;
      }
    }
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
