// kerf demo: anatomy of Kerf's own making, as a user asks for it.
#include "tests/ui/cli_runner.h"

namespace kerf {
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
  refuses(command, {"molar", "--force"});
  auto forced = command;
  forced.push_back("--force");
  EXPECT_EQ(runKerf(forced).exit_code, 0);
}

TEST_F(CliDemo, RefusesWhatItCanNotMakeAndReplacesNoForeignFolder) {
  refuses({"demo", "molar", "-o", at("nowhere/molar")}, {"nowhere"});
  refuses({"demo", "molar", "-o", at("molar"), "--coarseness", "nan"}, {"--coarseness", "0.5 to 4"});
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
}  // namespace kerf
