// Input and result of a scene of `kerf-bench`.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "bench/verdict.h"
#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/demo/demo_anatomy.h"

namespace kerf::cli {

/// All scenes in running order, which is the row order of scene_table.cpp.
enum class SceneId {
  kBake,
  kMandible,
  kOpen,
  kCutBur,
  kExport,
  kPoints,
  kTickBur,
  kTickSaw,
  kTickFine,
  kTickSizes,
  kRealtime,
  kInvariance,
  kSharp,
  kSharpRack,
  kForces,
  kDrives,
  kDrillSites,
  kSaw,
  kHeat,
  kResponse,
  kSink,
  kTunnelling,
  kEdges,
  kLedger,
  kPieces,
  kSplit,
  kPassivity,
  kPassivityLarge,
  kDevices,
  kWindowSession,
  kWindowMemory,
  kCount
};

/// Scratch folder, removed by the destructor.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Input of a scene.
struct Bench {
  const Scratch& scratch;
  Progress progress;
  std::string mesh{};         ///< the user's mesh for bake and export; empty: the demo molar
  std::string case_folder{};  ///< the user's case for open; empty: the demo mandible
  double seconds = 20;        ///< duration of realtime, window-session and window-memory
};

/// Result of a scene. The table holds the goals, by the names of the numbers.
struct Result {
  Result(SceneId an_id, std::string text) : id(an_id), what(std::move(text)) {}

  void add(std::string name, double value, std::string_view unit = "") {
    measured.push_back({std::move(name), value, std::string(unit)});
  }
  /// Adds a number and its distance outside the range, as "  NAME: out of LOW to HIGH by". NaN gives NaN, which meets
  /// no goal.
  void addWithin(const std::string& name, double value, double low, double high, std::string_view unit);

  SceneId id;
  std::string what;          ///< one line: the measured subject
  std::vector<double> ms{};  ///< one per repetition, motion or tick
  std::string state_hash{};
  double ratio = 0;  ///< relative to a bare library call of the same run; 0: none
  std::string ratio_to{};
  std::string part{};  ///< name of a part of the work with its own ratio
  double part_ratio = 0;
  double peak_gb = 0;  ///< peak memory of the whole program; 0: not measured
  std::vector<Measured> measured{};
  std::vector<std::string> notes{};  ///< sentences, such as a refusal of the system
  bool is_table = false;             ///< every name is "COLUMN: ROW"
};

/// Monotonic clock, ms.
inline double now() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Upper bound of a share p in [0, 1] of the values; 0 if there are none.
double percentile(std::vector<double> values, double p);

inline auto cancelled() { return fail({.code = Error::Code::kCancelled, .found = "cancelled"}); }

/// Error for a scene that missed its purpose, such as a cut without contact.
inline auto brokenScene(std::string place, std::string found, std::string expected) {
  return fail({.code = Error::Code::kEmpty,
               .place = std::move(place),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = "report this bug"});
}

/// A tool of assets/tools.
Expected<Tool> toolOfRack(const std::string& id);
/// All tools of the rack.
Expected<std::vector<Tool>> wholeRack();

/// Writes the files of a demo into the scratch folder and bakes them there.   @return the case.
Expected<std::filesystem::path> bakedDemo(const DemoAnatomy& anatomy, double voxel, const Bench& bench);

// The scenes. Bake and export, relative to the library calls: bake.cpp. Opening a case: open.cpp. Motions of a bur:
// cut.cpp.
Expected<Result> benchBake(const Bench& bench);
Expected<Result> benchMandible(const Bench& bench);
Expected<Result> benchOpen(const Bench& bench);
Expected<Result> benchExport(const Bench& bench);
Expected<Result> benchCutBur(const Bench& bench);
// Times of the 1 kHz step: tick.cpp. The step on its own thread and in real time: realtime.cpp.
Expected<Result> benchPoints(const Bench& bench);
Expected<Result> benchTickBur(const Bench& bench);
Expected<Result> benchTickSaw(const Bench& bench);
Expected<Result> benchTickFine(const Bench& bench);
Expected<Result> benchTickSizes(const Bench& bench);
Expected<Result> benchRealtime(const Bench& bench);
// Laws of the step, with the same numbers on every machine: invariance.cpp, sharp.cpp, forces.cpp, drives.cpp,
// drill_sites.cpp, saw.cpp, heat.cpp.
Expected<Result> benchInvariance(const Bench& bench);
Expected<Result> benchSharp(const Bench& bench);
Expected<Result> benchSharpRack(const Bench& bench);
Expected<Result> benchForces(const Bench& bench);
Expected<Result> benchDrives(const Bench& bench);
Expected<Result> benchDrillSites(const Bench& bench);
Expected<Result> benchSaw(const Bench& bench);
Expected<Result> benchHeat(const Bench& bench);
// One source each: comparison of responses, thin walls, ledger, pieces, splits in real time, energy.
Expected<Result> benchResponse(const Bench& bench);
Expected<Result> benchSink(const Bench& bench);
Expected<Result> benchTunnelling(const Bench& bench);
Expected<Result> benchLedger(const Bench& bench);
Expected<Result> benchPieces(const Bench& bench);
Expected<Result> benchSplit(const Bench& bench);
Expected<Result> benchPassivity(const Bench& bench);
Expected<Result> benchPassivityLarge(const Bench& bench);
Expected<Result> benchDevices(const Bench& bench);
Expected<Result> benchEdges(const Bench& bench);
// Frame times of the window, measured by kerf-sim: window.cpp.
Expected<Result> benchWindowSession(const Bench& bench);
Expected<Result> benchWindowMemory(const Bench& bench);

}  // namespace kerf::cli
