// kerf compare: deviations of two meshes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/base/atomic_file.h"
#include "geometry/compare/comparison.h"
#include "geometry/compare/deviation_picture.h"
#include "geometry/compare/rigid_fit.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/unit/unit.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "ui/app/view/mesh_in_mm.h"
#include "ui/cli/command.h"
#include "ui/cli/solid_source.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct CompareArguments {
  std::string first, second, unit, onto = "second";
  std::vector<std::string> outputs;
  double tolerance_mm = 0.1, range_mm = 0;  // 0: by the deviations
  bool aligns = false, overwrites = false, json = false;
};

// ---- The two meshes

struct Side {
  std::string name;
  Mesh mesh;
  std::optional<MeshDistance> distance;
  double volume_mm3 = 0;  // if closed

  bool isClosed() const { return distance->isClosed(); }
};

struct Sides {
  Side first, second;
  std::vector<std::string> notes;
  std::optional<RigidFit> fit;  // the second mesh was moved by it
  Vec3d shift = Vec3d::Zero();  // of its middle, mm
};

void note(Sides& sides, std::string text) { sides.notes.push_back(std::move(text)); }

Expected<Side> readSide(const std::string& name, const CompareArguments& a, Sides& sides) {
  Side out{.name = name, .mesh = {}, .distance = {}};
  if (isRun(name) || isCase(name)) {
    KERF_TRY(exported, [&] {
      TerminalProgress progress;
      return exportBundle(name, {}, progress.callback());
    }());
    out.mesh = std::move(exported.post_op.mesh);
    if (std::any_of(exported.pieces.begin(), exported.pieces.end(), [](const auto& p) { return p.isMoved(); }))
      note(sides, name + ": pieces are compared at their scan positions, not where they were moved");
  } else {
    KERF_TRY(read, readMeshInMm(name, a.unit));
    out.mesh = std::move(read.mesh);
    if (!read.note.empty()) note(sides, name + ": " + read.note);
  }
  out.distance.emplace(out.mesh);
  if (!out.isClosed()) return out;
  out.volume_mm3 = signedVolume(out.mesh);
  if (out.volume_mm3 >= 0) return out;
  return fail({.code = Error::Code::kGeometry,
               .file = name,
               .found = "a closed mesh that is inside out",
               .expected = "triangles turned outwards",
               .hint = fmt::format("kerf bake {} -o {}.case, which turns them", name, fs::path(name).stem().string())});
}

double degrees(double rad) { return rad * 180 / std::numbers::pi; }

// Of the middle of the mesh, mm.
Vec3d shiftOf(const RigidFit& fit, const Side& second) {
  const Vec3d middle = second.distance->bounds().center();
  return fit.T_first_second * middle - middle;
}

Expected<void> align(Sides& sides) {
  KERF_TRY(fit, [&] {
    TerminalProgress progress(false);
    return fitRigidly(sides.first.mesh, *sides.first.distance, sides.second.mesh, *sides.second.distance, {},
                      progress.callback());
  }());
  if (fit.free_motions)
    note(sides, fmt::format("--align: {} leave the fit unchanged, so the pose is not certain",
                            counted(static_cast<std::size_t>(fit.free_motions), "motion")));
  constexpr double kFew = 0.5;
  if (static_cast<double>(fit.kept) < kFew * static_cast<double>(fit.samples))
    note(sides, fmt::format("CHECK THE FIT: only {} of {} samples have a partner", fit.kept, fit.samples));
  constexpr double kFar = 0.005;  // of the size: models of one object fit better
  if (const double size = sides.first.distance->bounds().size().norm(); fit.median_mm > kFar * size)
    note(sides,
         fmt::format("CHECK THE FIT: half of the surface deviates by more than {:.3g} mm; these may be models of "
                     "two objects",
                     fit.median_mm));
  sides.fit = fit;
  sides.shift = shiftOf(fit, sides.second);
  for (Vec3d& p : sides.second.mesh.vertices) p = fit.T_first_second * p;
  sides.second.distance.emplace(sides.second.mesh);
  return {};
}

