#include "ui/app/readout/point_readout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"

namespace kerf {
namespace {

// As loaded; a cut does not change the remaining material.
Material materialAt(const BakedObject& object, const Vec3d& p) {
  const Vec3d nodes = p / object.voxel();
  const Vec3i node(static_cast<int>(std::lround(nodes[0])), static_cast<int>(std::lround(nodes[1])),
                   static_cast<int>(std::lround(nodes[2])));
  const Vec3i brick = brickOf(node);
  const int slot = object.directory().find(brick);
  if (slot < 0) return Material::kNone;
  const auto offset = static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]));
  return static_cast<Material>(object.slots()[static_cast<std::size_t>(slot)].materials[offset]);
}

}  // namespace

std::optional<PointReadout> readoutAt(const Workbench& bench, const Ray& ray) {
  if (!bench.document->isOpen()) return {};
  const auto seen = bench.views->behindSection(ray);
  if (!seen) return {};
  const auto hit = bench.document->scene().hit(*seen);
  if (!hit) return {};
  const SceneObject& object = *bench.document->scene().find(hit->id);
  const Rigid3 to_scan = object.pose().inverse();
  const LiveRun& run = *bench.document->run();
  const BakedObject& loaded = object.isBeside() ? *run.neighbours()[object.loaded - 1].object : run.object();

  PointReadout out;
  out.point = to_scan * hit->on_surface.point;
  out.normal = to_scan.rotation * hit->on_surface.normal;
  if (object.isBeside())
    out.piece = "neighbour " + object.name;
  else if (bench.document->scene().pieceCount() > 1)
    out.piece = object.name;
  const Material material = materialAt(loaded, out.point - 0.5 * loaded.voxel() * out.normal);
  if (material != Material::kNone && material != Material::kGeneric) out.tissue = bench.document->nameOf(material);

  const Ray local = inFrame(object.pose(), *seen);
  if (const auto way = object.surface.exit(local, hit->on_surface.way)) out.thickness_mm = *way - hit->on_surface.way;
  if (const auto over = bench.strokes->over(ray)) out.T_scan_tool = to_scan * over->T_world_tool;
  return out;
}

std::optional<PointReadout> readoutOfTool(const Workbench& bench) {
  const auto front = bench.monitor->toolFront();
  if (!front) return {};
  const BakedObject& loaded = bench.document->run()->object();
  const StepOutput& now = bench.document->report().output;
  PointReadout out;
  out.point = front->point + std::max(0.0, -front->depth) * front->into;  // in air: the next contact
  out.normal = -front->into;
  const bool touches = now.touching > 0 && (now.objects_touched & objectBit(0));
  const Material under = touches ? now.material : materialAt(loaded, out.point + 0.5 * loaded.voxel() * front->into);
  if (under != Material::kNone && under != Material::kGeneric) out.tissue = bench.document->nameOf(under);
  return out;
}

std::string textOf(const PointReadout& r) {
  std::string out = fmt::format("{:.3f}, {:.3f}, {:.3f} mm; normal {:.3f}, {:.3f}, {:.3f}", r.point[0], r.point[1],
                                r.point[2], r.normal[0], r.normal[1], r.normal[2]);
  if (!r.tissue.empty()) out += "; " + r.tissue;
  if (r.thickness_mm) out += fmt::format("; {:.2f} mm thick along the view", *r.thickness_mm);
  if (!r.piece.empty()) out += "; " + r.piece;
  return out;
}

std::string pathRowOf(const PointReadout& r) {
  const Rigid3 pose = r.T_scan_tool.value_or(Rigid3{Eigen::Quaterniond::Identity(), r.point});
  const Vec3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return fmt::format("0,{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f}", t[0], t[1], t[2], q.w(), q.x(), q.y(),
                     q.z());
}

}  // namespace kerf
