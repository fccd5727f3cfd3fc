// Object names in OBJ and 3MF: read, written, and replaced in files of other programs.
#include "geometry/formats/named_part.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/base/text.h"
#include "geometry/base/xml_text.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"

namespace kerf::named_part_test {
namespace {

using Objects = std::vector<NamedPart>;

class NamedParts : public testing::Test {
 protected:
  MeshFile read(const std::filesystem::path& path) {
    auto file = readMesh(path);
    EXPECT_TRUE(file) << file.error().message();
    return file ? std::move(*file) : MeshFile{};
  }
  Objects ofObj(const std::string& text) { return read(folder_.write("a.obj", text)).objects; }
  MeshFile thereAndBack(const std::string& name, const Mesh& mesh, const Objects& objects) {
    const auto path = folder_.path() / name;
    const auto written = writeMesh(path, mesh, {.objects = objects});
    EXPECT_TRUE(written) << written.error().message();
    return read(path);
  }
  TemporaryFolder folder_;
};

const std::string kCorners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\n";

// Two blocks, the triangles of each together.
Mesh twoBlocks() {
  Mesh out = test::blockMesh(true), other = test::blockMesh(true);
  for (Vec3d& p : other.vertices) p.x() += 10;
  append(out, other);
  return out;
}

TEST_F(NamedParts, ObjObjectsBeginAtTheTrianglesOfTheirFaces) {
  EXPECT_EQ(ofObj(kCorners + "o tooth 36 \nf 1 2 3 4\nf 1 2 5\no gingiva\nf 2 3 5\n"),
            (Objects{{"tooth 36", 0}, {"gingiva", 3}}));
  EXPECT_EQ(ofObj(kCorners + "f 1 2 3\no late\nf 1 2 5\no late\nf 2 3 5\no none\n"), (Objects{{"", 0}, {"late", 1}}));
  EXPECT_EQ(ofObj(kCorners + "f 1 2 3\n"), Objects{});
  EXPECT_EQ(ofObj(kCorners + "o\nf 1 2 3\n"), Objects{});
}

TEST_F(NamedParts, ObjGroupsNameAFileWithoutObjects) {
  EXPECT_EQ(ofObj("g default\n" + kCorners + "g crown\nf 1 2 3\ng root\nf 1 2 5\n"),
            (Objects{{"crown", 0}, {"root", 1}}));
}

TEST_F(NamedParts, FormatsBringThemBackAsTheirRowsSay) {
  const Mesh mesh = twoBlocks();
  const Objects objects{{"tooth 36", 0}, {"Zahnfleisch \xc3\xbc", 12}};
  for (const MeshFormatRow& row : meshFormats()) {
    const std::string name = "named" + std::string(row.extensions.substr(0, row.extensions.find(' ')));
    const MeshFile file = thereAndBack(name, mesh, objects);
    EXPECT_EQ(file.objects, row.carries.object_names ? objects : Objects{}) << row.name;
    if (!row.carries.object_names) continue;
    EXPECT_EQ(file.mesh.vertices, mesh.vertices) << row.name;
    EXPECT_EQ(file.mesh.triangles, mesh.triangles) << row.name;
    EXPECT_EQ(thereAndBack(name, mesh, {{"one", 0}}).objects, (Objects{{"one", 0}})) << row.name;
    EXPECT_EQ(thereAndBack(name, mesh, {{"", 0}, {"second", 12}}).objects, (Objects{{"", 0}, {"second", 12}}))
        << row.name;
  }
}

TEST_F(NamedParts, ThreeMfKeepsTheColoursOfEachObject) {
  Mesh by_face = twoBlocks(), by_vertex = twoBlocks();
  for (std::size_t t = 0; t < by_face.triangles.size(); ++t)
    by_face.face_colors.push_back({static_cast<std::uint8_t>(t), 7, 9, 255});
  for (std::size_t v = 0; v < by_vertex.vertices.size(); ++v)
    by_vertex.vertex_colors.push_back({static_cast<std::uint8_t>(v), 7, 9, 255});
  const Objects objects{{"a", 0}, {"b", 12}};
  EXPECT_EQ(thereAndBack("c.3mf", by_face, objects).mesh.face_colors, by_face.face_colors);
  EXPECT_EQ(thereAndBack("c.3mf", by_vertex, objects).mesh.vertex_colors, by_vertex.vertex_colors);
}

TEST_F(NamedParts, AreOneShortLineOfUtf8) {
  EXPECT_EQ(objectName(" \ttooth 36\r\n"), "tooth 36");
  EXPECT_EQ(objectName("a\x1b[31m\xff\nb"), "a\\x1b[31m\\xff b");
  EXPECT_EQ(objectName(" "), "");
  std::string umlauts;
  for (int n = 0; n < 1000; ++n) umlauts += "\xc3\xbc";
  EXPECT_EQ(objectName(umlauts), umlauts.substr(0, kLongestObjectName));
  EXPECT_EQ(objectName("x" + umlauts), "x" + umlauts.substr(0, kLongestObjectName - 2)) << "no half of a character";
  for (std::size_t n = 0; n < 20; ++n) {
    const std::string once = objectName(std::string(kLongestObjectName - n, 'x') + "\x01 \xc3\xbc");
    EXPECT_LE(once.size(), kLongestObjectName);
    EXPECT_EQ(objectName(once), once);
  }
}

TEST_F(NamedParts, HostileNamesBreakNoFile) {
  const Mesh mesh = twoBlocks();
  const std::string names[] = {"f 1 2 3",
                               "\"><object id=\"9",
                               "a\nv nan nan nan",
                               "\xef\xbf\xbe \xef\xbf\xbf",
                               "\xed\xa0\x80",
                               std::string("nul\0nul", 7),
                               "back\\",
                               "\\",
                               "# no comment",
                               "]]>&#0;<!--",
                               std::string(100000, '\x02'),
                               "\xe2\x80\xae"
                               "63 htoot"};
  for (const std::string& name : names)
    for (const char* file : {"h.3mf", "h.obj"}) {
      SCOPED_TRACE(printable(name.substr(0, 40)) + " in " + file);
      const MeshFile back = thereAndBack(file, mesh, {{"first", 0}, {name, 12}});
      EXPECT_EQ(back.mesh.triangles, mesh.triangles);
      ASSERT_EQ(back.objects.size(), 2u);
      EXPECT_EQ(back.objects[0].name, "first");
      EXPECT_EQ(back.objects[1].first_triangle, 12u);
      EXPECT_LE(back.objects[1].name.size(), kLongestObjectName);
      EXPECT_EQ(back.objects[1].name, printable(back.objects[1].name));
    }
  EXPECT_EQ(xmlText("a\xef\xbf\xbe"
                    "b\xef\xbf\xbf"),
            "a?b?")
      << "XML forbids them";
}

TEST_F(NamedParts, GroupsTellMoreThanOneNameForAll) {
  EXPECT_EQ(ofObj(kCorners + "o model\ng tooth 36\nf 1 2 3\ng gingiva\nf 1 2 5\n"),
            (Objects{{"tooth 36", 0}, {"gingiva", 1}}));
  EXPECT_EQ(ofObj(kCorners + "o model\ng default\nf 1 2 3\nf 1 2 5\n"), (Objects{{"model", 0}}));
  EXPECT_EQ(ofObj(kCorners + "o a\ng tooth 36\nf 1 2 3\no b\ng gingiva\nf 1 2 5\n"), (Objects{{"a", 0}, {"b", 1}}));
}

TEST_F(NamedParts, AnObjectWithoutANameAfterOneWithANameHasNone) {
  const Mesh mesh = read(folder_.write("two.obj", kCorners + "f 1 2 3\nf 1 2 5\n")).mesh;
  const Objects objects{{"tooth 36", 0}, {"", 1}};
  const auto file = folder_.path() / "back.obj";
  ASSERT_TRUE(writeMesh(file, mesh, {.objects = objects}));
  EXPECT_EQ(read(file).objects, objects);
}

TEST_F(NamedParts, TooManyAreNoneAndSaid) {
  std::string text = kCorners;
  for (std::size_t n = 0; n <= kMostObjectNames; ++n) text += "o part " + std::to_string(n) + "\nf 1 2 3\n";
  const MeshFile file = read(folder_.write("many.obj", text));
  EXPECT_EQ(file.mesh.triangles.size(), kMostObjectNames + 1);
  EXPECT_EQ(file.objects, Objects{});
  EXPECT_TRUE(std::any_of(file.notes.begin(), file.notes.end(),
                          [](const std::string& note) { return note.starts_with("Names of objects"); }));

  std::string in_turn = kCorners;
  for (std::size_t n = 0; n <= 2 * kMostObjectNames; ++n)
    in_turn += n % 2 ? "o upper\nf 1 2 3\n" : "o lower\nf 1 2 3\n";
  EXPECT_EQ(ofObj(in_turn).size(), 2 * kMostObjectNames + 1) << "names, not parts, are counted";

  std::string empty = kCorners + "f 1 2 3\n";
  for (int n = 0; n < 100000; ++n) empty += "o part " + std::to_string(n) + "\n";
  EXPECT_EQ(ofObj(empty + "f 1 2 5\n"), (Objects{{"", 0}, {"part 99999", 1}}));
}

}  // namespace
}  // namespace kerf::named_part_test
