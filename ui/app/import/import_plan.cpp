#include "ui/app/import/import_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/formats/mesh_io.h"
#include "preprocess/close/close.h"
#include "preprocess/close/occlusal_plane.h"
#include "preprocess/unit/unit.h"
#include "ui/app/base/language.h"
#include "ui/app/view/upright.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Weight = Finding::Weight;

constexpr std::size_t kMostCrossings = 1000;          // upper limit of the count
constexpr std::size_t kByItselfUpTo = 1'000'000;      // triangles: closing takes a few seconds
constexpr Rgba8 kAddedColour = {190, 203, 216, 255};  // added faces in the preview
constexpr Rgba8 kScannedColour = {233, 221, 197, 255};

double secondsSince(Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); }

Mesh scaled(const Mesh& mesh, double factor) {
  Mesh out = mesh;
  for (Vec3d& p : out.vertices) p *= factor;
  return out;
}

// Colours of the scan, or ivory; added faces are bluish.
void colourAdded(Solid& solid, const Mesh& source) {
  solid.mesh.vertex_colors.clear();
  solid.mesh.face_colors.assign(solid.mesh.triangles.size(), kAddedColour);
  for (std::size_t t = 0; t < solid.source_triangle.size(); ++t) {
    const std::uint32_t from = solid.source_triangle[t];
    if (from == kAdded) continue;
    Rgba8& colour = solid.mesh.face_colors[t];
    colour = source.hasFaceColors()     ? source.face_colors[from]
             : source.hasVertexColors() ? source.vertex_colors[source.triangles[from][0]]
                                        : kScannedColour;
  }
}

Expected<ClosedPreview> closed(const Mesh& source, double scale_to_mm, const CloseOptions& options,
                               const Progress& progress) {
  const auto began = Clock::now();
  const Mesh scan = scaled(source, scale_to_mm);
  KERF_TRY(solid, closeMesh(scan, options, progress));

  ClosedPreview out;
  out.changes = solid.report.changes;
  out.warnings = solid.report.warnings;
  out.is_exact = solid.report.exact;
  out.volume_mm3 = signedVolume(solid.mesh);
  out.area_mm2 = surfaceArea(solid.mesh);
  out.base_direction = solid.report.base_direction;
  out.base_level_mm = solid.report.base_level_mm;
  if (const auto& plane = solid.report.occlusal_plane) out.occlusal_plane = Plane{plane->point, plane->normal};
  colourAdded(solid, scan);
  out.solid = std::make_shared<const Mesh>(std::move(solid.mesh));
  out.seconds = secondsSince(began);
  return out;
}

std::string counted(std::size_t n, const char* one, const char* several) {
  return fmt::format("{} {}", n, shownText(n == 1 ? one : several));
}

tl::unexpected<Error> wrong(std::string found, std::string expected) {
  return fail({.code = Error::Code::kBadValue, .found = std::move(found), .expected = std::move(expected)});
}

}  // namespace

Expected<ScanFound> readScan(const fs::path& path, const Progress& progress) {
  const auto began = Clock::now();
  if (!report(progress, 0, "reading")) return cancelled();
  KERF_TRY(file, readMesh(path, progress));
  if (file.mesh.triangles.empty())
    return fail({.code = Error::Code::kEmpty,
                 .file = path.string(),
                 .found = "a mesh without triangles",
                 .expected = "a surface",
                 .hint = "export the scan as a mesh, not as points"});

  if (!report(progress, 0.5, "checking the surface")) return cancelled();
  ScanFound out;
  out.file = path;
  out.format = file.format;
  out.declared_unit = file.declared_unit;
  out.notes = std::move(file.notes);
  out.check = checkMesh(file.mesh, {.max_self_intersections = kMostCrossings});

  if (!report(progress, 0.8, "finding the occlusal plane")) return cancelled();
  KERF_TRY(unit, chooseUnit(out.check.box, "", out.declared_unit));
  const Mesh in_mm = scaled(file.mesh, unit.scale_to_mm);
  if (const auto away = awayFromOpening(in_mm)) {
    const auto plane = findOcclusalPlane(in_mm, *away);
    out.up = plane ? plane->normal : *away;
    out.has_occlusal_plane = plane.has_value();
  } else if (const auto normal = occlusalNormalOf(in_mm)) {
    out.up = *normal;
  }
  out.mesh = std::make_shared<const Mesh>(std::move(file.mesh));
  out.seconds = secondsSince(began);
  return out;
}

