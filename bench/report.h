// Report of a `kerf-bench` run: lines or JSON, by the table of scenes.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/scene_table.h"

namespace kerf::cli {

/// @param verdict  null: nothing was judged, and neither limits nor verdicts are shown.
void printResult(const Result& result, const Verdict* verdict);
nlohmann::json jsonOf(const Result& result, const Verdict* verdict);

/// The table itself: every scene with its text and its goals.
void printScenes();
nlohmann::json jsonOfScenes();

}  // namespace kerf::cli
