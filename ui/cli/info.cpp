#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/case/case_bundle.h"
#include "geometry/field/vdb_io.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/solids.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/unit/unit.h"
#include "preprocess/volume/label_names.h"
#include "preprocess/volume/label_volume.h"
#include "sim/run/report/run_report.h"
#include "ui/cli/closing_json.h"
#include "ui/cli/command.h"
#include "ui/cli/run_info.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json point(const Vec3d& p) { return {p[0], p[1], p[2]}; }
json size(const Box3& box) { return point(box.size()); }

Expected<json> meshInfo(const fs::path& path) {
  KERF_TRY(file, readMesh(path));
  const Box3 box = bounds(file.mesh);  // in the file's unit
  KERF_TRY(unit, chooseUnit(box, "", file.declared_unit));
  for (Vec3d& p : file.mesh.vertices) p *= unit.scale_to_mm;
  json j{{"kind", "mesh"},
         {"format", std::string(file.format)},
         {"vertices", file.mesh.vertices.size()},
         {"triangles", file.mesh.triangles.size()},
         {"size_in_file_unit", size(box)},
         {"center_in_file_unit", {box.center()[0], box.center()[1], box.center()[2]}},
         {"unit", unit.unit},
         {"unit_reason", unit.reason},
         {"size_mm", size(bounds(file.mesh))},
         {"vertex_colors", file.mesh.hasVertexColors()},
         {"face_colors", file.mesh.hasFaceColors()},
         {"double_coordinates", file.had_double_coordinates},
         {"notes", file.notes}};
  j["check"] = json::parse(toJson(checkMesh(file.mesh)));
  return j;
}

// Contents and sources of a case: lists and parts that it may lack.
void addContents(const CaseManifest& m, json& j) {
  for (const CaseMaterial& c : m.materials)
    j["materials"].push_back({{"id", c.id}, {"number", c.number}, {"volume_mm3", c.volume_mm3}});
  for (const CasePart& p : m.parts)
    j["parts"].push_back(
        {{"material", p.material}, {"origin", p.origin}, {"own_mm3", p.own_mm3}, {"volume_mm3", p.volume_mm3}});
  if (m.gaps) j["gaps"] = {{"unclaimed_mm3", m.gaps->unclaimed_mm3}, {"forgotten_mm3", m.gaps->forgotten_mm3}};
  if (m.region)
    j["region"] = {{"voxel_mm", m.region->where.voxel_mm},
                   {"radius_mm", m.region->where.radius_mm},
                   {"points", m.region->where.line.size()},
                   {"shell_points", m.region->shell_points},
                   {"shell_area_mm2", m.region->shell_area_mm2}};
  for (const CaseSource& s : m.sources)
    j["sources"].push_back({{"stored_as", s.stored_as},
                            {"format", s.format},
                            {"unit", s.unit},
                            {"unit_reason", s.unit_reason},
                            {"vertices", s.vertices},
                            {"triangles", s.triangles},
                            {"sha256", s.sha256}});
}

json pairInfo(const CasePair& pair, const fs::path& folder) {
  const fs::path partner = (folder / ".").lexically_normal().parent_path().parent_path() / pair.partner;
  const auto other = readCaseManifest(partner);
  const bool meets = other && other->pair && other->pair->frame == pair.frame;
  return {{"frame", pair.frame}, {"partner", pair.partner}, {"partner_is_beside", meets}};
}

Expected<json> caseInfo(const fs::path& folder) {
  KERF_TRY(m, readCaseManifest(folder));
  json j{{"kind", "case"},
         {"id", m.id},
         {"kerf_version", m.kerf_version},
         {"exact", m.exact},
         {"close_mode", m.close_mode},
         {"changes", m.changes},
         {"warnings", m.warnings ? json(*m.warnings) : json()},
         {"closing", m.closing.empty() ? json() : closingJson(m.closing)},
         {"voxel_mm", m.voxel_mm},
         {"size_mm", size(m.box)},
         {"box_mm", {{"min", point(m.box.min)}, {"max", point(m.box.max)}}},
         {"vertices", m.solid_vertices},
         {"triangles", m.solid_triangles},
         {"volume_mm3", m.solid_volume_mm3},
         {"area_mm2", m.solid_area_mm2},
         {"shell_points", m.shell_points},
         {"shell_area_mm2", m.shell_area_mm2}};

  KERF_TRY(solid, readCaseSolid(folder));
  const PieceCount pieces = countPieces(solid);
  j["pieces"] = pieces.pieces;
  j["cavities"] = pieces.cavities;
  j["specks"] = pieces.specks;
  j["specks_mm3"] = pieces.specks_mm3;
  addContents(m, j);
  if (m.pair) j["pair"] = pairInfo(*m.pair, folder);

  // Reads only headers: readers of the fields check that they are the baked ones.
  KERF_TRY(grids, inspectVdb(folder / kCaseAnatomy));
  for (const VdbGridInfo& g : grids)
    j["grids"].push_back(
        {{"name", g.name}, {"type", g.type}, {"voxel_mm", g.voxel}, {"active_voxels", g.active_voxels}});
  return j;
}

