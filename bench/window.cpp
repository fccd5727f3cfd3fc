// Cost of a window frame. kerf-bench has no OpenGL: it runs kerf-sim from its own folder.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/demo/demo_molar.h"

namespace kerf::cli {
namespace {

constexpr double kEdge = 0.0773;  // mm: 300 000 triangles

Error noWindowProgram(std::string found) {
  return {.code = Error::Code::kUnsupported,
          .place = "kerf-bench window",
          .found = std::move(found),
          .expected = "the frame times of kerf-sim",
          .hint = "build kerf-sim (KERF_BUILD_WINDOW=ON); it must be in the folder of kerf-bench"};
}

struct Output {
  std::string text;
  int status = 0;
};

// Path of the kerf-sim beside this program.
Expected<Output> runWindowProgram(const std::string& arguments) {
  std::error_code failed;
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe", failed).parent_path() / "kerf-sim";
  if (failed || !std::filesystem::exists(program, failed)) return fail(noWindowProgram("no kerf-sim"));

  FILE* const pipe = ::popen(fmt::format("'{}' {} 2>&1", program.string(), arguments).c_str(), "r");
  if (!pipe) return fail(noWindowProgram("kerf-sim could not be started"));
  Output out;
  for (char bytes[256]; std::fgets(bytes, sizeof bytes, pipe);) out.text += bytes;
  out.status = ::pclose(pipe);
  return out;
}

// The object of {"name": {...}} behind `watched`, as FrameWatch prints it; 0: missing.
double watched(const std::string& text, const std::string& part, const std::string& number) {
  const std::size_t begin = part.empty() ? text.find("watched {") : text.find("\"" + part + "\": {");
  const std::size_t at = begin == text.npos ? begin : text.find("\"" + number + "\": ", begin);
  return at == text.npos ? 0 : std::atof(text.c_str() + at + number.size() + 4);
}

}  // namespace

// Opens a scan, drills along its middle for a while, and exports it. Every frame is drawn as in the window.
Expected<Result> benchWindowSession(const Bench& bench) {
  constexpr int kWidth = 1280, kHeight = 720;
  constexpr double kWay = 0.4;  // s between two places of the pointer
  const std::filesystem::path folder = bench.scratch.path();
  KERF_CHECK(writeMesh(folder / "scan.ply", demoMolar(kEdge)));
  std::string script = fmt::format(
      "file.open '{0}/scan.ply'\nwait\nview.top\nview.fit\ntool.select round-014\ncut.force 1\ncut.press {1} {2}\n",
      folder.string(), kWidth / 2, kHeight / 2);
  std::replace(script.begin(), script.end(), '\'', '"');
  const int ways = std::max(5, static_cast<int>(bench.seconds / kWay));
  for (int n = 0; n < ways; ++n)
    script += fmt::format("cut.drag {:.0f} {:.0f}\nwait {}\n", kWidth / 2 + 50 * std::sin(0.6 * n),
                          kHeight / 2 + 40 * std::sin(0.37 * n), kWay);
  script += fmt::format("cut.release\nwait 0.2\nfile.export \"{}/cut.stl\"\nwait\n", folder.string());
  std::ofstream(folder / "session.kerf") << script;

  KERF_TRY(output, runWindowProgram(fmt::format("--script '{0}/session.kerf' --watch --size {1}x{2} --voxel 0.1 "
                                                "--data '{0}/data' --config '{0}/config'",
                                                folder.string(), kWidth, kHeight)));
  const std::string& text = output.text;
  if (output.status != 0 || text.find("watched {") == text.npos) return fail(noWindowProgram(text));

  Result result(SceneId::kWindowSession,
                fmt::format("the demo molar as a scan of 300 000 triangles at 0.1 mm: opened, {:.0f} s of drilling, "
                            "exported, every frame drawn, {} x {}",
                            kWay * ways, kWidth, kHeight));
  for (const char* const part : {"opening", "cutting", "exporting"}) {
    result.add(fmt::format("frame while {}, p50", part), watched(text, part, "p50_ms"), "ms");
    result.add(fmt::format("frame while {}, p95", part), watched(text, part, "p95_ms"), "ms");
    result.add(fmt::format("frame while {}, longest", part), watched(text, part, "max_ms"), "ms");
  }
  result.add("carve to picture, p95", watched(text, "", "carve_to_picture_frames_p95"), "frames");
  result.add("haptic loop, mean", watched(text, "", "haptic_hz"), "Hz");
  result.add("overruns", watched(text, "", "overruns"));
  return result;
}

namespace {

// Many strokes of three burs all over a tooth, at increasing depth so that each cuts. After every tenth stroke: two
// undos, one redo. Each stroke prints the memory.
// @return  number of strokes.
int writeLongSession(std::ostream& script, double seconds) {
  constexpr double kStroke = 6.4;  // s
  constexpr const char* kBurs[] = {"round-014", "round-010", "856-016"};
  const int strokes = std::max(2, static_cast<int>(seconds / kStroke));
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int n = 0; n < strokes; ++n) {
    const double share = static_cast<double>(n) / strokes, away = std::sqrt(std::fmod(7 * share, 1.0));
    const double x = 640 + 130 * away * std::cos(n * turn), y = 360 + 110 * away * std::sin(n * turn);
    script << fmt::format("tool.select {}\ncut.depth {:.2f}\ncut.press {:.0f} {:.0f}\nwait 2\n", kBurs[n % 3],
                          0.3 + 2.5 * share, x, y);
    for (int way = 1; way <= 4; ++way)
      script << fmt::format("cut.drag {:.0f} {:.0f}\nwait 1\n", x + 12 * way * std::cos(n), y + 12 * way * std::sin(n));
    script << "cut.release\nwait 0.4\n";
    if (n % 10 == 9) script << "edit.undo\nwait 0.3\nedit.undo\nwait 0.3\nedit.redo\nwait 0.3\n";
    script << "print\n";
  }
  return strokes;
}

// The memory values of `print`, in order. Skips other lines.
std::vector<nlohmann::json> memoryIn(const std::string& text) {
  std::vector<nlohmann::json> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json state = nlohmann::json::parse(line, nullptr, false);
    if (state.is_object() && state.contains("memory")) out.push_back(state["memory"]);
  }
  return out;
}

}  // namespace

