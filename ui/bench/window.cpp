// What a frame of the window costs. `kerf` knows no OpenGL: it asks kerf-sim, the program beside it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "geometry/formats/mesh_writer.h"
#include "preprocess/demo/demo_molar.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

constexpr double kEdge = 0.0773;  // mm: 300 000 triangles

Error noWindowProgram(std::string found) {
  return {.code = Error::Code::kUnsupported,
          .place = "kerf bench window",
          .found = std::move(found),
          .expected = "the frame times of kerf-sim",
          .hint = "build kerf-sim (KERF_BUILD_WINDOW=ON); it must stand beside kerf"};
}

struct Output {
  std::string text;
  int status = 0;
  std::string firstLine() const { return {text.begin(), std::find(text.begin(), text.end(), '\n')}; }
};

// Of the kerf-sim beside this program.
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

// The object of {"name": {...}} behind `watched`, as FrameWatch prints it; 0: it is not there.
double watched(const std::string& text, const std::string& part, const std::string& number) {
  const std::size_t begin = part.empty() ? text.find("watched {") : text.find("\"" + part + "\": {");
  const std::size_t at = begin == text.npos ? begin : text.find("\"" + number + "\": ", begin);
  return at == text.npos ? 0 : std::atof(text.c_str() + at + number.size() + 4);
}

}  // namespace

Expected<Result> benchWindow(const Bench& bench) {
  const std::filesystem::path mesh = bench.scratch.path() / "window.ply";
  KERF_CHECK(writeMesh(mesh, demoMolar(kEdge)));
  KERF_TRY(output, runWindowProgram(fmt::format("--time 60 --size 1280x720 '{}'", mesh.string())));
  const std::string &text = output.text, first_line = output.firstLine();

  double live50 = 0, live95 = 0, old50 = 0, old95 = 0;
  const std::size_t at = text.find("live p50");
  if (output.status != 0 || at == text.npos ||
      std::sscanf(text.c_str() + at, "live p50 %lf p95 %lf ms picture p50 %lf p95 %lf", &live50, &live95, &old50,
                  &old95) != 4)
    return fail(noWindowProgram(first_line));

  Result result(SceneId::kWindow, "processor time of a frame, 1280 x 720, the demo molar in 300 000 triangles");
  result.add("live frame, p50", live50, "ms");
  result.add("live frame, p95", live95, "ms");
  result.add("picture frame, p50", old50, "ms");
  result.add("picture frame, p95", old95, "ms");
  result.notes.push_back(first_line);
  return result;
}

// A scan is opened, drilled along its middle for a while and exported, every frame drawn as in the window.
Expected<Result> benchWindowSession(const Bench& bench) {
  constexpr int kWidth = 1280, kHeight = 720;
  constexpr double kWay = 0.4;  // s from one place of the pointer to the next
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

}  // namespace kerf::cli
