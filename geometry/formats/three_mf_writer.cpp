// 3MF: an object and a build item for each named part, or one of all; millimetres. Text of shortest length that brings
// every float32 back.
#include <algorithm>
#include <charconv>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "geometry/base/xml_text.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/formats/zip_archive.h"

namespace kerf::internal {
namespace {

constexpr const char* kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
 <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
 <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";
constexpr const char* kRelations =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
 <Relationship Id="model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/>
</Relationships>
)";
constexpr int kColorGroup = 1;
constexpr std::size_t kFirstObject = 2;

template <class Number>
void append(std::string& text, const char* before, Number value, const char* after = "\"") {
  char digits[32];
  text += before;
  text.append(digits, static_cast<std::size_t>(std::to_chars(digits, digits + sizeof digits, value).ptr - digits));
  text += after;
}

// An object of the file.
struct WrittenObject {
  std::string_view name;
  std::size_t first = 0;                ///< of its triangles in the mesh
  std::vector<std::uint32_t> vertices;  ///< of the mesh, in its order
  std::vector<Triangle> triangles;      ///< of positions in `vertices`
};

// Every edge between exactly two triangles that run along it in opposite directions, as type "model" requires.
bool isClosedManifold(const std::vector<Triangle>& triangles) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::uint64_t{t[k]} << 32 | t[(k + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
  return std::all_of(edges.begin(), edges.end(), [&](std::uint64_t e) {
    return std::binary_search(edges.begin(), edges.end(), e << 32 | e >> 32);
  });
}

// The colours of a mesh, each once, numbered in order of first appearance.
class Palette {
 public:
  explicit Palette(const std::vector<Rgba8>& colors) {
    index_.reserve(colors.size());
    for (const Rgba8& c : colors) {
      const std::uint32_t key = std::uint32_t{c[0]} << 24 | std::uint32_t{c[1]} << 16 | std::uint32_t{c[2]} << 8 | c[3];
      const auto [at, is_new] = numbers_.try_emplace(key, static_cast<std::uint32_t>(numbers_.size()));
      if (is_new) keys_.push_back(key);
      index_.push_back(at->second);
    }
  }
  std::uint32_t operator[](std::size_t i) const { return index_[i]; }
  bool isEmpty() const { return keys_.empty(); }
  void write(std::string& text) const {
    constexpr const char* kHex = "0123456789ABCDEF";
    append(text, "  <m:colorgroup id=\"", kColorGroup, "\">\n");
    for (const std::uint32_t key : keys_) {
      text += "   <m:color color=\"#";
      for (int shift = 28; shift >= 0; shift -= 4) text += kHex[key >> shift & 15];
      text += "\"/>\n";
    }
    text += "  </m:colorgroup>\n";
  }

 private:
  std::unordered_map<std::uint32_t, std::uint32_t> numbers_;
  std::vector<std::uint32_t> keys_, index_;
};

Expected<void> checkWritable(const Mesh& mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (const Triangle& v = mesh.triangles[t]; v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
      return fail({.code = Error::Code::kGeometry,
                   .place = "triangle " + std::to_string(t),
                   .found = "a triangle that repeats a vertex",
                   .expected = "three different vertices, as 3MF demands",
                   .hint = "repair the mesh first, or write PLY or OBJ"});
  if (mesh.vertices.size() > 0x7fffffffu)
    return fail({.code = Error::Code::kUnsupported,
                 .place = "vertices",
                 .found = std::to_string(mesh.vertices.size()) + " vertices",
                 .expected = "at most 2 147 483 647, as 3MF demands",
                 .hint = "write PLY instead"});
  return {};
}

// Without names all vertices of the mesh, used or not; else each part those that it uses.
std::vector<WrittenObject> writtenObjects(const Mesh& mesh, const std::vector<NamedPart>& objects) {
  std::vector<WrittenObject> out;
  if (objects.size() <= 1) {
    WrittenObject& all = out.emplace_back();
    if (!objects.empty()) all.name = objects[0].name;
    all.vertices.resize(mesh.vertices.size());
    std::iota(all.vertices.begin(), all.vertices.end(), 0u);
    all.triangles = mesh.triangles;
    return out;
  }

  std::vector<std::uint32_t> place(mesh.vertices.size());  // in the part being made
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const std::size_t end = n + 1 < objects.size() ? objects[n + 1].first_triangle : mesh.triangles.size();
    WrittenObject part{objects[n].name, objects[n].first_triangle, {}, {}};
    for (std::size_t t = part.first; t < end; ++t)
      part.vertices.insert(part.vertices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(part.vertices.begin(), part.vertices.end());
    part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
    for (std::uint32_t v = 0; v < part.vertices.size(); ++v) place[part.vertices[v]] = v;
    for (std::size_t t = part.first; t < end; ++t) {
      const Triangle& v = mesh.triangles[t];
      part.triangles.push_back({place[v[0]], place[v[1]], place[v[2]]});
    }
    out.push_back(std::move(part));
  }
  return out;
}

void appendVertices(std::string& text, const Mesh& mesh, const WrittenObject& part) {
  for (const std::uint32_t v : part.vertices) {
    const Vec3d& p = mesh.vertices[v];
    append(text, "<vertex x=\"", static_cast<float>(p.x()));
    append(text, " y=\"", static_cast<float>(p.y()));
    append(text, " z=\"", static_cast<float>(p.z()), "\"/>\n");
  }
}

// The palette colours whole triangles, or their corners, or is unused.
void appendTriangles(std::string& text, const WrittenObject& part, const Palette& palette, bool by_face,
                     bool by_vertex) {
  for (std::size_t t = 0; t < part.triangles.size(); ++t) {
    const Triangle& v = part.triangles[t];
    append(text, "<triangle v1=\"", v[0]);
    append(text, " v2=\"", v[1]);
    append(text, " v3=\"", v[2]);
    if (by_face) append(text, " p1=\"", palette[part.first + t]);
    if (by_vertex) {
      append(text, " p1=\"", palette[part.vertices[v[0]]]);
      append(text, " p2=\"", palette[part.vertices[v[1]]]);
      append(text, " p3=\"", palette[part.vertices[v[2]]]);
    }
    text += "/>\n";
  }
}

}  // namespace

Expected<void> writeThreeMf(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options) {
  KERF_CHECK(checkWritable(mesh));
  const bool by_face = options.colors && mesh.hasFaceColors(),
             by_vertex = options.colors && !by_face && mesh.hasVertexColors();
  const Palette palette(by_face ? mesh.face_colors : by_vertex ? mesh.vertex_colors : std::vector<Rgba8>{});

  std::string text;
  text.reserve(1024 + 60 * mesh.vertices.size() + 60 * mesh.triangles.size());
  text +=
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"";
  if (!palette.isEmpty()) text += " xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"";
  text += ">\n";
  if (!options.comment.empty()) text += " <metadata name=\"Application\">" + xmlText(options.comment) + "</metadata>\n";

  text += " <resources>\n";
  if (!palette.isEmpty()) palette.write(text);

  const std::vector<WrittenObject> parts = writtenObjects(mesh, options.objects);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    append(text, "  <object id=\"", kFirstObject + n);
    if (!parts[n].name.empty()) text += " name=\"" + xmlText(parts[n].name) + '"';
    // An open surface must not have the type "model".
    text += isClosedManifold(parts[n].triangles) ? " type=\"model\"" : " type=\"surface\"";
    if (!palette.isEmpty()) {
      append(text, " pid=\"", kColorGroup);
      text += " pindex=\"0\"";
    }
    text += ">\n   <mesh>\n    <vertices>\n";
    appendVertices(text, mesh, parts[n]);
    text += "    </vertices>\n    <triangles>\n";
    appendTriangles(text, parts[n], palette, by_face, by_vertex);
    text += "    </triangles>\n   </mesh>\n  </object>\n";
  }
  text += " </resources>\n <build>\n";
  for (std::size_t n = 0; n < parts.size(); ++n) append(text, "  <item objectid=\"", kFirstObject + n, "\"/>\n");
  text += " </build>\n</model>\n";
  return writeZip(
      out,
      {{"[Content_Types].xml", kContentTypes}, {"_rels/.rels", kRelations}, {"3D/3dmodel.model", std::move(text)}});
}

}  // namespace kerf::internal