// Nothing moves without --align. An error or a warning if the meshes seem to lie in different frames.
Expected<void> requireOneFrame(Sides& sides) {
  const Box3 &a = sides.first.distance->bounds(), &b = sides.second.distance->bounds();
  if ((a.min.array() > b.max.array()).any() || (b.min.array() > a.max.array()).any())
    return fail(
        {.code = Error::Code::kGeometry,
         .file = sides.second.name,
         .found = fmt::format("it lies {:.3g} mm beside {}", (a.center() - b.center()).norm(), sides.first.name),
         .expected = "two meshes in one frame",
         .hint = "--align, which moves the second mesh onto the first and reports the residual"});
  const auto fit = fitRigidly(sides.first.mesh, *sides.first.distance, sides.second.mesh, *sides.second.distance,
                              {.samples = 1000, .from_anywhere = false});
  constexpr double kSeen = 0.01;  // mm
  if (!fit || fit->before_mm < kSeen || fit->median_mm > 0.5 * fit->before_mm) return {};
  note(sides,
       fmt::format("CHECK THE FRAME: half of the surface deviates by more than {:.3g} mm; turned by {:.3g} "
                   "degrees and shifted by {:.3g} mm, by {:.3g} mm: --align",
                   fit->before_mm, degrees(fit->rotation()), shiftOf(*fit, sides.second).norm(), fit->median_mm));
  return {};
}

// ---- Output

json deviationJson(const Deviations& d) {
  const auto at = [](const DeviationAt& e) { return json{{"mm", e.mm}, {"at_mm", {e.at[0], e.at[1], e.at[2]}}}; };
  return {{"area_mm2", d.area_mm2}, {"excluded_mm2", d.excluded_mm2},
          {"mean_mm", d.mean_mm},   {"mean_abs_mm", d.mean_abs_mm},
          {"rms_mm", d.rms_mm},     {"p95_mm", d.p95_mm},
          {"most", at(d.most)},     {"least", at(d.least)},
          {"within", d.within},     {"over", d.over},
          {"under", d.under},       {"unchanged", d.unchanged},
          {"samples", d.samples},   {"spacing_mm", d.spacing_mm}};
}

json fitJson(const RigidFit& fit, const Vec3d& shift) {
  const Vec3d& t = fit.T_first_second.translation;
  const Eigen::Quaterniond& q = fit.T_first_second.rotation;
  return {{"rotation_deg", degrees(fit.rotation())},
          {"translation_mm", {shift[0], shift[1], shift[2]}},
          {"pose", {{"position_mm", {t[0], t[1], t[2]}}, {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}}},
          {"before_mm", fit.before_mm},
          {"median_mm", fit.median_mm},
          {"rms_mm", fit.rms_mm},
          {"samples", fit.samples},
          {"kept", fit.kept},
          {"free_motions", fit.free_motions}};
}

std::vector<std::string> linesOf(const Deviations& d, double tolerance_mm) {
  const auto at = [](const DeviationAt& e) {
    return fmt::format("{:+.4f} mm at ({:.2f}, {:.2f}, {:.2f})", e.mm, e.at[0], e.at[1], e.at[2]);
  };
  std::vector<std::string> out{
      fmt::format("mean {:+.4f} mm, RMS {:.4f} mm, 95 % within {:.4f} mm", d.mean_mm, d.rms_mm, d.p95_mm),
      fmt::format("{:.2f} % of {:.2f} mm2 within {:g} mm, {:.2f} % over, {:.2f} % under; {:.2f} % unchanged",
                  100 * d.within, d.area_mm2, tolerance_mm, 100 * d.over, 100 * d.under, 100 * d.unchanged),
      fmt::format("largest {}; smallest {}", at(d.most), at(d.least))};
  if (d.excluded_mm2 > 0)
    out.push_back(
        fmt::format("left out {:.2f} mm2, which only the boundary of the other mesh is near to", d.excluded_mm2));
  return out;
}

std::string fitLine(const RigidFit& fit, Vec3d shift) {
  constexpr double kShown = 5e-5;  // smaller ones are not printed as -0.0000
  for (double& mm : shift) mm = std::abs(mm) < kShown ? 0 : mm;
  return fmt::format(
      "aligned: second mesh turned by {:.4f} degrees, shifted by ({:.4f}, {:.4f}, {:.4f}) mm; residual RMS {:.5f} mm "
      "of "
      "{} of {} samples, median of all {:.5f} mm",
      degrees(fit.rotation()), shift[0], shift[1], shift[2], fit.rms_mm, fit.kept, fit.samples, fit.median_mm);
}