Expected<json> toolInfo(const fs::path& file) {
  KERF_TRY(tool, readTool(file));
  json j = json::parse(toJson(tool));
  j["kind"] = "tool";
  return j;
}

/// @param missing  reason for a missing spacing; empty: there is one.
json gridInfo(const LabelVolume& v, const char* kind, const std::string& missing) {
  const auto list = [](const Vec3d& p) { return json{p[0], p[1], p[2]}; };
  json j{{"kind", kind},
         {"format", v.format},
         {"size", v.size},
         {"spacing_mm", missing.empty() ? list(v.spacing) : json(nullptr)},
         {"origin_mm", list(v.origin)},
         {"direction", {list(v.direction.col(0)), list(v.direction.col(1)), list(v.direction.col(2))}}};
  if (!missing.empty())
    j["notes"] = {missing +
                  ": the file states no usable spacing, so there are no lengths and volumes; a recipe gives it "
                  "as `spacing = [x, y, z]` in mm"};
  return j;
}

json volumeInfo(const fs::path& path, const LabelVolume& v, const std::string& missing) {
  json j = gridInfo(v, "label volume", missing);
  const auto names = labelNames(path);
  for (const LabelCount& c : countLabels(v)) {
    json label{{"label", c.label}, {"voxels", c.voxels}};
    if (const auto name = names.find(c.label); name != names.end()) label["name"] = name->second;
    if (missing.empty()) label["volume_mm3"] = static_cast<double>(c.voxels) * v.voxelVolume();
    j["labels"].push_back(label);
  }
  if (const std::string cut = textOfCutLabels(v); !cut.empty())
    j["warnings"] = {"labels touch the faces of the volume, where their surfaces are cut off flat: " + cut};
  return j;
}

// Intensities: grid and value range. `why`: the error of reading them as labels.
Expected<json> intensityInfo(const fs::path& path, const LabelReadOptions& options, const std::string& missing,
                             const Error& why) {
  const auto summary = summariseVolume(path, options);
  if (!summary) return fail(why);
  json j = gridInfo(summary->grid, "intensity volume", missing);
  j["lowest_value"] = summary->lowest;
  j["highest_value"] = summary->highest;
  j["notes"].push_back(why.found + "; " + why.hint);
  return j;
}

Expected<json> labelVolumeInfo(const fs::path& path) {
  const auto volume = readLabelVolume(path);
  if (volume) return volumeInfo(path, *volume, "");
  const auto isOfSpacing = [](const Error& error) { return error.place == "spacing"; };
  const bool has_spacing = !isOfSpacing(volume.error());
  if (has_spacing) return intensityInfo(path, {}, "", volume.error());

  // Labels can be counted without a spacing. A damaged file gets its own error: a spacing does not mend it.
  const LabelReadOptions ones{.spacing_mm = Vec3d::Ones()};
  const auto unplaced = readLabelVolume(path, ones);
  if (unplaced) return volumeInfo(path, *unplaced, volume.error().found);
  if (!isOfSpacing(unplaced.error())) return intensityInfo(path, ones, volume.error().found, unplaced.error());
  return fail(volume.error());
}

