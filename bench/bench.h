// Shared by the scenes of `kerf-bench`: input and result of a scene.
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

/// Every scene, in the order in which they run: the order of the rows of scene_table.cpp.
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

/// A folder for scratch files, removed at the end.
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

/// What a scene is given.
struct Bench {
  const Scratch& scratch;
  Progress progress;
  std::string mesh{};         ///< of the user, for bake and export; empty: the demo molar
  std::string case_folder{};  ///< of the user, for open; empty: the demo mandible
  double seconds = 20;        ///< length of realtime, window-session and window-memory
};

/// What a scene gives back. Goals are not its business: they are in the table, by the names of the numbers.
struct Result {
  Result(SceneId an_id, std::string text) : id(an_id), what(std::move(text)) {}

  void add(std::string name, double value, std::string_view unit = "") {
    measured.push_back({std::move(name), value, std::string(unit)});
  }
  /// A number, and by how much it leaves its range, as "  NAME: out of LOW to HIGH by": NaN of NaN, which meets no
  /// goal.
  void addWithin(const std::string& name, double value, double low, double high, std::string_view unit);

  SceneId id;
  std::string what;          ///< one line: what was timed or measured
  std::vector<double> ms{};  ///< one per repetition, motion or tick
  std::string state_hash{};
  double ratio = 0;  ///< to a bare library call measured in the same run; 0: none
  std::string ratio_to{};
  std::string part{};  ///< of the work, with a ratio of its own
  double part_ratio = 0;
  double peak_gb = 0;  ///< most memory of the whole program; 0: not measured
  std::vector<Measured> measured{};
  std::vector<std::string> notes{};  ///< sentences, such as what the system refused
  bool is_table = false;             ///< every name is "COLUMN: ROW"
};

/// ms, of a clock that never goes back.
inline double now() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The value that a share p in [0, 1] of them stays below; 0 of none.
double percentile(std::vector<double> values, double p);

inline auto cancelled() { return fail({.code = Error::Code::kCancelled, .found = "cancelled"}); }

/// A scene that did not do what it is there for, such as a cut without contact.
inline auto brokenScene(std::string place, std::string found, std::string expected) {
  return fail({.code = Error::Code::kEmpty,
               .place = std::move(place),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = "report this"});
}

/// A tool of assets/tools.
Expected<Tool> toolOfRack(const std::string& id);
/// All tools of the rack.
Expected<std::vector<Tool>> wholeRack();

/// Writes a demo's files into the scratch folder and bakes them there.   @return the case.
Expected<std::filesystem::path> bakedDemo(const DemoAnatomy& anatomy, double voxel, const Bench& bench);

// The scenes. Bake and export, against the library they call: bake.cpp. Opening a case: open.cpp. Motions of a bur:
// cut.cpp.
Expected<Result> benchBake(const Bench& bench);
Expected<Result> benchMandible(const Bench& bench);
Expected<Result> benchOpen(const Bench& bench);
Expected<Result> benchExport(const Bench& bench);
Expected<Result> benchCutBur(const Bench& bench);
// Times of the 1 kHz step: tick.cpp. The same on its own thread and on the clock: realtime.cpp.
Expected<Result> benchPoints(const Bench& bench);
Expected<Result> benchTickBur(const Bench& bench);
Expected<Result> benchTickSaw(const Bench& bench);
Expected<Result> benchTickFine(const Bench& bench);
Expected<Result> benchTickSizes(const Bench& bench);
Expected<Result> benchRealtime(const Bench& bench);
// The step's laws, numbers that are the same on every machine: invariance.cpp, sharp.cpp, forces.cpp, drives.cpp,
// drill_sites.cpp, saw.cpp, heat.cpp.
Expected<Result> benchInvariance(const Bench& bench);
Expected<Result> benchSharp(const Bench& bench);
Expected<Result> benchSharpRack(const Bench& bench);
Expected<Result> benchForces(const Bench& bench);
Expected<Result> benchDrives(const Bench& bench);
Expected<Result> benchDrillSites(const Bench& bench);
Expected<Result> benchSaw(const Bench& bench);
Expected<Result> benchHeat(const Bench& bench);
// One source each: the responses side by side, thin walls, ledger, pieces, splits on the clock, energy.
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
// A frame of the window, as kerf-sim times it: window.cpp.
Expected<Result> benchWindowSession(const Bench& bench);
Expected<Result> benchWindowMemory(const Bench& bench);

}  // namespace kerf::cli
