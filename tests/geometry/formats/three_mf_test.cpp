// 3MF: the specification on packages written by hand; Kerf's output, judged by lib3mf where it is installed.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/formats/zip_archive.h"
#include "geometry/mesh/mesh_check.h"
#include "tests/support/temporary_folder.h"
#ifdef KERF_HAS_LIB3MF
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif
#include <Model/COM/NMR_DLLInterfaces.h>
#endif

namespace kerf::three_mf_test {
namespace {

constexpr const char* kRelations =
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"0\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" Target=\"/3D/Part.model\"/>"
    "</Relationships>";
const std::string kVertices =
    "<vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1.5\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"0.1\" "
    "z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"-3e-5\"/></vertices>";
const std::string kMesh =
    "<mesh>" + kVertices +
    "<triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/><triangle v1=\"0\" v2=\"3\" v3=\"1\"/>"
    "<triangle v1=\"1\" v2=\"3\" v3=\"2\"/><triangle v1=\"0\" v2=\"2\" v3=\"3\"/></triangles></mesh>";

std::string model(const std::string& resources, const std::string& build, const std::string& attributes = "") {
  return "<?xml version=\"1.0\"?>\n<model xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" "
         "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" "
         "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" " +
         attributes + ">\n<resources>" + resources + "</resources>\n<build>" + build + "</build></model>";
}
std::string object(int id, const std::string& content = kMesh, const std::string& attributes = "") {
  return "<object id=\"" + std::to_string(id) + "\" " + attributes + ">" + content + "</object>";
}
const std::string kItem = "<item objectid=\"1\"/>";

std::string packed(const std::vector<internal::ZipEntry>& entries) {
  std::ostringstream out;
  EXPECT_TRUE(internal::writeZip(out, entries));
  return out.str();
}
std::string package(const std::string& xml) { return packed({{"_rels/.rels", kRelations}, {"3D/Part.model", xml}}); }

class ThreeMf : public testing::Test {
 protected:
  Expected<MeshFile> read(const std::string& bytes) { return readMesh(folder_.write("a.3mf", bytes)); }
  MeshFile good(const std::string& bytes) {
    auto file = read(bytes);
    EXPECT_TRUE(file) << file.error().message();
    return file ? *file : MeshFile{};
  }
  Error refused(const std::string& bytes) {
    const auto file = read(bytes);
    EXPECT_FALSE(file);
    if (file) return {};
    EXPECT_EQ(file.error().file, (folder_.path() / "a.3mf").string());
    EXPECT_FALSE(file.error().place.empty() || file.error().found.empty() || file.error().hint.empty())
        << file.error().message();
    return file.error();
  }
  std::string refusal(const std::string& bytes) { return refused(bytes).message(); }
  TemporaryFolder folder_;
};

TEST_F(ThreeMf, ObjectsHaveTheirNamesOrThatOfWhatTheyAreIn) {
  const std::string parts = "<components><component objectid=\"1\"/><component objectid=\"2\"/></components>";
  const MeshFile file = good(
      package(model(object(1) + object(2, kMesh, "name=\"gingiva &amp; bone&#10;\"") + object(3, parts, "name=\"jaw\""),
                    "<item objectid=\"1\"/><item objectid=\"3\"/>")));
  EXPECT_EQ(file.objects, (std::vector<NamedPart>{{"", 0}, {"jaw", 4}, {"gingiva & bone", 8}}));
  EXPECT_EQ(good(package(model(object(1), kItem))).objects, std::vector<NamedPart>{});
}

TEST_F(ThreeMf, VerticesAndTrianglesKeepTheirOrder) {
  const MeshFile file = good(package(model(object(1), kItem)));
  EXPECT_EQ(file.format, "3MF");
  EXPECT_EQ(file.mesh.vertices, (std::vector<Vec3d>{{0, 0, 0}, {1.5, 0, 0}, {0, 0.1, 0}, {0, 0, -3e-5}}));
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}}));
  EXPECT_FALSE(file.had_double_coordinates);
  EXPECT_FALSE(file.mesh.hasVertexColors() || file.mesh.hasFaceColors());
  EXPECT_TRUE(file.notes.empty());
}