double closingSeconds(std::size_t triangles, bool is_closed) {
  // Measured: an arch of 10 000 to 640 000 triangles, and closed teeth.
  constexpr double kSecondsOfOpen = 3.5e-5, kSecondsOfClosed = 1e-5;
  return (is_closed ? kSecondsOfClosed : kSecondsOfOpen) * static_cast<double>(triangles);
}

Prediction predict(double area_mm2, double voxel_mm, double closing_s) {
  constexpr double kTrianglesPerVoxel = 2.75;                   // of the drawn surface
  constexpr double kProgram = 5.5e8, kBytesPerTriangle = 135;   // window, log and tools; field, shell, chunks
  constexpr double kStart = 0.8, kSecondsPerTriangle = 2.6e-6;  // two cores
  Prediction out;
  out.surface_triangles = kTrianglesPerVoxel * area_mm2 / (voxel_mm * voxel_mm);
  out.bytes = kProgram + kBytesPerTriangle * out.surface_triangles;
  out.seconds = kStart + closing_s + kSecondsPerTriangle * out.surface_triangles;
  return out;
}

ImportPlan::ImportPlan(ScanFound found, PrepareOptions defaults)
    : found_(std::move(found)), mesh_(found_.mesh), check_(found_.check), choice_(std::move(defaults)) {
  const Vec3d size = found_.check.box.size();
  for (const std::string& name : unitNames()) {
    const double scale = millimetresPer(name).value_or(1);
    const auto alone = chooseUnit(found_.check.box, name, "");
    units_.push_back({name, scale, scale * size, alone && !alone->is_doubtful});
  }
  const std::string asked = std::exchange(choice_.unit, {});
  (void)setUnit(asked);  // ignores an unknown unit; openToCut() reports it
}

// ---- Choices

Expected<void> ImportPlan::setUnit(const std::string& name) {
  KERF_TRY(chosen, chooseUnit(found_.check.box, name, found_.declared_unit));
  choice_.unit = name;
  for (ScanTrim& trim : choice_.closing.trims)
    trim = scaledBy(std::move(trim), chosen.scale_to_mm / unit().scale_to_mm);
  unit_is_doubtful_ = chosen.is_doubtful;
  for (std::size_t n = 0; n < units_.size(); ++n)
    if (units_[n].unit == chosen.unit) unit_ = n;
  if (trimmed_) return setTrims(choice_.closing.trims);
  changed();
  return {};
}

Expected<void> ImportPlan::setClosing(const ClosingChoice& c) {
  if (c == choice_.closing) return {};
  if (!(c.base_mm >= kThinnestBase && c.base_mm <= kThickestBase))
    return wrong(fmt::format("a base of {:g} mm", c.base_mm),
                 fmt::format("{:g} to {:g} mm", kThinnestBase, kThickestBase));
  if (!(c.smooth_mm >= 0 && c.smooth_mm <= kSmoothest))
    return wrong(fmt::format("walls smooth over {:g} mm", c.smooth_mm), fmt::format("0 to {:g} mm", kSmoothest));
  if (!(c.wrap_mm >= kFinestWrap && c.wrap_mm <= kCoarsestWrap))
    return wrong(fmt::format("a wrap of {:g} mm", c.wrap_mm),
                 fmt::format("{:g} to {:g} mm", kFinestWrap, kCoarsestWrap));
  if (!(c.trim_rim_mm >= 0 && c.trim_rim_mm <= kWidestRimTrim))
    return wrong(fmt::format("a rim trimmed by {:g} mm", c.trim_rim_mm), fmt::format("0 to {:g} mm", kWidestRimTrim));
  if (c.holes_up_to_mm && !(*c.holes_up_to_mm > 0 && *c.holes_up_to_mm < 1e4))
    return wrong(fmt::format("holes up to {:g} mm", *c.holes_up_to_mm), "more than 0, less than 10000 mm");
  if (c.follows_occlusal_plane && !found_.has_occlusal_plane)
    return wrong("a scan without an occlusal plane", "at least six cusp tips that agree");
  choice_.closing = c;
  changed();
  return {};
}

// ---- Trims

