// Files of other programs: read, with a note for each repair, or refused with the cause.
#include <gtest/gtest.h>

#include "geometry/formats/mesh_io.h"
#include "geometry/formats/zip_archive.h"
#include "tests/geometry/mesh_samples.h"
#include "tests/support/temporary_folder.h"

namespace kerf::peers_files_test {
namespace {

class PeersFiles : public testing::Test {
 protected:
  Expected<MeshFile> read(const std::string& name, const std::string& bytes) {
    return readMesh(folder_.write(name, bytes));
  }
  /// Reads the tetrahedron of the samples, with a note that contains `says`.
  void expectMended(const std::string& name, const std::string& bytes, const std::string& says) {
    const auto file = read(name, bytes);
    ASSERT_TRUE(file) << name << ": " << file.error().message();
    ASSERT_EQ(file->mesh.triangles.size(), 4u) << name;
    for (std::size_t t = 0; t < 4; ++t)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_EQ(static_cast<float>(file->mesh.vertices[file->mesh.triangles[t][k]][static_cast<int>(c)]),
                    samples::kCorner[samples::kFace[t][k]][c])
              << name;
    std::string notes;
    for (const std::string& note : file->notes) notes += note + "\n";
    EXPECT_NE(notes.find(says), std::string::npos) << name << ": " << notes;
  }
  void expectRefused(const std::string& name, const std::string& bytes, Error::Code code, const std::string& says,
                     const std::string& not_says = "cut short") {
    const auto file = read(name, bytes);
    ASSERT_FALSE(file) << name;
    const Error& e = file.error();
    EXPECT_EQ(e.code, code) << name << ": " << e.message();
    EXPECT_FALSE(e.place.empty() || e.expected.empty() || e.hint.empty()) << name;
    EXPECT_NE(e.message().find(says), std::string::npos) << name << ": " << e.message();
    EXPECT_EQ(e.message().find(not_says), std::string::npos) << name << ": " << e.message();
  }
  TemporaryFolder folder_;
};

std::string utf16(const std::string& text, bool big, bool marked) {
  std::string out = marked ? (big ? "\xfe\xff" : "\xff\xfe") : "";
  for (const char c : text) out += big ? std::string{'\0', c} : std::string{c, '\0'};
  return out;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  std::size_t count = 0;
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()), ++count)
    text.replace(at, from.size(), to);
  EXPECT_GT(count, 0u) << from;
  return text;
}

TEST_F(PeersFiles, AByteOrderMarkIsSkipped) {
  const std::string mark = "\xef\xbb\xbf";
  expectMended("a.obj", mark + samples::obj(), "byte order mark");
  expectMended("a.stl", mark + samples::asciiStl(), "byte order mark");
  expectMended("a.ply", mark + samples::asciiPly(), "byte order mark");
  expectMended("b.ply", mark + samples::binaryPly(false), "byte order mark");
  expectMended("a.off", mark + samples::off(), "byte order mark");
  // The header of a binary STL may hold any bytes.
  std::string wide = samples::binaryStl("", 0);
  for (std::size_t n = 0; n < 80; ++n) wide[n] = n % 2 == 0 ? 'K' : '\0';
  expectMended("wide.stl", wide, "counts 0 triangles");
  EXPECT_EQ(read("b.stl", samples::binaryStl(mark))->format, "binary STL");
}

TEST_F(PeersFiles, TextInUtf16IsRead) {
  for (const bool big : {false, true})
    for (const bool marked : {false, true}) {
      expectMended("a.obj", utf16(samples::obj(), big, marked), "UTF-16");
      expectMended("a.stl", utf16(samples::asciiStl("\r\n"), big, marked), "UTF-16");
      expectMended("a.ply", utf16(samples::asciiPly(), big, marked), "UTF-16");
      expectMended("a.off", utf16(samples::off(), big, marked), "UTF-16");
    }
  // Half a unit, half a pair: no crash, and the text before it counts.
  expectMended("odd.obj", utf16(samples::obj(), false, true) + "\n", "UTF-16");
  EXPECT_EQ(read("lines.obj", utf16("v 0 0 0\n# x\nv 1 x 0\n", false, true)).error().place, "line 3");
}

