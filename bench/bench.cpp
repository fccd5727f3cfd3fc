#include "bench/bench.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "preprocess/bake/bake.h"

namespace kerf::cli {

namespace fs = std::filesystem;

void Result::addWithin(const std::string& name, double value, double low, double high, std::string_view unit) {
  add(name, value, unit);
  const double out = std::isnan(value) ? value : std::max({0.0, low - value, value - high});
  add(fmt::format("  {}: out of {} to {} by", name, low, high), out, unit);
}

Scratch::Scratch() : path_(fs::temp_directory_path() / ("kerf-bench-" + std::to_string(getpid()))) {
  fs::create_directories(path_);
}

Scratch::~Scratch() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

double percentile(std::vector<double> values, double p) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(p * static_cast<double>(values.size())))];
}

Expected<Tool> toolOfRack(const std::string& id) {
  KERF_TRY(file, findToolFile(id, defaultToolFolders()));
  return readTool(file);
}

Expected<std::vector<Tool>> wholeRack() {
  std::vector<Tool> tools;
  for (ToolListing& listing : listTools(defaultToolFolders())) {
    if (!listing.tool) return fail(*listing.error);
    tools.push_back(std::move(*listing.tool));
  }
  return tools;
}

Expected<fs::path> bakedDemo(const DemoAnatomy& anatomy, double voxel, const Bench& bench) {
  const fs::path folder = bench.scratch.path() / anatomy.name;
  const fs::path out = bench.scratch.path() / (anatomy.name + ".case");
  KERF_CHECK(writeDemoAnatomy(anatomy, folder, true));

  BakeOptions options;
  options.overwrite = true;
  options.voxelize.voxel_mm = voxel;
  options.voxel_is_given = true;
  KERF_CHECK(bakeRecipe(folder / anatomy.manifest(), out, options, bench.progress));
  return out;
}

}  // namespace kerf::cli
