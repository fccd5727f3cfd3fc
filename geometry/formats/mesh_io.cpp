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

// Rejects common files that are no readable mesh, by their first bytes.
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

  if (text.substr(0, 132).ends_with("DICM") && text.size() >= 132)
    return refuse(
        "a DICOM image, one slice of a volume",
        "a recipe that takes the folder of the series (docs/reference/recipes.md), or export the surface as STL");

  constexpr const char* kSave = "save it as STL or PLY in the program that made it";
  constexpr struct {
    std::string_view begin, found;  // letters of any case
    const char* hint;
  } kForeign[] = {
      {"\x1f\x8b", "a gzip archive", "unpack it first (gunzip)"},
      {"7z\xbc\xaf\x27\x1c", "a 7z archive", "unpack it first"},
      {"rar!", "a RAR archive", "unpack it first"},
      {"version https://git-lfs", "a Git LFS pointer, not the file it stands for", "fetch the file: git lfs pull"},
      {"<!doctype html", "a web page (HTML)", "download the file itself: the server sent a page instead"},
      {"<html", "a web page (HTML)", "download the file itself: the server sent a page instead"},
      {"iso-10303-21", "a STEP file: surfaces of CAD, no triangles", kSave},
      {"gltf", "a binary glTF file", kSave},
      {"kaydara fbx", "an FBX file", kSave},
      {"; fbx", "an FBX file", kSave},
      {"blender", "a Blender file", kSave},
      {"#vrml", "a VRML file", kSave},
      {"3d geometry file format", "a Rhino file", kSave},
      {"%pdf", "a PDF file", "export the mesh itself"},
      {"\x89png", "a PNG picture", "name the mesh beside it"},
      {"\xff\xd8\xff", "a JPEG picture", "name the mesh beside it"},
      {"<?xml", "an XML file, but no mesh Kerf reads", kSave},
  };
  const std::size_t first = std::min(start.find_first_not_of(" \t\r\n"), start.size());
  for (const auto& foreign : kForeign)
    if (internal::equalsIgnoringCase(start.substr(first, foreign.begin.size()), foreign.begin))
      return refuse(std::string(foreign.found), foreign.hint);
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

Expected<MeshFile> readSource(MeshSource& source, const Progress& progress) {
  const auto recognised = [&]() -> const MeshFormatRow* {
    for (const MeshFormatRow& row : meshFormats())
      if (row.recognise && row.recognise(source)) return &row;
    return nullptr;
  };
  const MeshFormatRow* row = recognised();
  std::string_view encoding;
  if (MeshSource text; !row && !(encoding = internal::decodeText(source, text)).empty()) {
    std::swap(source, text);
    row = recognised();
    if (!row) std::swap(source, text);  // its bytes mean something else
  }

  const MeshFormatRow* by_name = formatOfExtension(source.extension());
  if (!row) {
    KERF_CHECK(refuseForeign(source));
    row = by_name;  // the reader of the extension gives the best error
  }
  if (!row || !row->read)
    return fail(source.atByte(0, Error::Code::kUnsupported,
                              "content of an unknown kind: " + internal::inQuotes(source.text().substr(0, 16)),
                              "a mesh file (" + readableExtensions() + ")", "export the mesh as STL or PLY"));

  Expected<MeshFile> file = row->read(source, progress);
  if (!file) return file;
  if (file->format.empty()) file->format = row->name;
  if (!encoding.empty()) file->notes.emplace_back(encoding);
  if (by_name != row && !source.extension().empty())
    file->notes.emplace_back("The extension \"" + source.extension() + "\" does not fit: by its content the file is " +
                             std::string(row->name) + "; it was read as such.");
  return file;
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
