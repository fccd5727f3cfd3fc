// Closing results kept in a case, as JSON.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "geometry/case/case_bundle.h"

namespace kerf::cli {

/// Counts are written as whole numbers; lengths, areas, volumes and shares are not, even if whole.
inline nlohmann::json closingJson(const std::map<std::string, double>& numbers) {
  nlohmann::json out = nlohmann::json::object();
  for (const auto& [key, value] : numbers) {
    if (isCountOfClosing(key))
      out[key] = static_cast<std::int64_t>(value);
    else
      out[key] = value;
  }
  return out;
}

}  // namespace kerf::cli