TEST_F(ThreeMf, UnitIsDeclaredAndMillimetreWithoutOne) {
  const std::pair<const char*, const char*> units[] = {{"", "mm"},
                                                       {"unit=\"micron\"", "um"},
                                                       {"unit=\"millimeter\"", "mm"},
                                                       {"unit=\"centimeter\"", "cm"},
                                                       {"unit=\"inch\"", "inch"},
                                                       {"unit=\"meter\"", "m"}};
  for (const auto& [attribute, unit] : units)
    EXPECT_EQ(good(package(model(object(1), kItem, attribute))).declared_unit, unit) << attribute;
  const MeshFile feet = good(package(model(object(1), kItem, "unit=\"foot\"")));
  EXPECT_EQ(feet.declared_unit, "inch");
  EXPECT_EQ(feet.mesh.vertices[1].x(), 18);
  EXPECT_NE(refusal(package(model(object(1), kItem, "unit=\"furlong\""))).find("millimeter"), std::string::npos);
}

TEST_F(ThreeMf, ItemsAndComponentsAreUnitedWhereTheBuildPutsThem) {
  // Row vectors: x -> y, y -> z, z -> x, then 10 along x.
  const std::string turned = "transform=\"0 1 0 0 0 1 1 0 0 10 0 0\"";
  const std::string pair =
      "<components><component objectid=\"1\"/><component objectid=\"1\" " + turned + "/></components>";
  const MeshFile file = good(package(
      model(object(1) + object(2, pair), "<item objectid=\"2\" transform=\"2 0 0 0 2 0 0 0 2 0 0 1\"/>" + kItem)));
  ASSERT_EQ(file.mesh.vertices.size(), 12u);
  ASSERT_EQ(file.mesh.triangles.size(), 12u);
  EXPECT_EQ(file.mesh.vertices[1], Vec3d(3, 0, 1));    // component unchanged, item twice as large and 1 up
  EXPECT_EQ(file.mesh.vertices[5], Vec3d(20, 3, 1));   // rotated first
  EXPECT_EQ(file.mesh.vertices[9], Vec3d(1.5, 0, 0));  // the second item
  EXPECT_EQ(file.mesh.triangles[4], (Triangle{4, 5, 6}));
  ASSERT_EQ(file.notes.size(), 2u);
  EXPECT_NE(file.notes[0].find("2 build items, 3 objects"), std::string::npos) << file.notes[0];
}

TEST_F(ThreeMf, MirroredObjectsKeepTheirOutsideOutside) {
  const MeshFile file =
      good(package(model(object(1), "<item objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/>")));
  EXPECT_EQ(file.mesh.triangles[0], (Triangle{0, 2, 1}));
  const MeshFile upright = good(package(model(object(1), kItem)));
  EXPECT_DOUBLE_EQ(signedVolume(file.mesh), signedVolume(upright.mesh));
}

TEST_F(ThreeMf, PartsOfTheProductionExtensionAreFollowed) {
  const std::string xml = model(object(1,
                                       "<components><component objectid=\"7\" p:path=\"/3D/Objects/tooth.model\"/>"
                                       "</components>"),
                                kItem, "requiredextensions=\"p\"");
  const std::string part = model(object(7), "<item objectid=\"7\"/>");  // its build does not count
  EXPECT_EQ(good(packed({{"_rels/.rels", kRelations}, {"3D/Part.model", xml}, {"3d/objects/Tooth.model", part}}))
                .mesh.triangles.size(),
            4u);
  EXPECT_NE(refusal(package(xml)).find("tooth.model"), std::string::npos);
  EXPECT_NE(
      refusal(packed({{"_rels/.rels", kRelations}, {"3D/Part.model", xml}, {"3D/Objects/tooth.model", model("", "")}}))
          .find("no object 7"),
      std::string::npos);
}