// Drills a tooth for long, without pictures: growth of memory.
Expected<Result> benchWindowMemory(const Bench& bench) {
  const std::filesystem::path folder = bench.scratch.path();
  KERF_CHECK(writeMesh(folder / "scan.ply", demoMolar(0.2)));
  std::ofstream script(folder / "long.kerf");
  script << fmt::format("file.open \"{}/scan.ply\"\nwait\nview.top\nview.fit\ncut.force 2\nprint\n", folder.string());
  const int strokes = writeLongSession(script, bench.seconds);
  script.close();

  KERF_TRY(output,
           runWindowProgram(fmt::format("--script '{0}/long.kerf' --size 1280x720 --voxel 0.1 --data '{0}/data' "
                                        "--config '{0}/config'",
                                        folder.string())));
  const std::vector<nlohmann::json> memory = memoryIn(output.text);
  if (output.status != 0 || memory.size() != static_cast<std::size_t>(strokes) + 1)
    return fail(noWindowProgram(output.text));

  Result result(SceneId::kWindowMemory,
                fmt::format("the demo molar as a scan at 0.1 mm, {} strokes of three burs in {:.1f} minutes, without "
                            "pictures",
                            strokes, bench.seconds / 60));
  const auto at = [&](std::size_t n, const char* name) { return memory[n].value(name, 0.0); };
  const std::size_t middle = memory.size() / 2, last = memory.size() - 1;
  double most = 0;
  for (std::size_t n = 0; n < memory.size(); ++n) most = std::max(most, at(n, "resident_MB"));
  result.add("strokes", strokes);
  result.add("in memory when opened", at(0, "resident_MB"), "MB");
  result.add("in memory half way", at(middle, "resident_MB"), "MB");
  result.add("in memory at the end", at(last, "resident_MB"), "MB");
  result.add("in memory, most over what it was when opened", most - at(0, "resident_MB"), "MB");
  constexpr std::array<std::array<const char*, 2>, 3> kPools = {
      {{"heap_in_use_MB", "heap in use"}, {"heap_kept_MB", "heap kept for later"}, {"log_MB", "log on disk"}}};
  for (const auto& [name, what] : kPools) {
    result.add(fmt::format("{}, grown by half way", what), at(middle, name) - at(0, name), "MB");
    result.add(fmt::format("{}, grown since then", what), at(last, name) - at(middle, name), "MB");
  }
  result.add("brick pools taken by half way", at(middle, "brick_pools"));
  result.add("brick pools taken since then", at(last, "brick_pools") - at(middle, "brick_pools"));
  return result;
}

}  // namespace kerf::cli
