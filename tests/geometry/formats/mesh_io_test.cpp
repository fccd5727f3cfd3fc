#include "geometry/formats/mesh_io.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "tests/geometry/mesh_samples.h"
#include "tests/support/temporary_folder.h"

namespace kerf::mesh_io_test {
namespace {

class MeshIo : public testing::Test {
 protected:
  Expected<MeshFile> read(const std::string& name, const std::string& bytes) {
    return readMesh(folder_.write(name, bytes));
  }
  MeshFile good(const std::string& name, const std::string& bytes) {
    auto file = read(name, bytes);
    EXPECT_TRUE(file) << file.error().message();
    return file ? *file : MeshFile{};
  }
  static void expectTetrahedron(const MeshFile& file, bool as_float) {
    ASSERT_EQ(file.mesh.vertices.size(), 4u);
    ASSERT_EQ(file.mesh.triangles.size(), 4u);
    for (std::size_t t = 0; t < 4; ++t)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c) {
          const double x = file.mesh.vertices[file.mesh.triangles[t][k]][static_cast<int>(c)];
          const float expected = samples::kCorner[samples::kFace[t][k]][c];
          EXPECT_EQ(static_cast<float>(x), expected);
          if (as_float) {
            EXPECT_EQ(x, static_cast<double>(expected));
          }
        }
  }
  TemporaryFolder folder_;
};

TEST_F(MeshIo, BinaryStlIsWeldedInOrderOfAppearance) {
  const MeshFile file = good("a.stl", samples::binaryStl("UNITS=mm", 4, 0x7fff));
  expectTetrahedron(file, true);
  EXPECT_EQ(file.mesh.triangles[1], (Triangle{0, 3, 1}));
  EXPECT_EQ(file.format, "binary STL");
  EXPECT_EQ(file.declared_unit, "mm");
  EXPECT_EQ(file.unwelded_vertices, 12u);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("attribute"), std::string::npos);
}

TEST_F(MeshIo, SizeDecidesBeforeTheWordSolid) {
  const MeshFile file = good("a.stl", samples::binaryStl("solid exported by something"));
  EXPECT_EQ(file.format, "binary STL");
  expectTetrahedron(file, true);
}

TEST_F(MeshIo, AsciiStlInAnyCaseAndLineEndAndWithManySolids) {
  for (const char* eol : {"\n", "\r\n", "\r"}) {
    const MeshFile file = good("a.stl", samples::asciiStl(eol));
    expectTetrahedron(file, false);
    EXPECT_EQ(file.format, "ASCII STL");
    EXPECT_FALSE(file.had_double_coordinates);
  }
  EXPECT_EQ(good("two.stl", samples::asciiStl() + "\n" + samples::asciiStl()).mesh.triangles.size(), 8u);
}

TEST_F(MeshIo, PlyKeepsColoursOrderAndDoubles) {
  for (const bool big : {false, true}) {
    const MeshFile file = good("a.ply", samples::binaryPly(big));
    expectTetrahedron(file, true);
    EXPECT_EQ(file.format, big ? "binary PLY (big endian)" : "binary PLY (little endian)");
    EXPECT_TRUE(file.had_double_coordinates);
    EXPECT_EQ(file.declared_unit, "mm");
    ASSERT_EQ(file.mesh.vertex_colors.size(), 4u);
    ASSERT_EQ(file.mesh.face_colors.size(), 4u);
    EXPECT_EQ(file.mesh.vertex_colors[3], (Rgba8{13, 20, 30, 255}));
    EXPECT_EQ(file.mesh.face_colors[2], (Rgba8{102, 1, 2, 200}));
    EXPECT_EQ(file.notes, (std::vector<std::string>{"Not read: camera, vertex.quality."}));
  }
  const MeshFile ascii = good("b.ply", samples::asciiPly());
  expectTetrahedron(ascii, true);
  EXPECT_FALSE(ascii.had_double_coordinates);
  EXPECT_EQ(ascii.mesh.vertex_colors[3], (Rgba8{13, 20, 30, 254}));
}