// @param least  triangles to remove.
Expected<void> ImportPlan::setTrims(std::vector<ScanTrim> trims, std::size_t least) {
  const double scale = unit().scale_to_mm;
  if (trims.empty()) {
    trimmed_.reset();
    mesh_ = found_.mesh;
    check_ = found_.check;
  } else {
    KERF_TRY(trimmed, trimScan(*found_.mesh, trims, scale));
    if (trimmed.triangles_removed < least)
      return fail({.code = Error::Code::kEmpty,
                   .place = "trim",
                   .found = "a cut that removes no triangle",
                   .expected = "a line around or across a part of the scan"});
    check_ = checkMesh(trimmed.mesh, {.self_intersections = false});
    check_.self_intersections = found_.check.self_intersections;
    mesh_ = std::make_shared<const Mesh>(std::move(trimmed.mesh));
    trimmed_ = std::move(trimmed);
  }
  choice_.closing.trims = std::move(trims);
  changed();
  return {};
}

Expected<void> ImportPlan::trim(const ScanTrim& trim) {
  std::vector<ScanTrim> trims = choice_.closing.trims;
  trims.push_back(trim);
  return setTrims(std::move(trims), (trimmed_ ? trimmed_->triangles_removed : 0) + 1);
}

ScanTrim ImportPlan::removingLess(const PlaneTrim& plane) const {
  const ScanTrim other = flipped(plane);
  // A trim that would remove all is an error: the most.
  const auto removed = [&](const ScanTrim& trim) {
    const auto out = trimScan(*mesh_, {&trim, 1}, unit().scale_to_mm);
    return out ? out->removed_mm2 : std::numeric_limits<double>::infinity();
  };
  return removed(plane) <= removed(other) ? ScanTrim(plane) : other;
}

bool ImportPlan::undoTrim() {
  std::vector<ScanTrim> trims = choice_.closing.trims;
  if (trims.empty()) return false;
  trims.pop_back();
  return setTrims(std::move(trims)).has_value();
}

Expected<void> ImportPlan::flipTrim() {
  std::vector<ScanTrim> trims = choice_.closing.trims;
  if (trims.empty()) return wrong("no cut", "a cut to flip");
  trims.back() = flipped(std::move(trims.back()));
  return setTrims(std::move(trims));
}

Expected<void> ImportPlan::setVoxel(double mm) {
  if (mm != 0 && !(mm >= kFinestVoxel && mm <= kCoarsestVoxel))
    return wrong(fmt::format("a voxel of {:g} mm", mm), fmt::format("{:g} to {:g} mm", kFinestVoxel, kCoarsestVoxel));
  choice_.voxel_mm = mm;  // the solid and its preview stay
  return {};
}

double ImportPlan::suggestedVoxel() const {
  const double scale = unit().scale_to_mm;
  return voxelFor(found_.check.area * scale * scale);
}

// ---- Results

Box3 ImportPlan::boxMm() const {
  const double scale = unit().scale_to_mm;
  Box3 out;
  out.add(scale * check_.box.min);
  out.add(scale * check_.box.max);
  return out;
}

double ImportPlan::rimMm() const {
  const auto& loops = check_.boundary_loops;
  return loops.empty() ? 0 : unit().scale_to_mm * loops[0].length;
}

std::size_t ImportPlan::rimCount() const {
  const auto& loops = check_.boundary_loops;
  const ClosingChoice& c = choice_.closing;
  if (loops.empty()) return 0;
  if (c.way == ClosingChoice::Way::kBase) return 1;
  const double scale = unit().scale_to_mm;
  const double longest_hole = c.holes_up_to_mm.value_or(CloseOptions{}.rim_to_diagonal * boxMm().size().norm());
  return static_cast<std::size_t>(std::count_if(loops.begin(), loops.end(), [&](const BoundaryLoop& loop) {
    constexpr std::size_t kTriangle = 3;  // a missing triangle of a coarse solid
    return scale * loop.length > longest_hole && (loop.edges > kTriangle || c.holes_up_to_mm);
  }));
}

Prediction ImportPlan::prediction() const {
  constexpr double kWithBase = 1.35;  // estimate before the preview
  const double scale = unit().scale_to_mm;
  const double area =
      preview() ? preview()->area_mm2 : check_.area * scale * scale * (isWithoutUnderside() ? kWithBase : 1);
  const double closing = previewSeconds() > 0 ? previewSeconds() : closingSeconds(check_.triangles, check_.isClosed());
  return predict(area, voxel(), closing + found_.seconds);
}

