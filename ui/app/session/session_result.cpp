#include "ui/app/session/session_result.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "ui/app/base/language.h"

namespace kerf {
namespace {

using Peak = RunReport::Peak;

std::string nameIn(const MaterialTable& materials, const std::string& id) {
  if (id.starts_with("beside_")) return phrase("neighbour {}", id.substr(7));
  const MaterialProperties* const row = materials.find(std::string_view(id));
  return shownText(row ? row->name : id);
}

std::string volumesText(const RunReport& r, const MaterialTable& materials) {
  constexpr double kWorthSaying = 0.0005;  // mm^3
  std::string out = phrase("Removed {:.3f} mm3 in {:.0f} s", *r.removed_mm3, r.seconds.value_or(0));
  const char* between = ": ";
  for (const auto& [id, volume] : r.removed_by_material) {
    if (std::abs(volume) < kWorthSaying) continue;
    out += shownNumbers("{}{} {:.3f}", between, nameIn(materials, id), volume);
    between = ", ";
  }
  return out + "\n";
}

std::string distanceText(const std::string& name, const std::optional<Peak>& least) {
  if (!least) return phrase("Never near the {}", name);
  return least->value < 0 ? phrase("Tool in the {}: {:.2f} mm deep", name, -least->value)
                          : phrase("Nearest to the {}: {:.2f} mm", name, least->value);
}

}  // namespace

std::string resultText(const RunReport& r, const MaterialTable& materials) {
  std::string out = r.removed_mm3 ? volumesText(r, materials) : "";
  if (r.contact_force) {
    out += phrase("Force on the tool: {:.2f} N mean, {:.2f} N at most", r.mean_contact_force.value_or(0),
                  r.contact_force->value);
    if (const auto& back = r.taken_back.contact_force) out += phrase(" ({:.2f} N in an undone stroke)", back->value);
    out += "\n";
  }
  for (const auto& [id, least] : r.least_distance) {
    out += distanceText(nameIn(materials, id), least);
    const auto back = r.taken_back.least_distance.find(id);
    if (back != r.taken_back.least_distance.end())
      out += back->second.value < 0 ? phrase(" ({:.2f} mm deep in an undone stroke)", -back->second.value)
                                    : phrase(" ({:.2f} mm in an undone stroke)", back->second.value);
    out += "\n";
  }
  if (r.hottest) {
    out += phrase("Warmest tissue under the tool: {:.1f} °C", r.hottest->value);
    if (const auto& back = r.taken_back.hottest) out += phrase(" ({:.1f} °C in an undone stroke)", back->value);
    out += "\n";
  }
  return out;
}

nlohmann::json resultJson(const RunReport& r) {
  nlohmann::json out = peaksJson(r);
  out["removed_mm3"] = r.removed_mm3 ? nlohmann::json(*r.removed_mm3) : nlohmann::json();
  out["removed_by_material_mm3"] = r.removed_by_material;
  out["time_s"] = r.seconds ? nlohmann::json(*r.seconds) : nlohmann::json();
  return out;
}

}  // namespace kerf
