#include "sim/run/files/haptic_summary.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numeric>

namespace kerf {
namespace {

nlohmann::json jsonOf(const HapticSummary::Neighbour& n) {
  nlohmann::json j{{"id", n.id},
                   {"case_path", n.case_path},
                   {"case_id", n.case_id},
                   {"initial_mm3", n.initial_mm3},
                   {"removed_mm3", n.removed_mm3},
                   {"seconds_touched", n.seconds_touched},
                   {"seconds_in", n.seconds_in},
                   {"overlap_mm3", n.overlap_mm3}};
  for (const auto& [id, volume] : n.removed_by_material) j["removed_by_material_mm3"][id] = volume;
  return j;
}

// null: never.
nlohmann::json firstTimeIn(double at_s) { return at_s < 0 ? nlohmann::json() : nlohmann::json(at_s); }

}  // namespace

std::string toJson(const HapticSummary& s) {
  nlohmann::json j{{"settings", toJson(s.settings)},
                   {"ticks", s.ticks},
                   {"seconds", s.seconds},
                   {"is_complete", s.is_complete},
                   {"ended", s.ended},
                   {"short_of_end_mm", s.short_of_end_mm},
                   {"initial_mm3", s.initial_mm3},
                   {"removed_mm3", s.removed_mm3},
                   {"removed_uncertainty_mm3", s.removed_uncertainty_mm3},
                   {"added_mm3", s.added_mm3},
                   {"planned_mm3", s.planned_mm3},
                   {"reached_mm3", s.reached_mm3},
                   {"farthest_off_mm", s.farthest_off_mm},
                   {"farthest_off_at", {s.farthest_off_at[0], s.farthest_off_at[1], s.farthest_off_at[2]}},
                   {"remaining_mm3", s.remaining_mm3},
                   {"began_inside_mm", s.began_inside_mm},
                   {"seconds_in_contact", s.seconds_in_contact},
                   {"mean_contact_force_N", s.mean_contact_force},
                   {"peak_contact_force_N", s.peak_contact_force},
                   {"peak_contact_force_at_s", s.peak_contact_force_s},
                   {"mean_normal_load_N", s.mean_normal_load},
                   {"peak_hand_force_N", s.peak_hand_force},
                   {"work_mJ", s.work},
                   {"least_speed_of_nominal", s.least_speed},
                   {"stalled_s", s.stalled_s},
                   {"ticks_too_fast", s.too_fast},
                   {"ticks_out_of_room", s.out_of_bricks},
                   {"ticks_clamped", s.clamped},
                   {"ticks_clipped", s.clipped},
                   {"hottest_C", s.hottest_c},
                   {"hottest_at_s", s.hottest_s},
                   {"pulp_rise_K", s.pulp_rise},
                   {"nerve_rise_K", s.nerve_rise},
                   {"bone_limit_at_s", firstTimeIn(s.bone_limit_s)},
                   {"pulp_limit_at_s", firstTimeIn(s.pulp_limit_s)},
                   {"pieces", s.pieces},
                   {"crumbs", s.crumbs},
                   {"state_hash", s.state_hash}};
  if (s.coupling > 0) j["coupling_N_per_mm"] = s.coupling;
  if (!s.coupling_text.empty()) j["coupling"] = s.coupling_text;
  for (const auto& [id, volume] : s.initial_by_material) j["initial_by_material_mm3"][id] = volume;
  for (const auto& [id, volume] : s.removed_by_material) j["removed_by_material_mm3"][id] = volume;
  for (const auto& [id, volume] : s.planned_by_material) j["planned_by_material_mm3"][id] = volume;
  for (const auto& [id, volume] : s.added_by_material) j["added_by_material_mm3"][id] = volume;
  for (const auto& [id, distance] : s.least_distance_mm) j["least_distance_mm"][id] = distance;
  for (const auto& [id, at_s] : s.least_distance_s) j["least_distance_at_s"][id] = at_s;
  j["strokes"] = s.findings.strokes;
  j["idle_strokes"] = s.findings.idle;
  const auto& out_at = s.findings.comes_out_at;
  j["comes_out_at_mm"] = out_at ? nlohmann::json{out_at->x(), out_at->y(), out_at->z()} : nlohmann::json();
  for (const HapticSummary::Neighbour& n : s.beside) j["beside"].push_back(jsonOf(n));
  return j.dump(2);
}

namespace internal {

double sumOf(const VolumeByNumber& volumes) { return std::accumulate(volumes.begin(), volumes.end(), 0.0); }

std::map<std::string, double> byMaterial(const VolumeByNumber& volumes, const MaterialTable& materials) {
  std::map<std::string, double> out;
  for (std::size_t m = 0; m < volumes.size(); ++m) {
    if (volumes[m] == 0) continue;
    const MaterialProperties* row = materials.find(static_cast<Material>(m));
    out[row ? row->id : fmt::format("material {}", m)] += volumes[m];
  }
  return out;
}

}  // namespace internal
}  // namespace kerf
