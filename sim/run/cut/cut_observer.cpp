#include "sim/run/cut/cut_observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>

#include "geometry/base/hash.h"
#include "geometry/base/version.h"
#include "sim/monitor/felt_vibration.h"
#include "sim/monitor/monitor.h"
#include "sim/monitor/vibration.h"
#include "sim/monitor/wave_file.h"
#include "sim/run/files/log_sink.h"
#include "sim/run/files/run_output.h"
#include "sim/run/sweep/tip_exit.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;
constexpr const char* kSound = "sound.wav";
constexpr std::uint32_t kSoundRate = 48'000;

// ---- Session log: session.kerflog

class SessionLogFile final : public CutObserver {
 public:
  explicit SessionLogFile(SessionLogWriter writer) : writer_(std::move(writer)), sink_(writer_) {}
  SessionSink& sink() { return sink_; }
  void tick(const CutTick&) override {}  // the session writes to the sink itself
  Expected<void> close() override { return sink_.close(); }

 private:
  SessionLogWriter writer_;
  LogSink sink_;
};

Expected<SessionLogWriter> startLog(const CutScene& scene, const fs::path& staging) {
  const CutInputs& in = scene.inputs;
  KERF_TRY(tool_hash, sha256OfFile(in.tool_file));
  SessionHeader header{{"kerf_version", kVersion},
                       {"case_id", in.manifests.front().id},
                       {"tool", in.tool.id},
                       {"tool_sha256", tool_hash}};
  for (std::size_t n = 1; n < in.manifests.size(); ++n) header.emplace_back(neighbourKey(n), in.manifests[n].id);
  // The header describes the session and is written before it: a session without a log provides it.
  const SessionHeader settings = describe(Session(scene.model, {scene.objects.front()}, scene.start()));
  header.insert(header.end(), settings.begin(), settings.end());
  return SessionLogWriter::create(staging / kRunLog, header);
}

// ---- Temperature, distances and neighbours

// Common volume of two objects, mm^3: nodes of one that lie in the other.
double overlapOf(const BakedObject& a, const BakedObject& b) {
  const double scale = b.voxel() / a.voxel();
  std::size_t nodes = 0;
  for (const BakedObject::Slot& slot : b.slots()) {
    const Vec3i base = kBrickSide * slot.brick;
    const auto inOfA = [&](const Vec3i& node) -> Vec3i {
      return (scale * node.cast<double>()).array().round().matrix().cast<int>();
    };
    const Vec3i low = brickOf(inOfA(base)) - a.directoryLow();
    const Vec3i high = brickOf(inOfA(base + Vec3i::Constant(kBrickSide - 1))) - a.directoryLow();
    if ((high.array() < 0).any() || (low.array() >= a.directorySize().array()).any()) continue;

    for (int n = 0; n < kBrickNodes; ++n)
      if (slot.phi[n] <= 0 && a.phi0().at(inOfA(base + Vec3i(n >> 6, n >> 3 & 7, n & 7))) <= 0) ++nodes;
  }
  return static_cast<double>(nodes) * b.voxel() * b.voxel() * b.voxel();
}

class MonitorObserver final : public CutObserver {
 public:
  MonitorObserver(const CutScene& scene, Monitor monitor)
      : scene_(scene),
        monitor_(std::move(monitor)),
        hottest_(monitor_.hottest()),
        least_(monitor_.structures().size()) {}
  const Monitor& monitor() const { return monitor_; }
  void tick(const CutTick& tick) override {
    monitor_.tick(tick.sample, tick.output, tick.objects);

    const double now = static_cast<double>(tick.ticks) * kTick;
    if (monitor_.hottest() > hottest_) {
      hottest_ = monitor_.hottest();
      hottest_s_ = now;
    }
    for (std::size_t n = 0; n < monitor_.structures().size(); ++n) {
      const double least = monitor_.structures()[n].least;
      if (!(least < least_[n].value)) continue;
      least_[n] = {least, now};
    }
  }

  void addTo(HapticSummary& summary, std::span<const CutObject> objects) const override {
    summary.hottest_c = monitor_.hottest();
    summary.pulp_rise = monitor_.mostPulpRise();
    summary.nerve_rise = monitor_.mostNerveRise();
    summary.bone_limit_s = monitor_.alarms().bone_warm;
    summary.pulp_limit_s = monitor_.alarms().pulp;
    summary.hottest_s = hottest_s_;
    for (std::size_t n = 0; n < least_.size(); ++n) {
      const Monitor::Structure& structure = monitor_.structures()[n];
      if (structure.least < kNever) {
        summary.least_distance_mm[structure.id] = structure.least;
        summary.least_distance_s[structure.id] = least_[n].at_s;
      }
      if (structure.object > 0) summary.beside.push_back(neighbour(structure, objects[structure.object]));
    }
  }

