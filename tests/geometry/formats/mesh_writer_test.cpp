#include "geometry/formats/mesh_writer.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <locale>
#include <random>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "tests/support/temporary_folder.h"

namespace kerf::mesh_writer_test {
namespace {

// A bumpy closed grid on a torus: 2-manifold, every vertex different, coordinates that need all 24 bits, colours.
Mesh torus(std::uint32_t n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> bump(0.9, 1.1);
  std::uniform_int_distribution<int> byte(0, 255);
  const auto color = [&] {
    return Rgba8{static_cast<std::uint8_t>(byte(random)), static_cast<std::uint8_t>(byte(random)),
                 static_cast<std::uint8_t>(byte(random)), 255};
  };
  Mesh m;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const double u = 6.283185307179586 * i / n, v = 6.283185307179586 * j / n, r = 3 * bump(random);
      m.vertices.emplace_back((10 + r * std::cos(v)) * std::cos(u), (10 + r * std::cos(v)) * std::sin(u),
                              r * std::sin(v));
      m.vertex_colors.push_back(color());
      const std::uint32_t a = i * n + j, b = (i + 1) % n * n + j, c = (i + 1) % n * n + (j + 1) % n,
                          d = i * n + (j + 1) % n;
      m.triangles.push_back({a, b, c});
      m.triangles.push_back({a, c, d});
      m.face_colors.push_back(color());
      m.face_colors.push_back(color());
    }
  m.vertices[0] = {1e-30, -0.0, 16777216.0};  // tiny, negative zero, large
  m.vertices[1] = {0.1, 1.0 / 3, 1e-41};      // the last is subnormal in float32
  return m;
}

bool sameBits(double a, double b) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(a)) == std::bit_cast<std::uint32_t>(static_cast<float>(b));
}

class MeshWriter : public testing::Test {
 protected:
  MeshFile roundTrip(const std::string& name, const Mesh& mesh, const MeshWriteOptions& options = {}) {
    const auto written = writeMesh(folder_.path() / name, mesh, options);
    EXPECT_TRUE(written) << written.error().message();
    auto file = readMesh(folder_.path() / name);
    EXPECT_TRUE(file) << file.error().message();
    return file ? *file : MeshFile{};
  }
  TemporaryFolder folder_;
};

TEST_F(MeshWriter, PositionsComeBackBitForBitInEveryFormat) {
  const Mesh m = torus(40);
  for (const char* name : {"a.stl", "a.ply", "a.off", "a.obj", "a.3mf", "A.STL"}) {
    const Mesh back = roundTrip(name, m).mesh;
    ASSERT_EQ(back.triangles.size(), m.triangles.size()) << name;
    ASSERT_EQ(back.vertices.size(), m.vertices.size()) << name;
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c)
          ASSERT_TRUE(sameBits(back.corner(t, k)[c], m.corner(t, k)[c])) << name << " triangle " << t;
    if (name[2] != 's' && name[2] != 'S') {
      EXPECT_EQ(back.triangles, m.triangles) << name << ": vertices keep their order";
    }
  }
}

struct CommaPoint : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST_F(MeshWriter, TextDoesNotDependOnTheLocale) {
  const Mesh m = torus(40);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new CommaPoint));
  for (const char* name : {"a.ply", "a.off", "a.obj", "a.3mf"}) {
    const Mesh back = roundTrip(name, m).mesh;
    EXPECT_EQ(back.triangles, m.triangles) << name;
    ASSERT_EQ(back.vertices.size(), m.vertices.size()) << name;
    EXPECT_TRUE(sameBits(back.vertices[5].x(), m.vertices[5].x())) << name;
  }
  std::locale::global(before);
}

TEST_F(MeshWriter, ColoursComeBack) {
  const Mesh m = torus(12);
  for (const char* name : {"a.ply", "a.off", "a.obj"})
    EXPECT_EQ(roundTrip(name, m).mesh.vertex_colors, m.vertex_colors) << name;
  for (const char* name : {"a.ply", "a.off", "a.3mf"})
    EXPECT_EQ(roundTrip(name, m).mesh.face_colors, m.face_colors) << name;
  EXPECT_FALSE(roundTrip("a.ply", m, {.colors = false}).mesh.hasVertexColors());
}

