#include "preprocess/volume/label_names.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace kerf::label_names_test {
namespace {

using Names = std::map<std::uint16_t, std::string>;

TEST(LabelNames, ComeFromTheSegmentsOfAnNrrdHeader) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("a.seg.nrrd",
                   "NRRD0004\ntype: unsigned char\nSegment0_Name:=Mandible\r\nSegment0_LabelValue:=3\r\n"
                   "Segment1_LabelValue:=12\nSegment1_Name:=Left canal, inferior\n\nSegment2_Name:=values\n"
                   "Segment2_LabelValue:=5\n");
  EXPECT_EQ(labelNames(file), (Names{{3, "Mandible"}, {12, "Left canal, inferior"}}));
}

TEST(LabelNames, WhatMakesNoSenseHasNone) {
  const TemporaryFolder folder;
  const std::string head = "NRRD0004\n";
  EXPECT_EQ(labelNames(folder.write("a.nrrd", head + "Segment0_Name:=No value\n\n")), Names{});
  EXPECT_EQ(labelNames(folder.write("b.nrrd", head + "Segment0_Name:=Far\nSegment0_LabelValue:=70000\n\n")), Names{});
  EXPECT_EQ(labelNames(folder.write("c.nrrd", head + "Segmentx_Name:=X\nSegmentx_LabelValue:=1\n\n")), Names{});
  EXPECT_EQ(labelNames(folder.write("d.nrrd", head + "Segment0_Name:=\nSegment0_LabelValue:=1\n\n")), Names{});
  EXPECT_EQ(labelNames(folder.write("e.mha", head + "Segment0_Name:=A\nSegment0_LabelValue:=1\n\n")), Names{});
  EXPECT_EQ(labelNames(folder.write("f.nrrd", "")), Names{});
  EXPECT_EQ(labelNames(folder.path() / "none.nrrd"), Names{});
  EXPECT_EQ(labelNames(folder.write("g.nrrd", head + std::string(3 << 20, 'x'))), Names{});
}

}  // namespace
}  // namespace kerf::label_names_test
