// 3MF: one object, one build item, millimetres. Text of shortest length that brings every float32 back.
#include <algorithm>
#include <charconv>
#include <unordered_map>

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
constexpr int kColorGroup = 1, kObject = 2;

template <class Number>
void append(std::string& text, const char* before, Number value, const char* after = "\"") {
  char digits[32];
  text += before;
  text.append(digits, static_cast<std::size_t>(std::to_chars(digits, digits + sizeof digits, value).ptr - digits));
  text += after;
}

// Every edge between exactly two triangles that run along it in opposite directions: what type "model" promises.
bool isClosedManifold(const Mesh& mesh) {
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
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

void appendVertices(std::string& text, const Mesh& mesh) {
  for (const Vec3d& p : mesh.vertices) {
    append(text, "<vertex x=\"", static_cast<float>(p.x()));
    append(text, " y=\"", static_cast<float>(p.y()));
    append(text, " z=\"", static_cast<float>(p.z()), "\"/>\n");
  }
}

// The palette colours whole triangles, or their corners, or nothing.
void appendTriangles(std::string& text, const Mesh& mesh, const Palette& palette, bool by_face, bool by_vertex) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& v = mesh.triangles[t];
    append(text, "<triangle v1=\"", v[0]);
    append(text, " v2=\"", v[1]);
    append(text, " v3=\"", v[2]);
    if (by_face) append(text, " p1=\"", palette[t]);
    if (by_vertex) {
      append(text, " p1=\"", palette[v[0]]);
      append(text, " p2=\"", palette[v[1]]);
      append(text, " p3=\"", palette[v[2]]);
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

  append(text, "  <object id=\"", kObject);
  // An open surface may not call itself a model.
  text += isClosedManifold(mesh) ? " type=\"model\"" : " type=\"surface\"";
  if (!palette.isEmpty()) {
    append(text, " pid=\"", kColorGroup);
    text += " pindex=\"0\"";
  }
  text += ">\n   <mesh>\n    <vertices>\n";
  appendVertices(text, mesh);
  text += "    </vertices>\n    <triangles>\n";
  appendTriangles(text, mesh, palette, by_face, by_vertex);
  text += "    </triangles>\n   </mesh>\n  </object>\n </resources>\n <build>\n";
  append(text, "  <item objectid=\"", kObject, "\"/>\n </build>\n</model>\n");
  return writeZip(
      out,
      {{"[Content_Types].xml", kContentTypes}, {"_rels/.rels", kRelations}, {"3D/3dmodel.model", std::move(text)}});
}

}  // namespace kerf::internal