TEST_F(MeshWriter, FaceColoursAloneComeBack) {
  Mesh m = torus(12);
  m.vertex_colors.clear();
  for (const char* name : {"a.ply", "a.off", "a.3mf"}) {
    const MeshFile back = roundTrip(name, m);
    EXPECT_EQ(back.mesh.face_colors, m.face_colors) << name;
    EXPECT_FALSE(back.mesh.hasVertexColors()) << name;
  }
  // COFF promises vertex colours. Other programs write other values there, which are read.
  const std::string off = contentOf(folder_.path() / "a.off");
  EXPECT_EQ(off.substr(0, 4), "OFF\n");
  const auto other = readMesh(folder_.write("b.off", "C" + off));
  ASSERT_TRUE(other) << other.error().message();
  EXPECT_EQ(other->mesh.face_colors, m.face_colors);
}

TEST_F(MeshWriter, PlyKeepsDoublesWhenAsked) {
  const Mesh m = torus(12);
  const MeshFile file = roundTrip("a.ply", m, {.double_positions = true});
  EXPECT_TRUE(file.had_double_coordinates);
  for (std::size_t v = 0; v < m.vertices.size(); ++v)
    for (int c = 0; c < 3; ++c)
      ASSERT_EQ(std::bit_cast<std::uint64_t>(file.mesh.vertices[v][c]), std::bit_cast<std::uint64_t>(m.vertices[v][c]));
}

TEST_F(MeshWriter, StlHeaderAttributesAndNormals) {
  const Mesh m = torus(12);
  ASSERT_TRUE(writeMesh(folder_.path() / "a.stl", m));
  const std::string bytes = contentOf(folder_.path() / "a.stl");
  ASSERT_EQ(bytes.size(), 84 + 50 * m.triangles.size());
  EXPECT_NE(bytes.substr(0, 5), "solid");
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    float normal[3];
    std::memcpy(normal, bytes.data() + 84 + 50 * t, 12);
    const Vec3d n = doubleAreaVector(m, t).normalized();
    const bool extreme = std::min({m.triangles[t][0], m.triangles[t][1], m.triangles[t][2]}) < 2;
    if (!extreme) {
      EXPECT_NEAR(n.dot(Vec3d(normal[0], normal[1], normal[2])), 1, 1e-4);
    }
    EXPECT_EQ(bytes[84 + 50 * t + 48], 0);
    EXPECT_EQ(bytes[84 + 50 * t + 49], 0);
  }
}

TEST_F(MeshWriter, FilesDoNotNameThemselves) {
  for (const char* extension : {".stl", ".ply", ".off", ".obj", ".3mf"}) {
    const std::string name = std::string("smith_john") + extension;
    ASSERT_TRUE(writeMesh(folder_.path() / name, torus(5)));
    EXPECT_EQ(contentOf(folder_.path() / name).find("smith"), std::string::npos) << extension;
  }
  ASSERT_TRUE(writeMesh(folder_.path() / "a.ply", torus(5), {.comment = "two\nlines"}));
  EXPECT_NE(contentOf(folder_.path() / "a.ply").find("comment two lines\n"), std::string::npos);
  EXPECT_TRUE(readMesh(folder_.path() / "a.ply"));
}

TEST_F(MeshWriter, NonManifoldIsRefusedByStlAndOffAndKeptByTheOthers) {
  Mesh fan;
  fan.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  fan.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  for (const char* name : {"a.stl", "a.off"}) {
    const auto written = writeMesh(folder_.path() / name, fan);
    ASSERT_FALSE(written) << name;
    EXPECT_EQ(written.error().code, Error::Code::kGeometry);
    EXPECT_EQ(written.error().place, "triangle 2");
    EXPECT_EQ(written.error().file, (folder_.path() / name).string());
  }
  EXPECT_EQ(folder_.entries(), 0u) << "nothing half-written is left";
  for (const char* name : {"a.ply", "a.obj", "a.3mf"}) EXPECT_EQ(roundTrip(name, fan).mesh.triangles, fan.triangles);
  fan.triangles = {{0, 1, 2}, {0, 1, 1}};
  EXPECT_FALSE(writeMesh(folder_.path() / "a.stl", fan)) << "a repeated corner";
}

TEST_F(MeshWriter, AFileThatDiffersFromItsMeshIsFound) {
  const Mesh mesh = torus(8);
  const auto differs = [&](const Mesh& read, bool in_double = false) {
    const auto same = internal::requireSameTriangles(read, mesh, in_double);
    return same ? std::string() : same.error().found;
  };
  EXPECT_EQ(differs(mesh), "");
  Mesh rounded = mesh;
  for (Vec3d& p : rounded.vertices) p = p.cast<float>().cast<double>();
  EXPECT_EQ(differs(rounded), "");
  EXPECT_NE(differs(rounded, true), "");

  Mesh fewer = mesh;
  fewer.triangles.pop_back();
  EXPECT_EQ(differs(fewer), std::to_string(fewer.triangles.size()) + " triangles");
  Mesh turned = mesh;
  std::swap(turned.triangles[5][0], turned.triangles[5][1]);
  EXPECT_TRUE(differs(turned).starts_with("triangle 5 at"));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    Mesh moved = rounded;
    moved.vertices[v][2] = std::nextafter(static_cast<float>(moved.vertices[v][2]), 1e9f);
    EXPECT_NE(differs(moved), "") << v;
  }
}

