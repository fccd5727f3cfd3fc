#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include "geometry/case/case_bundle.h"
#include "geometry/field/material_field.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/ray_hits.h"
#include "preprocess/unit/unit.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/view/camera.h"
#include "ui/app/view/mesh_in_mm.h"
#include "ui/app/view/upright.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct PickArguments {
  std::string scene, view = "top", up = "auto", unit;
  std::vector<std::string> at, pixels;
  std::string size = "1200x900";
  bool json = false;
};

// Picked object: a surface in mm, and its materials if known.
struct Picked {
  Mesh mesh;
  std::string note;
  std::optional<MaterialField> materials;
  std::vector<CaseMaterial> names;
};

Expected<Picked> readCaseScene(const fs::path& bundle, const fs::path& case_folder) {
  KERF_TRY(shown, exportBundle(bundle));
  KERF_TRY(manifest, readCaseManifest(case_folder));
  Picked out;
  out.mesh = std::move(shown.post_op.mesh);
  out.names = manifest.materials;
  MaterialBricks added;  // of a run
  if (isRun(bundle)) {
    KERF_TRY(known, readRunMaterials(bundle));
    const auto isInCase = [&](int number) {
      return std::any_of(manifest.materials.begin(), manifest.materials.end(),
                         [number](const CaseMaterial& m) { return m.number == number; });
    };
    for (const auto& [number, id] : known.added)
      if (!isInCase(number)) out.names.push_back({.id = id, .number = number});
    added = std::move(known);
  }
  if (out.names.size() > 1) {
    KERF_TRY(materials, readRunLabels(case_folder, added));
    out.materials = std::move(materials);
  }
  return out;
}

Expected<Picked> readScene(const PickArguments& a) {
  const fs::path path = a.scene;
  if (isCase(path)) return readCaseScene(path, path);
  if (isRun(path)) {
    KERF_TRY(case_folder, caseOfRun(path));
    return readCaseScene(path, case_folder);
  }
  KERF_TRY(read, readMeshInMm(path, a.unit));
  return Picked{std::move(read.mesh), std::move(read.note), {}, {}};
}

// "X,Y" or "WxH".
std::optional<std::array<double, 2>> twoNumbers(std::string_view text, char between) {
  const std::size_t at = text.find(between);
  if (at == text.npos) return {};
  std::array<double, 2> out{};
  const std::array<std::string_view, 2> words{text.substr(0, at), text.substr(at + 1)};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto [end, error] = std::from_chars(words[k].data(), words[k].data() + words[k].size(), out[k]);
    if (error != std::errc() || end != words[k].data() + words[k].size() || !std::isfinite(out[k])) return {};
  }
  return out;
}

Error wrongOption(const char* option, const std::string& found, const char* expected, const char* hint) {
  return {.code = Error::Code::kBadValue,
          .place = option,
          .found = "\"" + found + "\"",
          .expected = expected,
          .hint = hint};
}

// Place in the view, in mm to the right and up, from the scan's origin.
struct Place {
  std::string asked;
  double right = 0, up = 0;
};

Expected<std::vector<Place>> placesOf(const PickArguments& a, const Camera& view, const Mesh& mesh) {
  std::vector<Place> out;
  for (const std::string& text : a.at) {
    const auto xy = twoNumbers(text, ',');
    if (!xy) return fail(wrongOption("--at", text, "X,Y in mm", "--at 1.5,-2"));
    out.push_back({text, (*xy)[0], (*xy)[1]});
  }
  if (a.pixels.empty()) return out;

  const auto size = twoNumbers(a.size, 'x');
  constexpr double kLeast = 16, kMost = 8192;
  if (!size || std::min((*size)[0], (*size)[1]) < kLeast || std::max((*size)[0], (*size)[1]) > kMost)
    return fail(wrongOption("--size", a.size, "WxH, 16 to 8192 pixels a side", "--size 1200x900"));
  const int width = static_cast<int>((*size)[0]), height = static_cast<int>((*size)[1]);
  Camera fitted = view;
  fitTo(fitted, mesh, width, height);
  const double mm = fitted.mmPerPixel(height);
  for (const std::string& text : a.pixels) {
    const auto uv = twoNumbers(text, ',');
    if (!uv)
      return fail(wrongOption("--pixel", text, "U,V: pixels from the left and the upper edge", "--pixel 600,450"));
    out.push_back({"pixel " + text, fitted.target.dot(view.right()) + ((*uv)[0] - 0.5 * width) * mm,
                   fitted.target.dot(view.up()) - ((*uv)[1] - 0.5 * height) * mm});
  }
  return out;
}

// Rounding of a point in a coordinate plane would print -0.000.
double withoutNegativeZero(double x) { return std::abs(x) < 1e-12 ? 0 : x; }

struct Found {
  PointReadout readout;
  bool from_behind = false;
};

std::string tissueAt(const Picked& scene, const Vec3d& inside) {
  if (!scene.materials) return {};
  const Material material = scene.materials->near(inside);
  for (const CaseMaterial& m : scene.names)
    if (m.number == static_cast<int>(material)) return m.id;
  return {};
}

std::optional<Found> look(const Picked& scene, const Camera& view, const Place& place, double nearest) {
  const Vec3d towards = -view.backwards();
  const Vec3d from = place.right * view.right() + place.up * view.up() + nearest * view.backwards();
  const std::vector<RayHit> hits = rayHits(scene.mesh, from, towards);
  if (hits.empty()) return {};

  Found out;
  const RayHit& first = hits.front();
  out.from_behind = !first.enters;
  out.readout.point = (from + first.way * towards).unaryExpr(&withoutNegativeZero);
  out.readout.normal = doubleAreaVector(scene.mesh, first.triangle).normalized();
  Eigen::Quaterniond along = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), view.backwards());
  along.coeffs() = along.coeffs().unaryExpr(&withoutNegativeZero).eval();
  out.readout.T_scan_tool = Rigid3{along, out.readout.point};
  constexpr double kInside = 0.05;  // mm under the surface, or at the next labelled node
  out.readout.tissue = tissueAt(scene, out.readout.point - kInside * out.readout.normal);
  if (first.enters)
    for (const RayHit& hit : hits)
      if (!hit.enters) {
        out.readout.thickness_mm = hit.way - first.way;
        break;
      }
  return out;
}

