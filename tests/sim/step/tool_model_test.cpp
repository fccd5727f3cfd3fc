// The drive of a tool: its file's numbers, and the mean speed of a reciprocating motion.
#include "sim/step/tool_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tool/tool_file.h"
#include "tests/support/places.h"
#include "tests/support/temporary_file.h"

namespace kerf::tool_model_test {
namespace {

constexpr double kPi = std::numbers::pi;
const std::string kHead = "format = \"kerf-tool\"\nversion = 1\nid = \"a\"\nname = \"A\"\n";
const std::string kBur = kHead + "kind = \"bur\"\nshape = \"round\"\nhead_diameter = 1.4\n";
const std::string kBlade =
    kHead + "kind = \"blade\"\nthickness = 0.4\nwidth = 6\nlength = 20\ntooth_pitch = 1\nmotion = ";

Tool toolOf(const std::string& text) {
  const TemporaryFile file("a.toml", text);
  auto tool = readTool(file.path());
  EXPECT_TRUE(tool) << tool.error().message();
  return tool ? *tool : Tool{};
}

TEST(ToolModel, MeanSpeedIsThatOfAnyMotionThereAndBack) {
  constexpr double kStroke = 3, kFrequency = 187;
  // By its definition, for a crank's sine, for a cam that dwells at the ends, and for a motion with one slow direction.
  const auto sine = [](double phase) { return 0.5 * kStroke * std::sin(2 * kPi * phase); };
  const auto dwelling = [&](double phase) { return kStroke * std::clamp(std::sin(2 * kPi * phase), -0.5, 0.5); };
  const auto uneven = [](double phase) { return kStroke * (phase < 0.8 ? phase / 0.8 : (1 - phase) / 0.2); };
  constexpr int kSteps = 100000;
  const auto mean = [&](const auto& place) {
    double way = 0;
    for (int n = 0; n < kSteps; ++n) way += std::abs(place((n + 1.0) / kSteps) - place(1.0 * n / kSteps));
    return way * kFrequency;
  };
  EXPECT_NEAR(mean(sine), meanSpeed(kStroke, kFrequency), 1e-4);
  EXPECT_NEAR(mean(dwelling), meanSpeed(kStroke, kFrequency), 1e-4);
  EXPECT_NEAR(mean(uneven), meanSpeed(kStroke, kFrequency), 1e-4);
  // In the middle of a crank's stroke, a tooth is pi / 2 times the mean speed.
  const double fastest = (sine(1e-6) - sine(-1e-6)) / 2e-6 * kFrequency;
  EXPECT_NEAR(fastest / meanSpeed(kStroke, kFrequency), kPi / 2, 1e-6);
}

TEST(ToolModel, WithoutADriveInTheFileTheDefaultsHold) {
  for (const ToolListing& t : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"})) {
    ASSERT_TRUE(t.tool) << t.error->message();
    if (t.tool->drive.frequency_hz) continue;  // its file has a drive
    const ToolDrive drive = driveOf(*t.tool), expected = defaultDrive(*t.tool);
    EXPECT_EQ(drive.speed, expected.speed) << t.tool->id;
    EXPECT_EQ(drive.stall_load, expected.stall_load) << t.tool->id;
    EXPECT_EQ(drive.time_constant, expected.time_constant) << t.tool->id;
    EXPECT_EQ(drive.energy_factor, expected.energy_factor) << t.tool->id;
    EXPECT_EQ(drive.drag_factor, expected.drag_factor) << t.tool->id;
    EXPECT_GT(drive.speed, 0) << t.tool->id;
    EXPECT_NE(describeDrive(*t.tool).find("training defaults"), std::string::npos) << t.tool->id;
  }
}

TEST(ToolModel, TheFilesNumbersTurnIntoTheModelsUnits) {
  const std::string rest = "time_constant_s = 0.2\nenergy_factor = 4\ndrag_factor = 0.5\n";
  struct Case {
    std::string text;
    double speed, stall;
  };
  const Case cases[] = {
      {kBur + "[drive]\nspeed_rpm = 60000\nstall_torque_Nmm = 12\n" + rest, 2 * kPi * 1000, 12},
      {kBlade + "\"reciprocating\"\nstroke = 3\n[drive]\ncycles_per_min = 9600\nstall_force_N = 45\n" + rest,
       2 * 3 * 160.0, 45},
      {kBlade + "\"piezo\"\nstroke = 0.1\n[drive]\nfrequency_khz = 30\nstall_force_N = 18\n" + rest, 2 * 0.1 * 30000,
       18},
      {kBlade + "\"sagittal\"\nswing = 4\n[drive]\ncycles_per_min = 12000\nstall_torque_Nmm = 900\n" + rest,
       2 * 4 * kPi / 180 * 200, 900},
      {kHead +
           "kind = \"blade\"\nmotion = \"spin\"\nthickness = 0.4\ndiameter = 20\n[drive]\nspeed_rpm = 600\n"
           "stall_torque_Nmm = 90\n" +
           rest,
       2 * kPi * 10, 90},
  };

  for (const Case& c : cases) {
    const Tool tool = toolOf(c.text);
    const ToolDrive drive = makeToolModel(tool, 0.2).drive;
    EXPECT_NEAR(drive.speed, c.speed, 1e-9 * c.speed) << c.text;
    EXPECT_EQ(drive.stall_load, c.stall) << c.text;
    EXPECT_EQ(drive.time_constant, 0.2);
    EXPECT_EQ(drive.energy_factor, 4);
    EXPECT_EQ(drive.drag_factor, 0.5);
    EXPECT_NE(describeDrive(tool).find("(from the tool's file: speed, stall, time, energy, drag)"), std::string::npos)
        << describeDrive(tool);
  }
}

TEST(ToolModel, AHandpieceOfTheFileTurnsTheTool) {
  EXPECT_NE(describeDrive(toolOf(kBur)).find("turbine, 380000 rpm, stalls at 1 N mm"), std::string::npos);
  for (const Handpiece& row : handpieces()) {
    if (!(row.rpm > 0)) continue;
    const Tool tool = toolOf(kBur + "[drive]\nhandpiece = \"" + row.name + "\"\n");
    const ToolDrive drive = driveOf(tool);
    EXPECT_EQ(drive.form, row.form) << row.name;
    EXPECT_NEAR(drive.speed, row.rpm * 2 * kPi / 60, 1e-9 * drive.speed) << row.name;
    EXPECT_EQ(drive.stall_load, row.stall_Nmm) << row.name;
    EXPECT_NE(describeDrive(tool).find("(from the tool's file: handpiece)"), std::string::npos) << describeDrive(tool);
  }
  // Its numbers, if the file has them.
  const ToolDrive own = driveOf(toolOf(kBur + "[drive]\nhandpiece = \"electric\"\nstall_torque_Nmm = 3\n"));
  EXPECT_EQ(own.stall_load, 3);
  EXPECT_EQ(own.form, DriveForm::kGoverned);
}

// Both have the shape of a drill. A tool that cuts only with its point turns slowly; a bone cutter would hardly cut.
TEST(ToolModel, ADrillIsTurnedByAnImplantMotorABoneCutterByAStraightHandpiece) {
  const std::string drill = kHead +
                            "kind = \"bur\"\nshape = \"drill\"\nhead_diameter = 2\nhead_length = 9\npoint_angle = 118\n"
                            "shank_diameter = 2.35\nshank_length = 30\n";
  const Tool ends = toolOf(drill + "cuts = [\"end\"]\n"), all = toolOf(drill);
  EXPECT_TRUE(isDrill(ends));
  EXPECT_FALSE(isDrill(all));
  EXPECT_STREQ(handpieceOf(ends).name, "implant");
  EXPECT_STREQ(handpieceOf(all).name, "straight");
  EXPECT_TRUE(makeToolModel(ends, 0.2).lips.areThere());
  EXPECT_FALSE(makeToolModel(all, 0.2).lips.areThere());
}

TEST(ToolModel, WhatTheFileLeavesOutStaysADefault) {
  const Tool tool = toolOf(kBur + "[drive]\nspeed_rpm = 40000\n");
  const ToolDrive drive = driveOf(tool), usual = defaultDrive(tool);
  EXPECT_NEAR(drive.speed, 40000 * 2 * kPi / 60, 1e-9 * drive.speed);
  EXPECT_NE(drive.speed, usual.speed);
  EXPECT_EQ(drive.stall_load, usual.stall_load);
  EXPECT_EQ(drive.energy_factor, usual.energy_factor);
  EXPECT_NE(describeDrive(tool).find("40000 rpm"), std::string::npos) << describeDrive(tool);
  EXPECT_NE(describeDrive(tool).find("(from the tool's file: speed)"), std::string::npos) << describeDrive(tool);
}

}  // namespace
}  // namespace kerf::tool_model_test
