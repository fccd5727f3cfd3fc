// What a case keeps of its closing, as JSON.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace kerf::cli {

/// Counts are whole numbers; lengths, areas, volumes and shares are not, even where they happen to be.
inline nlohmann::json closingJson(const std::map<std::string, double>& numbers) {
  nlohmann::json out = nlohmann::json::object();
  for (const auto& [key, value] : numbers) {
    const bool is_count =
        !key.ends_with("_mm") && !key.ends_with("_mm2") && !key.ends_with("_mm3") && !key.ends_with("_share");
    if (is_count)
      out[key] = static_cast<std::int64_t>(value);
    else
      out[key] = value;
  }
  return out;
}

}  // namespace kerf::cli