std::string endingOf(const std::string& file) {
  std::string out = fs::path(file).extension().string();
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

Expected<void> writeText(const std::string& path, const std::string& text) {
  KERF_TRY(file, AtomicFile::create(path));
  file.stream() << text;
  return file.commit();
}

std::string csvOf(const Mesh& mesh, const Deviations& d) {
  std::string out = "x_mm,y_mm,z_mm,deviation_mm\n";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3d& p = mesh.vertices[v];
    const float mm = d.at_vertex[v];
    out += fmt::format("{},{},{},{}\n", static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]),
                       std::isnan(mm) ? "" : fmt::format("{}", mm));
  }
  return out;
}

Expected<void> writeOutputs(const CompareArguments& a, const Sides& sides, const Comparison& comparison) {
  const bool is_second = a.onto == "second";
  const Deviations& d = is_second ? comparison.of_second : comparison.of_first;
  const Side& side = is_second ? sides.second : sides.first;
  DeviationScale scale = DeviationScale::of(comparison, a.tolerance_mm);
  if (a.range_mm > 0) scale.range_mm = a.range_mm;
  for (const std::string& path : a.outputs) {
    const std::string ending = endingOf(path);
    if (ending == ".csv") {
      KERF_CHECK(writeText(path, csvOf(side.mesh, d)));
    } else if (ending == ".svg") {
      DeviationPicture picture{fmt::format("{} against {}", fs::path(sides.second.name).filename().string(),
                                           fs::path(sides.first.name).filename().string()),
                               fmt::format("shown on {}", fs::path(side.name).filename().string()),
                               linesOf(d, a.tolerance_mm)};
      if (sides.fit) picture.lines.push_back(fitLine(*sides.fit, sides.shift));
      KERF_CHECK(writeText(path, drawDeviations(side.mesh, d, scale, picture)));
    } else {
      Mesh painted = side.mesh;
      painted.face_colors.clear();
      painted.vertex_colors = vertexColours(d, scale);
      KERF_CHECK(writeMesh(path, painted, {.vertex_quality = d.at_vertex}));
    }
  }
  return {};
}

Expected<void> requireWritable(const CompareArguments& a) {
  for (const std::string& path : a.outputs) {
    const std::string ending = endingOf(path);
    if (ending != ".ply" && ending != ".csv" && ending != ".svg")
      return fail({.code = Error::Code::kBadValue,
                   .place = "-o",
                   .found = "\"" + path + "\"",
                   .expected = "a name that ends in .ply, .svg or .csv",
                   .hint = fs::path(path).replace_extension(".ply").string()});
    for (const std::string& input : {a.first, a.second}) KERF_CHECK(requireNotInput(input, path));
    KERF_CHECK(requireFree(path, a.overwrites));
    KERF_CHECK(canWriteFile(path));
  }
  return {};
}

void printComparison(const CompareArguments& a, const Sides& sides, const Comparison& c) {
  if (sides.fit) printText("{}\n", fitLine(*sides.fit, sides.shift));
  const auto block = [&](const Side& of, const Side& from, const Deviations& d) {
    printText("{} from {}:\n", of.name, from.name);
    for (const std::string& line : linesOf(d, a.tolerance_mm)) printText("  {}\n", line);
  };
  block(sides.second, sides.first, c.of_second);
  block(sides.first, sides.second, c.of_first);
  printText("Hausdorff distance: {:.4f} mm, sampled every {:.3f} mm\n", c.hausdorff_mm(),
            std::max(c.of_first.spacing_mm, c.of_second.spacing_mm));
  if (sides.first.isClosed() && sides.second.isClosed())
    printText("volume: {:.4f} mm3 - {:.4f} mm3 = {:+.4f} mm3\n", sides.second.volume_mm3, sides.first.volume_mm3,
              sides.second.volume_mm3 - sides.first.volume_mm3);
  for (const std::string& path : a.outputs) printText("written: {}\n", path);
}

json comparisonJson(const CompareArguments& a, const Sides& sides, const Comparison& c) {
  const auto side = [](const Side& s) {
    json out{{"file", s.name}, {"closed", s.isClosed()}, {"triangles", s.mesh.triangles.size()}};
    if (s.isClosed()) out["volume_mm3"] = s.volume_mm3;
    return out;
  };
  json out{{"first", side(sides.first)},
           {"second", side(sides.second)},
           {"tolerance_mm", a.tolerance_mm},
           {"second_from_first", deviationJson(c.of_second)},
           {"first_from_second", deviationJson(c.of_first)},
           {"hausdorff_mm", c.hausdorff_mm()},
           {"files", a.outputs},
           {"notes", sides.notes}};
  if (sides.first.isClosed() && sides.second.isClosed())
    out["volume_difference_mm3"] = sides.second.volume_mm3 - sides.first.volume_mm3;
  if (sides.fit) out["fit"] = fitJson(*sides.fit, sides.shift);
  return out;
}

