#include <fmt/format.h>
#include <fmt/ranges.h>

#include "preprocess/bake/bake.h"

namespace kerf {

std::string describe(const BakeReport& r) {
  std::string text;
  const auto line = [&text](const std::string& s) { text += s + "\n"; };
  const auto addPairCheck = [&] {
    if (!r.pair_check) return;
    for (const std::string& note : r.pair_check->notes) line("pair: " + note);
    for (const std::string& warning : r.pair_check->warnings) line("WARNING: " + warning);
  };
  if (r.was_up_to_date) {
    addPairCheck();
    line("the case is there already, of the same inputs and settings; --force bakes it again");
    return text;
  }
  for (std::size_t i = 0; i < r.manifest.sources.size(); ++i) {
    const CaseSource& s = r.manifest.sources[i];
    if (i >= r.source_checks.size()) {  // a volume: it comes after the meshes
      line(fmt::format("source {}: {}", i + 1, s.format));
      for (const std::string& note : r.notes[i]) line("  note     " + note);
      continue;
    }
    const MeshReport& c = r.source_checks[i];
    line(fmt::format("source {}: {}, {} vertices, {} triangles", i + 1, s.format, s.vertices, s.triangles));
    line(fmt::format("  unit     {}{}: {}", r.unit_is_doubtful[i] ? "CHECK THIS: " : "", s.unit, s.unit_reason));
    line(fmt::format("  size     {:.2f} x {:.2f} x {:.2f} mm", c.box.size()[0], c.box.size()[1], c.box.size()[2]));
    line(
        fmt::format("  defects  {} boundary loops ({} edges), {} non-manifold edges, {} flipped, {} degenerate, {} "
                    "repeated, {} pieces, "
                    "{} self-intersections",
                    c.boundary_loops.size(), c.boundary_edges, c.non_manifold_edges, c.flipped_edges,
                    c.degenerate_triangles, c.duplicate_triangles, c.pieces, c.self_intersections));
    for (const std::string& note : r.notes[i]) line("  note     " + note);
  }
  if (r.manifest.changes.empty()) line("closing: nothing had to be changed");
  for (const std::string& change : r.manifest.changes) line("closing: " + change);
  if (!r.manifest.exact && r.manifest.parts.empty())
    line("WARNING: the surface is a shrink-wrap, an approximation of the scan: no source vertex is preserved");
  const CaseManifest& m = r.manifest;
  if (m.pair) line(fmt::format("pair: one frame with {}; nothing was moved", m.pair->partner));
  addPairCheck();
  line(fmt::format("solid: {} vertices, {} triangles, {:.2f} mm3, {:.2f} mm2", m.solid_vertices, m.solid_triangles,
                   m.solid_volume_mm3, m.solid_area_mm2));
  line(fmt::format("field: {} mm voxels, {:.2f} M in the band; shell: {:.2f} M points standing for {:.2f} mm2",
                   m.voxel_mm, static_cast<double>(m.field_voxels) / 1e6, static_cast<double>(m.shell_points) / 1e6,
                   m.shell_area_mm2));
  if (m.region)
    line(fmt::format(
        "fine region: {} mm around a line of {} points: {} mm voxels, {:.2f} M in the band; shell: {:.2f} M "
        "points standing for {:.2f} mm2",
        m.region->where.radius_mm, m.region->where.line.size(), m.region->where.voxel_mm,
        static_cast<double>(m.region->field_voxels) / 1e6, static_cast<double>(m.region->shell_points) / 1e6,
        m.region->shell_area_mm2));
  for (const CasePart& p : m.parts)
    line(fmt::format(
        "part: {:<12} {:<28} {:10.3f} mm3{}", p.material, p.origin, p.volume_mm3,
        p.own_mm3 > 0 ? fmt::format(" of {:.3f} its own ({:+.2f} %)", p.own_mm3, 100 * (p.volume_mm3 / p.own_mm3 - 1))
                      : std::string()));
  for (std::size_t n = 0; n < m.parts.size(); ++n)
    if (const CasePart& p = m.parts[n]; p.volume_mm3 <= 1e-3 * p.own_mm3)
      line(fmt::format("WARNING: part {} ({}, {}) got nothing: earlier parts cover it{}", n + 1, p.material, p.origin,
                       n > 0 ? ". Try: move it before them in the recipe, the first part wins" : ""));
  if (m.parts.size() > 1)
    for (const CaseMaterial& c : m.materials) line(fmt::format("material: {:<12} {:10.3f} mm3", c.id, c.volume_mm3));
  if (m.gaps && m.gaps->unclaimed_mm3 > 0)
    line(fmt::format("gaps: {:.3f} mm3 lay in no part and went to their neighbours{}", m.gaps->unclaimed_mm3,
                     m.gaps->forgotten_mm3 > 0
                         ? fmt::format("; WARNING: {:.3f} mm3 lay too far from every part and became the fallback "
                                       "material",
                                       m.gaps->forgotten_mm3)
                         : std::string()));
  if (m.shell_area_mm2 < 0.98 * m.solid_area_mm2)
    line(
        fmt::format("WARNING: the field holds {:.1f} % less surface than the solid: slots and fins thinner than a "
                    "voxel are lost in it "
                    "(export is exact all the same). A finer --voxel keeps more",
                    100 * (1 - m.shell_area_mm2 / m.solid_area_mm2)));
  line(fmt::format("time: read {:.2f}, check {:.2f}, close {:.2f}, voxelize {:.2f}, write {:.2f} s", r.times.read,
                   r.times.check, r.times.close, r.times.voxelize, r.times.write));
  return text;
}

}  // namespace kerf
