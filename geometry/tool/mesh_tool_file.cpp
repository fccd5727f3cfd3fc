#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "geometry/formats/mesh_formats.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/mesh_shape.h"
#include "geometry/tool/tool_doubt.h"
#include "geometry/tool/tool_kinds.h"
#include "geometry/tool/tool_template.h"
#include "geometry/tool/tool_ways.h"
#include "geometry/tool/turned_mesh.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr double kLeastRound = 0.6;  // of its solid of revolution: a shank with a flat is round, a handpiece is not
constexpr const char* kMeshKeys[] = {"mesh", "mm_per_unit", "tip", "axis", "cut_below"};

bool isMeshName(const std::string& name) {
  const MeshFormatRow* format = formatOfExtension(fs::path(name).extension().string());
  return fs::path(name).filename() == name && format && format->read;
}

Vec3d readVector(TomlTable& top, const char* key) {
  const std::vector<double> v = top.numbers(key, 3);
  return {v[0], v[1], v[2]};
}

// Lines for a file whose tip is not the mesh's lowest point. An axis off the mesh's length, or from its thicker end, is
// probably wrong: Kerf then offers the thinner end of the length.
// @param mesh  placed: mm, its tip in the file at the origin, its axis upright.
template <class ToFile>
std::string tipAdvice(const Mesh& mesh, const Vec3d& axis, const ToFile& toFile) {
  const Vec3d z = Vec3d::UnitZ();
  const auto lines = [&](const ToolWay& way) {
    const Vec3d begin = toFile(way.tip), end = toFile(way.tip + way.axis);
    const Vec3d direction = way.axis == z ? Vec3d(axis) : Vec3d((end - begin).normalized());
    return fmt::format("tip = {} and axis = {}", tomlVector(begin), tomlVector(direction));
  };
  const SurfaceSpread spread = spreadOf(mesh);
  if (!spread.isSlender()) return lines(toolWayAlong(mesh, "", z));

  const bool is_along = std::abs(spread.longest[2]) > std::cos(kMostDegreesOff * std::numbers::pi / 180);
  const Vec3d length = is_along ? z : spread.longest;
  ToolWay way = toolWayAlong(mesh, "", length), other = toolWayAlong(mesh, "", -length);
  const auto [thin, thick] = std::minmax(way.tip_width_mm, other.tip_width_mm);
  const bool is_open = thick < ToolWay::kDoubt * thin;  // either end may cut: the axis of the file decides, if it can
  if (is_open && is_along ? other.tip.norm() < way.tip.norm() : other.tip_width_mm < way.tip_width_mm)
    std::swap(way, other);
  return lines(way) + (is_open ? "; if the other end cuts, " + lines(other) : ", from the thinner end of its length");
}

}  // namespace

void allowMeshKeys(TomlTable& top) {
  for (const char* key : kMeshKeys) top.allow(key);
}

void readMeshTool(TomlTable& top, const fs::path& folder, Tool& tool) {
  for (const char* key : {"unit", "units", "scale"})
    top.explain(key, "mm_per_unit = 1 for a file in mm, 25.4 for inches, 1000 for metres");
  const auto name = top.get<std::string>("mesh", "the name of a mesh file beside this one");
  const double scale = top.number("mm_per_unit", 1e-4, 1e4, "mm");
  const Vec3d tip = readVector(top, "tip"), axis = readVector(top, "axis");
  tool.cut_below_mm = top.number("cut_below", 0.01, 100, "mm above the tip");

  if (!isMeshName(name))
    top.reject("mesh", "\"" + name + "\"",
               "the name of a mesh file (" + readableExtensions() + ") in the folder of this one");
  if (!(axis.norm() > 1e-9)) top.reject("axis", "no direction", "the direction from the tip to the shank: [0, 0, 1]");
  if (top.failed()) return;

  tool.companion = folder / name;
  auto file = readMesh(tool.companion);
  if (!file) return top.reject("mesh", file.error().message(), "a mesh that can be read", "kerf check " + name);

  Mesh mesh = withoutStrayVertices(file->mesh);
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(axis, Vec3d::UnitZ()).normalized();
  for (Vec3d& p : mesh.vertices) p = upright * (scale * (p - tip));
  tool.mm_per_unit = scale;

  const Box3 box = bounds(mesh);
  // Shorter or longer than any tool: most often another unit.
  constexpr double kShortest = 1, kLongest = 500;
  const double longest = box.size().maxCoeff();
  if (const std::string units = unitsOfABur(longest / scale); longest < kShortest || longest > kLongest)
    return top.reject("mm_per_unit", fmt::format("{} makes a tool of {:.4g} mm", scale, longest),
                      fmt::format("a tool of {} to {} mm", kShortest, kLongest),
                      units.empty() ? "the unit of the file: 1 for mm, 25.4 for inches, 1000 for metres" : units);

  const MeshReport report = checkMesh(mesh);
  if (!report.print_ready)
    return top.reject("mesh", report.reasons.empty() ? "not a solid" : report.reasons.front(),
                      "a closed solid that does not cross itself",
                      "kerf bake closes and repairs meshes: use its solid.ply");

  if (const double lowest = box.min[2]; std::abs(lowest) > 0.02)
    return top.reject(
        "tip", fmt::format("the mesh begins {:.4g} mm {} it", std::abs(lowest), lowest < 0 ? "below" : "above"),
        "the mesh's lowest point along the axis",
        tipAdvice(mesh, axis, [&](const Vec3d& p) -> Vec3d { return tip + upright.conjugate() * p / scale; }));

  constexpr double kLeastPart = 0.01;  // mm
  const double cut_to = tool.cut_below_mm > box.max[2] - kLeastPart ? box.max[2] : tool.cut_below_mm;
  if (cut_to - box.min[2] < kLeastPart)
    return top.reject("cut_below", fmt::format("{:.6g}, below the mesh's lowest point", tool.cut_below_mm),
                      fmt::format("at least {} mm of the mesh", kLeastPart), "the height of the cutting part");
  const TurnedMesh cut = turnedMesh(mesh, box.min[2], cut_to);
  if (cut.second_ring_at)
    return top.reject(
        "cut_below",
        fmt::format("{:.6g}, and at {:.3g} mm the cutting part is more than one disc or ring about its axis",
                    tool.cut_below_mm, *cut.second_ring_at),
        "a part that turns: one disc or one ring at every height",
        "a smaller cut_below if a handle is in its way; else check `tip` and `axis`");
  tool.cut = shapeOf(cut);
  tool.cutting = std::make_shared<const RevolvedProfile>(cut.outline);
  tool.hollows = cut.hollows;
  tool.turned_mm3 = cut.volume_mm3;
  tool.unturned_mm3 = cut.mesh_volume_mm3;

  if (cut_to < box.max[2]) {
    const TurnedMesh body = turnedMesh(mesh, cut_to, box.max[2]);
    tool.body_turns = !body.second_ring_at && body.mesh_volume_mm3 > kLeastRound * body.volume_mm3;
    if (tool.body_turns)
      tool.body = shapeOf(body);
    else
      tool.body = std::make_shared<const HalfShape>(std::make_shared<const MeshShape>(mesh), cut_to);
  }
  tool.mesh = std::make_shared<const Mesh>(std::move(mesh));
}

}  // namespace kerf
