#include "preprocess/demo_molar.h"

#include <fmt/format.h>

#include <memory>

#include "geometry/mesh_writer.h"
#include "ui/cli/command.h"

namespace kerf::cli {

void addDemoMolar(CLI::App& app, int& exit_code) {
  struct Arguments {
    std::string output;
    double edge_mm = 0.18;
  };
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("demo-molar", "Write a lower first molar of Kerf's own making, to try things on");
  c->footer("Example: kerf demo-molar -o molar.ply");
  c->add_option("-o,--output", a->output, "STL, PLY (coloured), OBJ or OFF")->required();
  c->add_option("--edge", a->edge_mm, "edge length of the triangles [mm]")
      ->capture_default_str()
      ->check(CLI::Range(0.08, 1.0));
  c->callback([a, &exit_code] {
    const Mesh mesh = demoMolar(a->edge_mm);
    if (const auto written = writeMesh(a->output, mesh); !written) {
      exit_code = complain(written.error());
      return;
    }
    fmt::print("written: {} ({} triangles, {:.1f} mm3)\n", a->output, mesh.triangles.size(), signedVolume(mesh));
    exit_code = kOk;
  });
}

}  // namespace kerf::cli
