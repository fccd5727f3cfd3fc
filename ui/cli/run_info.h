// What `kerf info` says of a run: first what a trainer asks, then the technical rest.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "sim/run/run_report.h"

namespace kerf::cli {

/// All of it, units in the keys; null: it never was, or is not known, and then "missing" says why.
nlohmann::json runJson(const RunReport& report);

/// The same for people, without the technical rest: lines, each ended.
std::string runText(const RunReport& report);

}  // namespace kerf::cli