Error nothingThere(const PickArguments& a, const Place& place, const Camera& view, const Mesh& mesh) {
  Box3 seen;
  for (const Vec3d& p : mesh.vertices) seen.add({p.dot(view.right()), p.dot(view.up()), 0});
  return {.code = Error::Code::kNotFound,
          .file = a.scene,
          .place = fmt::format("at {} in the view {}", place.asked, a.view),
          .found = "nothing",
          .expected = fmt::format(
              "a point on the object, which covers {:.2f} to {:.2f} mm to the right and {:.2f} to {:.2f} mm up",
              seen.min.x(), seen.max.x(), seen.min.y(), seen.max.y()),
          .hint = fmt::format("kerf-sim --screenshot OUT.png --view {} --up {} {}", a.view, a.up, a.scene)};
}

json toJson(const Place& place, const Found& found) {
  const PointReadout& r = found.readout;
  json j{{"at", {place.right, place.up}},
         {"point_mm", {r.point[0], r.point[1], r.point[2]}},
         {"normal", {r.normal[0], r.normal[1], r.normal[2]}},
         {"is_seen_from_behind", found.from_behind},
         {"path_row", pathRowOf(r)}};
  j["tissue"] = r.tissue.empty() ? json() : json(r.tissue);
  j["thickness_mm"] = r.thickness_mm ? json(*r.thickness_mm) : json();
  return j;
}

int runPick(const PickArguments& a) {
  if (a.at.empty() && a.pixels.empty())
    return complainOfUsage({.code = Error::Code::kBadValue,
                            .found = "no place given",
                            .expected = "--at X,Y or --pixel U,V",
                            .hint = "--at 0,0"});
  auto view = cameraFromView(a.view);
  if (!view) return complainOfUsage(view.error());
  const auto asked_up = a.up == "auto" ? Expected<Vec3d>(Vec3d::UnitZ()) : axisFromName(a.up);
  if (!asked_up)
    return complainOfUsage(wrongOption("--up", a.up, "auto, or one of +x, -x, +y, -y, +z, -z", "--up auto"));
  const auto scene = readScene(a);
  if (!scene) return complain(scene.error());
  const Vec3d up = a.up == "auto" ? surelyUp(a.scene, scene->mesh).value_or(*asked_up) : *asked_up;
  view->upright = uprightFrame(up);
  const auto places = placesOf(a, *view, scene->mesh);
  if (!places) return complainOfUsage(places.error());

  double nearest = 0;
  for (const Vec3d& p : scene->mesh.vertices) nearest = std::max(nearest, p.dot(view->backwards()));
  json rows = json::array();
  std::string text = scene->note.empty() ? "" : scene->note + "\n";
  if (a.up == "auto" && !view->upright.isIdentity())
    text += fmt::format("seen with {} up, the occlusal side of the scan; --up +z takes it as stored\n", nameOfAxis(up));
  for (const Place& place : *places) {
    const auto found = look(*scene, *view, place, nearest + 1);
    if (!found) return complain(nothingThere(a, place, *view, scene->mesh));
    rows.push_back(toJson(place, *found));
    text += textOf(found->readout);
    if (found->from_behind) text += "; SEEN FROM BEHIND: the scan is open there or inside out";
    text += '\n';
  }
  json all{{"view", a.view}, {"up", nameOfAxis(up)}, {"points", std::move(rows)}};
  if (!scene->note.empty()) all["note"] = scene->note;
  if (a.json)
    printJson(all);
  else
    printText("{}", text);
  return kOk;
}

}  // namespace

void addPick(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<PickArguments>();
  command.footer(
      "--at gives mm to the right and up in the view, from the scan's origin. From the top with +z up, these are x and "
      "y. The path row of --json puts a tool there, along the viewing direction. --pixel refers to a picture of "
      "kerf-sim --screenshot with the same view and size.\n"
      "Example: kerf pick molar.case --view top --at 1.2,-0.4");
  command.add_option("SCENE", a->scene, "mesh, case or run; meshes: " + readableFormats())->required();
  command
      .add_option(
          "--view", a->view,
          "view: front, back, left, right, top (or occlusal), bottom, iso, or AZ,EL in degrees, as kerf-sim --view")
      ->type_name("NAME")
      ->capture_default_str();
  command.add_option("--up", a->up, "side that is up, as kerf-sim --up")->type_name("AXIS")->capture_default_str();
  command.add_option("--at", a->at, "mm to the right and up in the view; may be repeated")
      ->type_name("X,Y")
      ->allow_extra_args(false);
  command.add_option("--pixel", a->pixels, "pixel of a picture, from its left and upper edge; may be repeated")
      ->type_name("U,V")
      ->allow_extra_args(false);
  command.add_option("--size", a->size, "size of that picture in pixels")->type_name("WxH")->capture_default_str();
  command
      .add_option("--unit", a->unit, "unit of a mesh: mm, cm, m, um or inch (default: the declared unit, or by size)")
      ->type_name("UNIT")
      ->check(CLI::IsMember(unitNames()));
  addCasePlaces(command);
  command.add_flag("--json", a->json, "print JSON on standard output");
  command.callback([a, &exit_code] { exit_code = runPick(*a); });
}

}  // namespace kerf::cli