 private:
  HapticSummary::Neighbour neighbour(const Monitor::Structure& structure, const CutObject& object) const {
    const BakedObject& baked = *scene_.objects[structure.object];
    HapticSummary::Neighbour out;
    out.id = structure.id;
    out.case_path = scene_.inputs.paths[structure.object];
    out.case_id = scene_.inputs.manifests[structure.object].id;
    out.initial_mm3 = sumOf(baked.volumes());
    out.removed_mm3 = structure.removed_mm3;
    out.removed_by_material = byMaterial(object.removed_mm3, scene_.materials);
    out.seconds_touched = static_cast<double>(structure.ticks_touched) * kTick;
    out.seconds_in = static_cast<double>(structure.ticks_in) * kTick;
    out.overlap_mm3 = overlapOf(scene_.object(), baked);
    return out;
  }

  static constexpr double kNever = 1e8;  // mm; Monitor::Structure::least begins above
  struct Least {
    double value = kNever, at_s = 0;
  };

  const CutScene& scene_;
  Monitor monitor_;
  double hottest_, hottest_s_ = 0;
  std::vector<Least> least_;  // of the monitor's structures
};

// ---- Forces, loads and speeds of the summary

class LoadStatistics final : public CutObserver {
 public:
  /// @param nominal_speed  of the tool's drive.
  explicit LoadStatistics(double nominal_speed) : nominal_speed_(nominal_speed) {}

  void tick(const CutTick& tick) override {
    const StepOutput& out = tick.output;
    sum_.work += out.power * kTick;

    const double contact = out.contact.force.norm();
    if (out.touching > 0) {
      ++ticks_in_contact_;
      contact_sum_ += contact;
      load_sum_ += out.normal_load;
    }
    if (contact > sum_.peak_contact_force) {
      sum_.peak_contact_force = contact;
      sum_.peak_contact_force_s = static_cast<double>(tick.ticks) * kTick;
    }
    sum_.peak_hand_force = std::max(sum_.peak_hand_force, out.force.force.norm());

    const double nominal = std::abs(tick.sample.pedal) * nominal_speed_;
    const double relative = nominal > 0 ? std::abs(out.speed) / nominal : 0;
    // A turbine may meet the tissue while still coming up; from then on its speed falls.
    has_come_up_ = nominal > 0 && (has_come_up_ || relative > 0.98 || relative < last_relative_);
    last_relative_ = relative;
    if (has_come_up_) sum_.least_speed = std::min(sum_.least_speed, relative);
    if (has_come_up_ && relative < kStalled) ++ticks_stalled_;

    sum_.too_fast += (out.status & kStepTooFast) != 0;
    sum_.out_of_bricks += (out.status & (kStepBricksRanOut | kStepNearRanOut)) != 0;
    sum_.clamped += (out.status & kStepForceClamped) != 0;
    sum_.clipped += (out.status & kStepFillClipped) != 0;
  }

  void addTo(HapticSummary& summary, std::span<const CutObject>) const override {
    summary.work = sum_.work;
    summary.peak_contact_force = sum_.peak_contact_force;
    summary.peak_contact_force_s = sum_.peak_contact_force_s;
    summary.peak_hand_force = sum_.peak_hand_force;
    summary.least_speed = sum_.least_speed;
    summary.stalled_s = static_cast<double>(ticks_stalled_) * kTick;
    summary.too_fast = sum_.too_fast;
    summary.out_of_bricks = sum_.out_of_bricks;
    summary.clamped = sum_.clamped;
    summary.clipped = sum_.clipped;

    summary.seconds_in_contact = static_cast<double>(ticks_in_contact_) * kTick;
    if (ticks_in_contact_ == 0) return;
    summary.mean_contact_force = contact_sum_ / static_cast<double>(ticks_in_contact_);
    summary.mean_normal_load = load_sum_ / static_cast<double>(ticks_in_contact_);
  }

