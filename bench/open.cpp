// Cost of opening a case: from its files to an object that can be cut.
#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/resources.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/bake/bake.h"
#include "preprocess/demo/demo_anatomy.h"
#include "sim/object/cut_object.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;

// The user's case, or the demo mandible without its interior, at 0.1 mm.
Expected<fs::path> caseOf(const Bench& bench) {
  if (!bench.case_folder.empty()) return fs::path(bench.case_folder);
  KERF_TRY(anatomy, demoMandible(1, bench.progress));
  const fs::path mesh = bench.scratch.path() / "open.ply", folder = bench.scratch.path() / "open.case";
  KERF_CHECK(writeMesh(mesh, anatomy.mesh(anatomy.outline.front())));
  BakeOptions options;
  options.overwrite = true;
  KERF_CHECK(bake({mesh}, folder, options, bench.progress));
  return folder;
}

}  // namespace

Expected<Result> benchOpen(const Bench& bench) {
  KERF_TRY(folder, caseOf(bench));
  Result r(SceneId::kOpen, "");
  std::vector<double> processor_ms;
  clearPeak();
  for (int n = 0; n < 3; ++n) {
    const double start = now(), processor_start = processorTime();
    KERF_TRY(baked, loadObject(folder));
    const CutObject object(baked);
    r.ms.push_back(now() - start);
    processor_ms.push_back(processorTime() - processor_start);

    r.what = fmt::format("a case of {} bricks at {:g} mm opened to be cut", object.slotCount(), object.voxel());
    r.state_hash = fmt::format("{:016x}", baked->phi0().stateHash());
  }
  r.peak_gb = peakGigabytes();
  r.add("processor time, p50", 1e-3 * percentile(processor_ms, 0.5), "s");
  r.add("most memory", r.peak_gb, "GB");
  return r;
}

}  // namespace kerf::cli
