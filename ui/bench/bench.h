// What the sources of `kerf bench` share.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/field/brick_field.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/demo/demo_anatomy.h"

namespace kerf::cli {

/// ms, of a clock that never goes back.
inline double now() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Calls stop() of a thread where a scope ends: before that which was declared earlier is gone.
template <class Thread>
struct StoppedAtTheEnd {
  Thread& thread;
  ~StoppedAtTheEnd() { thread.stop(); }
};

/// One number and what it has to be.
struct Measured {
  std::string name;  ///< as in JSON: "points_50k_p99"
  double value = 0;
  std::string unit;
  double goal = 0;  ///< the most it may be
  bool has_goal = true;
  bool passed() const { return !has_goal || value <= goal; }
};

struct Result {
  std::string scene, what;
  std::vector<double> ms;  // one per repetition, motion or tick
  std::string state_hash;
  double ratio = 0;  // to a bare library call measured in the same run; 0: none
  std::string ratio_to;
  std::string part{};  // of the work, with a ratio of its own
  double part_ratio = 0;
  double peak_gb = 0;  // most memory of the whole program; 0: not measured
  std::vector<Measured> measured{};
  std::vector<std::string> notes{};  // sentences, such as what the system refused
  bool is_table = false;             // every name is "COLUMN: ROW"

  double percentile(double p) const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted.empty()
               ? 0
               : sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(p * static_cast<double>(sorted.size())))];
  }
};

/// A folder for scratch files, removed at the end.
class Scratch {
 public:
  Scratch() : path_(std::filesystem::temp_directory_path() / ("kerf-bench-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Of bench_tick.cpp, for the other scenes too.
/// The case a demo makes.
Expected<std::filesystem::path> bakedDemo(const DemoAnatomy& anatomy, double voxel, const Scratch& scratch,
                                          const Progress& progress);
/// The highest tissue on a vertical line, mm; NaN: none.
double topAt(const BrickField& phi, double x, double y, const Box3& box);
inline auto cancelled() { return fail({Error::Code::kCancelled, "", "", "cancelled", "", ""}); }

inline Expected<Tool> toolOfRack(const std::string& id) {
  KERF_TRY(file, findToolFile(id, defaultToolFolders()));
  return readTool(file);
}

// Scenes of the 1 kHz step, times: bench_tick.cpp.
Expected<Result> benchPoints(const Progress& progress);
Expected<Result> benchTickBur(const Scratch& scratch, const Progress& progress);
Expected<Result> benchTickSaw(const Scratch& scratch, const Progress& progress);
Expected<Result> benchTickSizes(const Progress& progress);
// The same on its own thread, in real time, with mesher and recorder beside it: bench_realtime.cpp.
Expected<Result> benchRealtime(double seconds, const Scratch& scratch, const Progress& progress);
// And its laws, numbers that are the same on every machine: bench_law.cpp.
Expected<Result> benchInvariance(const Progress& progress);
Expected<Result> benchForces(const Progress& progress);
Expected<Result> benchSaw(const Progress& progress);
// Passing thin walls, falling apart, giving energy away: sources of their own.
Expected<Result> benchTunnelling(const Progress& progress);
Expected<Result> benchPieces(const Progress& progress);
Expected<Result> benchSever(const Scratch& scratch, const Progress& progress);
Expected<Result> benchPassivity(const Progress& progress);
// The responses to contact side by side: bench_response.cpp.
Expected<Result> benchResponse(const Progress& progress);
Expected<Result> benchPassivityLarge(const Progress& progress);

}  // namespace kerf::cli
