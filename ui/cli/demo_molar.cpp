#include "preprocess/demo/demo_molar.h"

#include <fmt/format.h>

#include <memory>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_writer.h"
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
  c->add_option("-o,--output", a->output, writableFormats() + "; colours in " + colorFormats())->required();
  c->add_option("--edge", a->edge_mm, "edge length of the triangles [mm]")
      ->capture_default_str()
      ->check(CLI::Range(0.08, 1.0));
  c->callback([a, &exit_code] {
    if (!(a->edge_mm >= 0.08 && a->edge_mm <= 1)) {  // CLI::Range lets "nan" pass
      exit_code =
          complain({Error::Code::kBadValue, "", "--edge", fmt::format("{} mm", a->edge_mm), "0.08 to 1 mm", ""});
      return;
    }
    if (const auto possible = canWriteMesh(a->output); !possible) {
      exit_code = complain(possible.error());
      return;
    }
    const TerminalProgress guard;  // Ctrl-C waits until no file is half written
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
