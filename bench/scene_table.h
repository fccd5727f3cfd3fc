// The scenes of `kerf-bench` and their goals, in one table. The command's help, --list, the printed lines, JSON and the
// exit code derive from it.
//
// To add a scene, add an id and a function to bench.h and a row to scene_table.cpp. An id without a row, or a row
// without a function, a text or goals, does not compile.
#pragma once

#include <span>
#include <string_view>

#include "bench/bench.h"
#include "bench/verdict.h"

namespace kerf::cli {

using RunScene = Expected<Result> (*)(const Bench& bench);

/// One row. Only the constructor makes one, so every field is set.
struct Scene {
  /// For scenes whose times have no goal, because they depend on the machine.
  static constexpr std::span<const Goal> kTimesOnly{};
  enum class When { kAlways, kOnlyByName };

  consteval Scene(SceneId an_id, std::string_view a_name, std::string_view a_text, RunScene a_function,
                  std::span<const Goal> its_goals, When is_run = When::kAlways)
      : id(an_id), name(a_name), what(a_text), run(a_function), goals(its_goals), when(is_run) {}

  SceneId id;
  std::string_view name;  ///< as the user types it, and in JSON
  std::string_view what;  ///< one line for the help
  RunScene run;
  std::span<const Goal> goals;
  When when;
};

/// All scenes, in running order.
std::span<const Scene> scenes();

const Scene& sceneOf(SceneId id);

/// @return an error that lists the names.
Expected<const Scene*> findScene(std::string_view name);

}  // namespace kerf::cli
