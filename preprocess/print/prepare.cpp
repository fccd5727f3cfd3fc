#include "preprocess/print/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/solids.h"
#include "preprocess/print/base_face.h"
#include "preprocess/print/glyph_outlines.h"

namespace kerf {
namespace {

constexpr double kOnPlate = 0.999;   // cosine between the base and the plate
constexpr double kLeastPocket = 10;  // mm^3: letters on the plate are less

Error noBase() {
  return {.code = Error::Code::kGeometry,
          .place = "up",
          .found = "no flat base",
          .expected = "a flat face that the model stands on, or a direction",
          .hint = "a line such as up = [0, 0, 1] in the plan, or a base by kerf bake or kerf trim"};
}

// Bits of the positions; the source's are float32.
std::array<float, 3> keyOf(const Vec3d& p) {
  const Eigen::Vector3f f = p.cast<float>();
  return {f[0], f[1], f[2]};
}

std::size_t verticesKept(const Mesh& source, const Mesh& result) {
  std::vector<std::array<float, 3>> there;
  there.reserve(result.vertices.size());
  for (const Vec3d& p : result.vertices) there.push_back(keyOf(p));
  std::sort(there.begin(), there.end());
  return static_cast<std::size_t>(std::count_if(source.vertices.begin(), source.vertices.end(), [&](const Vec3d& p) {
    return std::binary_search(there.begin(), there.end(), keyOf(p));
  }));
}

// Runs the steps one after the other on its mesh.
class Preparation {
 public:
  Preparation(const Mesh& solid, Vec3d up, const std::map<std::string, std::string>& words)
      : mesh(solid), up_(std::move(up)), words_(words) {}

  Expected<StepReport> run(const HollowOptions& options, const Progress& progress) {
    KERF_TRY(done, hollow(mesh, options, progress));
    const WallNumbers& wall = done.wall;
    StepReport out{"hollow",
                   fmt::format("wall of {:.2f} mm: {:.3f} to {:.3f} mm for 5 to 95 % of it, least {:.3f} mm; {:.1f} % "
                               "within {:g} mm; {:.2f} ml of resin in place of {:.2f} ml",
                               options.wall_mm, wall.p05_mm, wall.p95_mm, wall.least_mm, 100 * wall.share_within,
                               kWallTolerance, 1e-3 * done.resin_mm3, 1e-3 * done.solid_mm3),
                   {{"wall_mm", options.wall_mm},
                    {"rounding_mm", options.rounding_mm},
                    {"voxel_mm", done.voxel_mm},
                    {"wall_least_mm", wall.least_mm},
                    {"wall_mean_mm", wall.mean_mm},
                    {"wall_p05_mm", wall.p05_mm},
                    {"wall_p95_mm", wall.p95_mm},
                    {"wall_share_within", wall.share_within},
                    {"solid_mm3", done.solid_mm3},
                    {"resin_mm3", done.resin_mm3},
                    {"cavities", static_cast<double>(done.cavities)},
                    {"cavities_dropped", static_cast<double>(done.cavities_dropped)},
                    {"shells_swallowed", static_cast<double>(done.shells_swallowed)}},
                   {}};
    if (done.cavities_dropped > 0)
      out.warnings.push_back(fmt::format("{} cavities below {:g} mm3 stay full, {:.1f} mm3 together",
                                         done.cavities_dropped, options.least_cavity_mm3, done.dropped_mm3));
    if (done.shells_swallowed > 0)
      out.warnings.push_back(
          fmt::format("{} cavities of the source are part of the new cavity now", done.shells_swallowed));
    mesh = std::move(done.mesh);
    return out;
  }

  Expected<StepReport> run(DrainOptions options, const Progress& progress) {
    options.build_direction = up_;
    KERF_TRY(plan, placeDrains(mesh, options, partOf(progress, 0, 0.4)));
    std::vector<RoundHole> holes;
    std::size_t below = 0;
    for (const Drain& drain : plan.drains) {
      holes.push_back(drain.hole);
      below += drain.is_below ? 1 : 0;
    }
    KERF_TRY(done, drained(mesh, holes, partOf(progress, 0.4, 1)));
    StepReport out{
        "drain",
        fmt::format("drains of {:g} mm: {}, {} of them from below; cavities opened: {} of {}", options.diameter_mm,
                    holes.size(), below, plan.cavities.size() - done.cavities_left, plan.cavities.size()),
        {{"drains", static_cast<double>(holes.size())},
         {"drains_from_below", static_cast<double>(below)},
         {"diameter_mm", options.diameter_mm},
         {"cavities", static_cast<double>(plan.cavities.size())},
         {"cavities_left", static_cast<double>(done.cavities_left)},
         {"removed_mm3", done.removed_mm3}},
        {}};
    for (std::size_t n = 0; n < plan.drains.size(); ++n) {
      const Vec3d& mouth = plan.drains[n].hole.mouth;
      for (int axis = 0; axis < 3; ++axis) out.numbers[fmt::format("drain_{}_{}_mm", n + 1, "xyz"[axis])] = mouth[axis];
    }
    if (holes.size() < plan.cavities.size() * options.count && options.at.empty())
      out.warnings.push_back(fmt::format("room for {} of {} drains; one drain alone lets no air in", holes.size(),
                                         plan.cavities.size() * options.count));
    if (options.side == DrainSide::kUnderside && below < holes.size())
      out.warnings.push_back(
          fmt::format("{} drains lead through the nearest wall: no place from below", holes.size() - below));
    mesh = std::move(done.mesh);
    return out;
  }