std::string ImportPlan::reasonOfUnit() const {
  const std::string& declared = found_.declared_unit;
  if (!choice_.unit.empty())
    return declared.empty() || declared == choice_.unit ? "as chosen" : phrase("as chosen; the file says {}", declared);
  if (!declared.empty()) return "as the file says";

  std::string others;
  for (const UnitOption& option : units_)
    if (option.is_plausible && option.unit != unit().unit) others += (others.empty() ? "" : ", ") + option.unit;
  if (!unit().is_plausible) return "unchanged, because no other unit fits alone; the file names no unit";
  if (unit().scale_to_mm != 1) return "the only unit with a dental size; the file names no unit";
  return unit_is_doubtful_ && !others.empty() ? phrase("by size, but {} would also fit; the file names no unit", others)
                                              : "by size; the file names no unit";
}

std::vector<Finding> ImportPlan::findings() const {
  const MeshReport& r = check_;
  std::vector<Finding> out;

  // Size and unit: the most frequent and worst errors.
  const Vec3d size = unit().size_mm;
  out.push_back({unit().is_plausible ? Weight::kFine : Weight::kDoubtful, "Size",
                 shownNumbers("{:.1f} x {:.1f} x {:.1f} mm{}", size[0], size[1], size[2],
                              shownText(unit().is_plausible ? "" : ": not a dental size. Check the unit"))});
  const double scale = unit().scale_to_mm;
  const std::string scaling = scale == 1 ? shownText("Not scaled") : phrase("Scaled by {:g}", scale);
  out.push_back({unit_is_doubtful_ ? Weight::kDoubtful : Weight::kFine, "Unit",
                 fmt::format("{}: {}. {}", unit().unit, shownText(reasonOfUnit()), scaling)});
  out.push_back({Weight::kFine, "Mesh",
                 fmt::format("{}, {}, {}", found_.format, counted(r.triangles, "triangle", "triangles"),
                             counted(r.pieces, "piece", "pieces"))});

  // Open or closed.
  if (r.isClosed()) {
    out.push_back({Weight::kFine, "Surface", "closed: a solid already"});
  } else {
    const std::size_t rims = rimCount(), holes = r.boundary_loops.size() - rims;
    if (rims > 0)
      out.push_back({Weight::kMended, "Surface",
                     rims > 1 ? phrase("open: the underside is missing, as in an intraoral scan. Kerf adds a flat base "
                                       "along {} rims, the longest {:.0f} mm",
                                       rims, rimMm())
                              : phrase("open: the underside is missing, as in an intraoral scan. Kerf adds a flat base "
                                       "along a rim of {:.0f} mm",
                                       rimMm())});
    else
      out.push_back({Weight::kMended, "Surface", "open: holes, but the underside is present"});
    if (holes > 0)
      out.push_back({Weight::kMended, "Holes",
                     phrase("{}, circumference up to {:.1f} mm: filled", counted(holes, "hole", "holes"),
                            unit().scale_to_mm * r.boundary_loops[rims].length)});
  }

  // Other defects.
  if (r.self_intersections > 0)
    out.push_back({Weight::kMended, "Crossings",
                   phrase("{}{} cross each other: united exactly",
                          shownText(r.self_intersections >= kMostCrossings ? "at least " : ""),
                          counted(r.self_intersections, "pair of triangles", "pairs of triangles"))});
  if (r.flipped_edges + r.inward_pieces > 0)
    out.push_back({Weight::kMended, "Inside out", "parts face inwards: flipped"});
  if (r.non_manifold_edges + r.non_manifold_vertices > 0)
    out.push_back({Weight::kMended, "Touching",
                   phrase("surfaces touch in {}: separated",
                          counted(r.non_manifold_edges + r.non_manifold_vertices, "place", "places"))});
  if (r.degenerate_triangles + r.duplicate_triangles > 0)
    out.push_back({Weight::kMended, "Degenerate",
                   phrase("{} without area or duplicate: removed",
                          counted(r.degenerate_triangles + r.duplicate_triangles, "triangle", "triangles"))});
  for (const std::string& note : found_.notes) out.push_back({Weight::kDoubtful, "File", note});
  return out;
}

// ---- The closed solid

bool ImportPlan::startsByItself() const {
  return choice_.closing.way != ClosingChoice::Way::kWrap && check_.triangles <= kByItselfUpTo;
}

std::unique_ptr<Job<ClosedPreview>> ImportPlan::makePreview() const {
  CloseOptions options = closeOptionsOf(choice_.closing);
  options.cleanup_length_mm = std::min(0.01 * voxel(), 0.1);  // as baking sets it
  return std::make_unique<Job<ClosedPreview>>(
      "closing " + found_.file.filename().string(),
      [mesh = found_.mesh, scale = unit().scale_to_mm, options](const Progress& progress) {
        return closed(*mesh, scale, options, progress);
      });
}

}  // namespace kerf
