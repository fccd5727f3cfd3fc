// kerf prepare, run as a user does.
#include <nlohmann/json.hpp>

#include "tests/support/places.h"
#include "tests/ui/cli_runner.h"

namespace kerf::cli_prepare_test {
namespace {

using nlohmann::json;

class CliPrepare : public Cli {
 protected:
  // The box of box() is 6 x 5 x 4 mm, its top at z = 0.
  void SetUp() override {
    folder_.write("box.off", box());
    folder_.write("plan.toml",
                  "format = \"kerf-print\"\nversion = 1\nup = [0, 0, 1]\n"
                  "[[step]]\ndo = \"hollow\"\nwall = 0.9\nrounding = 0\nvoxel = 0.2\nleast_cavity = 1\n"
                  "[[step]]\ndo = \"drain\"\ndiameter = 0.8\ncount = 1\n");
  }
  std::vector<std::string> command(const std::string& input, const std::string& output) {
    return {"prepare", at(input), "--unit", "mm", "--plan", at("plan.toml"), "-o", at(output), "--json"};
  }
};

TEST_F(CliPrepare, HollowsDrainsAndReports) {
  const Outcome o = runKerf(command("box.off", "print.stl"));
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const json j = json::parse(o.out, nullptr, false);
  ASSERT_FALSE(j.is_discarded()) << o.out;
  EXPECT_NEAR(j["source_mm3"].get<double>(), 120, 1e-3);
  EXPECT_NEAR(j["resin_mm3"].get<double>(), 120 - 4.2 * 3.2 * 2.2, 1.5);
  EXPECT_EQ(j["source_vertices_kept"], 8);
  EXPECT_EQ(j["steps"][1]["numbers"]["cavities_left"], 0);
  EXPECT_EQ(j["frame"], "scan");
  EXPECT_EQ(runKerf({"check", at("print.stl"), "--unit", "mm"}).exit_code, 0);
}

TEST_F(CliPrepare, AFileOfAnyFormatIsPreparedAgain) {
  const auto label = [](const char* face) {
    return fmt::format(
        "format = \"kerf-print\"\nversion = 1\nup = [0, 0, 1]\n[[step]]\ndo = \"label\"\ntext = \"{{tooth}}\"\n"
        "on = \"{}\"\nheight = 1.6\ndepth = 0.4\n",
        face);
  };
  folder_.write("below.toml", label("underside"));
  folder_.write("side.toml", label("side"));
  const auto prepare = [&](const std::string& input, const std::string& plan, const std::string& output) {
    return runKerf({"prepare", at(input), "--unit", "mm", "--plan", at(plan), "--word", "tooth=1", "-o", at(output),
                    "--overwrite"});
  };
  for (const char* format : {"stl", "ply", "obj", "off", "3mf"}) {
    const std::string name = std::string("print.") + format;
    ASSERT_EQ(prepare("box.off", "below.toml", name).exit_code, 0) << format;
    const Outcome o = prepare(name, "side.toml", "again.stl");
    EXPECT_EQ(o.exit_code, 0) << format << ": " << o.err;
  }
}

TEST_F(CliPrepare, Refuses) {
  folder_.write("copy.off", box());
  refuses({"prepare", at("copy.off"), "--unit", "mm", "--plan", at("plan.toml"), "-o", at("copy.off"), "--overwrite"},
          {"never overwrites a scan"});
  folder_.write("old.stl", "mine\n");
  refuses({"prepare", at("box.off"), "--unit", "mm", "--plan", at("plan.toml"), "-o", at("old.stl")}, {"--overwrite"});
  refuses({"prepare", at("box.off"), "--plan", at("none.toml"), "-o", at("x.stl")}, {"none.toml"});
  refuses({"prepare", at("box.off"), "--unit", "mm", "--word", "36", "-o", at("x.stl")}, {"--word", "tooth=36"}, 2);
  refuses(
      {"prepare", at("box.off"), "--unit", "mm", "--plan", at("plan.toml"), "--to-bed", "Nobody", "-o", at("x.stl")},
      {"Nobody", "Form 3"});
  folder_.write("word.toml",
                "format = \"kerf-print\"\nversion = 1\n[[step]]\ndo = \"hollow\"\n[[step]]\ndo = \"label\"\ntext = "
                "\"{dat}\"\n");
  refuses({"prepare", at("box.off"), "--unit", "mm", "--plan", at("word.toml"), "-o", at("x.stl")},
          {"step 2, label", "dat"});
}

}  // namespace
}  // namespace kerf::cli_prepare_test