  Expected<StepReport> run(const LabelStep& step, const Progress& progress) {
    LabelOptions label = step.label;
    if (label.embossed && step.face == LabelFace::kUnderside)
      return fail({.code = Error::Code::kBadValue,
                   .place = "embossed",
                   .found = "raised letters on the underside",
                   .expected = "an engraved label there: the model would stand on its letters",
                   .hint = "embossed = false, or on = \"side\""});
    KERF_TRY(text, withPlaceholders(label.text, words_));
    label.text = std::move(text);
    KERF_TRY(place, placeLabel(mesh, -up_, step.face, label, partOf(progress, 0, 0.4)));
    KERF_TRY(done, withLabel(mesh, place.label, partOf(progress, 0.4, 1)));
    const LabelReport& r = done.report;
    StepReport out{
        "label",
        fmt::format("\"{}\" {}, capitals of {:.2f} mm, {:.2f} to {:.2f} mm {}", place.label.text,
                    step.face == LabelFace::kSide ? "on the side" : "on the underside", place.label.height_mm,
                    r.least_depth_mm, r.most_depth_mm, label.embossed ? "high" : "deep"),
        {{"height_mm", place.label.height_mm},
         {"depth_least_mm", r.least_depth_mm},
         {"depth_most_mm", r.most_depth_mm},
         {"stroke_least_mm", r.least_stroke_mm},
         {"volume_mm3", r.volume_mm3}},
        r.warnings};
    if (!place.note.empty()) out.warnings.push_back(place.note);
    mesh = std::move(done.part.mesh);
    return out;
  }

  Mesh mesh;

 private:
  Vec3d up_;
  const std::map<std::string, std::string>& words_;
};

const char* nameOf(const PrintStep& step) {
  constexpr std::array kNames{"hollow", "drain", "label"};
  static_assert(kNames.size() == std::variant_size_v<PrintStep>);
  return kNames[step.index()];
}

}  // namespace

namespace {

// Of a mesh file: vertices of no triangle would count in boxes and heights.
Mesh withoutUnused(const Mesh& mesh) { return subset(mesh, std::vector<char>(mesh.triangles.size(), 1)); }

Error inStep(Error error, std::size_t n, const PrintStep& step) {
  error.place = fmt::format("step {}, {}{}{}", n + 1, nameOf(step), error.place.empty() ? "" : ": ", error.place);
  return error;
}

// The texts of all labels, before the work of the steps.
Expected<void> checkTexts(const PrintPlan& plan, const std::map<std::string, std::string>& words) {
  for (std::size_t n = 0; n < plan.steps.size(); ++n) {
    const auto* const step = std::get_if<LabelStep>(&plan.steps[n]);
    if (!step) continue;
    auto checked = [&]() -> Expected<void> {
      KERF_TRY(text, withPlaceholders(step->label.text, words));
      KERF_CHECK(internal::glyphOutlines(text, step->label.height_mm, step->label.align, step->label.font));
      return {};
    }();
    if (!checked) return fail(inStep(std::move(checked).error(), n, plan.steps[n]));
  }
  return {};
}

}  // namespace

Expected<Prepared> prepareForPrint(const Mesh& source, const PrintPlan& plan,
                                   const std::map<std::string, std::string>& words, const Progress& progress) {
  KERF_CHECK(checkTexts(plan, words));
  const Mesh solid = withoutUnused(source);
  const auto base = findBase(solid, plan.up ? Vec3d(-*plan.up) : Vec3d(Vec3d::Zero()));
  if (!plan.up && !base) return fail(noBase());
  Prepared out;
  out.up = plan.up ? *plan.up : Vec3d(-base->plane.normal);
  out.source_mm3 = signedVolume(solid);

  std::optional<PrintBed> bed;
  if (!plan.to_bed.empty()) {
    KERF_TRY(found, printBedOf(plan.to_bed));
    bed = std::move(found);
  }

  Preparation run(solid, out.up, words);
  const double share = 0.8 / static_cast<double>(std::max<std::size_t>(plan.steps.size(), 1));
  for (std::size_t n = 0; n < plan.steps.size(); ++n) {
    const Progress part = partOf(progress, share * static_cast<double>(n), share * static_cast<double>(n + 1));
    auto report = std::visit([&](const auto& step) { return run.run(step, part); }, plan.steps[n]);
    if (!report) return fail(inStep(std::move(report).error(), n, plan.steps[n]));
    out.steps.push_back(std::move(*report));
  }

  out.source_vertices_kept = verticesKept(solid, run.mesh);
  const auto stands_on = findBase(run.mesh, -out.up);
  out.on_plate = stands_on && -stands_on->plane.normal.dot(out.up) > kOnPlate;
  if (bed) {
    KERF_TRY(laid, laidOnBed(run.mesh, out.up, *bed, partOf(progress, 0.8, 0.85), plan.up.has_value()));
    run.mesh = std::move(laid.mesh);
    out.laid = std::move(laid.pieces);
    out.up = Vec3d::UnitZ();
    out.on_plate =
        std::all_of(out.laid.begin(), out.laid.end(), [](const LaidPiece& piece) { return piece.is_on_base; });
  }

  if (!report(progress, 0.85, "checking")) return cancelled();
  const MeshReport check = checkMesh(run.mesh);
  if (!check.print_ready)
    return fail({.code = Error::Code::kGeometry,
                 .place = "check of the result",
                 .found = check.reasons.empty() ? "not ready to print" : check.reasons.front(),
                 .expected = "a printable mesh",
                 .hint = "another wall, or other places of drains and labels"});
  PocketOptions pockets;
  pockets.direction = out.up;
  pockets.on_plate = out.on_plate;
  pockets.least_mm3 = kLeastPocket;
  KERF_TRY(found, findPockets(run.mesh, pockets, partOf(progress, 0.9, 1)));
  out.pockets = std::move(found);
  out.resin_mm3 = signedVolume(run.mesh);
  out.mesh = std::move(run.mesh);
  return out;
}

}  // namespace kerf