 private:
  static constexpr double kStalled = 0.02;  // of the nominal speed
  std::uint64_t ticks_stalled_ = 0;
  double last_relative_ = 0;  // speed over the nominal, a tick ago
  double nominal_speed_;
  HapticSummary sum_;  // only the fields of this class
  double contact_sum_ = 0, load_sum_ = 0;
  std::uint64_t ticks_in_contact_ = 0;
  bool has_come_up_ = false;
};

// ---- Distance of the tool from its path

class PathDeviation final : public CutObserver {
 public:
  explicit PathDeviation(const CutPath& path) : path_(path) {}

  void tick(const CutTick& tick) override {
    // Usually the nearest stretch is near the last one. Searches all of the path only if the tool is off the path
    // there, or the path comes back to it.
    const Vec3d& tip = tick.output.T_world_tool.translation;
    const std::size_t last = path_.cuts.size() - 1;
    double nearest = nearestOf(stretch_ > kAround ? stretch_ - kAround : 0, std::min(stretch_ + kAround, last), tip);
    if (nearest > kOnPath) nearest = nearestOf(0, last, tip);
    if (nearest <= farthest_) return;
    farthest_ = nearest;
    at_ = tip;
  }

  void addTo(HapticSummary& summary, std::span<const CutObject>) const override {
    summary.farthest_off_mm = farthest_;
    summary.farthest_off_at = at_;
  }

 private:
  double distanceTo(std::size_t stretch, const Vec3d& p) const {
    const Vec3d& from = path_.poses[stretch].T_object_tool.translation;
    const Vec3d way = path_.poses[stretch + 1].T_object_tool.translation - from;
    const double length = way.squaredNorm();
    const double share = length > 0 ? std::clamp(way.dot(p - from) / length, 0.0, 1.0) : 0;
    return (from + share * way - p).norm();
  }

  double nearestOf(std::size_t first, std::size_t last, const Vec3d& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t n = first; n <= last; ++n)
      if (const double distance = distanceTo(n, p); distance < nearest) {
        nearest = distance;
        stretch_ = n;
      }
    return nearest;
  }

  static constexpr std::size_t kAround = 8;  // stretches
  static constexpr double kOnPath = 0.005;   // mm
  const CutPath& path_;
  std::size_t stretch_ = 0;
  double farthest_ = 0;
  Vec3d at_ = Vec3d::Zero();
};

// ---- Idle strokes, and a tip that comes out behind

class StrokeWatch final : public CutObserver {
 public:
  /// @param is_adding  the tool adds material: a stroke that added nothing is idle, and exits do not count.
  StrokeWatch(const BrickField& loaded, bool is_adding) : exit_(loaded), is_adding_(is_adding) {}

  void tick(const CutTick& tick) override {
    const bool is_cutting = tick.sample.pedal != 0;
    if (is_cutting && !is_cutting_) {
      ++begun_;
      changed_before_ = changed_;
    }
    changed_ = tick.added_mm3;
    for (const CutObject& object : tick.objects) changed_ += sumOf(object.removed_mm3);
    if (is_cutting_ && !is_cutting) endStroke();
    is_cutting_ = is_cutting;
    if (!is_adding_) exit_.moveTo(tick.output.T_world_tool);
  }

  // Does not judge a stroke in which the cut ended before its path.
  void addTo(HapticSummary& summary, std::span<const CutObject>) const override {
    PathFindings& out = summary.findings;
    out.strokes = begun_;
    out.idle = idle_;
    if (summary.is_complete && is_cutting_ && changedNothing()) out.idle.push_back(begun_);
    out.comes_out_at = exit_.place();
  }

 private:
  static constexpr double kLeast = 1e-6;  // mm^3
  bool changedNothing() const { return changed_ - changed_before_ < kLeast; }
  void endStroke() {
    if (changedNothing()) idle_.push_back(begun_);
  }

  TipExit exit_;
  std::size_t begun_ = 0;
  std::vector<std::size_t> idle_;
  double changed_ = 0, changed_before_ = 0;  // mm^3
  bool is_adding_ = false, is_cutting_ = false;
};

// ---- One row a tick: forces.csv

