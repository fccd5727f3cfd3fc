// The result of an ended session, in the window's language and for scripts.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "geometry/field/material.h"
#include "sim/run/report/run_report.h"

namespace kerf {

/// Lines: time and removed volumes, force, distances to protected structures, temperature; omits unknown values.
std::string resultText(const RunReport& report, const MaterialTable& materials);
/// The same as numbers, units in the keys.
nlohmann::json resultJson(const RunReport& report);

}  // namespace kerf