TEST_F(PeersFiles, AnAsciiStlMayEndWithoutEndsolid) {
  expectMended("a.stl", replaced(samples::asciiStl(), "ENDSOLID tooth 36\n", ""), "endsolid");
  const auto two = read("two.stl", replaced(samples::asciiStl() + samples::asciiStl(), "ENDSOLID tooth 36\n", ""));
  ASSERT_TRUE(two) << two.error().message();
  EXPECT_EQ(two->mesh.triangles.size(), 8u);
  // Inside a facet it is damage.
  const std::string text = samples::asciiStl();
  expectRefused("cut.stl", text.substr(0, text.find("endloop")), Error::Code::kBadFormat, "end of the file",
                "endsolid");
}

TEST_F(PeersFiles, WordsThatDoNotBelongToAnAsciiStlAreSkipped) {
  expectMended("a.stl", replaced(samples::asciiStl(), "endfacet", "endfacet facet_of_tooth 12"), "4 places");
  expectMended("b.stl", replaced(samples::asciiStl(), "endfacet", "endfacet 17"), "4 places");
  expectMended("c.stl", replaced(samples::asciiStl(), "outer loop", "outer loop begin"), "4 places");
  const auto one_line = read("d.stl", replaced(samples::asciiStl(), "endfacet\n", "endfacet x "));
  ASSERT_TRUE(one_line) << one_line.error().message();
  EXPECT_EQ(one_line->mesh.triangles.size(), 4u) << "a facet behind an odd word is one";
  // Several facets on one line are valid, and a corner may have a fourth number.
  EXPECT_TRUE(read("line.stl", replaced(samples::asciiStl(), "endfacet\n", "endfacet "))->notes.empty());
  EXPECT_FALSE(read("numbers.stl", replaced(samples::asciiStl(), "+1.5 0 0", "1 5 0 0")));
}

TEST_F(PeersFiles, AnUnfilledCountOfABinaryStlIsTakenFromTheSize) {
  expectMended("zero.stl", samples::binaryStl("x", 0), "counts 0 triangles");
  expectMended("ones.stl", samples::binaryStl("x", 0xffffffffu), "4 behind it");
  expectMended("solid.stl", samples::binaryStl("solid x", 0), "4 behind it");
  EXPECT_FALSE(read("odd.stl", samples::binaryStl("x", 0) + "1"));
}

TEST_F(PeersFiles, PaddingBehindABinaryStlIsIgnoredAndOtherBytesAreNamed) {
  expectMended("zeros.stl", samples::binaryStl() + std::string(212, '\0'), "212 bytes");
  expectMended("line.stl", samples::binaryStl() + "\r\n", "2 bytes");
  expectRefused("longer.stl", samples::binaryStl() + "more", Error::Code::kBadFormat,
                "4 bytes after the last of 4 triangles");
  expectRefused("half.stl", samples::binaryStl("x", 3), Error::Code::kBadFormat, "50 bytes after the last of 3");
}

std::string strips(const std::string& list) {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n1 1 0\n" +
         list + "\n";
}

TEST_F(PeersFiles, TriangleStripsOfPlyTurnEverySecondTriangle) {
  const auto file = read("a.ply", strips("4 0 1 2 3"));
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
  // Two strips, where the second starts anew; repeated corners join parts of one.
  EXPECT_EQ(read("b.ply", strips("8 0 1 2 -1 1 3 2 2"))->mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
  EXPECT_FALSE(file->notes.empty());

  std::string binary = replaced(strips(""), "ascii", "binary_little_endian");
  binary.resize(binary.find("end_header\n") + 11);
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 1.f, 1.f, 0.f}) binary += samples::bytes(x);
  for (const std::int32_t i : {4, 0, 1, 2, 3}) binary += samples::bytes(i);
  EXPECT_EQ(read("c.ply", binary)->mesh.triangles, file->mesh.triangles);

  EXPECT_EQ(read("d.ply", strips("4 0 1 2 4")).error().code, Error::Code::kBadValue);
  EXPECT_EQ(read("e.ply", strips("4 0 1 -2 3")).error().code, Error::Code::kBadValue);
  EXPECT_EQ(read("f.ply", strips("9 0 1 2 3")).error().code, Error::Code::kBadFormat);
}

