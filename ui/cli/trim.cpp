// kerf trim: a solid cut by planes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/boolean/plane_cut.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/solids.h"
#include "preprocess/unit/unit.h"
#include "ui/app/saw/plane_words.h"
#include "ui/app/saw/saw_plan.h"
#include "ui/cli/command.h"
#include "ui/cli/solid_source.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct TrimArguments {
  std::string what, plan, box, between, keep = "both", unit;
  std::vector<std::string> planes, outputs;
  std::vector<double> hole;  // empty: none
  double kerf_mm = 0;
  bool overwrites = false, json = false;
};

// ---- The cutting planes

struct Cut {
  std::vector<Plane> planes;
  PlaneCutOptions options;
  std::array<const char*, 2> names{"above", "below"};  // of the two parts, in files
  std::string note;                                    // about a plan of 3D Slicer
};

Error wrongTrimOption(const char* option, const std::string& found, const char* expected, const char* hint) {
  return {.code = Error::Code::kBadValue,
          .place = option,
          .found = "\"" + found + "\"",
          .expected = expected,
          .hint = hint};
}

// Six planes around the box between two corners.
Expected<void> addBox(const std::string& word, Cut& cut) {
  KERF_TRY(corners, twoPointsOfWord(word, "--box"));
  Box3 box;
  box.add(corners[0]);
  box.add(corners[1]);
  if (!(box.size().minCoeff() > 0))
    return fail(wrongTrimOption("--box", word, "two corners that differ in x, y and z", "-8,30,-20/2,42,20"));
  for (int axis = 0; axis < 3; ++axis) {
    cut.planes.push_back({box.min, Vec3d::Unit(axis)});
    cut.planes.push_back({box.max, -Vec3d::Unit(axis)});
  }
  return {};
}

// A plane through each point, perpendicular to their connection: cuts off the part between them.
Expected<void> addBetween(const std::string& word, Cut& cut) {
  KERF_TRY(ends, twoPointsOfWord(word, "--between"));
  const Vec3d way = ends[1] - ends[0];
  constexpr double kLeast = 0.1;  // mm
  if (!(way.norm() > kLeast))
    return fail(wrongTrimOption("--between", word, "two points more than 0.1 mm apart", "-8,40,3/2,42,3"));
  cut.planes.push_back({ends[0], way.normalized()});
  cut.planes.push_back({ends[1], -way.normalized()});
  cut.options.piece_at = 0.5 * (ends[0] + ends[1]);
  return {};
}

// Slicer writes the frame into its mesh files, into the first lines or the header.
Expected<void> requireLps(const TrimArguments& a) {
  constexpr std::size_t kHeader = 512;
  std::string begin(kHeader, '\0');
  std::ifstream(a.what, std::ios::binary).read(begin.data(), kHeader);
  if (begin.find("SPACE=RAS") == std::string::npos) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = a.what,
               .place = "header",
               .found = "SPACE=RAS",
               .expected = "a mesh in LPS, the frame of the planes",
               .hint = "export the mesh from 3D Slicer in LPS, its default"});
}

std::string slicerNote(const PlanOrigin& origin, std::size_t planes) {
  std::string out = fmt::format("{} of 3D Slicer in {}: {}", counted(planes, "plane"), origin.frame,
                                origin.isTurned() ? "x and y of RAS negated, to LPS" : "as written");
  if (origin.others) out += fmt::format("; left out {}", counted(origin.others, "other markup"));
  return out;
}

Expected<Cut> cutOf(const TrimArguments& a, const Mesh& solid) {
  Cut out;
  for (const std::string& word : a.planes) {
    KERF_TRY(plane, planeOfWord(word, solid, "--plane"));
    out.planes.push_back(plane);
  }
  if (!a.plan.empty()) {
    SawPlan plan;
    KERF_TRY(origin, plan.load(a.plan));
    if (!origin.frame.empty()) {
      KERF_CHECK(requireLps(a));
      out.note = slicerNote(origin, plan.planes().size());
    }
    for (const SawPlane& plane : plan.planes()) out.planes.push_back({plane.point, plane.normal});
  }
  if (!a.box.empty()) KERF_CHECK(addBox(a.box, out));
  if (!a.between.empty()) KERF_CHECK(addBetween(a.between, out));
  if (!a.box.empty() || !a.between.empty()) out.names = {"die", "rest"};
  out.options.kerf_mm = a.kerf_mm;
  return out;
}

