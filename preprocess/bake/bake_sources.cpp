#include "preprocess/bake/bake_sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <system_error>

#include "geometry/base/atomic_file.h"
#include "geometry/base/available_memory.h"
#include "geometry/base/hash.h"
#include "geometry/formats/mesh_io.h"
#include "preprocess/bake/bake_job.h"
#include "preprocess/unit/unit.h"
#include "preprocess/volume/label_volume.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

constexpr double kKeptArea = 0.5;  // of the sources' area: closing drops one of two equal layers

/// The voxel size, rounded up to a micron, whose field fits into memory.
double voxelThatFits(const Mesh& half, VoxelizeOptions options, std::uint64_t most_bytes) {
  while (estimateBakeBytes(half, options) > most_bytes) options.voxel_mm *= 1.02;
  return std::ceil(options.voxel_mm * 1000) / 1000;
}

/// The sources, shrunk to the smallest area that closing leaves: half of theirs, and at most that of their box.
/// Thousands of copies of one triangle have a large area, too.
Mesh shrunkToKeptArea(const std::vector<Mesh>& meshes, const Vec3d& size) {
  Mesh out;
  for (const Mesh& mesh : meshes) append(out, mesh);
  const double area = surfaceArea(out);
  const double around = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
  const double kept = std::min(kKeptArea * area, around);
  for (Vec3d& p : out.vertices) p *= area > 0 ? std::sqrt(kept / area) : 0;
  return out;
}

// The extension to store a source under. A name may hold any byte, a manifest only text: odd ones are dropped.
std::string safeExtension(const fs::path& path) {
  std::string e = path.extension().string();
  // `.nii.gz` counts as one extension.
  if (const fs::path inner = path.stem().extension(); e == ".gz") e = inner.string() + e;
  const auto plain = [](char c) {
    return c == '.' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  return std::all_of(e.begin(), e.end(), plain) ? e : std::string();
}

std::vector<fs::path> filesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
    if (entry->is_regular_file(failed)) files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  return files;
}

// Names and contents of files, each on a line.
Expected<std::string> sha256OfFiles(const std::vector<fs::path>& files) {
  std::string text;
  for (const fs::path& file : files) {
    KERF_TRY(hash, sha256OfFile(file));
    text += file.filename().string() + ' ' + hash + '\n';
  }
  return sha256(std::as_bytes(std::span(text.data(), text.size())));
}

void describeSource(const MeshFile& file, const UnitChoice& choice, CaseSource& source) {
  source.unit = choice.unit;
  source.unit_reason = choice.reason;
  source.scale_to_mm = choice.scale_to_mm;
  source.vertices = file.mesh.vertices.size();
  source.triangles = file.mesh.triangles.size();
}

void bringToMm(MeshFile& file, double scale_to_mm) {
  if (scale_to_mm != 1)
    for (Vec3d& p : file.mesh.vertices) p *= scale_to_mm;
  else if (!file.had_double_coordinates)  // decimals within float32 precision: nothing to report
    for (Vec3d& p : file.mesh.vertices) p = roundedToFloat(p);
}

}  // namespace

Expected<std::string> sha256OfSource(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) {
    KERF_TRY(files, filesOfVolume(path));
    return files.size() == 1 ? sha256OfFile(path) : sha256OfFiles(files);
  }
  if (!fs::is_directory(path, ignored)) {
    const bool is_there = fs::exists(path, ignored);  // a device has no end
    return fail({.code = is_there ? Error::Code::kUnreadable : Error::Code::kNotFound,
                 .file = path.string(),
                 .found = is_there ? "neither a file nor a folder" : "no such file",
                 .expected = "a file",
                 .hint = "check the path"});
  }
  return sha256OfFiles(filesIn(path));
}

Expected<CaseSource*> storeSource(const fs::path& path, const std::string& format, const std::string& sha256,
                                  const fs::path& case_folder, CaseManifest& manifest) {
  std::error_code failed;
  const bool is_folder = fs::is_directory(path, failed);
  std::vector<fs::path> files{path};
  if (is_folder) {
    files = filesIn(path);
  } else {
    KERF_TRY(parts, filesOfVolume(path));
    files = std::move(parts);
  }
  const bool keeps_names = is_folder || files.size() > 1;  // a header names the file with its values

  CaseSource source;
  source.stored_as =
      fmt::format("source-{}{}", manifest.sources.size() + 1, keeps_names ? std::string() : safeExtension(path));
  source.format = format;
  source.sha256 = sha256;

  const fs::path copy = case_folder / source.stored_as;
  failed.clear();
  if (keeps_names) {
    fs::create_directory(copy, failed);
    for (const fs::path& file : files) KERF_CHECK(copyFile(file, copy / file.filename()));
  } else {
    KERF_CHECK(copyFile(path, copy));
  }
  manifest.sources.push_back(source);
  return &manifest.sources.back();
}

