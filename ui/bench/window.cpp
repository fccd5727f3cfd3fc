// What a frame of the window costs. `kerf` knows no OpenGL: it asks kerf-sim, the program beside it.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
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

}  // namespace

Expected<Result> benchWindow(const Bench& bench) {
  std::error_code failed;
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe", failed).parent_path() / "kerf-sim";
  if (failed || !std::filesystem::exists(program, failed)) return fail(noWindowProgram("no kerf-sim"));

  const std::filesystem::path mesh = bench.scratch.path() / "window.ply";
  KERF_CHECK(writeMesh(mesh, demoMolar(kEdge)));
  const std::string command = fmt::format("'{}' --time 60 --size 1280x720 '{}' 2>&1", program.string(), mesh.string());
  FILE* const pipe = ::popen(command.c_str(), "r");
  if (!pipe) return fail(noWindowProgram("kerf-sim could not be started"));
  std::string text;
  for (char bytes[256]; std::fgets(bytes, sizeof bytes, pipe);) text += bytes;
  const int status = ::pclose(pipe);
  const std::string first_line(text.begin(), std::find(text.begin(), text.end(), '\n'));

  double live50 = 0, live95 = 0, old50 = 0, old95 = 0;
  const std::size_t at = text.find("live p50");
  if (status != 0 || at == text.npos ||
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

}  // namespace kerf::cli
