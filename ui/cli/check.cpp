#include "geometry/mesh/mesh_check.h"

#include <fmt/format.h>

#include <memory>

#include "geometry/formats/mesh_formats.h"
#include "ui/cli/command.h"

namespace kerf::cli {

void addCheck(CLI::App& app, int& exit_code) {
  struct Arguments {
    std::string mesh;
    bool json = false;
  };
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("check", "Say whether a mesh is ready to print, and if not, why (exit 0 yes, 1 no)");
  c->footer("Example: kerf check molar.stl --json");
  c->add_option("MESH", a->mesh, readableFormats() + "; judged in its own unit")->required();
  c->add_flag("--json", a->json, "verdict as JSON on standard output");
  c->callback([a, &exit_code] {
    const auto file = readMesh(a->mesh);
    if (!file) {
      exit_code = complain(file.error());
      return;
    }
    const MeshReport report = checkMesh(file->mesh);
    fmt::print("{}", a->json ? toJson(report) + "\n" : describe(report));
    exit_code = report.print_ready ? kOk : kFailed;
  });
}

}  // namespace kerf::cli
