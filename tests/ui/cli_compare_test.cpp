// kerf compare, run as a user does.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "tests/support/places.h"
#include "tests/ui/cli_runner.h"

namespace kerf::cli_compare_test {
namespace {

using nlohmann::json;

class CliCompare : public Cli {
 protected:
  json parsed(const std::vector<std::string>& words) {
    const Outcome o = runKerf(words);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    const json j = json::parse(o.out, nullptr, false);
    EXPECT_FALSE(j.is_discarded()) << o.out;
    return j;
  }

  // The box of box(), 6 x 5 x 4 mm, with every vertex moved by `place` from x, y, z.
  template <class Place>
  void writeBox(const std::string& name, const Place& place, const std::string& comment = "") {
    std::istringstream in(box());
    std::string line, out;
    for (int n = 0; std::getline(in, line); ++n) {
      double x = 0, y = 0, z = 0;
      if (n >= 2 && n < 10) {
        std::istringstream(line) >> x >> y >> z;
        const std::array<double, 3> p = place(x, y, z);
        line = fmt::format("{:.9g} {:.9g} {:.9g}", p[0], p[1], p[2]);
      }
      out += line + "\n";
      if (n == 0) out += comment;
    }
    folder_.write(name, out);
  }
  // The top of the box, z = 0, raised.
  void writeRaised(const std::string& name, double by) {
    writeBox(name, [&](double x, double y, double z) { return std::array{x, y, z == 0 ? by : z}; });
  }
};

TEST_F(CliCompare, MeasuresARaisedTop) {
  folder_.write("box.off", box());
  writeRaised("high.off", 0.25);
  const json j = parsed({"compare", at("box.off"), at("high.off"), "--unit", "mm", "--json"});
  EXPECT_NEAR(j["hausdorff_mm"].get<double>(), 0.25, 1e-6);
  EXPECT_NEAR(j["volume_difference_mm3"].get<double>(), 6 * 5 * 0.25, 1e-4);
  const json& d = j["second_from_first"];
  EXPECT_NEAR(d["most"]["mm"].get<double>(), 0.25, 1e-6);
  EXPECT_NEAR(d["most"]["at_mm"][2].get<double>(), 0.25, 1e-6);
  EXPECT_EQ(d["under"].get<double>(), 0);
  // The top and the upper parts of the sides: 30 and 22 * (0.25 - 0.1) of 30 + 30 + 22 * 4.25 mm^2.
  EXPECT_NEAR(d["over"].get<double>(), (30 + 22 * 0.15) / (60 + 22 * 4.25), 0.005);
  EXPECT_NEAR(j["first_from_second"]["over"].get<double>(), 30.0 / (60 + 22 * 4), 0.02);
  EXPECT_TRUE(j["notes"].empty()) << j["notes"];
  EXPECT_FALSE(j.contains("fit"));
}

TEST_F(CliCompare, WritesAMapAPictureAndATable) {
  folder_.write("box.off", box());
  writeRaised("high.off", 0.25);
  const json j = parsed(
      {"compare", at("box.off"), at("high.off"), "-o", at("m.ply"), "-o", at("m.svg"), "-o", at("m.csv"), "--json"});
  EXPECT_EQ(j["files"], json({at("m.ply"), at("m.svg"), at("m.csv")}));
  EXPECT_EQ(parsed({"check", at("m.ply"), "--json"})["print_ready"], true);
  EXPECT_NE(contentOf(at("m.ply")).find("\nproperty float quality\n"), std::string::npos);
  const std::string svg = contentOf(at("m.svg"));
  EXPECT_NE(svg.find("href=\"data:image/png;base64,iVBOR"), std::string::npos);
  EXPECT_NE(svg.find("within \u00b10.1 mm"), std::string::npos);

  std::istringstream table(contentOf(at("m.csv")));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "x_mm,y_mm,z_mm,deviation_mm");
  int raised = 0, rows = 0;
  for (; std::getline(table, line); ++rows) {
    const double mm = std::stod(line.substr(line.rfind(',') + 1));
    raised += std::abs(mm - 0.25) < 1e-6;
    EXPECT_TRUE(mm == 0 || std::abs(mm - 0.25) < 1e-6) << line;
  }
  EXPECT_EQ(rows, 8);
  EXPECT_EQ(raised, 4);
}

// Untouched surface is exactly 0, and the floor of the cut lies as deep as its path.
TEST_F(CliCompare, OfACaseAndItsRunIsTheCutAlone) {
  makeRun();
  const json j = parsed({"compare", at("box.case"), at("box.run"), "--json"});
  const json& d = j["second_from_first"];
  EXPECT_NEAR(d["least"]["mm"].get<double>(), -0.5, 0.01) << "the groove's floor, below a flat top";
  EXPECT_LT(d["most"]["mm"].get<double>(), 1e-4) << "a cut adds nothing";
  EXPECT_GT(d["unchanged"].get<double>(), 0.9);
  // A round bur of 0.7 mm radius, 0.5 mm deep, along 4 mm: a segment of its circle, and a cap of its ball.
  const double r = 0.7, deep = 0.5;
  const double segment = r * r * std::acos((r - deep) / r) - (r - deep) * std::sqrt(2 * r * deep - deep * deep);
  EXPECT_NEAR(j["volume_difference_mm3"].get<double>(),
              -(4 * segment + std::numbers::pi * deep * deep * (3 * r - deep) / 3), 0.01);
}

TEST_F(CliCompare, NothingMovesWithoutAlign) {
  folder_.write("box.off", box());
  const auto turned = [](double by, double shift) {
    return [=](double x, double y, double z) {
      return std::array{std::cos(by) * x - std::sin(by) * y + shift, std::sin(by) * x + std::cos(by) * y, z};
    };
  };
  writeBox("far.off", turned(2, 90));
  writeBox("near.off", turned(0.05, 0.1));
  refuses({"compare", at("box.off"), at("far.off")}, {"far.off", "mm beside", "--align"});

  const json far = parsed({"compare", at("box.off"), at("far.off"), "--align", "--json"});
  EXPECT_LT(far["hausdorff_mm"].get<double>(), 1e-4);
  EXPECT_LT(far["fit"]["rms_mm"].get<double>(), 1e-5);
  EXPECT_GT(far["fit"]["samples"].get<int>(), 1000);
  EXPECT_NEAR(far["fit"]["translation_mm"][0].get<double>(), -90, 1e-3);

  const Outcome o = runKerf({"compare", at("box.off"), at("near.off"), "--json"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_NE(o.err.find("CHECK THE FRAME"), o.err.npos) << o.err;
  EXPECT_GT(json::parse(o.out)["hausdorff_mm"].get<double>(), 0.1);
  EXPECT_LT(parsed({"compare", at("box.off"), at("near.off"), "--align", "--json"})["hausdorff_mm"].get<double>(),
            1e-4);
}

TEST_F(CliCompare, ReadsDeclaredUnits) {
  folder_.write("box.off", box());
  writeBox(
      "cm.off",
      [](double x, double y, double z) {
        return std::array{x / 10, y / 10, z / 10};
      },
      "# units = cm\n");
  EXPECT_LT(parsed({"compare", at("box.off"), at("cm.off"), "--json"})["hausdorff_mm"].get<double>(), 1e-6);
}

TEST_F(CliCompare, Refuses) {
  folder_.write("box.off", box());
  refuses({"compare", at("box.off"), at("none.off")}, {"none.off"});
  refuses({"compare", at("box.off"), at("box.off"), "-o", at("map.stl")}, {"map.stl", ".ply, .svg or .csv"});
  folder_.write("in.ply", "ply\n");
  refuses({"compare", at("in.ply"), at("box.off"), "-o", at("in.ply"), "--overwrite"}, {"never overwrites a scan"});
  folder_.write("old.csv", "mine\n");
  refuses({"compare", at("box.off"), at("box.off"), "-o", at("old.csv")}, {"old.csv", "--overwrite"});
  refuses({"compare", at("box.off"), at("box.off"), "--range", "0.05"}, {"--range", "more than the tolerance"}, 2);
  writeBox("mirrored.off", [](double x, double y, double z) { return std::array{-x, y, z}; });
  refuses({"compare", at("box.off"), at("mirrored.off")}, {"mirrored.off", "inside out", "kerf bake"});
}

}  // namespace
}  // namespace kerf::cli_compare_test
