// Time of a bake and of an export, relative to the library calls beneath them.
#include "preprocess/bake/bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "bench/bench.h"
#include "bench/resources.h"
#include "geometry/boolean/removed_solid.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_molar.h"
#include "sim/run/cut/geometry_cut.h"
#include "sim/run/export/export_bundle.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;

// The user's mesh, or the demo molar with triangles of that edge length, mm.
Expected<fs::path> meshOf(const Bench& bench, double edge) {
  if (!bench.mesh.empty()) return fs::path(bench.mesh);
  const fs::path molar = bench.scratch.path() / "molar.ply";
  KERF_CHECK(writeMesh(molar, demoMolar(edge)));
  return molar;
}

// The whole bake with its files, relative to the bare library call on the same solid.
Expected<Result> bakeOf(SceneId scene, const fs::path& path, int repetitions, const Bench& bench) {
  Result r(scene, "");
  r.ratio_to = "meshToVolume alone on the closed mesh, same bands";
  BakeOptions options;
  options.overwrite = true;
  const fs::path folder = bench.scratch.path() / "bench.case";

  std::vector<double> ratios, voxelize_ratios;
  clearPeak();
  for (int n = 0; n < repetitions; ++n) {
    const double start = now();
    KERF_TRY(report, bake({path}, folder, options, bench.progress));
    r.ms.push_back(now() - start);
    r.peak_gb = peakGigabytes();

    KERF_TRY(solid, readCaseSolid(folder));
    KERF_TRY(bare, timeBareMeshToVolume(solid, options.voxelize));
    ratios.push_back(r.ms.back() / (1e3 * bare));
    voxelize_ratios.push_back(report.times.voxelize / bare);
    r.what = fmt::format("whole bake of {} triangles at 0.1 mm, files included", report.manifest.solid_triangles);
  }

  KERF_TRY(field, readCaseField(folder));
  r.state_hash = fmt::format("{:016x}", field.stateHash());
  std::sort(ratios.begin(), ratios.end());
  std::sort(voxelize_ratios.begin(), voxelize_ratios.end());
  r.ratio = ratios[ratios.size() / 2];
  r.part_ratio = voxelize_ratios[ratios.size() / 2];
  r.part = "field, materials and shell";
  return r;
}

// A groove over the middle of the box, 3 s long, as a path file.
void writeGroove(const fs::path& csv, const Box3& box) {
  const Vec3d c = box.center();
  std::ofstream out(csv);
  out << "t,x,y,z,qw,qx,qy,qz\n";
  for (int n = 0; n <= 60; ++n)
    out << fmt::format("{},{},{},{},1,0,0,0\n", 0.05 * n, c[0] + (n - 30) * box.size()[0] / 60, c[1], c[2]);
}

}  // namespace

Expected<Result> benchBake(const Bench& bench) {
  KERF_TRY(path, meshOf(bench, 0.0945));  // 200 000 triangles
  return bakeOf(SceneId::kBake, path, 5, bench);
}

Expected<Result> benchMandible(const Bench& bench) {
  KERF_TRY(anatomy, demoMandible(1, bench.progress));
  const fs::path path = bench.scratch.path() / "mandible.ply";
  KERF_CHECK(writeMesh(path, anatomy.mesh(anatomy.outline.front())));
  return bakeOf(SceneId::kMandible, path, 1, bench);
}

// Bakes once, cuts a groove over the top, exports five times.
Expected<Result> benchExport(const Bench& bench) {
  KERF_TRY(mesh, meshOf(bench, 0.0668));  // 400 000 triangles
  const fs::path& scratch = bench.scratch.path();
  const fs::path folder = scratch / "export.case", run = scratch / "export.run", csv = scratch / "groove.csv";
  BakeOptions options;
  options.overwrite = true;
  KERF_TRY(baked, bake({mesh}, folder, options, bench.progress));
  writeGroove(csv, baked.manifest.box);
  KERF_TRY(tool, findToolFile("round-014", defaultToolFolders()));
  KERF_TRY(manifest, cutCase(folder, tool, csv, run, {.overwrite = true}, bench.progress));

  Result r(SceneId::kExport,
           fmt::format("exact export of a groove through {} triangles", baked.manifest.solid_triangles));
  r.state_hash = manifest.state_hash;
  std::vector<double> processor_ms;
  for (int n = 0; n < 5; ++n) {
    const double start = now(), processor_start = processorTime();
    KERF_TRY(result, exportBundle(run, {}, bench.progress));
    KERF_CHECK(writeMesh(scratch / "export.stl", result.post_op.mesh));
    r.ms.push_back(now() - start);
    processor_ms.push_back(processorTime() - processor_start);
  }
  r.add("processor time, p50", 1e-3 * percentile(processor_ms, 0.5), "s");
  return r;
}

}  // namespace kerf::cli
