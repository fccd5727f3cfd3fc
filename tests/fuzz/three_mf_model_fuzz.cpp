// The XML in a 3MF file, packed for each input. The bytes after a zero byte are a second model part, "/3D/other.model".
// The harness writes the mesh and reads it again: it must be the same, rounded to float32.
#include <cmath>
#include <sstream>
#include <string>

#include "geometry/formats/zip_archive.h"
#include "tests/fuzz/mesh_harness.h"

namespace {

using namespace kerf;

constexpr const char* kRelations =
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"0\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" Target=\"/3D/3dmodel.model\"/>"
    "</Relationships>";

const MeshFormatRow& format() { return *formatOfExtension(".3mf"); }

Expected<MeshFile> readPackage(const std::string& bytes) {
  internal::MeshSource source;
  source.file = "input.3mf";
  source.bytes.reset(new char[bytes.size()]);
  source.size = bytes.size();
  std::memcpy(source.bytes.get(), bytes.data(), bytes.size());
  fuzz::require(format().recognise(source), "a package is recognised");
  return format().read(source, Progress{});
}

bool canBeWritten(const Mesh& mesh) {
  for (const Triangle& t : mesh.triangles)
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
  for (const Vec3d& p : mesh.vertices)
    if (!p.cast<float>().allFinite()) return false;
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t split = text.find('\0');
  std::vector<internal::ZipEntry> entries{{"_rels/.rels", kRelations}, {"3D/3dmodel.model", text.substr(0, split)}};
  if (split != text.npos) entries.push_back({"3D/other.model", text.substr(split + 1)});
  std::ostringstream package;
  fuzz::require(internal::writeZip(package, entries).has_value(), "packing");
  const Expected<MeshFile> file = readPackage(package.str());
  if (!file) {
    fuzz::requireError(file.error());
    return 0;
  }
  fuzz::requireMesh(*file);
  if (!canBeWritten(file->mesh)) return 0;
  std::ostringstream written;
  fuzz::require(format().write(written, file->mesh, {}).has_value(), "what was read can be written");
  const Expected<MeshFile> again = readPackage(written.str());
  fuzz::require(again.has_value(), "what was written can be read");
  fuzz::require(again->mesh.triangles == file->mesh.triangles, "triangles come back");
  fuzz::require(again->mesh.vertices.size() == file->mesh.vertices.size(), "vertices come back");
  for (std::size_t v = 0; v < file->mesh.vertices.size(); ++v)
    fuzz::require(roundedToFloat(again->mesh.vertices[v]) == roundedToFloat(file->mesh.vertices[v]),
                  "positions come back");
  if (file->mesh.hasFaceColors())
    fuzz::require(again->mesh.face_colors == file->mesh.face_colors, "face colours come back");
  return 0;
}
