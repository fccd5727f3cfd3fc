// kerf-bench: the table judges the goals, and a missed goal fails the command.
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/verdict.h"
#include "tests/ui/cli_runner.h"

namespace kerf::bench_test {
namespace {

using cli::Goal;
using cli::judge;
using cli::Measured;
using cli::Sense;
using nlohmann::json;

TEST(BenchGoal, ComparesAsItsSenseSays) {
  struct Row {
    Sense sense;
    double value;
    bool is_met;
  };
  const Row rows[] = {{Sense::kAtMost, 1.9, true},   {Sense::kAtMost, 2, true},  {Sense::kAtMost, 2.1, false},
                      {Sense::kAtLeast, 1.9, false}, {Sense::kAtLeast, 2, true}, {Sense::kAtLeast, 2.1, true},
                      {Sense::kExactly, 1.9, false}, {Sense::kExactly, 2, true}, {Sense::kExactly, 2.1, false}};
  for (const Row& row : rows) {
    const Goal goal{"p99", "ms", row.sense, 2};
    EXPECT_EQ(goal.isMetBy(row.value), row.is_met) << goal.requirement() << ": " << row.value;
    EXPECT_FALSE(goal.isMetBy(std::nan(""))) << goal.requirement();
  }
}

TEST(BenchGoal, IsAboutNumbersOfItsNameAndUnit) {
  const Goal goal{"force at {} mm, {} N", "N", Sense::kAtMost, 2};
  EXPECT_TRUE(goal.isAbout({"force at 0.05 mm, 1 N", 0, "N"}));
  EXPECT_FALSE(goal.isAbout({"force at 0.05 mm, 1 N", 0, "mN"}));
  EXPECT_FALSE(goal.isAbout({"force at 0.05 mm", 0, "N"}));
  EXPECT_FALSE(goal.isAbout({"force at  mm, 1 N and more", 0, "N"}));
  EXPECT_FALSE(goal.isAbout({"force at mm,  N", 0, "N"}));
}

TEST(BenchGoal, AGoalThatNothingMeasuresIsMissed) {
  const Goal goals[] = {{"p99", "ms", Sense::kAtMost, 2}, {"replay differs", "", Sense::kAtMost, 0}};
  const std::vector<Measured> all = {{"p50", 9, "ms"}, {"p99", 1, "ms"}, {"replay differs", 0, ""}};
  const auto met = judge(goals, all);
  EXPECT_TRUE(met.isMet());
  EXPECT_EQ(met.goal_of, (std::vector<const Goal*>{nullptr, &goals[0], &goals[1]}));

  const auto missed = judge(goals, std::span(all).first(2));
  EXPECT_FALSE(missed.isMet());
  EXPECT_EQ(missed.not_measured, std::vector<const Goal*>{&goals[1]});
  EXPECT_EQ(missed.missed, std::vector<std::string>{"replay differs was not measured"});
}

TEST(BenchGoal, AnAimIsShownAndFailsNothing) {
  const Goal goals[] = {{"{}, 1 m/s: passed", "", Sense::kAtMost, 0, cli::Weight::kAim},
                        {"{}: passed", "", Sense::kAtMost, 0}};
  const auto aim_missed = judge(goals, std::vector<Measured>{{"ball, 1 m/s: passed", 4, ""}, {"ball: passed", 0, ""}});
  EXPECT_TRUE(aim_missed.isMet());
  EXPECT_EQ(aim_missed.goal_of[0]->verdictOn(4), "MISSED, an aim");
  const auto goal_missed = judge(goals, std::vector<Measured>{{"ball, 1 m/s: passed", 4, ""}, {"ball: passed", 1, ""}});
  EXPECT_EQ(goal_missed.missed.size(), 1u);
  EXPECT_EQ(goal_missed.goal_of[1]->verdictOn(1), "MISSED");
}

TEST(BenchGoal, LimitsOfTheUserReplaceThoseOfTheTable) {
  std::vector<Goal> goals = {{"{} bricks, p99", "ms", Sense::kAtMost, 2}};
  ASSERT_TRUE(cli::changeLimits(goals, std::vector<std::string>{"400 bricks, p99=3.5"}));
  EXPECT_EQ(goals[0].limit, 3.5);
  for (const std::string bad : {"400 bricks, p99", "400 bricks, p99=", "400 bricks, p99=fast", "p99=1"}) {
    const auto refused = cli::changeLimits(goals, std::vector{bad});
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().place, "--limit") << bad;
  }
}

const RunOptions kBench{.program = "kerf-bench"};

using CliBench = Cli;

TEST_F(CliBench, TellsPercentilesAndStateHash) {
  const Outcome o = runKerf({"cut-bur", "--json"}, kBench);
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const json bench = json::parse(o.out);
  ASSERT_EQ(bench.size(), 1u);
  EXPECT_LE(bench[0]["p50_ms"], bench[0]["p99_ms"]);
  EXPECT_LE(bench[0]["p99_ms"], bench[0]["max_ms"]);
  EXPECT_EQ(bench[0]["state_hash"].get<std::string>().size(), 16u);
}

TEST_F(CliBench, RefusesWrongScenesMeshesAndNumbers) {
  folder_.write("noise.stl", "no mesh");
  refuses({"bake", "--mesh", at("noise.stl")}, {"noise.stl"}, 1, kBench);
  refuses({"drill"}, {"drill", "cut-bur"}, 1, kBench);
  refuses({"tick-sizes", "--limit", "p99=1"}, {"--limit", "over the smallest"}, 1, kBench);
  refuses({"--limit", "p99=1"}, {"SCENE"}, 2, kBench);
  for (const std::string option : {"--seconds", "--minutes"})
    for (const std::string number : {"nan", "-inf", "1e999"})
      refuses({"realtime", option + "=" + number}, {option, number}, 2, kBench);
}

TEST_F(CliBench, FailsWhenAGoalIsMissedAndNotWithoutGoals) {
  const auto run = [](const std::string& limit, const std::vector<std::string>& more) {
    std::vector<std::string> words{"tick-sizes", "--limit", "{} bricks: over the smallest=" + limit};
    words.insert(words.end(), more.begin(), more.end());
    return runKerf(words, kBench);
  };
  // The smallest over the smallest is 1.
  const Outcome missed = run("0.5", {});
  EXPECT_EQ(missed.exit_code, 1);
  EXPECT_NE(missed.out.find("(at most 0.5: MISSED)"), missed.out.npos) << missed.out;
  EXPECT_NE(missed.err.find("over the smallest is 1, not at most 0.5"), missed.err.npos) << missed.err;

  const Outcome met = run("1e9", {"--json"});
  EXPECT_EQ(met.exit_code, 0) << met.err;
  const json numbers = json::parse(met.out)[0]["measured"];
  int judged = 0;
  for (const auto& [name, number] : numbers.items())
    if (number.contains("at_most")) {
      ++judged;
      EXPECT_TRUE(number["passed"].get<bool>()) << name;
    }
  EXPECT_EQ(judged, 3);

  const Outcome unjudged = run("0.5", {"--no-goals"});
  EXPECT_EQ(unjudged.exit_code, 0) << unjudged.err;
  EXPECT_EQ(unjudged.out.find("at most"), unjudged.out.npos) << unjudged.out;
  EXPECT_NE(unjudged.out.find("over the smallest"), unjudged.out.npos) << unjudged.out;
}

TEST_F(CliBench, ListsEverySceneWithItsGoals) {
  const Outcome text = runKerf({"--list"}, kBench), help = runKerf({"--help"}, kBench);
  ASSERT_EQ(text.exit_code, 0) << text.err;
  const json all = json::parse(runKerf({"--list", "--json"}, kBench).out);
  EXPECT_EQ(all.size(), 31u);
  for (const json& scene : all) {
    const auto name = scene["scene"].get<std::string>(), what = scene["what"].get<std::string>();
    EXPECT_NE(text.out.find(name), text.out.npos) << name;
    EXPECT_NE(help.out.find(what.substr(0, 20)), help.out.npos) << what;
    for (const json& goal : scene["goals"])
      EXPECT_NE(text.out.find(goal["name"].get<std::string>()), text.out.npos) << goal;
  }
}

}  // namespace
}  // namespace kerf::bench_test