// 0.1f, 16777216 (the next is 16777218) and other numbers as programs write them.
TEST_F(MeshIo, TextKeepsItsDoubleAndIsKnownWhenItSaysNoMoreThanAFloat) {
  const auto read = [&](const std::string& number) {
    return good("a.off", "OFF\n3 1 0\n" + number + " 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  };
  for (const float f : {0.1f, -12.345678f, 1.17549435e-38f, 3.4e+7f, 104.69231f, 16.000002f})
    for (const std::string& text : {fmt::format("{}", f), fmt::format("{:.9g}", f), fmt::format("{:.25f}", f)}) {
      const MeshFile file = read(text);
      if (std::strtof(text.c_str(), nullptr) != f) continue;  // 25 decimals are none of 1e-38
      EXPECT_EQ(file.mesh.vertices[0][0], std::strtod(text.c_str(), nullptr)) << text;
      EXPECT_EQ(static_cast<float>(file.mesh.vertices[0][0]), f) << text;
      EXPECT_FALSE(file.had_double_coordinates) << text;
    }
  for (const std::string text : {"0.1", "1e-1", "+0.10", "1E-01"})
    EXPECT_EQ(read(text).mesh.vertices[0][0], 0.1) << text;
  for (const std::string text :
       {"0.1000000000000000056", "0.10000000001", "16777217", "123.456789012", "1.0000000001e+2"}) {
    const MeshFile file = read(text);
    EXPECT_EQ(file.mesh.vertices[0][0], std::strtod(text.c_str(), nullptr)) << text;
    EXPECT_TRUE(file.had_double_coordinates) << text;
  }
}

TEST_F(MeshIo, ObjFormsNegativeIndicesContinuationsAndColours) {
  const MeshFile file = good("a.obj", samples::obj());
  expectTetrahedron(file, false);
  EXPECT_EQ(file.declared_unit, "mm");
  EXPECT_EQ(file.mesh.vertex_colors[2], (Rgba8{255, 0, 0, 255}));
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("mtllib"), std::string::npos);
}

TEST_F(MeshIo, OffColours) {
  const MeshFile file = good("a.off", samples::off());
  expectTetrahedron(file, false);
  EXPECT_EQ(file.mesh.vertex_colors[1], (Rgba8{11, 20, 30, 255}));
  EXPECT_EQ(file.mesh.face_colors[1], (Rgba8{4, 5, 6, 255}));
  EXPECT_EQ(file.mesh.face_colors[2], (Rgba8{200, 200, 200, 255}));
  EXPECT_EQ(file.mesh.face_colors[3], (Rgba8{128, 255, 0, 255}));
  EXPECT_EQ(good("n.off", "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n").mesh.vertices[1],
            Vec3d(1, 0, 0));
}

TEST_F(MeshIo, UnusedAndRepeatedVerticesStayWhereTheyAre) {
  const MeshFile file = good("a.obj", "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 2 3 4\n");
  EXPECT_EQ(file.mesh.vertices.size(), 5u);
  EXPECT_EQ(file.mesh.triangles[0], (Triangle{1, 2, 3}));
}

TEST_F(MeshIo, ConcavePolygonsAreCoveredOnceAndFaceColoursFollow) {
  // An L of area 3, in a plane across x. Only two corners allow a fan within it.
  const MeshFile file = good("l.off", "OFF\n6 1 0\n7 0 2\n7 0 0\n7 2 0\n7 2 1\n7 1 1\n7 1 2\n6 0 1 2 3 4 5 9 8 7\n");
  EXPECT_EQ(file.polygons_triangulated, 1u);
  ASSERT_EQ(file.mesh.triangles.size(), 4u);
  EXPECT_EQ(file.mesh.face_colors.size(), 4u);
  double area = 0;
  for (std::size_t t = 0; t < 4; ++t) {
    EXPECT_GT(doubleAreaVector(file.mesh, t).x(), 0) << "turned over";
    area += doubleAreaVector(file.mesh, t).norm() / 2;
  }
  EXPECT_DOUBLE_EQ(area, 3);
}

TEST_F(MeshIo, WrongExtensionIsReadByContentAndNoted) {
  const MeshFile file = good("a.stl", samples::asciiPly());
  EXPECT_EQ(file.format, "ASCII PLY");
  ASSERT_FALSE(file.notes.empty());
  EXPECT_NE(file.notes.back().find("PLY"), std::string::npos);
  EXPECT_EQ(good("scan", samples::binaryStl()).format, "binary STL");
}

TEST_F(MeshIo, CancellingYieldsCancelled) {
  const auto file =
      readMesh(folder_.write("a.ply", samples::binaryPly(false)), [](double, std::string_view) { return false; });
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, Error::Code::kCancelled);
}

struct Bad {
  const char* name;
  std::string bytes;
  Error::Code code;
  const char* says;  // in the message
};

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string manyProperties(int count) {
  std::string ply = "ply\nformat ascii 1.0\nelement vertex 1\n";
  for (int k = 0; k < count; ++k) ply += "property char p" + std::to_string(k) + "\n";
  return ply + "element face 0\nend_header\n";
}