Expected<std::vector<Mesh>> readMeshSources(const std::vector<fs::path>& paths, const std::vector<std::string>& hashes,
                                            const std::string& unit, bool as_one, const fs::path& case_folder,
                                            BakeReport& out, const Progress& progress) {
  std::vector<MeshFile> files;
  Box3 common;              // of the meshes that declare no unit
  std::size_t largest = 0;  // of these
  double widest = 0;
  for (std::size_t n = 0; n < paths.size(); ++n) {
    if (!report(progress, static_cast<double>(n) / static_cast<double>(paths.size()),
                "reading " + paths[n].filename().string()))
      return cancelledBeforeWriting();
    KERF_TRY(file, readMesh(paths[n]));
    const Box3 box = bounds(file.mesh);
    if (file.declared_unit.empty()) common.add(box);
    if (file.declared_unit.empty() && box.size().norm() > widest) {
      widest = box.size().norm();
      largest = n;
    }
    files.push_back(std::move(file));
  }

  std::vector<Mesh> meshes;
  for (std::size_t n = 0; n < paths.size(); ++n) {
    MeshFile& file = files[n];
    auto choice =
        chooseUnit(as_one && file.declared_unit.empty() ? common : bounds(file.mesh), unit, file.declared_unit);
    if (!choice) {
      choice.error().file = paths[n].string();
      return fail(choice.error());
    }
    if (as_one && unit.empty() && file.declared_unit.empty())
      KERF_CHECK(requireOneUnit(paths[n], bounds(file.mesh), "", *choice, paths[n == largest ? 0 : largest]));

    KERF_TRY(source, storeSource(paths[n], std::string(file.format), hashes[n], case_folder, out.manifest));
    describeSource(file, *choice, *source);
    bringToMm(file, choice->scale_to_mm);
    out.unit_is_doubtful.push_back(choice->is_doubtful);
    out.notes.push_back(std::move(file.notes));
    meshes.push_back(std::move(file.mesh));
  }
  return meshes;
}

Expected<void> checkObjectSize(const std::vector<fs::path>& paths, const std::vector<Mesh>& meshes, bool is_whole,
                               const BakeOptions& options, const BakeReport& report) {
  Box3 box;
  for (const Mesh& mesh : meshes)
    for (const Triangle& f : mesh.triangles)
      for (const std::uint32_t v : f) box.add(mesh.vertices[v]);
  if (box.isEmpty()) return {};  // closing reports it

  const Vec3d size = box.size();
  const CaseSource& source = report.manifest.sources[0];
  const std::string object = fmt::format("an object of {:.4g} x {:.4g} x {:.4g} mm (unit {}: {})", size[0], size[1],
                                         size[2], source.unit, source.unit_reason);
  Error e{.code = Error::Code::kBadValue};
  if (paths.size() == 1) e.file = paths[0].string();

  // The box.
  const double h = options.voxelize.voxel_mm;
  if (size.norm() > kLargestObject) {
    e.place = "size";
    e.found = object;
    e.expected = fmt::format("at most {:g} mm across", kLargestObject);
    e.hint = "use another --unit, or none";
    return fail(std::move(e));
  }
  if (h > size.maxCoeff()) {
    e.place = "voxel size";
    e.found = fmt::format("{} mm for {}", h, object);
    e.expected = "an object larger than a voxel";
    e.hint = "use another --unit, or none; or a smaller --voxel";
    return fail(std::move(e));
  }

  // The memory.
  if (!is_whole) return {};
  const Mesh half = shrunkToKeptArea(meshes, size);
  const std::uint64_t most = std::min(options.voxelize.max_bytes, availableMemory() / 5 * 4);
  const std::uint64_t least = estimateBakeBytes(half, options.voxelize);
  if (least <= most) return {};
  const double fits = voxelThatFits(half, options.voxelize, most);
  e.place = "voxel size";
  e.found = fmt::format("{} mm would need {:.1f} GB or more for {}", h, static_cast<double>(least) / 1e9, object);
  e.expected = fmt::format("at most {:.1f} GB", static_cast<double>(most) / 1e9);
  e.hint = "use another --unit, or none";
  if (fits <= kLargestVoxel) e.hint += fmt::format("; or a coarser --voxel, {:.3f} or more", fits);
  return fail(std::move(e));
}

}  // namespace kerf::internal