// ---- Output

struct TrimOutput {
  std::string path;
  const PostOpMesh* part;
};

fs::path named(const fs::path& file, const char* part) {
  fs::path out = file;
  return out.replace_filename(fmt::format("{}-{}{}", file.stem().string(), part, file.extension().string()));
}

bool keepsFirst(const TrimArguments& a) { return a.keep == "both" || a.keep == "above" || a.keep == "die"; }
bool keepsSecond(const TrimArguments& a) { return a.keep == "both" || a.keep == "below" || a.keep == "rest"; }

std::vector<TrimOutput> trimOutputsOf(const TrimArguments& a, const Cut& cut, const PlaneCut& result) {
  std::vector<TrimOutput> out;
  const bool is_both = keepsFirst(a) && keepsSecond(a);
  for (const std::string& path : a.outputs) {
    if (keepsFirst(a)) out.push_back({is_both ? named(path, cut.names[0]).string() : path, &result.above});
    if (keepsSecond(a)) out.push_back({is_both ? named(path, cut.names[1]).string() : path, &result.rest});
  }
  return out;
}

// One piece of a part: several planes may cut off more than the intended one.
struct PieceAt {
  double volume_mm3 = 0;
  Vec3d middle = Vec3d::Zero();
};

std::vector<PieceAt> piecesAt(const Mesh& mesh) {
  const Solids solids = solidsOf(mesh);
  std::vector<PieceAt> out(solids.count);
  const Vec3d c = bounds(mesh).center();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d p = mesh.corner(t, 0) - c, q = mesh.corner(t, 1) - c, r = mesh.corner(t, 2) - c;
    const double volume = p.dot(q.cross(r)) / 6;
    out[solids.label[t]].volume_mm3 += volume;
    out[solids.label[t]].middle += volume / 4 * (p + q + r);
  }
  for (PieceAt& piece : out) piece.middle = c + piece.middle / piece.volume_mm3;
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.volume_mm3 > b.volume_mm3; });
  return out;
}

json trimJson(const char* name, const PostOpMesh& part) {
  const PostOpReport& r = part.report;
  json pieces = json::array();
  for (const PieceAt& piece : piecesAt(part.mesh))
    pieces.push_back(
        {{"volume_mm3", piece.volume_mm3}, {"middle_mm", {piece.middle[0], piece.middle[1], piece.middle[2]}}});
  return {{"part", name},
          {"volume_mm3", r.result_volume_mm3},
          {"pieces", r.pieces},
          {"pieces_at", pieces},
          {"vertices", part.mesh.vertices.size()},
          {"triangles", part.mesh.triangles.size()},
          {"source_vertices_kept", r.source_vertices_kept},
          {"cut_triangles", r.cut_triangles},
          {"crumbs_dropped", r.crumbs_dropped},
          {"crumbs_volume_mm3", r.crumbs_volume_mm3}};
}

json trimJson(const Cut& cut, const SolidSource& source, const PlaneCut& result,
              const std::vector<TrimOutput>& outputs) {
  json planes = json::array(), files = json::array();
  for (const Plane& p : cut.planes)
    planes.push_back(
        {{"point_mm", {p.point[0], p.point[1], p.point[2]}}, {"normal", {p.normal[0], p.normal[1], p.normal[2]}}});
  for (const TrimOutput& output : outputs) files.push_back(output.path);
  json j{{"files", files},
         {"planes", planes},
         {"source_volume_mm3", result.above.report.source_volume_mm3},
         {"parts", {trimJson(cut.names[0], result.above), trimJson(cut.names[1], result.rest)}},
         {"flatness_mm", result.flatness_mm},
         {"shift_mm", result.shift_mm},
         {"attempts", result.attempts}};
  if (!source.note.empty()) j["note"] = source.note;
  return j;
}