std::vector<Bad> badFiles() {
  using namespace samples;
  using Code = Error::Code;
  const std::string stl = binaryStl(), little = binaryPly(false), big = binaryPly(true), ply = asciiPly();
  std::string nan_stl = stl, inf_stl = stl, nan_ply = little, index_ply = little, list_ply = big;
  nan_stl.replace(84 + 50 + 12, 4, bytes(0x7fc00000u));
  inf_stl.replace(84 + 12, 4, bytes(0xff800000u));
  const std::size_t data = little.find("end_header\n") + 11;
  nan_ply.replace(data + 5 + 4, 8, bytes(0x7ff8000000000000ull));
  index_ply.replace(data + 5 + 4 * 31 + 1, 4, bytes(4u));
  list_ply.replace(data - 3 + 5 + 4 * 31, 1, "\xff");
  const std::string plain =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  return {
      {"empty.stl", "", Code::kEmpty, "0 bytes"},
      {"blank.obj", "\n\n", Code::kEmpty, "no faces"},
      {"short.stl", stl.substr(0, 50), Code::kBadFormat, "\"solid\""},
      {"truncated.stl", stl.substr(0, stl.size() - 7), Code::kBadFormat, "count of 4"},
      {"longer.stl", stl + "more", Code::kBadFormat, "4 bytes after"},
      {"huge_count.stl", binaryStl("x", 0x7fffffff), Code::kBadFormat, "2147483647"},
      {"solid_truncated.stl", binaryStl("solid x", 9), Code::kBadFormat, "count of 9"},
      {"no_triangles.stl", stl.substr(0, 80) + bytes(0u), Code::kEmpty, "no faces"},
      {"nan.stl", nan_stl, Code::kBadValue, "triangle 1"},
      {"inf.stl", inf_stl, Code::kBadValue, "triangle 0"},
      {"random.stl", std::string("\x12\x01\xfe", 3) + std::string(300, '\xa5'), Code::kBadFormat, "bytes"},
      {"text.stl", "this is not a mesh", Code::kBadFormat, "\"solid\""},
      {"truncated_ascii.stl", asciiStl().substr(0, 200), Code::kBadFormat, "end of the file"},
      {"nan_ascii.stl", changed(asciiStl(), "+1.5", "nan"), Code::kBadValue, "finite"},
      {"comma.stl", changed(asciiStl(), "+1.5", "1,5"), Code::kBadValue, "comma"},
      {"four_corners.stl", changed(asciiStl(), "endloop", "vertex 1 2 3\nendloop"), Code::kBadFormat, "endloop"},
      {"after_endsolid.stl", asciiStl() + "garbage", Code::kBadFormat, "garbage"},
      {"empty_solid.stl", "solid nothing\nendsolid nothing\n", Code::kEmpty, "no faces"},
      {"no_end_header.ply", plain, Code::kBadFormat, "end_header"},
      {"no_format.ply", changed(ply, "format ascii 1.0\r\n", ""), Code::kBadFormat, "format"},
      {"middle_endian.ply", changed(ply, "ascii", "binary_middle_endian"), Code::kBadFormat, "binary_middle_endian"},
      {"bad_type.ply", changed(ply, "property float x", "property half x"), Code::kBadFormat, "half"},
      {"huge_count.ply", changed(ply, "vertex 4", "vertex 2147483647"), Code::kBadFormat, "room"},
      {"huge_faces.ply", binaryPly(false, 4, 0xffffffff), Code::kBadFormat, "room"},
      {"negative_count.ply", changed(ply, "face 4", "face -4"), Code::kBadFormat, "-4"},
      {"truncated_ascii.ply", ply.substr(0, ply.size() - 12), Code::kBadFormat, "end of the line"},
      {"lines_missing.ply", ply.substr(0, ply.size() - 18), Code::kBadFormat, "end of the file at face 2"},
      {"truncated_little.ply", little.substr(0, little.size() - 1), Code::kBadFormat, "face 3"},
      {"truncated_big.ply", big.substr(0, big.size() - 30), Code::kBadFormat, "end of the file"},
      {"longer.ply", little + "0123456789", Code::kBadFormat, "after the last element"},
      {"longer_ascii.ply", ply + "3 0 1 2\r\n", Code::kBadFormat, "after the last element"},
      {"nan.ply", nan_ply, Code::kBadValue, "not finite"},
      {"nan_ascii.ply", changed(ply, "1.5", "NaN"), Code::kBadValue, "finite"},
      {"overflow.ply", changed(ply, "1.5", "1e39"), Code::kBadValue, "too large"},
      {"index.ply", index_ply, Code::kBadValue, "vertex index 4"},
      {"negative_index.ply", changed(ply, "3 0 3 1", "3 0 -1 1"), Code::kBadValue, "-1"},
      {"long_list.ply", list_ply, Code::kBadFormat, "end of the file"},
      {"short_line.ply", changed(ply, "3 1 3 2", "3 1 3"), Code::kBadFormat, "end of the line"},
      {"colour.ply", changed(ply, "11 20", "256 20"), Code::kBadValue, "255"},
      {"no_z.ply", changed(ply, "property float z\r\n", ""), Code::kBadFormat, "x, y or z"},
      {"many_properties.ply", manyProperties(300), Code::kBadFormat, "256 properties"},
      {"points.ply", plain + "end_header\n0 0 0\n1 0 0\n0 1 0\n", Code::kEmpty, "3 points"},
      {"zero.obj", changed(obj(), "f 2 4 3", "f 0 1 2"), Code::kBadValue, "\"0\""},
      {"out_of_range.obj", changed(obj(), "f 2 4 3", "f 2 4 5"), Code::kBadValue, "index 5"},
      {"negative.obj", changed(obj(), "f -4", "f -5"), Code::kBadValue, "-5"},
      {"huge_index.obj", changed(obj(), "f 2 4 3", "f 2 4 99999999999999999999"), Code::kBadValue, "too large"},
      {"nan.obj", changed(obj(), "v 1.5", "v nan"), Code::kBadValue, "finite"},
      {"two_numbers.obj", "v 0 0\nf 1 1 1\n", Code::kBadValue, "2 numbers"},
      {"two_corners.obj", changed(obj(), "f 2 4 3", "f 2 4"), Code::kBadValue, "2 corners"},
      {"cut_short.obj", obj() + "f 1 2", Code::kBadValue, "2 corners"},
      {"points.obj", "v 0 0 0\nv 1 1 1\n", Code::kEmpty, "2 points"},
      {"binary_garbage.obj", "v 0 0 0\n\x01\xff\x02\n", Code::kBadFormat, "\\xff"},
      {"binary.off", "OFF BINARY\n\0\0\0\4", Code::kUnsupported, "binary OFF"},
      {"four.off", "4OFF\n1 1 0\n0 0 0 1\n", Code::kUnsupported, "three"},
      {"huge.off", "OFF\n2147483647 2147483647 0\n0 0 0\n", Code::kBadFormat, "room"},
      {"truncated.off", off().substr(0, off().size() - 25), Code::kBadFormat, "nothing, not an integer"},
      {"lines_missing.off", off().substr(0, off().find("3 1 3 2")), Code::kBadFormat, "end of the file at face 2"},
      {"longer.off", off() + "3 0 1 2\n", Code::kBadFormat, "after the last face"},
      {"index.off", changed(off(), "3 1 3 2", "3 1 3 4"), Code::kBadFormat, "index 4"},
      {"inf.off", changed(off(), "1.5", "inf"), Code::kBadFormat, "finite"},
      {"no_counts.off", "OFF\n", Code::kBadFormat, "end of the file"},
      {"points.off", "OFF\n2 0 0\n0 0 0\n1 1 1\n", Code::kEmpty, "2 points"},
      {"scan.dcm", "PK\x03\x04rest of a zip archive", Code::kUnsupported, "3Shape"},
      {"hps.dcm", "<?xml version=\"1.0\"?>\n<HPS version=\"1.1\">", Code::kUnsupported, "3Shape"},
      {"scan.zip", "PK\x03\x04rest of a zip archive", Code::kUnsupported, "zip"},
      {"scan.stl.gz", "\x1f\x8b\x08rest of a gzip archive", Code::kUnsupported, "gzip"},
      {"picture.png", "\x89PNG\r\n\x1a\n", Code::kUnsupported, "PNG picture"},
  };
}