Expected<void> compare(const CompareArguments& a) {
  KERF_CHECK(requireWritable(a));
  Sides sides;
  KERF_TRY(first, readSide(a.first, a, sides));
  sides.first = std::move(first);
  KERF_TRY(second, readSide(a.second, a, sides));
  sides.second = std::move(second);
  if (a.aligns)
    KERF_CHECK(align(sides));
  else
    KERF_CHECK(requireOneFrame(sides));

  KERF_TRY(comparison, [&] {
    TerminalProgress progress(false);
    return compareMeshes(sides.first.mesh, *sides.first.distance, sides.second.mesh, *sides.second.distance,
                         {.tolerance_mm = a.tolerance_mm}, progress.callback());
  }());
  if (comparison.of_second.normals_agree < 0)
    note(sides, "CHECK THE SIGN: the surfaces face opposite ways, so one mesh is inside out");

  const TerminalProgress guard;  // Ctrl-C waits for complete files
  KERF_CHECK(writeOutputs(a, sides, comparison));
  for (const std::string& text : sides.notes) printText(stderr, "kerf: {}\n", text);
  if (a.json)
    printJson(comparisonJson(a, sides, comparison));
  else
    printComparison(a, sides, comparison);
  return {};
}

constexpr double kLeastTolerance = 1e-4, kMostTolerance = 10;  // mm

}  // namespace

void addCompare(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<CompareArguments>();
  command.footer(
      "Positive deviations: the second mesh has material too much; negative: it lacks material. Both ways are "
      "measured,\n"
      "weighted by area. An open scan has deviations by the side of its nearest triangle; points beside its boundary "
      "are "
      "left out.\n"
      "Nothing moves without --align, and nothing is scaled.\n"
      "Examples:\n"
      "  kerf compare molar.case molar.run -o removed.ply -o removed.svg\n"
      "  kerf compare planned.stl scan-of-print.stl --align --tolerance 0.05 -o map.ply --json");
  command.add_option("FIRST", a->first, "planned or before: a mesh, a case or a run")->required();
  command.add_option("SECOND", a->second, "achieved or after: a mesh, a case or a run")->required();
  command
      .add_option("-o,--output", a->outputs,
                  "map to write: .ply in colours, with the deviation as property quality; .svg from six sides with "
                  "histogram; .csv by vertex. Repeat for several")
      ->type_name("FILE")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--onto", a->onto, "mesh that the map shows: first or second")
      ->check(CLI::IsMember({"first", "second"}))
      ->capture_default_str();
  command.add_option("--tolerance", a->tolerance_mm, "half width of the neutral band, mm")
      ->type_name("MM")
      ->check(CLI::Range(kLeastTolerance, kMostTolerance))
      ->capture_default_str();
  command.add_option("--range", a->range_mm, "deviation of the darkest colour, mm (default: of 99 % of the area)")
      ->type_name("MM")
      ->check(CLI::PositiveNumber);
  command.add_flag(
      "--align", a->aligns,
      "move the second mesh onto the first before: a rigid fit of their common surface, with its residual");
  command
      .add_option("--unit", a->unit,
                  "unit of both meshes: mm, cm, m, um or inch (default: the declared unit, or by size)")
      ->type_name("UNIT")
      ->check(CLI::IsMember(unitNames()));
  addOverwrite(command, a->overwrites, "replace existing files");
  addCasePlaces(command);
  command.add_flag("--json", a->json, "print the numbers as JSON on standard output");
  command.callback([a, &exit_code] {
    if (a->range_mm > 0 && a->range_mm <= a->tolerance_mm) {
      exit_code = complainOfUsage({.code = Error::Code::kBadValue,
                                   .place = "--range",
                                   .found = fmt::format("{:g} mm", a->range_mm),
                                   .expected = fmt::format("more than the tolerance, {:g} mm", a->tolerance_mm),
                                   .hint = "omit it"});
      return;
    }
    const auto compared = compare(*a);
    exit_code = compared ? kOk : complain(compared.error());
  });
}

}  // namespace kerf::cli
