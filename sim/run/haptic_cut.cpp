#include "sim/run/haptic_cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/version.h"
#include "geometry/field/vdb_io.h"
#include "geometry/tool/tool_file.h"
#include "sim/monitor/monitor.h"
#include "sim/monitor/vibration.h"
#include "sim/monitor/wave_file.h"
#include "sim/pieces/pieces.h"
#include "sim/run/load_scene.h"
#include "sim/run/replay.h"
#include "sim/run/run_files.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr const char* kForces = "forces.csv";
constexpr const char* kSummary = "summary.json";
constexpr const char* kSound = "sound.wav";
constexpr std::uint32_t kSoundRate = 48'000;
constexpr std::uint64_t kSnapshotTicks = 10'000;  // between two snapshots in the log, at least

Expected<void> checkOptions(const HapticCutOptions& o) {
  struct Range {
    const char* name;
    double value, low, high;
    const char* unit;
  };
  const Range ranges[] = {
      {"force", o.force.force, 0.01, o.step.coupling.force_limit, "N"},
      {"feed limit", o.force.feed_limit, 0.01, 1000, "mm/s"},
      {"spindle", o.spindle, 0, 1, "of nominal"},
      {"coupling stiffness", o.step.coupling.stiffness, 0.01, 100, "N/mm"},
      {"coupling damping", o.step.coupling.damping, 0, 1, "N s/mm"},
      {"device mass", o.device.mass_kg, 0.001, 10, "kg"},
      {"device damping", o.device.damping, 0, 1, "N s/mm"},
      {"device friction", o.device.friction, 0, 10, "N"},
      {"encoder", o.device.encoder_mm, 0, 1, "mm"},
      {"delay", static_cast<double>(o.device.delay_ticks), 0, 50, "ticks"},
      {"hand stiffness", o.device.hand_stiffness, 0, 100, "N/mm"},
      {"hand damping", o.device.hand_damping, 0, 1, "N s/mm"},
      {"patience", o.force.patience, 0.001, 86400, "s"},
      {"coupling mass", o.step.coupling.mass_kg, 0.0001, 10, "kg"},
      {"coupling filter", o.step.coupling.filter_hz, 0.1, 1000, "Hz"},
      {"ramp", o.step.ramp_s, 0, 60, "s"},
      {"looks a tick", static_cast<double>(o.step.most_substeps), 1, 1000, ""},
      {"time limit", o.time_limit, 0.001, 86400, "s"},
  };
  for (const Range& r : ranges)
    if (!(r.value >= r.low && r.value <= r.high))
      return fail({Error::Code::kBadValue, "", r.name, fmt::format("{} {}", r.value, r.unit),
                   fmt::format("{} to {} {}", r.low, r.high, r.unit), ""});
  if (o.hand == HandKind::kFeed && o.step.response != Response::kPenalty)
    return fail({Error::Code::kBadValue, "", "response", "not penalty, with a hand that follows its path",
                 "penalty: a tool that is where its path says cannot be held back", "hand force or device"});
  return {};
}

// The cases of a session as files: the one to be cut first.
struct SceneFiles {
  std::vector<fs::path> folders;
  std::vector<CaseManifest> manifests;
  std::vector<std::string> paths;  // from the run
};

Expected<SceneFiles> filesOf(const fs::path& case_folder, const std::vector<fs::path>& beside,
                             const fs::path& run_folder) {
  if (beside.size() >= kMostObjects)
    return fail({Error::Code::kBadValue, "", "--beside", fmt::format("{} cases", beside.size()),
                 fmt::format("at most {}", kMostObjects - 1), "the nearest ones"});
  SceneFiles out;
  out.folders.push_back(case_folder);
  out.folders.insert(out.folders.end(), beside.begin(), beside.end());
  for (const fs::path& folder : out.folders) {
    KERF_TRY(manifest, readCaseManifest(folder));
    for (std::size_t n = 0; n < out.manifests.size(); ++n)
      if (out.manifests[n].id == manifest.id)
        return fail({Error::Code::kBadValue, folder.string(), "--beside",
                     "the same case as " + out.folders[n].string() + ": two solids in one place",
                     "another tooth or jaw of the same scan frame", "give each case once"});
    KERF_TRY(path, internal::relativeCasePath(folder, run_folder));
    out.manifests.push_back(std::move(manifest));
    out.paths.push_back(std::move(path));
  }
  return out;
}

