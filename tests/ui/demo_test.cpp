// kerf demo: Kerf's own anatomy, requested as a user does.
#include <map>
#include <nlohmann/json.hpp>

#include "tests/ui/cli_runner.h"

namespace kerf::demo_test {
namespace {

using CliDemo = Cli;

TEST_F(CliDemo, WritesMeshesAndARecipeAndReplacesThemOnlyOnDemand) {
  const std::vector<std::string> command{"demo", "molar", "-o", at("molar"), "--coarseness", "4"};
  const Outcome o = runKerf(command);
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(o.err, "");
  for (const char* file : {"caries.ply", "enamel.ply", "pulp.ply", "tooth.ply", "molar.toml"}) {
    EXPECT_TRUE(std::filesystem::is_regular_file(in("molar") / file)) << file;
    EXPECT_NE(o.out.find(std::string("molar/") + file), o.out.npos) << o.out;
  }
  refuses(command, {"molar", "--overwrite"});
  auto forced = command;
  forced.push_back("--force");
  EXPECT_EQ(runKerf(forced).exit_code, 0);
}

TEST_F(CliDemo, TheRecipeOfTheMolarBakesEveryTissueWithItsVolume) {
  ASSERT_EQ(runKerf({"demo", "molar", "-o", at("molar"), "--coarseness", "3"}).exit_code, 0);
  const Outcome o = runKerf({"bake", at("molar/molar.toml"), "-o", at("molar.case"), "--voxel", "0.15", "--json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const auto j = nlohmann::json::parse(o.out);
  EXPECT_TRUE(j["exact"]);
  std::map<std::string, double> volume;
  double sum = 0;
  for (const auto& m : j["materials"]) {
    volume[m["id"]] = m["volume_mm3"];
    sum += m["volume_mm3"].get<double>();
  }
  EXPECT_EQ(volume.size(), 4u);
  for (const char* id : {"enamel", "dentin", "pulp", "caries"}) EXPECT_GT(volume[id], 1) << id;
  EXPECT_NEAR(sum / j["solid"]["volume_mm3"].get<double>(), 1, 0.003) << "tissues fill the tooth, each place once";
  bool pulp_is_whole = false;
  for (const auto& p : j["parts"])
    if (p["material"] == "pulp")
      pulp_is_whole = std::abs(p["volume_mm3"].get<double>() / p["own_mm3"].get<double>() - 1) < 0.02;
  EXPECT_TRUE(pulp_is_whole) << j["parts"].dump();
  EXPECT_EQ(j["gaps"]["forgotten_mm3"], 0);
}

TEST_F(CliDemo, RefusesWhatItCanNotMakeAndReplacesNoForeignFolder) {
  refuses({"demo", "molar", "-o", at("nowhere/molar")}, {"nowhere"});
  refuses({"demo", "molar", "-o", at("molar"), "--coarseness", "nan"}, {"--coarseness", "nan"}, 2);
  refuses({"demo", "whale", "-o", at("whale")}, {}, 2);
  std::filesystem::create_directory(in("holiday"));
  folder_.write("holiday/photo.jpg", "dear");
  refuses({"demo", "molar", "-o", at("holiday"), "--force", "--coarseness", "4"}, {"holiday"});
}

TEST_F(CliDemo, LeavesNothingBehindWhenInterrupted) {
  const Outcome o = runKerf({"demo", "molar", "-o", at("molar")}, {.signal = SIGINT, .signal_after = 0.4});
  EXPECT_EQ(o.exit_code, 1) << o.out;
  EXPECT_NE(o.err.find("cancelled"), o.err.npos) << o.err;
  EXPECT_EQ(folder_.entries(), 0u);
}

}  // namespace
}  // namespace kerf::demo_test
