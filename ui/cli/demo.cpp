#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "geometry/base/atomic_file.h"
#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_arch.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct DemoArguments {
  std::string output, manifest;
  double detail = 1;
  std::uint32_t seed = DemoArchOptions().seed;
  bool overwrite = false;
};
using Model = Expected<DemoAnatomy> (*)(const DemoArguments& a, const Progress& progress);

Expected<DemoAnatomy> molar(const DemoArguments& a, const Progress& progress) {
  return demoMolarAnatomy(a.detail, progress);
}
Expected<DemoAnatomy> mandible(const DemoArguments& a, const Progress& progress) {
  return demoMandible(a.detail, progress);
}
Expected<DemoAnatomy> arch(const DemoArguments& a, const Progress& progress) {
  DemoArchOptions options;
  options.edge_mm *= a.detail;
  options.seed = a.seed;
  KERF_TRY(scan, demoArch(options, progress));
  const DemoArchDefects& d = scan.defects;

  DemoAnatomy anatomy{"arch", "Demo lower arch", 0, {}, {}, {}};
  anatomy.title += fmt::format(": no underside, {} pin holes, {} islands, {} spike, {} triangles inside out",
                               d.pin_holes, d.islands, d.spikes, d.flipped_triangles);
  anatomy.files.push_back({"arch.ply", std::move(scan.mesh)});
  return anatomy;
}

int runDemo(const DemoArguments& a, Model model) {
  // Checks before the work.
  if (const auto possible = AtomicFolder::create(a.output, a.overwrite, a.manifest); !possible)
    return complain(possible.error());

  TerminalProgress progress;
  const auto anatomy = model(a, progress.callback());
  if (!anatomy) return complain(anatomy.error());
  if (const auto written = writeDemoAnatomy(*anatomy, a.output, a.overwrite); !written)
    return complain(written.error());

  for (const DemoAnatomy::File& file : anatomy->files)
    printText("written: {}/{} ({} triangles)\n", a.output, file.name, file.mesh.triangles.size());
  if (!anatomy->parts.empty()) printText("written: {}/{}\n", a.output, anatomy->manifest());
  printText("{}\n", anatomy->title);
  return kOk;
}

void add(CLI::App& parent, const std::string& name, const std::string& sentence, Model model, int& exit_code) {
  auto a = std::make_shared<DemoArguments>();
  a->manifest = name + (model == arch ? ".ply" : ".toml");
  CLI::App* c = parent.add_subcommand(name, sentence);
  c->footer(fmt::format("Example: kerf demo {0} -o {0}", name));
  c->add_option("-o,--output", a->output, "folder to write")->required();
  c->add_option("--coarseness", a->detail, "scale factor of the triangle edges")
      ->capture_default_str()
      ->check(CLI::Range(0.5, 4.0));
  addOverwrite(*c, a->overwrite, "replace an existing folder of such a model");
  if (model == arch) c->add_option("--seed", a->seed, "random seed of noise, rim and faults")->capture_default_str();
  c->callback([a, model, &exit_code] { exit_code = runDemo(*a, model); });
}

}  // namespace

void addDemo(CLI::App& command, int& exit_code) {
  command.footer("Example: kerf demo molar -o molar");
  command.require_subcommand(1);
  add(command, "molar", "A lower first molar: enamel, dentin, pulp and a caries lesion", molar, exit_code);
  add(command, "mandible", "A mandible: compact and spongy bone, nerve canals, teeth 37 to 47 in their sockets",
      mandible, exit_code);
  add(command, "arch", "A lower arch as scanned: teeth and gums, open, with noise and faults", arch, exit_code);
}

}  // namespace kerf::cli
