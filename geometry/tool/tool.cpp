#include "geometry/tool/tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "geometry/tool/plunge.h"

namespace kerf {

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
  switch (tool.kind) {
    case ToolKind::kBur:
      return tool.cuts_end ? internal::revolvedPlunge(*tool.cutting, depth_mm)
                           : internal::sidewaysPlunge(*tool.cutting, depth_mm);
    case ToolKind::kBlade:
      return tool.motion->plunge_volume(tool, depth_mm, window_mm);
    case ToolKind::kMesh:
      return internal::turnedPlunge(*tool.cutting, tool.hollows, depth_mm);
  }
  return 0;
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
    text += fmt::format("  turns about its axis: fills {:.6g} mm3 there, its mesh {:.6g} mm3{}\n", tool.turned_mm3,
                        tool.unturned_mm3, tool.body_turns ? "" : "; its body does not turn");
  } else {
    text += fmt::format("  {} blade {:.3g} mm thick, set {:.3g} mm per side: kerf {:.3g} mm\n", tool.motion->name,
                        tool.thickness_mm, tool.set_per_side_mm, tool.kerfWidth());
    text += fmt::format("  {}\n", tool.motion->describe(tool));
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
    j["mesh_file"] = tool.companion.string();
    j["triangles"] = tool.mesh->triangles.size();
    j["cuts_to_mm"] = tool.cut_below_mm;
    j["cut_volume_mm3"] = tool.turned_mm3;
    j["cut_mesh_volume_mm3"] = tool.unturned_mm3;
    j["body_turns"] = tool.body_turns;
  } else {
    j["motion"] = tool.motion->name;
    j["thickness_mm"] = tool.thickness_mm;
    j["set_per_side_mm"] = tool.set_per_side_mm;
    j["kerf_mm"] = tool.kerfWidth();
    for (const auto& [key, number] : tool.motion->numbers(tool)) j[key] = number;
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
