#include "preprocess/bake/bake.h"

#include <fmt/format.h>

#include "geometry/base/hash.h"
#include "preprocess/bake/bake_job.h"
#include "preprocess/bake/bake_sources.h"
#include "preprocess/bake/closing_numbers.h"
#include "preprocess/volume/label_volume.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// A folder is no mesh.
Expected<void> requireMeshNotFolder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return {};

  if (isCase(path)) {
    std::string sources;
    if (const auto manifest = readCaseManifest(path))
      for (const CaseSource& source : manifest->sources)
        sources += (sources.empty() ? ", baked from " : ", ") + source.stored_as;
    return fail({.code = Error::Code::kUnsupported,
                 .file = path.string(),
                 .found = "a case already" + sources,
                 .expected = "a mesh file or a recipe",
                 .hint = sources.empty()
                             ? "kerf info " + path.string()
                             : "kerf cut takes it as it is; with other settings bake the original file again"});
  }

  if (isLabelVolume(path))
    return fail(
        {.code = Error::Code::kUnsupported,
         .file = path.string(),
         .found = "a folder of slices: a label volume, no mesh",
         .expected = "a mesh file or a recipe",
         .hint = "a recipe that makes tissues of its labels (docs/reference/recipes.md); kerf info lists them"});
  return fail({.code = Error::Code::kUnreadable,
               .file = path.string(),
               .found = "a folder, neither a case nor slices",
               .expected = "a mesh file or a recipe",
               .hint = "name the mesh in it"});
}

Expected<std::vector<std::string>> hashMeshes(const std::vector<fs::path>& meshes) {
  std::vector<std::string> hashes;
  for (const fs::path& path : meshes) {
    KERF_CHECK(requireMeshNotFolder(path));
    std::error_code ignored;
    const bool is_volume = fs::is_regular_file(path, ignored) && isLabelVolume(path);  // the reader rejects it
    KERF_TRY(hash, is_volume ? sha256OfFile(path) : internal::sha256OfSource(path));
    hashes.push_back(hash);
  }
  return hashes;
}

// All meshes as one solid. @param paths  of the sources, for errors.
Expected<Mesh> closeSources(const std::vector<fs::path>& paths, const std::vector<Mesh>& sources,
                            internal::BakeJob& job) {
  if (!report(job.progress, 0.05, "closing")) return cancelledBeforeWriting();
  auto solid = closeMeshes(sources, job.options.close, partOf(job.progress, 0.05, 0.3));
  if (!solid) {
    if (solid.error().file.empty())
      solid.error().file =
          paths[0].string() + (paths.size() > 1 ? fmt::format(" and {} more, as one object", paths.size() - 1) : "");
    return fail(solid.error());
  }
  job.report.close = solid->report;
  job.report.manifest.changes = job.report.close.changes;
  job.report.manifest.closing = closingNumbers(job.report.close);
  job.report.manifest.exact = job.report.close.exact;
  return std::move(solid->mesh);
}

}  // namespace

Expected<BakeReport> bake(const std::vector<fs::path>& meshes, const fs::path& case_folder, const BakeOptions& asked,
                          const Progress& progress) {
  internal::BakeJob job{asked, progress};

  // Plan: before the minutes of closing, not after.
  KERF_CHECK(internal::settleSizes(job.options));
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(hashes, hashMeshes(meshes));

  KERF_TRY(staging, internal::openCase(case_folder, hashes, "", job));
  if (!staging) return std::move(job.report);

  KERF_TRY(sources, internal::readMeshSources(meshes, hashes, job.options.unit, true, staging->staging(), job.report,
                                              partOf(progress, 0, 0.05)));
  KERF_CHECK(internal::checkObjectSize(meshes, sources, true, job.options, job.report));
  job.report.times.read = job.watch.lap();

  auto checks = internal::checkAside(sources);
  KERF_TRY(solid, closeSources(meshes, sources, job));
  internal::finishClosing(checks, job);

  const internal::BakeObject object{std::move(solid), {}};
  KERF_TRY(grids, internal::voxelizeObject(object, materials, job));
  KERF_CHECK(internal::writeCase(object, grids, materials, *staging, job));
  return std::move(job.report);
}

}  // namespace kerf