void printTrim(const TrimArguments& a, const Cut& cut, const PlaneCut& result, const std::vector<TrimOutput>& outputs) {
  const auto line = [](const char* name, const PostOpMesh& part, bool is_kept) {
    const PostOpReport& r = part.report;
    printText("{}: {:.4f} mm3 in {}{}; {} vertices of the solid kept bit for bit\n", name, r.result_volume_mm3,
              counted(r.pieces, "piece"), is_kept ? "" : ", cut off", r.source_vertices_kept);
    if (r.pieces > 1)
      for (const PieceAt& piece : piecesAt(part.mesh))
        printText("  {:.4f} mm3 around ({:.2f}, {:.2f}, {:.2f}) mm\n", piece.volume_mm3, piece.middle[0],
                  piece.middle[1], piece.middle[2]);
    if (r.crumbs_dropped)
      printText("  dropped {} below {:.2g} mm3, {:.6f} mm3 together\n", counted(r.crumbs_dropped, "crumb"), r.crumb_mm3,
                r.crumbs_volume_mm3);
  };
  for (const Plane& plane : cut.planes)
    printText("cut along {:.5f},{:.5f},{:.5f}@{:.4f},{:.4f},{:.4f} (normal @ point, mm)\n", plane.normal[0],
              plane.normal[1], plane.normal[2], plane.point[0], plane.point[1], plane.point[2]);
  line(cut.names[0], result.above, keepsFirst(a));
  line(cut.names[1], result.rest, keepsSecond(a));
  printText("the cut faces are flat to {:.3f} um\n", 1e3 * result.flatness_mm);
  if (result.shift_mm > 0)
    printText("the cut was moved by {:.2f} um along its normals to survive float32\n", 1e3 * result.shift_mm);
  for (const TrimOutput& output : outputs) printText("written: {}\n", output.path);
}

// In both parts, as a session does it.
Expected<void> drill(const TrimArguments& a, PlaneCut& cut, const PostOpOptions& options) {
  if (a.hole.empty()) return {};
  const std::vector<double>& v = a.hole;
  const RoundHole hole{{v[5], v[6], v[7]}, Vec3d(v[2], v[3], v[4]).stableNormalized(), v[0], v[1]};
  if (!hole.isUsable())
    return fail(wrongTrimOption("--hole", fmt::format("{}", fmt::join(v, ",")),
                                "a diameter of 0.3 to 20 mm, a depth up to 200 mm, a direction and a point",
                                "2,11,0,0,1,21,26,-25"));
  constexpr double kLeast = 1e-3;  // mm^3: a mouth that only touches the surface is no hole
  bool is_met = false;
  for (PostOpMesh* const part : {&cut.above, &cut.rest}) {
    KERF_TRY(drilled, withHole(part->mesh, hole, options));
    is_met |= drilled && signedVolume(part->mesh) - signedVolume(drilled->mesh) > kLeast;
    if (drilled) *part = std::move(*drilled);
  }
  if (is_met) return {};
  return fail(wrongTrimOption("--hole", fmt::format("{}: it meets no part", fmt::join(v, ",")),
                              "a mouth on the solid, and a direction into the material", "2,11,0,0,1,21,26,-25"));
}

Expected<void> trim(const TrimArguments& a) {
  for (const std::string& path : a.outputs) KERF_CHECK(canWriteMesh(path));
  KERF_TRY(source, readSolid(a.what, a.unit));
  KERF_TRY(cut, cutOf(a, source.solid));
  auto result = [&] {
    TerminalProgress progress;
    return cutByPlanes(source.solid, cut.planes, cut.options, progress.callback());
  }();
  if (!result) {
    result.error().file = a.what;
    return fail(std::move(result).error());
  }
  KERF_CHECK(drill(a, *result, cut.options.post_op));

  if (!cut.note.empty()) source.note += (source.note.empty() ? "" : "; ") + cut.note;

  const TerminalProgress guard;  // Ctrl-C waits for complete files
  const std::vector<TrimOutput> outputs = trimOutputsOf(a, cut, *result);
  for (const TrimOutput& output : outputs) {
    KERF_CHECK(requireNotInput(a.what, output.path));
    KERF_CHECK(requireFree(output.path, a.overwrites));
  }
  for (const TrimOutput& output : outputs) {
    const NamedMesh named = source.names.grouped(output.part->mesh, output.path);
    KERF_CHECK(writeMesh(output.path, named.mesh, {.objects = named.objects}));
  }
  if (!source.note.empty()) printText(stderr, "kerf: {}\n", source.note);
  if (a.json)
    printJson(trimJson(cut, source, *result, outputs));
  else
    printTrim(a, cut, *result, outputs);
  return {};
}