TEST_F(ThreeMf, ColoursOfTrianglesOfObjectsAndOfCorners) {
  const std::string palette =
      "<m:colorgroup id=\"5\"><m:color color=\"#0A141E\"/><m:color color=\"#ff000080\"/></m:colorgroup>"
      "<basematerials id=\"6\"><base name=\"enamel\" displaycolor=\"#FFFFF0\"/></basematerials>";
  const std::string triangles =
      "<triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"5\" p1=\"1\"/><triangle v1=\"0\" v2=\"3\" v3=\"1\"/>"
      "<triangle v1=\"1\" v2=\"3\" v3=\"2\" p1=\"0\"/>";
  const auto colored = [&](const std::string& more) {
    return package(
        model(palette + object(1, "<mesh>" + kVertices + "<triangles>" + triangles + more + "</triangles></mesh>",
                               "pid=\"6\" pindex=\"0\""),
              kItem));
  };
  const MeshFile flat = good(colored(""));
  EXPECT_EQ(flat.mesh.face_colors, (std::vector<Rgba8>{{255, 0, 0, 128}, {255, 255, 240, 255}, {255, 255, 240, 255}}));
  EXPECT_FALSE(flat.mesh.hasVertexColors());
  const MeshFile shaded = good(colored("<triangle v1=\"0\" v2=\"2\" v3=\"3\" pid=\"5\" p1=\"1\" p2=\"1\" p3=\"0\"/>"));
  EXPECT_FALSE(shaded.mesh.hasFaceColors());
  EXPECT_EQ(shaded.mesh.vertex_colors[0], (Rgba8{255, 0, 0, 128}));
  EXPECT_EQ(shaded.mesh.vertex_colors[3], (Rgba8{255, 255, 240, 255}));
  ASSERT_EQ(shaded.notes.size(), 1u);
  EXPECT_NE(shaded.notes[0].find("colour"), std::string::npos);
}

TEST_F(ThreeMf, WhatIsNotReadIsSaid) {
  const std::string texture = "<m:texture2dgroup id=\"3\" texid=\"4\"/>";
  const MeshFile file =
      good(package(model(texture + object(1, kMesh, "pid=\"3\"") + object(2, kMesh, "type=\"support\""),
                         kItem + "<item objectid=\"2\"/>")));
  ASSERT_EQ(file.notes.size(), 2u);
  EXPECT_NE(file.notes[0].find("1 supports"), std::string::npos);
  EXPECT_NE(file.notes[1].find("texture2dgroup"), std::string::npos);
}

