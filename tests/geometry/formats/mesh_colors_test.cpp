// Colours that scanners and CAD programs store beside or in a mesh: textures, materials, attribute words, numbers.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <limits>
#include <random>

#include "geometry/formats/mesh_io.h"
#include "tests/geometry/mesh_samples.h"
#include "tests/support/temporary_folder.h"

namespace kerf::mesh_colors_test {
namespace {

constexpr Rgba8 kRed{255, 0, 0, 255}, kGreen{0, 255, 0, 255}, kBlue{0, 0, 255, 255}, kWhite{255, 255, 255, 255},
    kNone{200, 200, 200, 255};

class MeshColors : public testing::Test {
 protected:
  MeshFile good(const std::string& name, const std::string& bytes) {
    auto file = readMesh(folder_.write(name, bytes));
    EXPECT_TRUE(file) << name << ": " << file.error().message();
    return file ? *file : MeshFile{};
  }
  static void expectNote(const MeshFile& file, const std::string& says) {
    std::string notes;
    for (const std::string& note : file.notes) notes += note + "\n";
    EXPECT_NE(notes.find(says), std::string::npos) << notes;
  }
  TemporaryFolder folder_;
};

void append(void* to, void* data, int size) {
  static_cast<std::string*>(to)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

// Four quarters: red and green above, blue and white below.
std::vector<std::uint8_t> quarters(int side) {
  std::vector<std::uint8_t> rgb;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const Rgba8 c = y < side / 2 ? (x < side / 2 ? kRed : kGreen) : (x < side / 2 ? kBlue : kWhite);
      rgb.insert(rgb.end(), c.begin(), c.begin() + 3);
    }
  return rgb;
}
std::string png(int side = 2) {
  std::string bytes;
  stbi_write_png_to_func(append, &bytes, side, side, 3, quarters(side).data(), 3 * side);
  return bytes;
}
std::string jpeg() {
  std::string bytes;
  stbi_write_jpg_to_func(append, &bytes, 64, 64, 3, quarters(64).data(), 95);
  return bytes;
}

// A square with the corners of the picture.
std::string square(const std::string& library = "mtllib a.mtl") {
  return library +
         "\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl skin\n"
         "f 1/1 2/2 3/3 4/4\n";
}
const std::vector<Rgba8> kOfSquare{kBlue, kWhite, kGreen, kRed};

TEST_F(MeshColors, ATextureOfAnObjBecomesColoursOfVertices) {
  folder_.write("a.png", png());
  folder_.write("a.mtl", "newmtl other\nKd 1 1 0\nnewmtl skin\nKd 0.1 0.1 0.1\nmap_Kd a.png\n");
  const MeshFile file = good("a.obj", square());
  EXPECT_EQ(file.mesh.vertex_colors, kOfSquare);
  EXPECT_TRUE(file.mesh.face_colors.empty());
  expectNote(file, "texture");

  // Names with blanks and options, a path of another machine, Windows line ends.
  folder_.write("my skin.png", png());
  folder_.write("b.mtl", "newmtl skin\r\nmap_Kd -clamp on -bm 0.5 C:\\scans\\my skin.png\r\n");
  EXPECT_EQ(good("b.obj", square("mtllib C:\\scans\\b.mtl")).mesh.vertex_colors, kOfSquare);
}

TEST_F(MeshColors, AJpegTextureIsRead) {
  folder_.write("a.jpg", jpeg());
  folder_.write("a.mtl", "newmtl skin\nmap_Kd a.jpg\n");
  const std::vector<Rgba8> colors = good("a.obj", square()).mesh.vertex_colors;
  ASSERT_EQ(colors.size(), 4u);
  for (std::size_t v = 0; v < 4; ++v)
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(colors[v][k], kOfSquare[v][k], 8) << v;  // lossy
}

TEST_F(MeshColors, WhereChartsMeetAVertexHasTheMeanOfItsCorners) {
  folder_.write("a.png", png());
  folder_.write("a.mtl", "newmtl skin\nmap_Kd a.png\n");
  const MeshFile file = good("a.obj",
                             "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.1 0.9\nvt 0.1 0.1\nusemtl skin\n"
                             "f 1/1 2/1 3/1\nf 2/2 4/2 3/2\n");
  EXPECT_EQ(file.mesh.vertex_colors, (std::vector<Rgba8>{kRed, {128, 0, 128, 255}, {128, 0, 128, 255}, kBlue}));
}

TEST_F(MeshColors, MaterialsWithoutTextureColourTheirFaces) {
  folder_.write("a.mtl", "newmtl gum\nKd 1 0 0\nnewmtl tooth\nKd 1 1 1\nnewmtl grey\nKd 0.8 0.8 0.8\n");
  const std::string vertices = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  EXPECT_EQ(good("a.obj", vertices + "f 1 2 3\nusemtl gum\nf 1 2 3 4\nusemtl tooth\nf 1 3 4\n").mesh.face_colors,
            (std::vector<Rgba8>{kNone, kRed, kRed, kWhite}));
  EXPECT_EQ(good("one.obj", vertices + "usemtl gum\nf 1 2 3\n").mesh.face_colors, (std::vector<Rgba8>{kRed}));
  // The default grey of modelling programs carries no information.
  EXPECT_TRUE(good("grey.obj", vertices + "usemtl grey\nf 1 2 3\n").mesh.face_colors.empty());
}

TEST_F(MeshColors, ATextureThatCannotBeReadIsNamedAndTheMeshIsReadWithout) {
  folder_.write("a.mtl", "newmtl skin\nmap_Kd a.png\n");
  MeshFile file = good("a.obj", square());
  EXPECT_TRUE(file.mesh.vertex_colors.empty());
  expectNote(file, "\"a.png\" (no such file)");
  expectNote(good("b.obj", square("mtllib absent.mtl")), "\"absent.mtl\"");

  const std::string whole = png();
  for (std::size_t length = 1; length < whole.size(); ++length) {
    folder_.write("a.png", whole.substr(0, length));
    EXPECT_EQ(good("a.obj", square()).mesh.triangles.size(), 2u);
  }
  folder_.write("a.png", "GIF89a" + std::string(100, '\1'));
  expectNote(good("a.obj", square()), "neither");
  // 9000 x 9000 pixels, declared in 33 bytes.
  std::string huge = whole;
  for (const std::size_t at : {16u, 20u}) huge.replace(at, 4, samples::bytes(std::uint32_t{9000}, true));
  folder_.write("a.png", huge);
  expectNote(good("a.obj", square()), "64 million");
  // Data that a decoder would unpack and discard.
  folder_.write("a.png", whole + std::string(2 << 20, '\0'));
  expectNote(good("a.obj", square()), "more data");
  std::filesystem::create_symlink("/dev/zero", folder_.path() / "zero");
  folder_.write("a.mtl", "newmtl skin\nmap_Kd zero\n");
  expectNote(good("a.obj", square()), "not a regular file");
}

TEST_F(MeshColors, OneOddNumberDoesNotChangeTheOtherColours) {
  std::string obj;
  for (int n = 0; n < 12; ++n) obj += fmt::format("v {} {} 0 0.5 0.5 0.5\n", n, n * n);
  for (const char* odd : {"300 0 0", "1.0 0.0 0.0"})
    EXPECT_EQ(good("a.obj", obj + "v 0 0 1 " + odd + "\nf 1 2 3\n").mesh.vertex_colors[0], (Rgba8{128, 128, 128, 255}))
        << odd;

  std::string ply = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n";
  for (const char* name : {"x", "y", "z", "red", "green", "blue"}) ply += fmt::format("property float {}\n", name);
  ply += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (int n = 0; n < 3; ++n) {
    for (const float x : {static_cast<float>(n), static_cast<float>(n * n), 0.0f}) ply += samples::bytes(x);
    for (int k = 0; k < 3; ++k) ply += samples::bytes(n == 2 ? std::numeric_limits<float>::infinity() : 0.5f);
  }
  ply += '\3';
  for (const std::int32_t v : {0, 1, 2}) ply += samples::bytes(v);
  const MeshFile file = good("a.ply", ply);
  ASSERT_EQ(file.mesh.vertex_colors.size(), 3u);
  EXPECT_EQ(file.mesh.vertex_colors[0], (Rgba8{128, 128, 128, 255}));
  EXPECT_EQ(file.mesh.vertex_colors[2], kNone);
}

// Another patient's export may lie at that place.
TEST_F(MeshColors, AnAbsolutePathFindsOnlyWhatLiesBesideTheMesh) {
  const TemporaryFolder other;
  other.write("a.png", png());
  folder_.write("a.mtl", "newmtl skin\nmap_Kd " + (other.path() / "a.png").string() + "\n");
  EXPECT_TRUE(good("a.obj", square()).mesh.vertex_colors.empty());
  folder_.write("a.png", png());
  EXPECT_EQ(good("a.obj", square()).mesh.vertex_colors, kOfSquare);
}

TEST_F(MeshColors, WhatATextureDoesNotCoverIsSaid) {
  folder_.write("a.png", png());
  folder_.write("a.mtl", "newmtl skin\nKd 1 0 0\nmap_Kd a.png\n");
  const std::string vertices = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\n";
  const MeshFile bare = good("bare.obj", vertices + "usemtl skin\nf 1 2 3\n");
  EXPECT_EQ(bare.mesh.face_colors, (std::vector<Rgba8>{kRed}));
  expectNote(bare, "no face has texture coordinates");
  expectNote(good("half.obj", vertices + "usemtl skin\nf 1/1 2/1 3/1\nf 1 3 4\n"), "3 corners");
  expectNote(good("other.obj", vertices + "usemtl absent\nf 1 2 3\n"), "\"absent\"");
}

TEST_F(MeshColors, NoBytesOfATextureBreakTheMesh) {
  std::mt19937 random(39);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  folder_.write("a.mtl", "newmtl skin\nmap_Kd a.picture\n");
  const std::string seeds[] = {png(), jpeg()};
  for (int round = 0; round < 600; ++round) {
    std::string bytes = seeds[round % 2];
    for (std::size_t n = 1 + below(4); n > 0; --n) bytes[below(bytes.size())] = static_cast<char>(below(256));
    if (below(4) == 0) bytes.resize(1 + below(bytes.size()));
    folder_.write("a.picture", bytes);
    const Mesh mesh = good("a.obj", square()).mesh;
    ASSERT_EQ(mesh.triangles.size(), 2u);
    ASSERT_TRUE(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == 4);
  }
}

TEST_F(MeshColors, ColoursOfVerticesComeBeforeATexture) {
  folder_.write("a.png", png());
  folder_.write("a.mtl", "newmtl skin\nmap_Kd a.png\n");
  const MeshFile file = good("a.obj",
                             "mtllib a.mtl\nv 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 1 1 0 1 1 1\nvt 0 0\nusemtl skin\n"
                             "f 1/1 2/1 3/1\n");
  EXPECT_EQ(file.mesh.vertex_colors, (std::vector<Rgba8>(3, kWhite)));
  expectNote(file, "colours of their own");
}

std::string texturedPly(bool by_face) {
  return std::string(
             "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\n"
             "property float y\nproperty float z\n") +
         (by_face ? "" : "property float s\nproperty float t\n") +
         "element face 1\nproperty list uchar int vertex_indices\n" +
         (by_face ? "property list uchar float texcoord\n" : "") + "end_header\n" +
         (by_face ? "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"
                  : "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n");
}

TEST_F(MeshColors, ATextureOfAPlyBecomesColoursOfVertices) {
  folder_.write("a.png", png());
  for (const bool by_face : {false, true}) {
    EXPECT_EQ(good("a.ply", texturedPly(by_face)).mesh.vertex_colors, kOfSquare) << by_face;
    std::string odd = texturedPly(by_face);
    odd.replace(odd.find("a.png"), 5, "b.png");
    const MeshFile without = good("b.ply", odd);
    EXPECT_TRUE(without.mesh.vertex_colors.empty());
    expectNote(without, "\"b.png\" (no such file)");
  }

  // Two pictures, selected by the face; the second is upside down.
  std::string flipped;
  auto rgb = quarters(2);
  std::rotate(rgb.begin(), rgb.begin() + 6, rgb.end());
  stbi_write_png_to_func(append, &flipped, 2, 2, 3, rgb.data(), 6);
  folder_.write("b.png", flipped);
  std::string two = texturedPly(true);
  two.insert(two.find("element vertex"), "comment TextureFile b.png\n");
  two.insert(two.find("end_header"), "property int texnumber\n");
  two.insert(two.size() - 1, " 1");
  EXPECT_EQ(good("two.ply", two).mesh.vertex_colors, (std::vector<Rgba8>{kRed, kGreen, kWhite, kBlue}));
}

TEST_F(MeshColors, ColoursOfPlyMayBeRealsOrShorts) {
  const auto ply = [](const std::string& type, const std::string& first, const std::string& second) {
    return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty " +
           type + " red\nproperty " + type + " green\nproperty " + type +
           " blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 " + first + "\n1 0 0 " +
           second + "\n0 1 0 0 0 0\n3 0 1 2\n";
  };
  const std::vector<Rgba8> expected{{255, 128, 0, 255}, {1, 2, 3, 255}, {0, 0, 0, 255}};
  EXPECT_EQ(good("a.ply", ply("float", "1 0.502 0", "0.0039 0.0078 0.0118")).mesh.vertex_colors, expected);
  EXPECT_EQ(good("b.ply", ply("double", "255 128 0", "1 2 3")).mesh.vertex_colors, expected);
  EXPECT_EQ(good("c.ply", ply("ushort", "65535 32896 0", "257 514 771")).mesh.vertex_colors, expected);
  EXPECT_EQ(good("d.ply", ply("int", "255 128 0", "1 2 3")).mesh.vertex_colors, expected);
  EXPECT_EQ(good("e.ply", ply("uchar", "255 128 0", "1 2 3")).mesh.vertex_colors, expected);
}

TEST_F(MeshColors, AttributeWordsOfAnStlAreColoursWhereTheySaySo) {
  constexpr std::uint16_t kOwn = 0x8000, kLow = 31, kHigh = 31 << 10;
  const auto colors = [&](const std::string& title, std::uint16_t word) {
    return good("a.stl", samples::binaryStl(title, 4, word)).mesh.face_colors;
  };
  // VisCAM and SolidView: red in the high bits, valid if the top bit is set.
  EXPECT_EQ(colors("VisCAM", kOwn | kHigh), (std::vector<Rgba8>(4, kRed)));
  EXPECT_EQ(colors("VisCAM", kOwn | kLow), (std::vector<Rgba8>(4, kBlue)));
  EXPECT_TRUE(colors("VisCAM", kHigh).empty());
  // Magics: red in the low bits; the top bit selects the colour of the whole.
  const std::string magics = "COLOR=" + std::string("\x00\xff\x00\xff", 4) + ",MATERIAL=";
  EXPECT_EQ(colors(magics, kLow), (std::vector<Rgba8>(4, kRed)));
  EXPECT_EQ(colors(magics, kOwn | kLow), (std::vector<Rgba8>(4, kGreen)));
  EXPECT_EQ(colors(magics, 0), (std::vector<Rgba8>(4, kGreen)));
}

}  // namespace
}  // namespace kerf::mesh_colors_test
