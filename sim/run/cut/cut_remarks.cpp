#include "sim/run/cut/cut_remarks.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/tool/tool_doubt.h"
#include "sim/run/files/small_cut.h"
#include "sim/run/sweep/tool_resolution.h"
#include "sim/step/response.h"

namespace kerf {
namespace {

class Remarks {
 public:
  void note(std::string text) { all_.push_back({false, std::move(text)}); }
  void warn(std::string text) { all_.push_back({true, std::move(text)}); }
  std::vector<CutRemark> take() { return std::move(all_); }

 private:
  std::vector<CutRemark> all_;
};

// Of a doubtful tool, and of one too thin for the voxels. A hand cuts on the object's own voxels.
// @param by_hand  against resistance.
void addTool(const Tool& tool, double voxel_mm, Held held, bool by_hand, bool is_unchanged, Remarks& out) {
  if (const std::string doubt = doubtAbout(tool); !doubt.empty()) out.warn(tool.id + ": " + doubt);
  if (const auto coarse = tooCoarseFor(tool, voxel_mm, held))
    out.warn(fmt::format("{}. Bake with --voxel {:.2g} or finer{}", coarse->what, coarse->finer_mm,
                         by_hand ? "" : ", or for the mesh alone with --fine-along the path"));
  if (is_unchanged) out.warn("the tool changed nothing");
}

void addFindings(const PathFindings& found, bool is_adding, Remarks& out) {
  if (!found.idle.empty()) {
    constexpr std::size_t kMostNamed = 8;
    std::string named;
    for (std::size_t n = 0; n < std::min(kMostNamed, found.idle.size()); ++n)
      named += fmt::format("{}{}", n ? ", " : "", found.idle[n]);
    const std::string more =
        found.idle.size() > kMostNamed ? fmt::format(" and {} more", found.idle.size() - kMostNamed) : std::string();
    out.note(fmt::format("stroke{} {}{} of {} {} nothing", found.idle.size() == 1 ? "" : "s", named, more,
                         found.strokes, is_adding ? "added" : "removed"));
  }
  if (const auto& at = found.comes_out_at)
    out.note(fmt::format("the tip leaves the object on the far side, at ({:.2f}, {:.2f}, {:.2f}) mm", at->x(), at->y(),
                         at->z()));
}

void addSmallCut(double removed_mm3, double voxel_mm, Remarks& out) {
  if (auto small = smallCut(removed_mm3, voxel_mm)) out.warn(std::move(*small));
}

// Only the penalty law holds a tool by its core.
void addResponse(const HapticCutOptions& options, const Tool& tool, Remarks& out) {
  if (options.step.response == StepSettings{}.response || !options.add.empty() || !isPointed(tool)) return;
  for (const ResponseRow& row : kResponses)
    if (row.response == options.step.response)
      out.warn(
          fmt::format("with {} a point as thin as that of {} may pass through tissue without cutting it. Omit "
                      "--response",
                      row.name, tool.id));
}

// A feed works like a machine: it moves on past remaining material. An unfinished path allows no such warning.
void addFeed(const HapticCutOptions& options, const HapticSummary& s, Remarks& out) {
  constexpr double kEnough = 0.9;  // of the plan
  if (options.hand == HandKind::kFeed && s.is_complete && s.reached_mm3 < kEnough * s.planned_mm3)
    out.warn(
        fmt::format("fed faster than it can cut: the tool removed {:.0f} % of the planned volume and passed through "
                    "the rest. Forces and volumes are not reliable. Use --hand force, or a slower feed",
                    100 * s.reached_mm3 / s.planned_mm3));
}

}  // namespace

std::vector<std::string> warningsOf(const RunManifest& m) {
  constexpr double kWorthSaying = 0.01;  // mm^3
  std::vector<std::string> out;
  for (const std::string& piece : m.missing_pieces)
    out.push_back("piece not found; it stays at its scan position: " + piece);
  for (const std::string& piece : m.pieces_cut_away) out.push_back("piece completely cut away: " + piece);
  if (m.added_before_mm3 > kWorthSaying)
    out.push_back(
        fmt::format("{:.4f} mm3 of earlier filling now count as the tissue around them. The run is from an older Kerf, "
                    "which saved the place of added material but not the material",
                    m.added_before_mm3));
  if (m.finer_before_mm > 0)
    out.push_back(
        fmt::format("the earlier run was cut on voxels of {} mm, in the case's fine region. Its cut outside the region "
                    "is now on the object's voxels, {} mm",
                    m.finer_before_mm, m.voxel_mm));
  return out;
}

std::vector<CutRemark> remarksOf(const RunManifest& m, const Tool& tool) {
  Remarks out;
  if (m.beyond_region_mm > 0)
    out.note(
        fmt::format("the cut reaches {:.2f} mm out of the case's fine region: cut on the object's voxels, {} mm. To "
                    "use the fine voxels, bake with a larger --fine-radius",
                    m.beyond_region_mm, m.voxel_mm));
  for (std::string& warning : warningsOf(m)) out.warn(std::move(warning));
  double removed = 0;
  for (const auto& [id, volume] : m.removed_by_material) removed += volume;
  // Volumes use the object's own voxels; strokes use those of a fine region if one was cut.
  const bool is_idle = m.findings.idle.size() == m.findings.strokes;
  const bool is_thin = m.thin_mm3 > 0;
  addTool(tool, m.voxel_mm, Held::kOnPath, false, removed < kUnchanged && is_idle && !is_thin, out);
  if (is_thin)
    out.warn(
        fmt::format("the cut is thinner than the voxels: the exported mesh loses about {:.2g} mm3, this report counts "
                    "none. Bake with smaller voxels",
                    m.thin_mm3));
  addFindings(m.findings, false, out);
  addSmallCut(removed, m.voxel_mm, out);
  return out.take();
}

std::vector<CutRemark> remarksOf(const HapticCut& cut, const HapticCutOptions& options, const Tool& tool) {
  Remarks out;
  const HapticSummary& s = cut.summary;
  const double voxel_mm = cut.manifest.voxel_mm;
  const bool is_adding = !options.add.empty();
  if (cut.left_region_unused)
    out.note(fmt::format("--hand does not use the case's fine region: cut on the object's voxels, {} mm", voxel_mm));
  for (std::string& warning : warningsOf(cut.manifest)) out.warn(std::move(warning));
  // Added material gives no force.
  const Held held = options.hand != HandKind::kFeed && !is_adding ? Held::kByHand : Held::kOnPath;
  addTool(tool, voxel_mm, held, true, s.removed_mm3 + s.added_mm3 < kUnchanged, out);
  addSmallCut(s.removed_mm3, voxel_mm, out);
  addFindings(s.findings, is_adding, out);
  addResponse(options, tool, out);
  addFeed(options, s, out);
  constexpr double kInside = 0.2;  // mm; less is a tool that leans on the surface
  if (s.began_inside_mm > kInside)
    out.warn(
        fmt::format("the path begins {:.2f} mm or more inside tissue. The tissue pushes the tool out, and the "
                    "force is meaningless. Begin the path in air, for example with a plunge",
                    s.began_inside_mm));
  return out.take();
}

}  // namespace kerf
