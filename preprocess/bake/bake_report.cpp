#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "preprocess/bake/bake.h"

namespace kerf {
namespace {

// Collects lines.
class Text {
 public:
  void line(const std::string& s) { text_ += s + "\n"; }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

// "3 pieces", "1 piece".
std::string counted(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

void addPairCheck(const BakeReport& r, Text& out) {
  if (!r.pair_check) return;
  for (const std::string& note : r.pair_check->notes) out.line("pair: " + note);
  for (const std::string& warning : r.pair_check->warnings) out.line("WARNING: " + warning);
}

void addSource(const BakeReport& r, std::size_t i, Text& out) {
  const CaseSource& s = r.manifest.sources[i];
  if (i >= r.source_checks.size()) {  // a volume: it comes after the meshes
    out.line(fmt::format("source {}: {}", i + 1, s.format));
  } else {
    const MeshReport& c = r.source_checks[i];
    out.line(fmt::format("source {}: {}, {} vertices, {} triangles", i + 1, s.format, s.vertices, s.triangles));
    out.line(fmt::format("  unit     {}{}: {}", r.unit_is_doubtful[i] ? "CHECK THIS: " : "", s.unit, s.unit_reason));
    out.line(fmt::format("  size     {:.2f} x {:.2f} x {:.2f} mm", c.box.size()[0], c.box.size()[1], c.box.size()[2]));
    out.line(fmt::format("  defects  {} ({}), {}, {} flipped, {} degenerate, {} repeated, {}, {}",
                         counted(c.boundary_loops.size(), "boundary loop"), counted(c.boundary_edges, "edge"),
                         counted(c.non_manifold_edges, "non-manifold edge"), c.flipped_edges, c.degenerate_triangles,
                         c.duplicate_triangles, counted(c.pieces, "piece"),
                         counted(c.self_intersections, "self-intersection")));
  }
  for (const std::string& note : r.notes[i]) out.line("  note     " + note);
}

std::string whatIsLost(const CloseReport& c) {
  std::string text = c.vertices_lost == 0   ? "every vertex is in the solid"
                     : c.vertices_lost == 1 ? "1 of its vertices is not in the solid"
                                            : fmt::format("{} of its vertices are not in the solid", c.vertices_lost);
  if (!c.lost_at.empty() && c.lost_at[0].vertices >= kManyLostTogether) {
    const Vec3d& p = c.lost_at[0].middle;
    text += fmt::format(", {} of them together near ({:.1f}, {:.1f}, {:.1f}) mm", c.lost_at[0].vertices, p.x(), p.y(),
                        p.z());
  }
  if (c.vertices_trimmed > 0) text += fmt::format(", besides {} trimmed by --trim-rim", c.vertices_trimmed);
  if (c.vertices_in_specks > 0)
    text += fmt::format(", besides {} of pieces dropped by --drop-specks", c.vertices_in_specks);
  return text;
}

// First lines: the result, and the missing parts of the scan.
void addHeadline(const BakeReport& r, Text& out) {
  const CaseManifest& m = r.manifest;
  out.line(fmt::format("solid: {}, {:.2f} mm3, {:.2f} mm2; {} vertices, {} triangles", describe(r.pieces),
                       m.solid_volume_mm3, m.solid_area_mm2, m.solid_vertices, m.solid_triangles));
  if (r.pieces.specks > 0 && r.pieces.pieces > 1)
    out.line(
        "  specks are printed, and cut, as pieces of their own: --drop-specks MM3, or drop_specks_mm3 in a recipe");
  if (m.parts.empty() && m.exact) out.line("scan: " + whatIsLost(r.close));
  for (const std::string& warning : warningsOf(r)) out.line("WARNING: " + warning);
}

void addClosing(const BakeReport& r, Text& out) {
  if (r.manifest.changes.empty()) out.line("closing: nothing had to be changed");
  const std::vector<std::string>& warnings = r.close.warnings;
  for (const std::string& change : r.manifest.changes)
    if (std::find(warnings.begin(), warnings.end(), change) == warnings.end()) out.line("closing: " + change);
}

void addGrids(const CaseManifest& m, Text& out) {
  out.line(fmt::format("field: {} mm voxels, {:.2f} M in the band; shell: {:.2f} M points standing for {:.2f} mm2",
                       m.voxel_mm, static_cast<double>(m.field_voxels) / 1e6, static_cast<double>(m.shell_points) / 1e6,
                       m.shell_area_mm2));
  if (m.region)
    out.line(fmt::format(
        "fine region: {} mm around a line of {} points: {} mm voxels, {:.2f} M in the band; shell: {:.2f} M "
        "points standing for {:.2f} mm2",
        m.region->where.radius_mm, m.region->where.line.size(), m.region->where.voxel_mm,
        static_cast<double>(m.region->field_voxels) / 1e6, static_cast<double>(m.region->shell_points) / 1e6,
        m.region->shell_area_mm2));
}

void addMaterials(const CaseManifest& m, Text& out) {
  for (const CasePart& p : m.parts)
    out.line(fmt::format(
        "part: {:<12} {:<28} {:10.3f} mm3{}", p.material, p.origin, p.volume_mm3,
        p.own_mm3 > 0 ? fmt::format(" of {:.3f} its own ({:+.2f} %)", p.own_mm3, 100 * (p.volume_mm3 / p.own_mm3 - 1))
                      : std::string()));

  if (m.parts.size() > 1)
    for (const CaseMaterial& c : m.materials)
      out.line(fmt::format("material: {:<12} {:10.3f} mm3", c.id, c.volume_mm3));

  if (m.gaps && m.gaps->unclaimed_mm3 > 0)
    out.line(fmt::format("gaps: {:.3f} mm3 lay in no part and went to their neighbours", m.gaps->unclaimed_mm3));
}

// ---- Warnings

constexpr const char* kUnitDoubt = "CHECK THE UNIT of source";

void warnOfParts(const CaseManifest& m, std::vector<std::string>& out) {
  for (std::size_t n = 0; n < m.parts.size(); ++n)
    if (const CasePart& p = m.parts[n]; p.volume_mm3 <= 1e-3 * p.own_mm3)
      out.push_back(fmt::format("part {} ({}, {}) got nothing: earlier parts cover it{}", n + 1, p.material, p.origin,
                                n > 0 ? ". Try: move it before them in the recipe, the first part wins" : ""));
  if (m.gaps && m.gaps->forgotten_mm3 > 0)
    out.push_back(
        fmt::format("{:.3f} mm3 lay too far from every part and became the fallback material", m.gaps->forgotten_mm3));
}

void warnOfLostSurface(const CaseManifest& m, std::vector<std::string>& out) {
  constexpr double kMatters = 0.05;  // less is lost by every scan at a coarse voxel, along its creases
  const double lost = 1 - m.shell_area_mm2 / m.solid_area_mm2;
  if (!(lost > kMatters)) return;
  out.push_back(
      fmt::format("the tool cannot cut or feel gaps and ridges narrower than {:g} mm, {:.0f} % of the surface. The "
                  "export keeps them. --voxel {:g} keeps more",
                  m.voxel_mm, 100 * lost, m.voxel_mm / 2));
}

}  // namespace

std::vector<std::string> warningsOf(const BakeReport& r) {
  const CaseManifest& m = r.manifest;
  std::vector<std::string> out;
  if (!m.exact && m.parts.empty())
    out.emplace_back("the surface is a shrink-wrap, an approximation of the scan: no source vertex is preserved");
  out.insert(out.end(), r.close.warnings.begin(), r.close.warnings.end());
  warnOfParts(m, out);
  warnOfLostSurface(m, out);
  return out;
}

std::vector<std::string> doubtsOfUnits(const BakeReport& r) {
  std::vector<std::string> out;
  for (std::size_t n = 0; n < r.unit_is_doubtful.size(); ++n)
    if (const CaseSource& s = r.manifest.sources[n]; r.unit_is_doubtful[n])
      out.push_back(fmt::format("{} {}, {}: {}", kUnitDoubt, n + 1, s.unit, s.unit_reason));
  return out;
}

std::vector<std::string> closingWarningsOf(const CaseManifest& manifest) {
  BakeReport without_closing;
  without_closing.manifest = manifest;
  const std::vector<std::string> others = warningsOf(without_closing);
  std::vector<std::string> out;
  for (const std::string& warning : *manifest.warnings)
    if (!warning.starts_with(kUnitDoubt) && std::find(others.begin(), others.end(), warning) == others.end())
      out.push_back(warning);
  return out;
}

std::string describe(const BakeReport& r) {
  Text out;
  if (r.was_up_to_date) {
    for (const std::string& warning : r.manifest.warnings.value_or(std::vector<std::string>{}))
      out.line("WARNING: " + warning);
    addPairCheck(r, out);
    out.line("the case already exists, from the same inputs and settings; --overwrite bakes it again");
    return out.take();
  }

  const CaseManifest& m = r.manifest;
  addHeadline(r, out);
  for (std::size_t i = 0; i < m.sources.size(); ++i) addSource(r, i, out);
  addClosing(r, out);
  if (m.pair) out.line(fmt::format("pair: one frame with {}; nothing was moved", m.pair->partner));
  addPairCheck(r, out);
  addGrids(m, out);
  addMaterials(m, out);
  out.line(fmt::format("time: read {:.2f}, check {:.2f}, close {:.2f}, voxelize {:.2f}, write {:.2f} s", r.times.read,
                       r.times.check, r.times.close, r.times.voxelize, r.times.write));
  return out.take();
}

}  // namespace kerf