TEST_F(ThreeMf, MalformedPackagesAreRefusedWithPlaceAndReason) {
  const auto changed = [](std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::string xml = model(object(1), kItem), whole = package(xml);
  const auto withComponents = [](const std::string& components) {
    return model(object(1) + object(2, "<components>" + components + "</components>"), "<item objectid=\"2\"/>");
  };
  const struct {
    std::string bytes;
    Error::Code code;
    const char* says;
  } cases[] = {
      {whole.substr(0, whole.size() / 2), Error::Code::kBadFormat, "zip"},
      {packed({{"3D/Part.model", xml}, {"x_rels/.rels", kRelations}}), Error::Code::kBadFormat, "no part"},
      {packed({{"_rels/.rels", kRelations}, {"3D/Other.model", xml}}), Error::Code::kBadFormat, "Part.model"},
      {packed({{"_rels/.rels", "<Relationships/>"}, {"3D/Part.model", xml}}), Error::Code::kBadFormat, "relationship"},
      {package(xml.substr(0, xml.size() - 20)), Error::Code::kBadFormat, "XML"},
      {package(changed(xml, "core/2015/02", "core/1999/02")), Error::Code::kBadFormat, "core/1999"},
      {package("<!DOCTYPE model [<!ENTITY a \"b\">]>" + xml.substr(21)), Error::Code::kUnsupported, "document type"},
      {package(changed(xml, "x=\"1.5\"", "x=\"nan\"")), Error::Code::kBadValue, "finite"},
      {package(changed(xml, "x=\"1.5\"", "x=\"1,5\"")), Error::Code::kBadValue, "1,5"},
      {package(changed(xml, "x=\"1.5\"", "")), Error::Code::kBadValue, "attribute x missing"},
      {package(changed(xml, "v3=\"2\"", "v3=\"4\"")), Error::Code::kBadValue, "0 to 4 - 1"},
      {package(changed(xml, "v3=\"2\"", "v3=\"-1\"")), Error::Code::kBadValue, "-1"},
      {package(changed(xml, "v3=\"2\"", "v3=\"4294967297\"")), Error::Code::kBadValue, "4294967297"},
      {package(changed(xml, "v3=\"2\"", "v3=\"2\" pid=\"9\" p1=\"0\"")), Error::Code::kBadValue, "defined before"},
      {package(changed(xml, "objectid=\"1\"", "objectid=\"9\"")), Error::Code::kBadValue, "defined before"},
      {package(changed(xml, kItem, "<item objectid=\"1\" transform=\"1 0 0\"/>")), Error::Code::kBadValue,
       "12 numbers"},
      {package(changed(xml, kItem, "<item objectid=\"1\" transform=\"0 0 0 0 0 0 0 0 0 0 0 0\"/>")),
       Error::Code::kBadValue, "flattens"},
      {package(model(object(1) + object(1), kItem)), Error::Code::kBadValue, "taken"},
      {package(withComponents("<component objectid=\"2\"/>")), Error::Code::kBadValue, "itself"},
      {package(withComponents("<component objectid=\"3\"/>") + ""), Error::Code::kBadValue, "defined before"},
      {package(model("<m:colorgroup id=\"5\"><m:color color=\"red\"/></m:colorgroup>" + object(1), kItem)),
       Error::Code::kBadValue, "#RRGGBB"},
      {package(model(object(1), kItem, "requiredextensions=\"b\"")), Error::Code::kUnsupported, "beamlattice"},
      {package(model(object(1), "")), Error::Code::kEmpty, "nothing to build"},
      {package(model("", "")), Error::Code::kEmpty, "no faces"},
      {package(model(object(1, "<mesh>" + kVertices + "</mesh>"), kItem)), Error::Code::kEmpty, "no faces"},
  };
  for (const auto& c : cases) {
    const Error error = refused(c.bytes);
    EXPECT_EQ(error.code, c.code) << error.message();
    EXPECT_NE(error.message().find(c.says), std::string::npos) << "should say " << c.says << ": " << error.message();
  }
  EXPECT_NE(refused(package(changed(xml, "x=\"1.5\"", "x=\"nan\""))).place.find("line 3"), std::string::npos);
}

TEST_F(ThreeMf, ZipBombsAreRefusedBeforeTheyUnfold) {
  const std::string xml = model(object(1), kItem);
  const std::string bomb = package(xml + std::string(std::size_t{80} << 20, ' '));
  ASSERT_LT(bomb.size(), 200000u);
  EXPECT_NE(refusal(bomb).find("zip bomb"), std::string::npos);
  // An unterminated tag.
  const std::string tag = package("<model a=\"" + std::string(std::size_t{40} << 20, 'x'));
  EXPECT_NE(refusal(tag).find("longer than 1 MiB"), std::string::npos);
}

TEST_F(ThreeMf, CopiesOfCopiesAreRefusedBeforeTheyAreMade) {
  std::string resources = object(1);
  for (int level = 2; level < 22; ++level) {
    std::string components;
    for (int k = 0; k < 10; ++k) components += "<component objectid=\"" + std::to_string(level - 1) + "\"/>";
    resources += object(level, "<components>" + components + "</components>");
  }
  EXPECT_NE(refusal(package(model(resources, "<item objectid=\"21\"/>"))).find("copies of copies"), std::string::npos);
  // A chain of single copies is no risk to memory, but to the stack.
  resources = object(1);
  for (int level = 2; level < 200; ++level)
    resources += object(level, "<components><component objectid=\"" + std::to_string(level - 1) + "\"/></components>");
  EXPECT_NE(refusal(package(model(resources, "<item objectid=\"199\"/>"))).find("deeper"), std::string::npos);
}

// --- writing ---

// An octahedron with a colour per face and coordinates of 24 bits.
Mesh octahedron() {
  Mesh m;
  m.vertices = {{0.1, 0, 0}, {-1.0 / 3, 0, 0}, {0, 16777215, 0}, {0, -2, 0}, {0, 0, 1e-30}, {-0.0, 0, -1e-41}};
  m.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (std::uint8_t k = 0; k < 8; ++k) m.face_colors.push_back({k, static_cast<std::uint8_t>(255 - k % 3), 7, 255});
  return m;
}

TEST_F(ThreeMf, TheSameMeshGivesTheSameBytes) {
  ASSERT_TRUE(writeMesh(folder_.path() / "a.3mf", octahedron()));
  ASSERT_TRUE(writeMesh(folder_.path() / "b.3mf", octahedron()));
  EXPECT_EQ(contentOf(folder_.path() / "a.3mf"), contentOf(folder_.path() / "b.3mf"));
}

TEST_F(ThreeMf, ShadedColoursComeBack) {
  Mesh m = octahedron();
  m.face_colors.clear();
  for (std::uint8_t k = 0; k < 6; ++k) m.vertex_colors.push_back({k, 1, 2, static_cast<std::uint8_t>(200 + k)});
  ASSERT_TRUE(writeMesh(folder_.path() / "a.3mf", m));
  const auto file = readMesh(folder_.path() / "a.3mf");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->mesh.vertex_colors, m.vertex_colors);
  ASSERT_TRUE(writeMesh(folder_.path() / "a.3mf", m, {.colors = false}));
  EXPECT_FALSE(readMesh(folder_.path() / "a.3mf")->mesh.hasVertexColors());
}

