#include "geometry/case/case_bundle.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/support/temporary_folder.h"

namespace kerf::case_bundle_test {
namespace {

// A manifest of Kerf with one value replaced.
class CaseManifestFromAStranger : public ::testing::Test {
 protected:
  void SetUp() override {
    CaseManifest m;
    m.kerf_version = "1";
    m.id = m.solid_sha256 = m.field_sha256 = std::string(64, '0');
    CaseSource source;
    source.stored_as = "source-1.ply";
    source.format = "ply";
    source.sha256 = m.id;
    source.unit = "mm";
    source.scale_to_mm = 1;
    m.sources = {source};
    m.close_mode = "none";
    m.solid_volume_mm3 = 8.25;
    m.solid_area_mm2 = 24.5;
    m.box.add(Vec3d(1, 1, 1));
    m.box.add(Vec3d(3, 3, 3));
    m.voxel_mm = 0.5;
    m.field_voxels = 1234;
    m.shell_area_mm2 = 23.5;
    m.materials = {{"generic", 9, 8.25}};
    m.closing = {{"bridged_mm2", 12.5}, {"vertices_lost", 3}, {"handles_added", -1}};
    ASSERT_TRUE(writeCaseManifest(folder_.path(), m));
    std::ifstream in(folder_.path() / kCaseManifest, std::ios::binary);
    good_ = {std::istreambuf_iterator<char>(in), {}};
    const auto read = readCaseManifest(folder_.path());
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->closing, m.closing);
  }

  std::string refusalOf(const std::string& line, const std::string& instead) {
    std::string bad = good_;
    const std::size_t at = bad.find(line);
    EXPECT_NE(at, bad.npos) << line << " in\n" << good_;
    if (at == bad.npos) return {};
    folder_.write(kCaseManifest, bad.replace(at, line.size(), instead));
    const auto read = readCaseManifest(folder_.path());
    return read ? std::string() : read.error().message();
  }

  TemporaryFolder folder_;
  std::string good_;
};

TEST_F(CaseManifestFromAStranger, NumbersThatNoCaseHasAreRefusedByTheirKey) {
  for (const char* bad : {"nan", "-8.25", "inf", "1e300"}) {
    EXPECT_NE(refusalOf("area_mm2 = 24.5", std::string("area_mm2 = ") + bad).find("solid.area_mm2"), std::string::npos);
    EXPECT_NE(refusalOf("shell_area_mm2 = 23.5", std::string("shell_area_mm2 = ") + bad).find("field.shell_area_mm2"),
              std::string::npos);
    EXPECT_NE(refusalOf("scale_to_mm = 1.0", std::string("scale_to_mm = ") + bad).find("source.scale_to_mm"),
              std::string::npos);
  }
  EXPECT_NE(refusalOf("bridged_mm2 = 12.5", "bridged_mm2 = nan").find("close.numbers.bridged_mm2"), std::string::npos);
  EXPECT_NE(refusalOf("bridged_mm2 = 12.5", "bridged_mm2 = 'a'").find("close.numbers.bridged_mm2"), std::string::npos);
  for (const char* bad : {"-3.0", "2.5"})
    EXPECT_NE(
        refusalOf("vertices_lost = 3.0", std::string("vertices_lost = ") + bad).find("close.numbers.vertices_lost"),
        std::string::npos)
        << bad;
  EXPECT_NE(refusalOf("voxels = 1234", "voxels = -1").find("field.voxels"), std::string::npos);
  EXPECT_NE(refusalOf("voxels = 1234", "voxels = 9000000000000000000").find("field.voxels"), std::string::npos);
}

TEST_F(CaseManifestFromAStranger, APathOutOfTheCaseIsRefused) {
  for (const char* bad : {"../source-1.ply", "/etc/passwd", "a/b.ply", "..", ""})
    EXPECT_NE(refusalOf("source-1.ply", bad).find("source.stored_as"), std::string::npos) << bad;
}

}  // namespace
}  // namespace kerf::case_bundle_test
