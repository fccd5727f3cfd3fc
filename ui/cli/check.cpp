#include "geometry/mesh/mesh_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_stream.h"
#include "preprocess/unit/unit.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

using nlohmann::json;

struct CheckArguments {
  std::vector<std::string> meshes;
  std::string unit;  // empty: numbers are in mm
  bool json = false;
};

// "-" is standard input. Checks a mesh by its numbers as they are, or in mm from the user's unit. Notes a likely other
// unit beside the verdict.
Expected<MeshFile> read(const CheckArguments& a, const std::string& name) {
  auto file = name == "-" ? readMeshStream(std::cin, "standard input") : readMesh(name);
  if (!file || file->mesh.vertices.empty()) return file;
  KERF_TRY(unit, chooseUnit(bounds(file->mesh), a.unit, file->declared_unit));
  if (!a.unit.empty()) {
    for (Vec3d& p : file->mesh.vertices) p *= unit.scale_to_mm;
  } else if (unit.scale_to_mm != 1) {
    printText(stderr, "kerf: {}: CHECK THE UNIT: checked in mm, but it seems to be in {}: {}\n", name, unit.unit,
              unit.reason);
  }
  if (unit.is_doubtful) printText(stderr, "kerf: {}: CHECK THE UNIT: {}\n", name, unit.reason);
  return file;
}

// One mesh alone: prints its full verdict.
int checkOne(const CheckArguments& a) {
  const auto file = read(a, a.meshes.front());
  if (!file) return complain(file.error());
  const MeshReport report = checkMesh(file->mesh);
  printText("{}", a.json ? toJson(report) + "\n" : describe(report));
  return report.print_ready ? kOk : kFailed;
}

// Several: each under its name, and a count. An unreadable file counts as not ready, and the others are still checked.
int runAll(const CheckArguments& a) {
  json rows = json::array();
  std::size_t ready = 0;
  int code = kOk;
  for (const std::string& name : a.meshes) {
    const auto file = read(a, name);
    if (!file) {
      code = complain(file.error());
      json row = errorJson(file.error(), file.error().message());
      row["file"] = name;
      rows.push_back(std::move(row));
      continue;
    }
    const MeshReport report = checkMesh(file->mesh);
    ready += report.print_ready;
    if (!a.json) printText("{}: {}\n", name, describe(report));
    json row = json::parse(toJson(report));
    row["file"] = name;
    rows.push_back(std::move(row));
  }
  if (a.json)
    printJson(rows);
  else
    printText("{} of {} ready to print\n", ready, a.meshes.size());
  return ready == a.meshes.size() ? kOk : std::max<int>(code, kFailed);
}

}  // namespace

void addCheck(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<CheckArguments>();
  command.footer(
      "Example: kerf check molar.stl --json\n         kerf check patient/*.stl\n         zcat molar.stl.gz | kerf "
      "check -");
  command.add_option("MESH", a->meshes, readableFormats() + "; several: each in turn; -: from standard input")
      ->required();
  command.add_option("--unit", a->unit, "unit of the meshes: mm, cm, m, um or inch (default: mm)")
      ->type_name("UNIT")
      ->check(CLI::IsMember(unitNames()));
  command.add_flag("--json", a->json,
                   "print the verdict as JSON on standard output; for several meshes a list with their files");
  command.callback([a, &exit_code] { exit_code = a->meshes.size() == 1 ? checkOne(*a) : runAll(*a); });
}

}  // namespace kerf::cli