// What two objects have in common, mm^3: nodes of one that lie in the other.
double overlapOf(const BakedObject& a, const BakedObject& b) {
  const double scale = b.voxel() / a.voxel();
  std::size_t nodes = 0;
  for (const BakedObject::Slot& slot : b.slots()) {
    const Vec3i base = kBrickSide * slot.brick;
    const auto inOfA = [&](const Vec3i& node) -> Vec3i {
      return (scale * node.cast<double>()).array().round().matrix().cast<int>();
    };
    const Vec3i low = brickOf(inOfA(base)) - a.directoryLow(),
                high = brickOf(inOfA(base + Vec3i::Constant(kBrickSide - 1))) - a.directoryLow();
    if ((high.array() < 0).any() || (low.array() >= a.directorySize().array()).any()) continue;
    for (int n = 0; n < kBrickNodes; ++n)
      if (slot.phi[n] <= 0 && a.phi0().at(inOfA(base + Vec3i(n >> 6, n >> 3 & 7, n & 7))) <= 0) ++nodes;
  }
  return static_cast<double>(nodes) * b.voxel() * b.voxel() * b.voxel();
}

double sumOf(const std::array<double, 256>& volumes) { return std::accumulate(volumes.begin(), volumes.end(), 0.0); }

std::map<std::string, double> byMaterial(const std::array<double, 256>& volumes, const MaterialTable& materials) {
  std::map<std::string, double> out;
  for (std::size_t m = 0; m < 256; ++m) {
    if (volumes[m] == 0) continue;
    const MaterialProperties* row = materials.find(static_cast<Material>(m));
    out[row ? row->id : fmt::format("material {}", m)] += volumes[m];
  }
  return out;
}

std::unique_ptr<VirtualHand> makeHand(const CutPath& path, const HapticCutOptions& o) {
  switch (o.hand) {
    case HandKind::kForce:
      return std::make_unique<ForceHand>(path, o.step.coupling, o.force);
    case HandKind::kDevice:
      return std::make_unique<DeviceHand>(path, o.device);
    default:
      return std::make_unique<FeedHand>(path);
  }
}

}  // namespace

std::string toJson(const HapticSummary& s) {
  nlohmann::json j{{"ticks", s.ticks},
                   {"seconds", s.seconds},
                   {"is_complete", s.is_complete},
                   {"ended", s.ended},
                   {"initial_mm3", s.initial_mm3},
                   {"removed_mm3", s.removed_mm3},
                   {"added_mm3", s.added_mm3},
                   {"remaining_mm3", s.remaining_mm3},
                   {"seconds_in_contact", s.seconds_in_contact},
                   {"mean_contact_force_N", s.mean_contact_force},
                   {"peak_contact_force_N", s.peak_contact_force},
                   {"mean_normal_load_N", s.mean_normal_load},
                   {"peak_hand_force_N", s.peak_hand_force},
                   {"work_mJ", s.work},
                   {"least_speed_of_nominal", s.least_speed},
                   {"ticks_too_fast", s.too_fast},
                   {"ticks_out_of_room", s.out_of_bricks},
                   {"ticks_clamped", s.clamped},
                   {"ticks_clipped", s.clipped},
                   {"hottest_C", s.hottest_c},
                   {"pulp_rise_K", s.pulp_rise},
                   {"bone_limit_at_s", s.bone_limit_s},
                   {"pulp_limit_at_s", s.pulp_limit_s},
                   {"pieces", s.pieces},
                   {"crumbs", s.crumbs},
                   {"state_hash", s.state_hash}};
  for (const auto& [id, volume] : s.removed_by_material) j["removed_by_material_mm3"][id] = volume;
  for (const auto& [id, volume] : s.added_by_material) j["added_by_material_mm3"][id] = volume;
  for (const auto& [id, distance] : s.least_distance_mm) j["least_distance_mm"][id] = distance;
  for (const HapticSummary::Neighbour& n : s.beside) {
    nlohmann::json other{{"id", n.id},
                         {"case_path", n.case_path},
                         {"case_id", n.case_id},
                         {"initial_mm3", n.initial_mm3},
                         {"removed_mm3", n.removed_mm3},
                         {"seconds_touched", n.seconds_touched},
                         {"seconds_in", n.seconds_in},
                         {"overlap_mm3", n.overlap_mm3}};
    for (const auto& [id, volume] : n.removed_by_material) other["removed_by_material_mm3"][id] = volume;
    j["beside"].push_back(std::move(other));
  }
  return j.dump(2);
}

