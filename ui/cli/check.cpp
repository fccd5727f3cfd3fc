#include "geometry/mesh/mesh_check.h"

#include <fmt/format.h>

#include <memory>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  std::string mesh;
  bool json = false;
};

int run(const Arguments& a) {
  const auto file = readMesh(a.mesh);
  if (!file) return complain(file.error());
  const MeshReport report = checkMesh(file->mesh);
  fmt::print("{}", a.json ? toJson(report) + "\n" : describe(report));
  return report.print_ready ? kOk : kFailed;
}

}  // namespace

void addCheck(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  command.footer("Example: kerf check molar.stl --json");
  command.add_option("MESH", a->mesh, readableFormats() + "; judged in its own unit")->required();
  command.add_flag("--json", a->json, "verdict as JSON on standard output");
  command.callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace kerf::cli
