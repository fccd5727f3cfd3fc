#include "ui/cli/run_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/run/files/small_cut.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

using nlohmann::json;

template <class T>
json orNull(const std::optional<T>& value) {
  return value ? json(*value) : json();
}

// Loaded tissues, then other removed ones.
std::vector<std::string> tissuesOf(const RunReport& r) {
  std::vector<std::string> out;
  for (const auto* volumes : {&r.loaded_by_material, &r.removed_by_material, &r.planned_by_material})
    for (const auto& [id, volume] : *volumes)
      if (std::find(out.begin(), out.end(), id) == out.end()) out.push_back(id);
  return out;
}

double volumeOf(const std::map<std::string, double>& volumes, const std::string& id) {
  const auto it = volumes.find(id);
  return it == volumes.end() ? 0 : it->second;
}

std::optional<double> shareOf(const RunReport& r, const std::string& id) {
  const double loaded = volumeOf(r.loaded_by_material, id);
  if (!(loaded > 0) || !r.removed_mm3) return {};
  return volumeOf(r.removed_by_material, id) / loaded;
}

void addVolumes(const RunReport& r, json& j) {
  j["loaded_mm3"] = orNull(r.loaded_mm3);
  j["removed_mm3"] = orNull(r.removed_mm3);
  if (r.added_mm3) {
    j["added_mm3"] = *r.added_mm3;
    j["added_by_material_mm3"] = r.added_by_material;
  }
  j["loaded_by_material_mm3"] = r.loaded_by_material;
  j["removed_by_material_mm3"] = r.removed_mm3 ? json(r.removed_by_material) : json();
  json shares = json::object();
  for (const std::string& id : tissuesOf(r)) shares[id] = orNull(shareOf(r, id));
  j["removed_share_by_material"] = shares;
}

void addPlan(const RunReport& r, json& j) {
  j["planned_mm3"] = orNull(r.planned_mm3);
  j["planned_by_material_mm3"] = r.planned_mm3 ? json(r.planned_by_material) : json();
  j["reached_mm3"] = orNull(r.reached_mm3);
  j["farthest_off_mm"] = orNull(r.farthest_off_mm);
  const auto& at = r.farthest_off_at;
  j["farthest_off_at_mm"] = at ? json{(*at)[0], (*at)[1], (*at)[2]} : json();
}