class ForcesTable final : public CutObserver {
 public:
  /// @param monitor  receives each tick before this; kept by reference.
  /// @param felt  how the hand feels the tool.   @param motion  of the tool: determines the units of speed and load.
  ForcesTable(const fs::path& staging, fs::path run_folder, const Monitor& monitor, const FeltSource& felt,
              std::size_t objects, ToolMotion motion)
      : out_(staging / kRunForces, std::ios::binary),
        run_folder_(std::move(run_folder)),
        monitor_(monitor),
        vibration_(felt, 1 / kTick) {
    out_ << "t_s,x_mm,y_mm,z_mm,contact_x_N,contact_y_N,contact_z_N,hand_x_N,hand_y_N,hand_z_N,normal_load_N,"
            "overlap_mm,removed_mm3,added_mm3,"
         << (motion == ToolMotion::kStroke ? "speed_mm_per_s,drive_load_N" : "speed_rad_per_s,drive_load_Nmm")
         << ",touching_nodes,temperature_C,vibration_N";
    for (const Monitor::Structure& structure : monitor_.structures()) out_ << "," << structure.id << "_mm";
    for (std::size_t n = 1; n < objects; ++n) out_ << "," << neighbourId(n) << "_removed_mm3";
    out_ << "\n";
  }

  void tick(const CutTick& tick) override {
    const StepOutput& out = tick.output;
    const Vec3d &p = out.T_world_tool.translation, &f = out.contact.force, &g = out.force.force;
    out_ << fmt::format(
        "{:.3f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.9f},"
        "{:.9f},{:.3f},{:.6f},{},{:.3f},{:.6f}",
        static_cast<double>(tick.ticks) * kTick, p[0], p[1], p[2], f[0], f[1], f[2], g[0], g[1], g[2], out.normal_load,
        out.deepest, tick.removed_mm3, tick.added_mm3, out.speed, out.drive_load, out.touching, monitor_.temperature(),
        vibration_.next({out.speed, out.normal_load, out.material}));
    for (const Monitor::Structure& structure : monitor_.structures())
      out_ << fmt::format(",{:.4f}", structure.distance);
    for (const Monitor::Structure& structure : monitor_.structures())
      if (structure.object > 0) out_ << fmt::format(",{:.9f}", structure.removed_mm3);
    out_ << "\n";
  }

  Expected<void> close() override {
    out_.close();
    if (out_) return {};
    return fail({.code = Error::Code::kWriteFailed,
                 .file = run_folder_.string(),
                 .place = kRunForces,
                 .found = "could not be written",
                 .expected = "a writable place with room",
                 .hint = "free some space"});
  }

 private:
  std::ofstream out_;
  fs::path run_folder_;
  const Monitor& monitor_;
  FeltVibration vibration_;
};

// ---- The sound of the tool: sound.wav

class SoundFile final : public CutObserver {
 public:
  SoundFile(const fs::path& staging, const VibrationSource& source)
      : file_(staging / kSound, kSoundRate), vibration_(source, kSoundRate) {}

  void tick(const CutTick& tick) override {
    const StepOutput& out = tick.output;
    vibration_.render({out.speed, std::min(1.0, out.cutting_load / kFirmLoad), out.material}, samples_);
    file_.add(samples_);
  }
  Expected<void> close() override { return file_.close(); }

 private:
  WaveFile file_;
  Vibration vibration_;
  std::array<float, kSoundRate / 1000> samples_;  // of one tick
};

}  // namespace

// To add an observer: its class above, one line here.
Expected<CutObservers> CutObservers::make(const CutScene& scene, const HapticCutOptions& options,
                                          const fs::path& staging, const fs::path& run_folder) {
  const ToolModel& tool = scene.model.tools.front();
  KERF_TRY(monitor, Monitor::make(scene.objects, tool, heatSource(scene.inputs.tool)));
  KERF_TRY(log, startLog(scene, staging));

  CutObservers out;
  out.log_ = &out.add<SessionLogFile>(std::move(log)).sink();
  const MonitorObserver& watch = out.add<MonitorObserver>(scene, std::move(monitor));
  out.add<LoadStatistics>(tool.drive.speed);
  out.add<PathDeviation>(scene.inputs.path);
  out.add<StrokeWatch>(scene.object().phi0(), !options.add.empty());
  out.add<ForcesTable>(staging, run_folder, watch.monitor(), feltSource(scene.inputs.tool, tool.drive),
                       scene.objects.size(), motionOf(scene.inputs.tool));
  if (options.with_sound) out.add<SoundFile>(staging, vibrationSource(scene.inputs.tool, tool.drive));
  return out;
}

Expected<void> CutObservers::close() {
  Expected<void> first;
  for (const auto& observer : all_) {
    auto closed = observer->close();
    if (first && !closed) first = std::move(closed);
  }
  return first;
}

}  // namespace kerf::internal
