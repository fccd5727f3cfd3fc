#include "preprocess/bake/closing_numbers.h"

namespace kerf {

std::map<std::string, double> closingNumbers(const CloseReport& c) {
  const auto count = [](auto n) { return static_cast<double>(n); };
  std::map<std::string, double> out{{"vertices_lost", count(c.vertices_lost)},
                                    {"vertices_lost_farther_than_1_mm_from_rim", count(c.vertices_lost_far)},
                                    {"holes_filled", count(c.holes_filled)},
                                    {"rims_extruded", count(c.rims_extruded)},
                                    {"gaps_bridged", count(c.gaps_bridged)},
                                    {"rim_bridged_mm", c.rim_bridged_mm},
                                    {"widest_gap_mm", c.widest_gap_mm},
                                    {"bridged_mm2", c.bridged_mm2},
                                    {"bridged_share", c.bridged_share},
                                    {"widest_span_mm", c.widest_span_mm},
                                    {"handles_added", count(c.handles_added)},
                                    {"pinholes_mended", count(c.pinholes_mended)},
                                    {"rim_places_trimmed", count(c.rim_places_trimmed)},
                                    {"vertices_trimmed", count(c.vertices_trimmed)},
                                    {"triangles_trimmed", count(c.triangles_trimmed)},
                                    {"trimmed_mm2", c.trimmed_mm2},
                                    {"specks_dropped", count(c.specks_dropped)},
                                    {"specks_dropped_mm3", c.specks_dropped_mm3},
                                    {"vertices_in_specks", count(c.vertices_in_specks)},
                                    {"vertices_moved", count(c.vertices_moved)},
                                    {"largest_move_mm", c.largest_move_mm},
                                    {"crossings_resolved", count(c.crossings_resolved)},
                                    {"triangles_dropped", count(c.triangles_dropped)},
                                    {"triangles_added", count(c.triangles_added)}};
  if (c.triangles_cut_away > 0) {
    out["vertices_cut_away"] = count(c.vertices_cut_away);
    out["triangles_cut_away"] = count(c.triangles_cut_away);
    out["cut_away_mm2"] = c.cut_away_mm2;
  }
  if (!c.exact) out["wrapped_mm3"] = c.volume_closed_mm3;
  return out;
}

}  // namespace kerf
