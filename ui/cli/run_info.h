// Run part of `kerf info`: results for trainers first, then technical data.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "sim/run/report/run_report.h"

namespace kerf::cli {

/// All data, units in the keys. Null: never measured or unknown; "missing" gives the reason.
nlohmann::json runJson(const RunReport& report);

/// The same as text without the technical data: lines, each ended.
std::string runText(const RunReport& report);

}  // namespace kerf::cli