TEST_F(MeshIo, MalformedFilesAreRefusedWithPlaceAndReason) {
  for (const Bad& bad : badFiles()) {
    ASSERT_LT(bad.bytes.size(), 8192u);
    const auto file = read(bad.name, bad.bytes);
    ASSERT_FALSE(file) << bad.name;
    const Error& e = file.error();
    EXPECT_EQ(e.file, (folder_.path() / bad.name).string());
    EXPECT_FALSE(e.place.empty()) << bad.name;
    EXPECT_FALSE(e.found.empty()) << bad.name;
    EXPECT_FALSE(e.hint.empty()) << bad.name;
    EXPECT_EQ(e.code, bad.code) << bad.name << ": " << e.message();
    EXPECT_NE(e.message().find(bad.says), std::string::npos)
        << bad.name << " should say " << bad.says << ": " << e.message();
  }
}

TEST_F(MeshIo, CoordinatesThatNoScanHasAreRefused) {
  const auto objOf = [](const char* far) { return fmt::format("v 0 0 0\nv 1 0 0\nv 0 {} 0\nf 1 2 3\n", far); };
  for (const char* const far : {"1e8", "-3e12", "7e38", "1e200"}) {
    const auto refused = read("far.obj", objOf(far));
    ASSERT_FALSE(refused) << far;
    EXPECT_EQ(refused.error().code, Error::Code::kBadValue) << far;
    EXPECT_EQ(refused.error().place, "vertex 2") << far;
  }
  EXPECT_TRUE(read("near.obj", objOf("9e7")));
}

