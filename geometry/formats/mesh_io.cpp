#include "geometry/formats/mesh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_source.h"
#include "geometry/formats/mesh_stream.h"

namespace kerf {

namespace {

using internal::MeshSource;

// Files that are often dropped in but are no mesh we can read; told apart by their first bytes.
Expected<void> refuseForeign(const MeshSource& source) {
  const std::string_view text = source.text();
  const std::string_view start = text.substr(0, 4096);
  const auto refuse = [&](std::string found, std::string hint) {
    return fail(source.atByte(0, Error::Code::kUnsupported, std::move(found),
                              "a mesh file (" + readableExtensions() + ")", std::move(hint)));
  };

  if (source.hasExtension(".nrrd .nii .mha .mhd") || source.file.ends_with(".nii.gz"))
    return refuse("a label volume by its name, no mesh",
                  "a recipe that makes tissues of its labels (docs/reference/recipes.md); kerf info lists them");

  const std::string dcm_hint = "export as STL or PLY from the scanner software (\"open\" export in 3Shape)";
  const bool is_zip = text.starts_with("PK\x03\x04") || text.starts_with("PK\x05\x06");
  if ((is_zip && source.hasExtension(".dcm")) || start.find("<HPS") != start.npos)
    return refuse("a 3Shape DCM file, a closed format", dcm_hint);
  if (is_zip && !source.hasExtension(".3mf"))
    return refuse("a zip archive", "unpack it first; if it is a 3Shape DCM file, export as STL or PLY instead");

  if (text.starts_with("\x1f\x8b")) return refuse("a gzip archive", "unpack it first (gunzip)");
  if (text.starts_with("7z\xbc\xaf\x27\x1c")) return refuse("a 7z archive", "unpack it first");
  if (text.substr(0, 132).ends_with("DICM") && text.size() >= 132)
    return refuse(
        "a DICOM image, one slice of a volume",
        "a recipe that takes the folder of the series (docs/reference/recipes.md), or export the surface as STL");
  if (text.starts_with("glTF")) return refuse("a binary glTF file", "save it as PLY or STL");
  return {};
}

// Single precision, in which meshes are printed, knows such a place to a whole unit at best.
Expected<void> refuseFarOff(const MeshSource& source, const Mesh& mesh) {
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3d& p = mesh.vertices[v];
    if (p.allFinite() && p.cwiseAbs().maxCoeff() < kLargestCoordinate) continue;
    return fail({.code = Error::Code::kBadValue,
                 .file = source.file,
                 .place = fmt::format("vertex {}", v),
                 .found = fmt::format("{:g}, {:g}, {:g}", p.x(), p.y(), p.z()),
                 .expected = fmt::format("coordinates below {:g}", kLargestCoordinate),
                 .hint = "export the scan again: the file is damaged, or far from its origin"});
  }
  return {};
}

Expected<MeshFile> readSource(const MeshSource& source, const Progress& progress) {
  const MeshFormatRow* by_name = formatOfExtension(source.extension());
  for (const MeshFormatRow& row : meshFormats()) {
    if (!row.recognise || !row.recognise(source)) continue;
    Expected<MeshFile> file = row.read(source, progress);
    if (file && file->format.empty()) file->format = row.name;
    if (file && by_name != &row && !source.extension().empty())
      file->notes.emplace_back("The extension \"" + source.extension() +
                               "\" does not fit: by its content the file is " + std::string(row.name) +
                               ", and was read as such.");
    return file;
  }

  KERF_CHECK(refuseForeign(source));

  // Not recognised: the reader that the extension names knows best what is missing.
  if (by_name && by_name->read) {
    Expected<MeshFile> file = by_name->read(source, progress);
    if (file && file->format.empty()) file->format = by_name->name;
    return file;
  }
  return fail(source.atByte(0, Error::Code::kUnsupported,
                            "content of an unknown kind: " + internal::inQuotes(source.text().substr(0, 16)),
                            "a mesh file (" + readableExtensions() + ")", "export the mesh as STL or PLY"));
}

}  // namespace

Expected<MeshFile> readMeshStream(std::istream& in, const std::string& name) {
  try {
    std::string bytes;
    std::array<char, 1 << 16> part;
    while (in.read(part.data(), part.size()) || in.gcount() > 0) {
      bytes.append(part.data(), static_cast<std::size_t>(in.gcount()));
      if (bytes.size() > kLargestStream)
        return fail({.code = Error::Code::kUnreadable,
                     .file = name,
                     .found = "more than 4 GB",
                     .expected = "one mesh",
                     .hint = "a file in its place"});
    }
    MeshSource source{name, std::make_unique<char[]>(bytes.size() + 1), bytes.size()};
    std::copy(bytes.begin(), bytes.end(), source.bytes.get());
    KERF_TRY(file, readSource(source, {}));
    KERF_CHECK(refuseFarOff(source, file.mesh));
    return std::move(file);
  } catch (const std::bad_alloc&) {
    return fail({.code = Error::Code::kUnreadable,
                 .file = name,
                 .place = "reading",
                 .found = "the mesh does not fit into memory",
                 .hint = "reduce the mesh first, or close other programs"});
  }
}

Expected<MeshFile> readMesh(const std::filesystem::path& path, const Progress& progress) {
  try {
    KERF_TRY(source, internal::loadMeshSource(path));
    KERF_TRY(file, readSource(source, progress));
    KERF_CHECK(refuseFarOff(source, file.mesh));
    return std::move(file);
  } catch (const std::bad_alloc&) {
    return fail({.code = Error::Code::kUnreadable,
                 .file = path.string(),
                 .place = "reading",
                 .found = "the mesh does not fit into memory",
                 .hint = "reduce the mesh first, or close other programs"});
  }
}

}  // namespace kerf