void addMoved(const RunManifest& m, json& j) {
  for (const RunManifest::Piece& p : m.pieces) {
    const Vec3d& t = p.T_case_piece.translation;
    const Eigen::Quaterniond& q = p.T_case_piece.rotation;
    j["pieces"].push_back({{"name", p.name},
                           {"volume_mm3", p.volume_mm3},
                           {"is_moved", p.isMoved()},
                           {"translation_mm", {t[0], t[1], t[2]}},
                           {"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}}});
  }
  for (const RunManifest::Beside& other : m.beside) {
    json row{{"case_path", other.case_path},
             {"case_id", other.case_id},
             {"voxel_mm", other.voxel_mm},
             {"removed_mm3", other.removed_mm3}};
    if (!other.name.empty()) row["name"] = other.name;
    j["beside"].push_back(std::move(row));
  }
}

// ---- As text

std::string at(const std::optional<double>& at_s) { return at_s ? fmt::format(" at {:.2f} s", *at_s) : ""; }

std::string percent(double share) { return fmt::format("{:.{}f} %", 100 * share, share < 0.1 ? 2 : 1); }

// A hardly touched tissue may have "lost" less than nothing: shares of voxels at its border. The text shows 0.
double noneBelow(double removed) { return std::max(0.0, removed); }

void printRunVolumes(const RunReport& r, std::string& out) {
  if (!r.removed_mm3) {
    out += "removed: not known\n";
    return;
  }
  out += fmt::format("removed {:.4f} mm3", *r.removed_mm3);
  if (r.loaded_mm3 && *r.loaded_mm3 > 0)
    out +=
        fmt::format(", {} of the {:.1f} mm3 that were loaded", percent(*r.removed_mm3 / *r.loaded_mm3), *r.loaded_mm3);
  out += "\n";
  if (const auto small = smallCut(*r.removed_mm3, r.manifest.voxel_mm)) out += fmt::format("  {}\n", *small);
  if (!r.manifest.begin_sha256.empty())
    out += r.manifest.mode == kModeSession
               ? "  since the case, with the cuts before this session; force, time and strokes are of this session\n"
               : "  since the run that this one continues; loaded is the result of that run\n";
  if (!r.manifest.earlier.empty())
    out += fmt::format("  with {} along other paths before; strokes and time are of the last path\n",
                       counted(r.manifest.earlier.size(), "cut"));
  for (const std::string& id : tissuesOf(r)) {
    const auto share = shareOf(r, id);
    out += fmt::format("  {:<18} {:>10.4f} mm3", id, noneBelow(volumeOf(r.removed_by_material, id)));
    if (share) out += fmt::format("  {:>7} of {:.1f}", percent(noneBelow(*share)), volumeOf(r.loaded_by_material, id));
    out += "\n";
  }
  if (!r.added_mm3) return;
  out += fmt::format("added {:.4f} mm3", *r.added_mm3);
  const char* between = ": ";
  for (const auto& [id, volume] : r.added_by_material)
    out += fmt::format("{}{} {:+.4f}", std::exchange(between, ", "), id, volume);
  out += "\n";
}

void printRunPlan(const RunReport& r, std::string& out) {
  if (!r.planned_mm3 || !r.reached_mm3 || !(*r.planned_mm3 > 0)) return;
  if (r.manifest.mode == kModeGeometry) {
    out += fmt::format("planned {:.4f} mm3, all done: without resistance the tool goes where its path says\n",
                       *r.planned_mm3);
    return;
  }
  const double beside = std::max(0.0, r.removed_mm3.value_or(0) - *r.reached_mm3);
  out += fmt::format("planned {:.4f} mm3, done {} of it, {:.4f} mm3 beside it\n", *r.planned_mm3,
                     percent(*r.reached_mm3 / *r.planned_mm3), beside);
  if (!r.farthest_off_mm) return;
  out += fmt::format("off the path by {:.2f} mm at most", *r.farthest_off_mm);
  if (const auto& p = r.farthest_off_at) out += fmt::format(", at ({:.2f}, {:.2f}, {:.2f})", (*p)[0], (*p)[1], (*p)[2]);
  out += "\n";
}

std::string nameOf(const std::string& id) {
  if (id == "nerve_canal") return "nerve canal";
  return id.starts_with("beside_") ? "neighbour " + id.substr(7) : id;
}

void printPeaks(const RunReport& r, std::string& out) {
  // Worse peak of an undone stroke.
  const auto back = [](const RunReport::Peak* peak, const char* unit) {
    if (!peak) return std::string();
    return fmt::format(" ({:.2f} {}{} in an undone stroke)", std::abs(peak->value), unit, at(peak->at_s));
  };
  const auto known = [](const std::optional<RunReport::Peak>& peak) { return peak ? &*peak : nullptr; };
  if (r.contact_force) {
    out += fmt::format("largest force {:.2f} N{}", r.contact_force->value, at(r.contact_force->at_s));
    out += back(known(r.taken_back.contact_force), "N");
    if (r.mean_contact_force) out += fmt::format("; mean {:.2f} N in contact", *r.mean_contact_force);
    out += "\n";
  }
  for (const auto& [id, least] : r.least_distance) {
    const auto worse = r.taken_back.least_distance.find(id);
    const auto* const undone = worse == r.taken_back.least_distance.end() ? nullptr : &worse->second;
    out += nameOf(id) + ": ";
    if (!least)
      out += "never near";
    else if (least->value < 0)
      out += fmt::format("TOOL IN IT by {:.2f} mm{}", -least->value, at(least->at_s));
    else
      out += fmt::format("{:.2f} mm at the nearest{}", least->value, at(least->at_s));
    out += back(undone, undone && undone->value < 0 ? "mm inside" : "mm") + "\n";
  }
  if (!r.hottest) return;
  out += fmt::format("highest temperature {:.1f} C{}", r.hottest->value, at(r.hottest->at_s));
  out += back(known(r.taken_back.hottest), "C");
  const auto limit = [](const char* what, const std::optional<RunReport::FirstTime>& when) {
    if (!when) return std::string();
    return *when ? fmt::format("; {} first at {:.2f} s", what, **when) : fmt::format("; {} never", what);
  };
  // Omits limits of tissues that the case lacks. Gives both if its tissues are unknown.
  const auto may_have = [&r](const char* id) {
    return r.loaded_by_material.empty() || r.loaded_by_material.contains(id);
  };
  if (may_have("cortical") || may_have("cancellous")) out += limit("47 C in bone", r.bone_limit);
  if (may_have("pulp")) out += limit("5.5 K in the pulp", r.pulp_limit);
  out += "\n";
}

void printCourse(const RunReport& r, std::string& out) {
  if (r.seconds)
    out += fmt::format("time {:.2f} s", *r.seconds);
  else if (r.path_s)
    out += fmt::format("time none: geometry alone, along a path of {:.2f} s", *r.path_s);
  if (r.strokes) out += "; " + counted(*r.strokes, "stroke");
  if (r.pieces) out += "; " + counted(*r.pieces, "piece");
  if (r.crumbs.value_or(0) > 0) out += fmt::format(" and {} below 0.1 mm3", counted(*r.crumbs, "crumb"));
  if (r.ended) out += "; ended: " + *r.ended;
  if (r.stalled_s.value_or(0) > 0.05)
    out += fmt::format("; the drive stalled for {:.2f} s of it: too {}", *r.stalled_s,
                       r.settings && r.settings->hand == nameOf(HandKind::kFeed) ? "fast a feed" : "heavy a hand");
  if (r.settings) out += "\nheld by " + describe(*r.settings);
  out += "\ntools: ";
  for (std::size_t n = 0; n < r.tools.size(); ++n) out += (n ? ", " : "") + r.tools[n];
  out += "\n";
}

}  // namespace

json runJson(const RunReport& r) {
  const RunManifest& m = r.manifest;
  json j{{"kind", "run"},          {"case_path", m.case_path},   {"case_id", m.case_id},
         {"mode", m.mode},         {"tool", m.tool_id},          {"duration_s", m.duration_s},
         {"voxel_mm", m.voxel_mm}, {"state_hash", m.state_hash}, {"kerf_version", m.kerf_version}};
  addVolumes(r, j);
  addPlan(r, j);
  j.update(peaksJson(r));
  j["time_s"] = orNull(r.seconds);
  j["stalled_s"] = orNull(r.stalled_s);
  j["strokes"] = orNull(r.strokes);
  j["piece_count"] = orNull(r.pieces);
  j["crumbs"] = orNull(r.crumbs);
  j["tools"] = r.tools;
  j["ended"] = orNull(r.ended);
  j["settings"] = r.settings ? toJson(*r.settings) : json();
  j["missing"] = r.missing;
  j["summary_is_edited"] = orNull(r.is_summary_edited);

  if (m.mode == kModeSession) {
    j["is_open"] = m.is_open;
  } else {
    j["segments"] = m.segments;
    j["path_length_mm"] = m.path_length_mm;
  }
  if (!m.begin_sha256.empty()) j["goes_on_from_field_sha256"] = m.begin_sha256;
  for (const RunManifest::EarlierCut& cut : m.earlier) j["earlier_tools"].push_back(cut.tool_id);
  addMoved(m, j);
  return j;
}

std::string runText(const RunReport& r) {
  std::string out;
  if (r.is_summary_edited.value_or(false))
    out +=
        "EDITED since it was written: summary.json. The values below come from it; kerf replay and kerf export do not "
        "use it\n";
  if (!r.manifest.is_open) {
    printRunVolumes(r, out);
    printRunPlan(r, out);
    printPeaks(r, out);
    printCourse(r, out);
  }
  for (const std::string& sentence : r.missing) out += "not known: " + sentence + "\n";
  return out;
}

}  // namespace kerf::cli