Expected<HapticCut> cutCaseByHand(const fs::path& case_folder, const fs::path& tool_file, const fs::path& path_file,
                                  const fs::path& run_folder, const HapticCutOptions& options,
                                  const Progress& progress) {
  const auto cancelError = [] {
    return fail({Error::Code::kCancelled, "", "", "cancelled; nothing was written", "", ""});
  };
  KERF_CHECK(checkOptions(options));
  KERF_TRY(files, filesOf(case_folder, options.beside, run_folder));
  const CaseManifest& in_case = files.manifests.front();
  KERF_TRY(tool, readTool(tool_file));
  KERF_TRY(path, readPath(path_file));
  KERF_TRY(staging, AtomicFolder::create(run_folder, options.overwrite, kRunManifest));
  if (!report(progress, 0.0, "loading the case")) return cancelError();
  LoadedObjects loaded;
  for (const fs::path& folder : files.folders) {
    KERF_TRY(object, loadObject(folder));
    loaded.push_back(std::move(object));
  }
  const BakedObject& baked = *loaded.front();
  KERF_TRY(materials, readDefaultMaterials());

  StepSettings settings = options.step;
  settings.rendering = options.hand == HandKind::kFeed ? Rendering::kRigid : Rendering::kCoupled;
  KERF_TRY(model, makeModel(std::span(&tool, 1), settings, widestBand(loaded)));
  for (std::size_t n = 0; n < loaded.size(); ++n)
    for (std::size_t m = 0; m < 256; ++m)
      if (loaded[n]->volumes()[m] > 0 && !model.tissues[m].is_in_table)
        return fail({Error::Code::kNotFound, files.folders[n].string(), fmt::format("material {}", m),
                     "not in the table of materials", "a row that says how it cuts; there are " + materials.ids(),
                     "KERF_ASSETS, or bake the case again"});
  if (!report(progress, 0.03, "measuring distances")) return cancelError();
  KERF_TRY(monitor, Monitor::make(loaded, model.tools[0]));
  const double nominal_speed = model.tools[0].drive.speed;
  KERF_TRY(tool_hash, sha256OfFile(tool_file));
  // The header is written first, and it describes the session: one without a log, then one with it.
  SessionHeader header{
      {"kerf_version", kVersion}, {"case_id", in_case.id}, {"tool", tool.id}, {"tool_sha256", tool_hash}};
  for (std::size_t n = 1; n < files.manifests.size(); ++n)
    header.emplace_back(internal::neighbourKey(n), files.manifests[n].id);
  const SessionHeader settings_of = describe(Session(model, {loaded.front()}, poseAt(path, 0)));
  header.insert(header.end(), settings_of.begin(), settings_of.end());
  KERF_TRY(writer, SessionLogWriter::create(staging.staging() / internal::kRunLog, header));
  LogSink sink(writer);
  Session session(std::move(model), loaded, poseAt(path, 0), &sink);
  session.snapshotEvery(kSnapshotTicks);
  const CutObject& object = session.state().objects.front();
  if (!options.add.empty()) {
    const MaterialProperties* row = materials.find(options.add);
    if (!row)
      return fail({Error::Code::kNotFound, "", "--add", "\"" + options.add + "\"", "one of " + materials.ids(),
                   "or add a [[material]] to materials.toml"});
    if (!session.apply(AddMaterial{static_cast<std::uint8_t>(row->material), 0}))
      return fail({Error::Code::kBadValue, "", "--add", "\"" + options.add + "\"", "a material that can be cut",
                   "another id, or contact stiffness and cutting energy in its row of materials.toml"});
  }

  HapticCut out;
  out.left_region_unused = in_case.region.has_value();
  HapticSummary& sum = out.summary;
  std::ofstream csv(staging.staging() / kForces, std::ios::binary);
  csv << "t_s,x_mm,y_mm,z_mm,contact_x_N,contact_y_N,contact_z_N,hand_x_N,hand_y_N,hand_z_N,normal_load_N,overlap_mm,"
         "removed_mm3,added_mm3,speed,drive_load,touching,temperature_C";
  for (const Monitor::Structure& structure : monitor.structures()) csv << "," << structure.id << "_mm";
  for (std::size_t n = 1; n < loaded.size(); ++n) csv << "," << neighbourId(n) << "_removed_mm3";
  csv << "\n";
  const std::unique_ptr<VirtualHand> hand = makeHand(path, options);
  std::optional<internal::WaveFile> sound;
  if (options.with_sound) sound.emplace(staging.staging() / kSound, kSoundRate);
  Vibration vibration(vibrationSource(tool, session.model().tools[0].drive), kSoundRate);
  std::array<float, kSoundRate / 1000> heard;
  StepOutput tick;
  tick.T_world_tool = session.state().body.pose;
  DeviceSample sample;
  double contact_sum = 0, load_sum = 0;
  std::uint64_t in_contact = 0;
  const auto limit = static_cast<std::uint64_t>(options.time_limit / kTick);
  bool has_come_up = false;
  while (true) {
    if (sum.ticks % 64 == 0 && !report(progress, 0.05 + 0.85 * hand->progress(), "cutting")) return cancelError();
    if (sum.ticks >= limit) {
      sum.ended = fmt::format("time limit of {} s", options.time_limit);
      break;
    }
    if (!hand->next(tick, sample)) {
      const auto* force = dynamic_cast<const ForceHand*>(hand.get());
      sum.is_complete = !(force && force->gaveUp());
      sum.ended = sum.is_complete
                      ? "end of the path"
                      : fmt::format("no progress in {} s at {} N", options.force.patience, options.force.force);
      break;
    }
    sample.pedal *= options.spindle;
    session.tick(sample, tick);
    monitor.tick(sample, tick, session.state().objects);
    if (sound) {
      vibration.render({tick.speed, std::min(1.0, tick.cutting_load / kFirmLoad), tick.material}, heard);
      sound->add(heard);
    }
    ++sum.ticks;
    sum.removed_mm3 = sumOf(object.removed_mm3);
    sum.added_mm3 += tick.added_mm3;
    sum.work += tick.power * kTick;
    const double contact = tick.contact.force.norm(), to_hand = tick.force.force.norm();
    if (tick.touching > 0) {
      ++in_contact;
      contact_sum += contact;
      load_sum += tick.normal_load;
    }
    sum.peak_contact_force = std::max(sum.peak_contact_force, contact);
    sum.peak_hand_force = std::max(sum.peak_hand_force, to_hand);
    const double nominal = sample.pedal * nominal_speed;
    const double relative = nominal > 0 ? tick.speed / nominal : 0;
    has_come_up = nominal > 0 && (has_come_up || relative > 0.98);
    if (has_come_up) sum.least_speed = std::min(sum.least_speed, relative);
    sum.too_fast += (tick.status & kStepTooFast) != 0;
    sum.out_of_bricks += (tick.status & (kStepBricksRanOut | kStepNearRanOut)) != 0;
    sum.clamped += (tick.status & kStepForceClamped) != 0;
    sum.clipped += (tick.status & kStepFillClipped) != 0;
    if (tick.status & kStepBadSample)
      return fail({Error::Code::kBadValue, path_file.string(), fmt::format("t = {} s", sum.ticks * kTick),
                   "a pose that is not finite", "finite poses", ""});
    const Vec3d &p = tick.T_world_tool.translation, &f = tick.contact.force, &g = tick.force.force;
    csv << fmt::format(
        "{:.3f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.9f},"
        "{:.9f},{:.3f},{:.6f},{},{:.3f}",
        static_cast<double>(sum.ticks) * kTick, p[0], p[1], p[2], f[0], f[1], f[2], g[0], g[1], g[2], tick.normal_load,
        tick.deepest, sum.removed_mm3, sum.added_mm3, tick.speed, tick.drive_load, tick.touching,
        monitor.temperature());
    for (const Monitor::Structure& structure : monitor.structures()) csv << fmt::format(",{:.4f}", structure.distance);
    for (const Monitor::Structure& structure : monitor.structures())
      if (structure.object > 0) csv << fmt::format(",{:.9f}", structure.removed_mm3);
    csv << "\n";
  }
  session.finish();
  KERF_CHECK(sink.close());
  csv.close();
  if (sound) KERF_CHECK(sound->close());
  std::vector<BrickField> changed_of;  // the case's, then those of its neighbours
  for (std::size_t n = 0; n < loaded.size(); ++n)
    changed_of.push_back(session.state().objects[n].bricks().changedField());
  const BrickField& changed = changed_of.front();
  if (changed.isEmpty()) {
    const Vec3d &low = in_case.box.min, &high = in_case.box.max;
    return fail({Error::Code::kEmpty, path_file.string(), "",
                 fmt::format("tool {} {} nothing{}", tool.id, options.add.empty() ? "cut" : "added",
                             loaded.size() > 1 ? " of the case that is to be cut" : ""),
                 fmt::format("a path through the box ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}) mm", low[0],
                             low[1], low[2], high[0], high[1], high[2]),
                 "check the path's frame and unit, the spindle and the force"});
  }
  sum.seconds = static_cast<double>(sum.ticks) * kTick;
  sum.seconds_in_contact = static_cast<double>(in_contact) * kTick;
  if (in_contact > 0) {
    sum.mean_contact_force = contact_sum / static_cast<double>(in_contact);
    sum.mean_normal_load = load_sum / static_cast<double>(in_contact);
  }
  const std::array<double, 256> left = object.bricks().countVolumes();
  sum.initial_mm3 = sumOf(baked.volumes());
  sum.remaining_mm3 = sumOf(left);
  sum.removed_by_material = byMaterial(object.removed_mm3, materials);
  sum.added_by_material = byMaterial(object.added_mm3, materials);
  sum.state_hash = fmt::format("{:016x}", session.hash());
  sum.hottest_c = monitor.hottest();
  sum.pulp_rise = monitor.mostPulpRise();
  sum.bone_limit_s = monitor.alarms().bone_warm;
  sum.pulp_limit_s = monitor.alarms().pulp;
  for (const Monitor::Structure& structure : monitor.structures())
    if (structure.least < 1e8) sum.least_distance_mm[structure.id] = structure.least;
  for (const Monitor::Structure& structure : monitor.structures()) {
    const std::size_t n = structure.object;
    if (n == 0) continue;
    HapticSummary::Neighbour& other = sum.beside.emplace_back();
    other.id = structure.id;
    other.case_path = files.paths[n];
    other.case_id = files.manifests[n].id;
    other.initial_mm3 = sumOf(loaded[n]->volumes());
    other.removed_mm3 = structure.removed_mm3;
    other.removed_by_material = byMaterial(session.state().objects[n].removed_mm3, materials);
    other.seconds_touched = static_cast<double>(structure.ticks_touched) * kTick;
    other.seconds_in = static_cast<double>(structure.ticks_in) * kTick;
    other.overlap_mm3 = overlapOf(baked, *loaded[n]);
    // Rounding must not make a manifest that its reader refuses.
    out.manifest.beside.push_back(
        {files.paths[n], files.manifests[n].id, loaded[n]->voxel(), std::max(other.removed_mm3, 0.0)});
  }
  PieceFinder finder(baked.phi0());
  std::vector<BrickEdit> edits(changed.brickCount());
  for (std::size_t b = 0; b < edits.size(); ++b) edits[b] = {changed.brickCoord(b), changed.brick(b)};
  finder.apply(edits);
  const PieceList& pieces = finder.find();
  sum.pieces = pieces.pieces.size();
  sum.crumbs = pieces.crumbs.size();

  if (!report(progress, 0.92, "writing")) return cancelError();
  RunManifest& m = out.manifest;
  m.mode = kModeHaptic;
  m.case_path = files.paths.front();
  m.case_id = in_case.id;
  for (std::size_t s = 0; s + 1 < path.poses.size(); ++s)
    if (path.cuts[s]) {
      ++m.segments;
      m.path_length_mm +=
          (path.poses[s + 1].T_object_tool.translation - path.poses[s].T_object_tool.translation).norm();
    }
  m.duration_s = sum.seconds;
  m.voxel_mm = baked.voxel();
  m.state_hash = sum.state_hash;
  std::vector<NamedField> fields{{"phi", &changed}};
  for (std::size_t n = 1; n < changed_of.size(); ++n) fields.push_back({neighbourId(n), &changed_of[n]});
  KERF_CHECK(writeVdb(staging.staging() / internal::kRunField, fields, {{"case_id", m.case_id}}));
  std::ofstream summary(staging.staging() / kSummary, std::ios::binary);
  summary << toJson(sum) << "\n";
  summary.close();
  if (!csv || !summary)
    return fail({Error::Code::kWriteFailed, run_folder.string(), csv ? kSummary : kForces, "could not be written",
                 "a writable place with room", "free some space"});
  KERF_CHECK(internal::finishRun(staging.staging(), tool, tool_file, path_file, m));
  KERF_CHECK(staging.commit());
  report(progress, 1.0, "done");
  return out;
}

}  // namespace kerf
