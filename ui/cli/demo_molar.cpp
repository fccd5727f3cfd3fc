#include "preprocess/demo/demo_molar.h"

#include <fmt/format.h>

#include <memory>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_writer.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct DemoMolarArguments {
  std::string output;
  double edge_mm = 0.18;
  bool overwrites = false;
};

int runDemoMolar(const DemoMolarArguments& a) {
  if (const auto possible = canWriteMesh(a.output); !possible) return complain(possible.error());
  if (const auto free = requireFree(a.output, a.overwrites); !free) return complain(free.error());

  const TerminalProgress guard;  // Ctrl-C waits for complete files
  const Mesh mesh = demoMolar(a.edge_mm);
  if (const auto written = writeMesh(a.output, mesh); !written) return complain(written.error());
  printText("written: {} ({} triangles, {:.1f} mm3)\n", a.output, mesh.triangles.size(), signedVolume(mesh));
  return kOk;
}

}  // namespace

void addDemoMolar(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<DemoMolarArguments>();
  command.footer("Example: kerf demo-molar -o molar.ply");
  command.add_option("-o,--output", a->output, writableFormats() + "; colours in " + colorFormats())->required();
  command.add_option("--edge", a->edge_mm, "edge length of the triangles [mm]")
      ->capture_default_str()
      ->check(CLI::Range(0.08, 1.0));
  addOverwrite(command, a->overwrites, "replace an existing file");
  command.callback([a, &exit_code] { exit_code = runDemoMolar(*a); });
}

}  // namespace kerf::cli