TEST_F(PeersFiles, AColourThatIsNotFiniteIsNoReasonToRefuseAMesh) {
  const Rgba8 none{200, 200, 200, 255};
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property float red\nproperty float green\nproperty float blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  const auto ply = read("a.ply", head + "0 0 0 1 0 0\n1 0 0 nan 0 0\n0 1 0 0 inf 1\n3 0 1 2\n");
  ASSERT_TRUE(ply) << ply.error().message();
  EXPECT_EQ(ply->mesh.vertex_colors, (std::vector<Rgba8>{{255, 0, 0, 255}, none, none}));
  EXPECT_EQ(ply->notes, (std::vector<std::string>{"2 colours are not finite (NaN or infinite): grey instead."}));

  std::string binary = replaced(head, "ascii", "binary_big_endian");
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 0.f, 0.f, NAN, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f})
    binary += samples::bytes(x, true);
  binary += '\3' + samples::bytes(0, true) + samples::bytes(1, true) + samples::bytes(2, true);
  EXPECT_EQ(read("b.ply", binary)->mesh.vertex_colors, (std::vector<Rgba8>{{255, 0, 0, 255}, none, {0, 0, 255, 255}}));

  const auto obj = read("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 nan nan nan\nv 0 1 0\nf 1 2 3\n");
  ASSERT_TRUE(obj) << obj.error().message();
  EXPECT_EQ(obj->mesh.vertex_colors, (std::vector<Rgba8>{{255, 0, 0, 255}, none, none}));
  const auto off = read("a.off", "COFF\n3 1 0\n0 0 0 255 0 0\n1 0 0 nan 0 0\n0 1 0 0 0 255\n3 0 1 2\n");
  ASSERT_TRUE(off) << off.error().message();
  EXPECT_EQ(off->mesh.vertex_colors, (std::vector<Rgba8>{{255, 0, 0, 255}, none, {0, 0, 255, 255}}));
  // A position is.
  EXPECT_FALSE(read("c.ply", head + "0 0 0 1 0 0\n1 nan 0 0 0 0\n0 1 0 0 0 1\n3 0 1 2\n"));
}

TEST_F(PeersFiles, FilesOfOtherKindsAreRefusedByTheirKind) {
  using Code = Error::Code;
  const std::string binary_stl = "binary STL";
  expectRefused("page.stl", "<!DOCTYPE html>\n<html><head><title>404</title></head><body>Not found</body></html>\n",
                Code::kUnsupported, "web page", binary_stl);
  expectRefused("page.ply", "\n  <HTML lang=\"en\">", Code::kUnsupported, "web page", "ply\"");
  expectRefused("pointer.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:0123456789abcdef\nsize 123456\n",
                Code::kUnsupported, "Git LFS", binary_stl);
  expectRefused("pointer.obj", "version https://git-lfs.github.com/spec/v1\noid sha256:01\nsize 6\n",
                Code::kUnsupported, "git lfs pull", "OBJ statement");
  expectRefused("part.stl", "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nENDSEC;\nDATA;\n",
                Code::kUnsupported, "STEP", binary_stl);
  expectRefused("note.stl", "patient 12, second scan, see the other folder for the upper jaw and the bite\n",
                Code::kBadFormat, "\"solid\"", binary_stl);
  expectRefused("picture.stl", "\xff\xd8\xff\xe0" + std::string(200, 'x'), Code::kUnsupported, "JPEG", binary_stl);
}

TEST_F(PeersFiles, AThreeMfOlderThanTheStandardIsCalledThat) {
  constexpr const char* kRelations =
      "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Id=\"0\" "
      "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" Target=\"/3D/3dmodel.model\"/>"
      "</Relationships>";
  constexpr const char* kModel =
      "<model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/2013/01\"><resources/></model>";
  std::ostringstream package;
  ASSERT_TRUE(internal::writeZip(package, {{"_rels/.rels", kRelations}, {"3D/3dmodel.model", kModel}}));
  expectRefused("old.3mf", package.str(), Error::Code::kUnsupported, "2013", "damaged");
}

}  // namespace
}  // namespace kerf::peers_files_test