int runTrim(const TrimArguments& a) {
  if (a.planes.empty() && a.plan.empty() && a.box.empty() && a.between.empty())
    return complainOfUsage({.code = Error::Code::kBadValue,
                            .found = "nothing to cut along",
                            .expected = "--plane, --plan, --box or --between",
                            .hint = "--plane 0,0,1@0,0,12"});
  const auto trimmed = trim(a);
  if (trimmed) return kOk;
  const Error& error = trimmed.error();
  const bool is_usage = error.code == Error::Code::kBadValue && error.place.starts_with("--");
  return is_usage ? complainOfUsage(error) : complain(error);
}

constexpr double kMostKerf = 10;  // mm

constexpr const char* kTrimFooter =
    "Above a plane is the side of its normal. Several planes cut off the volume above all of them. Kerf writes both "
    "parts\n"
    "unless --keep selects one: NAME-above.stl and NAME-below.stl; with --box or --between NAME-die.stl and "
    "NAME-rest.stl.\n"
    "Flat faces close both parts; uncut vertices stay bit for bit.\n"
    "A plane is infinite: it also cuts distant parts, such as the other condyle. Kerf lists each piece with its "
    "middle.\n"
    "To cut one side only, use --between or --box.\n"
    "Examples:\n"
    "  kerf trim arch.case --plane occlusal@-12 --keep above -o arch.stl    the underside off, 12 mm under the cusps\n"
    "  kerf trim arch.case --between -8,40,3/2,42,3 --keep die -o die.stl   a tooth out of a model, between two "
    "points\n"
    "  kerf trim arch.case --plane 1,0,0@4,0,0 --plane -1,0,0@12,0,0 -o slice.stl";

}  // namespace

void addTrim(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<TrimArguments>();
  command.footer(kTrimFooter);
  command
      .add_option("CASE|RUN|MESH", a->what,
                  "object to cut; a mesh must be a closed solid: kerf bake closes other meshes")
      ->required();
  const auto takeAll = [](CLI::Option* option) {
    return option->expected(1)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  takeAll(command.add_option("-o,--output", a->outputs,
                             writableFormats() + "; colours in " + colorFormats() + ". Repeat for several"))
      ->required();
  takeAll(command.add_option("--plane", a->planes,
                             "cutting plane, mm: normal@point; or three points, counter-clockwise as seen from above; "
                             "or a height above the occlusal plane (negative: below). Repeat for several"))
      ->type_name(kPlaneWords);
  command.add_option("--plan", a->plan, "planes of the window (saw.save) or of 3D Slicer (.mrk.json)")
      ->type_name("FILE");
  command.add_option("--box", a->box, "cut out the box between two corners")->type_name("X,Y,Z/X,Y,Z");
  command
      .add_option("--between", a->between,
                  "cut out the piece between two points, such as the contacts of a tooth with its neighbours, by "
                  "planes square to the line between them")
      ->type_name("X,Y,Z/X,Y,Z");
  command.add_option("--kerf", a->kerf_mm, "width of material lost along the planes, mm: half on either side")
      ->type_name("MM")
      ->check(CLI::Range(0.0, kMostKerf))
      ->capture_default_str();
  command
      .add_option("--hole", a->hole,
                  "a round hole in both parts, such as for a pin, mm: diameter, depth, direction into the material and "
                  "middle of the mouth")
      ->delimiter(',')
      ->expected(8)
      ->type_name("D,DEPTH,AX,AY,AZ,X,Y,Z");
  command.add_option("--keep", a->keep, "parts to write: above (or die), below (or rest), both")
      ->check(CLI::IsMember({"above", "below", "die", "rest", "both"}))
      ->capture_default_str();
  command
      .add_option("--unit", a->unit, "unit of a mesh: mm, cm, m, um or inch (default: the declared unit, or by size)")
      ->type_name("UNIT")
      ->check(CLI::IsMember(unitNames()));
  addOverwrite(command, a->overwrites, "replace existing files");
  addCasePlaces(command);
  command.add_flag("--json", a->json, "print the summary as JSON on standard output");
  command.callback([a, &exit_code] { exit_code = runTrim(*a); });
}

}  // namespace kerf::cli