TEST_F(ThreeMf, TrianglesThatRepeatAVertexAreRefused) {
  Mesh m = octahedron();
  m.triangles[3] = {3, 3, 4};
  const auto written = writeMesh(folder_.path() / "a.3mf", m);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().place, "triangle 3");
  EXPECT_EQ(folder_.entries(), 0u);
}

TEST_F(ThreeMf, CommentsAreEscaped) {
  ASSERT_TRUE(writeMesh(folder_.path() / "a.3mf", octahedron(), {.comment = "Kerf <&> \"1\" \xff"}));
  EXPECT_TRUE(readMesh(folder_.path() / "a.3mf"));
}

#ifdef KERF_HAS_LIB3MF

// lib3mf 1.8 never closes the archive entries it opens: not a leak of Kerf.
struct LeaksOfOthers {
#if defined(__SANITIZE_ADDRESS__)
  __lsan::ScopedDisabler off;
#endif
};

// lib3mf 1.8 of the 3MF Consortium, strict: warnings are failures.
class Lib3mf {
 public:
  explicit Lib3mf(const std::filesystem::path& file, bool has_more = false) {
    [[maybe_unused]] const LeaksOfOthers theirs;
    EXPECT_EQ(NMR::lib3mf_createmodel(&model_), 0);
    EXPECT_EQ(NMR::lib3mf_model_queryreader(model_, "3mf", &reader_), 0);
    EXPECT_EQ(NMR::lib3mf_reader_setstrictmodeactive(reader_, true), 0);
    read_ = NMR::lib3mf_reader_readfromfileutf8(reader_, file.c_str()) == 0;
    EXPECT_EQ(NMR::lib3mf_reader_getwarningcount(reader_, &warnings_), 0);
    if (!read_) return;
    NMR::PLib3MFModelResourceIterator* objects = nullptr;
    EXPECT_EQ(NMR::lib3mf_model_getmeshobjects(model_, &objects), 0);
    BOOL more = false;
    EXPECT_EQ(NMR::lib3mf_resourceiterator_movenext(objects, &more), 0);
    EXPECT_EQ(NMR::lib3mf_resourceiterator_getcurrent(objects, &object_), 0);
    EXPECT_EQ(NMR::lib3mf_resourceiterator_movenext(objects, &more), 0);
    EXPECT_EQ(more != 0, has_more) << "one object unless told";
    NMR::lib3mf_release(objects);
  }
  ~Lib3mf() {
    if (object_) NMR::lib3mf_release(object_);
    NMR::lib3mf_release(reader_);
    NMR::lib3mf_release(model_);
  }
  Lib3mf(const Lib3mf&) = delete;
  Lib3mf& operator=(const Lib3mf&) = delete;

