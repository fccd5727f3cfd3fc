// The result of a session that has ended, in the window's language and for scripts.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "geometry/field/material.h"
#include "sim/run/run_report.h"

namespace kerf {

/// Lines: time and removed volumes, force, distances to what is kept, temperature; without what is not known.
std::string resultText(const RunReport& report, const MaterialTable& materials);
/// The same in numbers, units in the keys.
nlohmann::json resultJson(const RunReport& report);

}  // namespace kerf