Expected<json> infoOf(const std::string& what) {
  const fs::path path = what;
  std::error_code ignored;
  if (isCase(path)) return caseInfo(path);

  if (isLabelVolume(path)) return labelVolumeInfo(path);
  if (fs::is_directory(path, ignored))
    if (const std::string folders = textOfSliceFolders(path); !folders.empty())
      return fail({.code = Error::Code::kUnsupported,
                   .file = what,
                   .found = "no slices" + folders,
                   .expected = "a folder that holds the slices of one series",
                   .hint = "name one of these folders"});
  if (fs::exists(path, ignored)) return path.extension() == ".toml" ? toolInfo(path) : meshInfo(path);
  // No such path: perhaps the id of a tool.
  if (const auto tool = findToolFile(what, defaultToolFolders())) return toolInfo(*tool);
  return fail({.code = Error::Code::kNotFound,
               .file = what,
               .found = "no such file, folder or tool",
               .expected = "a mesh, a label volume, a case, a run, a tool file or a tool id",
               .hint = "kerf tool list"});
}

// Keys and values, one a line, indented by depth: JSON as text.
void printInfo(const json& j, int depth) {
  for (const auto& [key, value] : j.items()) {
    const std::string indent(static_cast<std::size_t>(2 * depth), ' ');
    if (value.is_object()) {
      printText("{}{}:\n", indent, key);
      printInfo(value, depth + 1);
    } else if (value.is_array() && !value.empty() && (value[0].is_object() || value[0].is_string())) {
      printText("{}{}:\n", indent, key);
      for (const json& item : value) {
        if (item.is_string()) {
          printText("{}  - {}\n", indent, item.get<std::string>());
        } else {
          printText("{}  -\n", indent);
          printInfo(item, depth + 2);
        }
      }
    } else {
      printText(
          "{}{}: {}\n", indent, key,
          value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, json::error_handler_t::replace));
    }
  }
}

// Prints the most asked values first: kind, changes and losses, number of pieces, size.
void printLeading(json j) {
  if (j.contains("warnings") && j["warnings"].empty()) j.erase("warnings");
  for (const char* key :
       {"kind", "format", "unit", "unit_reason", "size_in_file_unit", "close_mode", "exact", "warnings", "changes",
        "notes", "pieces", "specks", "specks_mm3", "cavities", "volume_mm3", "size_mm", "voxel_mm"}) {
    if (!j.contains(key)) continue;
    printInfo(json{{key, j[key]}}, 0);
    j.erase(key);
  }
  j.erase("closing");  // the changes cover it
  printInfo(j, 0);
}

struct InfoArguments {
  std::string what;
  bool json = false, replays = false;
};

// Prints the run's text first, then the values missing in it.
void printRun(const RunReport& report, const json& j) {
  printText("{}\n", runText(report));
  json rest = json::object();
  for (const char* key : {"case_path", "case_id", "mode", "is_open", "duration_s", "segments", "path_length_mm",
                          "voxel_mm", "state_hash", "kerf_version", "goes_on_from_field_sha256", "pieces", "beside"})
    if (j.contains(key)) rest[key] = j[key];
  printInfo(rest, 0);
}

int runOfRun(const InfoArguments& a) {
  const auto report = [&] {
    TerminalProgress progress;
    return readRunReport(a.what, a.replays, progress.callback());
  }();
  if (!report) return complain(report.error());
  const json j = runJson(*report);
  if (a.json)
    printJson(j);
  else
    printRun(*report, j);
  return kOk;
}

int runInfo(const InfoArguments& a) {
  if (isRun(a.what)) return runOfRun(a);
  if (a.replays)
    return complainOfUsage({.code = Error::Code::kBadValue,
                            .place = "--replay",
                            .found = "\"" + a.what + "\", not a run",
                            .expected = "a run folder",
                            .hint = "omit --replay"});
  const auto info = infoOf(a.what);
  if (!info) return complain(info.error());
  if (a.json)
    printJson(*info);
  else
    printLeading(*info);
  return kOk;
}

}  // namespace

void addInfo(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<InfoArguments>();
  command.footer("Example: kerf info upper.ply");
  command
      .add_option("PATH", a->what,
                  "mesh file, label volume (file or folder of slices), case folder, run folder, tool file or tool id")
      ->required();
  command.add_flag("--json", a->json, "print JSON on standard output");
  command.add_flag("--replay", a->replays,
                   "for a session: replay its log for distances to neighbours, and for all peaks if it has no summary; "
                   "takes about a quarter of the session time");
  addCasePlaces(command);
  command.callback([a, &exit_code] { exit_code = runInfo(*a); });
}

}  // namespace kerf::cli
