// Report of a `kerf-bench` run, as lines or JSON, by the table of scenes.
#pragma once

#include <nlohmann/json.hpp>

#include "bench/scene_table.h"

namespace kerf::cli {

/// @param verdict  null: no judgement; omits limits and verdicts.
void printResult(const Result& result, const Verdict* verdict);
nlohmann::json jsonOf(const Result& result, const Verdict* verdict);

/// Prints the table itself: every scene with its text and goals.
void printScenes();
nlohmann::json jsonOfScenes();

}  // namespace kerf::cli