  bool read() const { return read_ && warnings_ == 0; }
  NMR::eModelUnit unit() const {
    DWORD unit = 0;
    EXPECT_EQ(NMR::lib3mf_model_getunit(model_, &unit), 0);
    return static_cast<NMR::eModelUnit>(unit);
  }
  bool isManifoldAndOriented() const {
    BOOL good = false;
    EXPECT_EQ(NMR::lib3mf_meshobject_ismanifoldandoriented(object_, &good), 0);
    return good;
  }
  Mesh mesh() const {
    Mesh m;
    DWORD n = 0;
    EXPECT_EQ(NMR::lib3mf_meshobject_getvertexcount(object_, &n), 0);
    for (DWORD v = 0; v < n; ++v) {
      NMR::MODELMESHVERTEX p;
      EXPECT_EQ(NMR::lib3mf_meshobject_getvertex(object_, v, &p), 0);
      m.vertices.emplace_back(p.m_fPosition[0], p.m_fPosition[1], p.m_fPosition[2]);
    }
    EXPECT_EQ(NMR::lib3mf_meshobject_gettrianglecount(object_, &n), 0);
    for (DWORD t = 0; t < n; ++t) {
      NMR::MODELMESHTRIANGLE f;
      EXPECT_EQ(NMR::lib3mf_meshobject_gettriangle(object_, t, &f), 0);
      m.triangles.push_back({f.m_nIndices[0], f.m_nIndices[1], f.m_nIndices[2]});
    }
    return m;
  }

 private:
  NMR::PLib3MFModel* model_ = nullptr;
  NMR::PLib3MFModelReader* reader_ = nullptr;
  NMR::PLib3MFModelMeshObject* object_ = nullptr;
  bool read_ = false;
  DWORD warnings_ = 0;
};

TEST_F(ThreeMf, Lib3mfReadsWhatWeWriteStrictlyAndToTheSameMesh) {
  Mesh m = octahedron();
  m.vertices[2].y() = 5;
  m.vertices[4].z() = 3;
  m.vertices[5].z() = -3;  // lib3mf refuses beyond 10^6
  for (const bool shaded : {false, true}) {
    if (shaded) {
      m.vertex_colors.assign(6, Rgba8{1, 2, 3, 255});
      m.vertex_colors[0][0] = 9;
      m.face_colors.clear();
    }
    ASSERT_TRUE(writeMesh(folder_.path() / "a.3mf", m));
    const Lib3mf theirs(folder_.path() / "a.3mf");
    ASSERT_TRUE(theirs.read());
    EXPECT_EQ(theirs.unit(), NMR::MODELUNIT_MILLIMETER);
    EXPECT_TRUE(theirs.isManifoldAndOriented());
    const Mesh back = theirs.mesh();
    EXPECT_EQ(back.triangles, m.triangles);
    ASSERT_EQ(back.vertices.size(), m.vertices.size());
    for (std::size_t v = 0; v < m.vertices.size(); ++v) EXPECT_EQ(back.vertices[v], roundedToFloat(m.vertices[v]));
  }
}

TEST_F(ThreeMf, Lib3mfReadsNamedObjectsStrictly) {
  Mesh first = octahedron();
  first.vertices[2].y() = 5;
  first.vertices[4].z() = 3;
  first.vertices[5].z() = -3;
  Mesh both = first, second = first;
  for (Vec3d& p : second.vertices) p.x() += 20;
  append(both, second);
  MeshWriteOptions options;
  options.objects = {{"tooth <36> & \"37\"", 0}, {"\xef\xbf\xbf\x01 Z\xc3\xa4hne", first.triangles.size()}};
  ASSERT_TRUE(writeMesh(folder_.path() / "a.3mf", both, options));
  const Lib3mf theirs(folder_.path() / "a.3mf", true);
  ASSERT_TRUE(theirs.read());
  EXPECT_TRUE(theirs.isManifoldAndOriented());
  EXPECT_EQ(theirs.mesh().triangles, first.triangles);
}

TEST_F(ThreeMf, Lib3mfReadsOpenSurfacesWeWrite) {
  Mesh m = octahedron();
  m.vertices[2].y() = 5;
  m.vertices[4].z() = 3;
  m.vertices[5].z() = -3;
  m.triangles.pop_back();
  m.face_colors.pop_back();
  ASSERT_TRUE(writeMesh(folder_.path() / "a.3mf", m));
  const Lib3mf theirs(folder_.path() / "a.3mf");
  EXPECT_TRUE(theirs.read());
  EXPECT_FALSE(theirs.isManifoldAndOriented());
}

#endif

}  // namespace
}  // namespace kerf::three_mf_test
