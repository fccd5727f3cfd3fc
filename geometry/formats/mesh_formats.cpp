#include "geometry/formats/mesh_formats.h"

#include <algorithm>
#include <vector>

#include "geometry/formats/mesh_source.h"

namespace kerf {
namespace internal {

// Defined in the sources of the formats.
MeshRecogniser isStl, isPly, isOff, isThreeMf, isObj;
MeshReader readStl, readPly, readOff, readThreeMf, readObj;
MeshWriter writeStl, writePly, writeOff, writeThreeMf, writeObj;

}  // namespace internal

namespace {

using namespace internal;

// In the order of recognition: the size of a binary STL is the surest sign, a line that begins with "v" the weakest.
constexpr MeshFormatRow kFormats[] = {
    {.name = "STL", .extensions = ".stl", .recognise = isStl, .read = readStl, .write = writeStl},
    {.name = "PLY",
     .extensions = ".ply",
     .carries = {.vertex_colors = true, .face_colors = true, .doubles = true},
     .recognise = isPly,
     .read = readPly,
     .write = writePly},
    {.name = "OFF",
     .extensions = ".off .coff .noff",
     .carries = {.vertex_colors = true, .face_colors = true},
     .recognise = isOff,
     .read = readOff,
     .write = writeOff},
    {.name = "3MF",
     .extensions = ".3mf",
     .carries = {.vertex_colors = true, .face_colors = true, .object_names = true, .unit = true},
     .recognise = isThreeMf,
     .read = readThreeMf,
     .write = writeThreeMf},
    {.name = "OBJ",
     .extensions = ".obj",
     .carries = {.vertex_colors = true, .object_names = true},
     .recognise = isObj,
     .read = readObj,
     .write = writeObj},
};

#ifndef __SANITIZE_ADDRESS__  // GCC 12 then takes no address of a function for a constant
// An incomplete row does not compile.
constexpr bool isComplete(const MeshFormatRow& row) {
  const bool is_spelled =
      !row.name.empty() && row.extensions.starts_with('.') &&
      std::none_of(row.extensions.begin(), row.extensions.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  const bool is_read_or_not = (row.recognise == nullptr) == (row.read == nullptr);
  return is_spelled && is_read_or_not && (row.read != nullptr || row.write != nullptr);
}
static_assert(std::all_of(std::begin(kFormats), std::end(kFormats), isComplete),
              "a format needs a name, extensions in lower case, and a recogniser with its reader, or a writer");
#endif

// The first word of `extensions`.
std::string usualExtension(const MeshFormatRow& row) { return std::string(Words(row.extensions).next()); }
std::string nameOf(const MeshFormatRow& row) { return std::string(row.name); }

bool isRead(const MeshFormatRow& row) { return row.read != nullptr; }
bool isWritten(const MeshFormatRow& row) { return row.write != nullptr; }
bool isWrittenInColor(const MeshFormatRow& row) {
  return isWritten(row) && (row.carries.vertex_colors || row.carries.face_colors);
}

// "A, B, C": of the rows wanted, with `last` before the last one.
std::string list(bool (*wanted)(const MeshFormatRow&), std::string (*text)(const MeshFormatRow&), const char* last) {
  std::vector<std::string> words;
  for (const MeshFormatRow& row : kFormats)
    if (wanted(row)) words.push_back(text(row));

  std::string out;
  for (std::size_t n = 0; n < words.size(); ++n) out += (n == 0 ? "" : n + 1 == words.size() ? last : ", ") + words[n];
  return out;
}

}  // namespace

std::span<const MeshFormatRow> meshFormats() { return kFormats; }

const MeshFormatRow* formatOfExtension(std::string_view extension) {
  for (const MeshFormatRow& row : kFormats) {
    Words words(row.extensions);
    for (std::string_view e = words.next(); !e.empty(); e = words.next())
      if (equalsIgnoringCase(extension, e)) return &row;
  }
  return nullptr;
}

std::string readableExtensions() { return list(isRead, usualExtension, ", "); }
std::string writableExtensions() { return list(isWritten, usualExtension, ", "); }
std::string readableFormats() { return list(isRead, nameOf, " or "); }
std::string writableFormats() { return list(isWritten, nameOf, " or "); }
std::string colorFormats() { return list(isWrittenInColor, nameOf, " or "); }

}  // namespace kerf