TEST_F(MeshIo, LinesAreCountedFromOne) {
  EXPECT_EQ(read("a.obj", "v 0 0 0\r\n# x\r\nv 1 x 0\r\n").error().place, "line 3");
  EXPECT_EQ(read("a.obj", "v 0 0 0\n\nv 1 \\\n2 x\n").error().place, "line 3");
}

TEST_F(MeshIo, WhatIsNoFileIsRefused) {
  EXPECT_EQ(readMesh(folder_.path() / "absent.stl").error().code, Error::Code::kNotFound);
  EXPECT_EQ(readMesh(folder_.path()).error().code, Error::Code::kUnreadable);
  EXPECT_EQ(readMesh("/dev/zero").error().code, Error::Code::kUnreadable);
  if (::geteuid() == 0) GTEST_SKIP() << "running as root, who may read everything: permission not tested";
  const auto secret = folder_.write("secret.stl", samples::binaryStl());
  std::filesystem::permissions(secret, std::filesystem::perms::none);
  EXPECT_NE(readMesh(secret).error().message().find("ermission"), std::string::npos);
}

// For any file content, the result is an Error or a mesh with indices in range and finite coordinates.
TEST_F(MeshIo, MutatedFilesNeverBreakThePromisesOfAMesh) {
  const std::pair<const char*, std::string> seeds[] = {{"a.stl", samples::binaryStl()},
                                                       {"a.stl", samples::asciiStl()},
                                                       {"a.ply", samples::binaryPly(false)},
                                                       {"a.ply", samples::binaryPly(true)},
                                                       {"a.ply", samples::asciiPly()},
                                                       {"a.obj", samples::obj()},
                                                       {"a.off", samples::off()}};
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  constexpr char kSpice[] = {'\0', '\x7f', '\xff', '0', '9', '-', ' ', '\n', '.', 'e', '\x80', '/'};
  std::size_t read_well = 0, refused = 0;
  for (int round = 0; round < 7000; ++round) {
    const auto& [name, seed] = seeds[static_cast<std::size_t>(round) % std::size(seeds)];
    std::string bytes = seed;
    for (std::size_t n = 1 + below(3); n > 0; --n) {
      const std::size_t at = below(bytes.size());
      switch (below(6)) {
        case 0:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
          break;
        case 1:
          bytes.erase(at, 1 + below(8));
          break;
        case 2:
          bytes.insert(at, bytes.substr(below(bytes.size()), 1 + below(8)));
          break;
        case 3:
          bytes.resize(at + 1);
          break;
        default:
          bytes[at] = kSpice[below(std::size(kSpice))];
      }
      if (bytes.empty()) bytes = "x";
    }
    const auto file = read(name, bytes);
    if (!file) {
      ++refused;
      EXPECT_FALSE(file.error().place.empty() || file.error().found.empty());
      continue;
    }
    ++read_well;
    const Mesh& m = file->mesh;
    ASSERT_FALSE(m.triangles.empty());
    for (const Triangle& t : m.triangles)
      for (const std::uint32_t v : t) ASSERT_LT(v, m.vertices.size());
    for (const Vec3d& p : m.vertices) ASSERT_TRUE(p.allFinite());
    ASSERT_TRUE(m.vertex_colors.empty() || m.vertex_colors.size() == m.vertices.size());
    ASSERT_TRUE(m.face_colors.empty() || m.face_colors.size() == m.triangles.size());
  }
  EXPECT_GT(read_well, 500u);
  EXPECT_GT(refused, 2000u);
}

}  // namespace
}  // namespace kerf::mesh_io_test
