// kerf plot: a run over time as a chart.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "geometry/base/atomic_file.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/report/run_chart.h"
#include "sim/run/report/run_series.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;

struct PlotArguments {
  std::string run, output;
  std::vector<std::string> show;
  bool overwrites = false;
  double from = 0, until = std::numeric_limits<double>::infinity();
};

std::vector<std::string> panelNames() {
  std::vector<std::string> names;
  for (const ChartPanelRow& row : kChartPanels) names.emplace_back(row.name);
  return names;
}

bool isSvg(const fs::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".svg";
}

// Errors of the command line.
std::optional<Error> wrongUsage(const PlotArguments& a) {
  if (!isSvg(a.output))
    return Error{.code = Error::Code::kBadValue,
                 .place = "-o",
                 .found = "\"" + a.output + "\"",
                 .expected = "a name that ends in .svg",
                 .hint = fs::path(a.output).replace_extension(".svg").string()};
  if (!(a.from >= 0) || !(a.until > a.from))
    return Error{.code = Error::Code::kBadValue,
                 .place = "--from, --until",
                 .found = fmt::format("{} s, {} s", a.from, a.until),
                 .expected = "--from 0 or later and --until after it",
                 .hint = "omit one of them"};
  return {};
}

Expected<void> plot(const PlotArguments& a) {
  KERF_TRY(manifest, readRunManifest(a.run));
  KERF_TRY(series, [&] {
    TerminalProgress progress;
    return readRunSeries(a.run, progress.callback());
  }());

  ChartOptions options;
  for (const ChartPanelRow& row : kChartPanels)
    if (std::find(a.show.begin(), a.show.end(), row.name) != a.show.end()) options.panels.push_back(row.panel);
  options.from_s = a.from;
  options.until_s = a.until;
  options.title = (fs::path(a.run) / ".").lexically_normal().parent_path().filename().string();
  options.subtitle =
      fmt::format("{} with {}; {}", fs::path(manifest.case_path).filename().string(), manifest.tool_id, series.source);
  KERF_TRY(svg, drawChart(series, options));

  KERF_TRY(file, AtomicFile::create(a.output));
  file.stream() << svg;
  return file.commit();
}

int runPlot(const PlotArguments& a) {
  if (const auto wrong = wrongUsage(a)) return complainOfUsage(*wrong);
  if (const auto free = requireFree(a.output, a.overwrites); !free) return complain(free.error());
  const auto plotted = plot(a);
  if (!plotted) return complain(plotted.error());
  printText("drawn: {}\n", a.output);
  return kOk;
}

}  // namespace

void addPlot(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<PlotArguments>();
  command.footer(
      "Reads the run's forces.csv. A session of the window has none: Kerf replays its log in about a quarter of its "
      "time. A geometry run has no time to show.\n"
      "Example: kerf plot molar.run -o forces.svg\n"
      "         kerf plot molar.run --show force,distance --from 2 --until 4 -o near.svg");
  command
      .add_option("RUN", a->run, "run folder: cut with --hand, or a session of the window, also as one file (.kerf)")
      ->required();
  command.add_option("-o,--output", a->output, "picture to write, SVG")->type_name("FILE.svg")->required();
  command.add_option("--show", a->show, "quantities to show, separated by commas (default: all of the run)")
      ->delimiter(',')
      ->check(CLI::IsMember(panelNames()))
      ->allow_extra_args(false);
  command.add_option("--from", a->from, "start of the chart, s")->capture_default_str();
  command.add_option("--until", a->until, "end of the chart, s (default: the end of the run)");
  addOverwrite(command, a->overwrites, "replace an existing picture");
  addCasePlaces(command);
  command.callback([a, &exit_code] { exit_code = runPlot(*a); });
}

}  // namespace kerf::cli