TEST_F(MeshWriter, UnknownExtensionListsTheKnownOnes) {
  for (const char* name : {"a.xyz", "a"}) {
    const auto written = writeMesh(folder_.path() / name, torus(5));
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, Error::Code::kUnsupported);
    EXPECT_NE(written.error().expected.find(".stl, .ply"), std::string::npos) << written.error().message();
  }
}

TEST_F(MeshWriter, WhatFloat32CannotHoldIsRefused) {
  Mesh m = torus(5);
  m.vertices[7].x() = 1e39;
  EXPECT_EQ(writeMesh(folder_.path() / "a.stl", m).error().place, "vertex 7");
  EXPECT_TRUE(writeMesh(folder_.path() / "a.ply", m, {.double_positions = true}));
}

TEST_F(MeshWriter, FullDiskAndMissingFolderAreReported) {
  EXPECT_EQ(writeMesh(folder_.path() / "no" / "a.stl", torus(5)).error().found, "No such file or directory");
  if (!std::filesystem::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  for (const char* extension : {".stl", ".ply", ".off", ".obj", ".3mf"}) {
    const auto link = folder_.path() / (std::string("full") + extension);
    std::filesystem::create_symlink("/dev/full", link);
    const auto written = writeMesh(link, torus(60));
    ASSERT_FALSE(written) << extension;
    EXPECT_EQ(written.error().code, Error::Code::kWriteFailed) << extension;
    EXPECT_EQ(written.error().found, "No space left on device") << extension;
  }
}

TEST_F(MeshWriter, EveryFormatBringsBackWhatItsRowSaysItCarries) {
  Mesh mesh;
  mesh.vertices = {{1.0 / 3, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // no float32, and no short text
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  Mesh by_vertex = mesh, by_face = mesh;
  by_vertex.vertex_colors = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {9, 9, 9, 255}};
  by_face.face_colors = by_vertex.vertex_colors;

  for (const MeshFormatRow& row : meshFormats()) {
    if (!row.read || !row.write) continue;
    const auto path = folder_.path() / ("carried" + std::string(row.extensions.substr(0, row.extensions.find(' '))));
    const auto there_and_back = [&](const Mesh& from) {
      MeshWriteOptions options;
      options.double_positions = true;
      EXPECT_TRUE(writeMesh(path, from, options)) << row.name;
      auto file = readMesh(path);
      EXPECT_TRUE(file) << row.name;
      return file ? std::move(*file) : MeshFile{};
    };
    EXPECT_EQ(there_and_back(by_vertex).mesh.hasVertexColors(), row.carries.vertex_colors) << row.name;
    const MeshFile file = there_and_back(by_face);
    EXPECT_EQ(file.mesh.hasFaceColors(), row.carries.face_colors) << row.name;
    EXPECT_EQ(!file.declared_unit.empty(), row.carries.unit) << row.name;
    ASSERT_FALSE(file.mesh.vertices.empty());
    EXPECT_EQ(file.mesh.vertices[0][0] == 1.0 / 3, row.carries.doubles) << row.name;
    EXPECT_NE(file.format.find(row.name), file.format.npos) << file.format;
  }
}

TEST(MeshFormats, EveryRowReadsOrWritesAndIsFoundByItsExtensions) {
  for (const MeshFormatRow& row : meshFormats()) {
    EXPECT_TRUE(row.read || row.write) << row.name;
    EXPECT_EQ(formatOfExtension(row.extensions.substr(0, row.extensions.find(' '))), &row);
  }
  EXPECT_EQ(formatOfExtension(".StL"), &meshFormats()[0]);
  EXPECT_EQ(formatOfExtension(".docx"), nullptr);
}

TEST(MeshFormats, AreListedForMessagesInTheOrderOfTheTable) {
  EXPECT_TRUE(readableExtensions().starts_with(".stl, .ply, .off")) << readableExtensions();
  EXPECT_TRUE(writableFormats().starts_with("STL, PLY, OFF")) << writableFormats();
  EXPECT_NE(writableFormats().find(" or "), std::string::npos) << writableFormats();
  EXPECT_TRUE(colorFormats().starts_with("PLY, OFF")) << colorFormats();  // STL has none
}

}  // namespace
}  // namespace kerf::mesh_writer_test
