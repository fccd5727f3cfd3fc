#include "geometry/formats/mesh_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>

#include "geometry/base/atomic_file.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_source.h"

namespace kerf {

namespace {

Expected<const MeshFormatRow*> writerOf(const std::filesystem::path& path) {
  const MeshFormatRow* row = formatOfExtension(path.extension().string());
  if (row != nullptr && row->write != nullptr) return row;
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .place = "extension",
               .found = internal::inQuotes(path.extension().string()),
               .expected = "one of " + writableExtensions(),
               .hint = "end the name with the format wanted"});
}

constexpr const char* kOtherDisk = "write to another disk; the file was not replaced";

// Disks, memory and libraries fail, and a printer would print the result.
Expected<void> requireReadsBack(const std::filesystem::path& written, const MeshFormatRow& row, const Mesh& mesh,
                                bool double_positions) {
  auto read = [&]() -> Expected<MeshFile> {
    KERF_TRY(source, internal::loadMeshSource(written));
    return row.read(source, {});
  }();
  if (read) return internal::requireSameTriangles(read->mesh, mesh, double_positions);
  return fail({.code = Error::Code::kWriteFailed,
               .place = "reading back",
               .found = read.error().found,
               .expected = "the mesh just written",
               .hint = kOtherDisk});
}

}  // namespace

Expected<void> internal::requireSameTriangles(const Mesh& read, const Mesh& written, bool double_positions) {
  const auto refuse = [](std::string found, std::string expected) {
    return fail({.code = Error::Code::kWriteFailed,
                 .place = "reading back",
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = kOtherDisk});
  };
  if (read.triangles.size() != written.triangles.size())
    return refuse(fmt::format("{} triangles", read.triangles.size()), std::to_string(written.triangles.size()));
  for (std::size_t t = 0; t < written.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec3d is = read.corner(t, k), wanted = written.corner(t, k);
      if (double_positions ? is == wanted : is.cast<float>() == wanted.cast<float>()) continue;
      return refuse(fmt::format("triangle {} at {:.9g}, {:.9g}, {:.9g}", t, is[0], is[1], is[2]),
                    fmt::format("{:.9g}, {:.9g}, {:.9g}", wanted[0], wanted[1], wanted[2]));
    }
  return {};
}

Expected<void> canWriteMesh(const std::filesystem::path& path) {
  KERF_CHECK(writerOf(path));
  return canWriteFile(path);
}

Expected<void> canWriteFile(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored)) {
    // A pipe or a device: its reader would treat a trial opening as the real one.
    if (!std::filesystem::is_directory(path, ignored) && access(path.c_str(), W_OK) == 0) return {};
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .found = std::filesystem::is_directory(path, ignored) ? "a folder" : "it cannot be written",
                 .expected = "a file",
                 .hint = "choose another name"});
  }
  KERF_CHECK(AtomicFile::create(path));
  return {};
}

Expected<void> writeMesh(const std::filesystem::path& path, const Mesh& mesh, const MeshWriteOptions& options) {
  KERF_TRY(row, writerOf(path));

  // Values beyond float32 would read back as infinity.
  if (!(options.double_positions && row->carries.doubles))
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      if (!mesh.vertices[v].cast<float>().allFinite())
        return fail({.code = Error::Code::kBadValue,
                     .file = path.string(),
                     .place = "vertex " + std::to_string(v),
                     .found = "a coordinate too large for float32",
                     .expected = "less than 3.4e38",
                     .hint = "check the unit and scale of the mesh"});

  MeshWriteOptions cleaned = options;
  for (char& c : cleaned.comment)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  for (NamedPart& part : cleaned.objects) part.name = objectName(part.name);

  KERF_TRY(file, AtomicFile::create(path));
  if (auto written = row->write(file.stream(), mesh, cleaned); !written) {
    Error error = std::move(written).error();
    error.file = path.string();
    return fail(std::move(error));
  }
  KERF_TRY(bytes, file.flushed());
  if (!bytes.empty() && !mesh.triangles.empty() && row->read != nullptr) {
    auto same = requireReadsBack(bytes, *row, mesh, options.double_positions && row->carries.doubles);
    if (!same) {
      same.error().file = path.string();
      return same;
    }
  }
  return file.commit();
}

}  // namespace kerf
