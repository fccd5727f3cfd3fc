#include "sim/run/report/run_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "geometry/tool/tool_file.h"
#include "sim/live/live_heat.h"
#include "sim/monitor/monitor.h"
#include "sim/monitor/structures.h"
#include "sim/run/files/haptic_summary.h"
#include "sim/run/files/run_output.h"
#include "sim/run/report/log_player.h"
#include "sim/step/tool_model.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// ---- From forces.csv

std::vector<std::string_view> fieldsOf(std::string_view line) {
  std::vector<std::string_view> out;
  while (true) {
    const std::size_t comma = line.find(',');
    out.push_back(line.substr(0, comma));
    if (comma == line.npos) return out;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> numberIn(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  constexpr double kMost = 1e9;  // above all values of a run: rows are kept as float, and drawn
  if (error != std::errc() || end != text.data() + text.size() || !(std::abs(value) <= kMost)) return {};
  return value;
}

constexpr double kMostSeconds = 1e6;  // eleven days; a cut takes at most one

// Indices of the columns that the series needs.
struct Columns {
  std::size_t count = 0;
  std::size_t t = 0, speed = 0, load = 0, temperature = 0, removed = 0;
  std::array<std::size_t, 3> contact{}, hand{};
  std::vector<std::size_t> distances;
};

class ForcesFile {
 public:
  explicit ForcesFile(const fs::path& file) : file_(file.string()), in_(file, std::ios::binary) {}

  Expected<RunSeries> read(const Progress& progress) {
    RunSeries out;
    out.source = internal::kRunForces;
    KERF_TRY(columns, readHeader(out));

    std::error_code ignored;
    const double size = static_cast<double>(std::max<std::uintmax_t>(1, fs::file_size(file_, ignored)));
    double done = 0;
    std::string line;
    std::vector<double> row(columns.count);
    while (std::getline(in_, line)) {
      ++line_number_;
      done += static_cast<double>(line.size() + 1);
      if (line_number_ % 4096 == 0 && !report(progress, std::min(1.0, done / size), "reading forces"))
        return cancelled();
      KERF_CHECK(readRow(line, row));
      if (row[columns.t] < 0 || row[columns.t] > kMostSeconds)
        return wrong(fmt::format("t_s {}", row[columns.t]), fmt::format("0 to {:g} s", kMostSeconds));
      add(columns, row, out);
    }
    if (out.size() == 0) return wrong("no row", "one row a tick");
    return out;
  }

 private:
  tl::unexpected<Error> wrong(std::string found, std::string expected) const {
    return fail({.code = Error::Code::kBadFormat,
                 .file = file_,
                 .place = fmt::format("line {}", line_number_),
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = "cut again: runs must not be edited"});
  }

  // Finds a column by its name, or by the first of its names: units were added to some of them.
  Expected<std::size_t> find(const std::vector<std::string_view>& names, std::string_view name) const {
    for (std::size_t n = 0; n < names.size(); ++n)
      if (names[n] == name || (names[n].starts_with(name) && names[n].substr(name.size()).starts_with("_"))) return n;
    return wrong(fmt::format("no column {}", name), "the columns of a run's forces.csv");
  }

  Expected<Columns> readHeader(RunSeries& out) {
    line_number_ = 1;
    if (!std::getline(in_, header_)) return wrong("an empty or unreadable file", "a header line");
    const std::vector<std::string_view> names = fieldsOf(header_);
    Columns c;
    c.count = names.size();
    KERF_TRY(t, find(names, "t_s"));
    KERF_TRY(speed, find(names, "speed"));
    KERF_TRY(load, find(names, "drive_load"));
    KERF_TRY(temperature, find(names, "temperature_C"));
    KERF_TRY(removed, find(names, "removed_mm3"));
    KERF_TRY(vibration, find(names, "vibration_N"));
    KERF_TRY(contact, find(names, "contact_x_N"));
    KERF_TRY(hand, find(names, "hand_x_N"));
    if (std::max(contact, hand) + 3 > c.count) return wrong("too few columns", "forces in x, y and z");
    c.t = t;
    c.speed = speed;
    c.load = load;
    c.temperature = temperature;
    c.removed = removed;
    c.contact = {contact, contact + 1, contact + 2};
    c.hand = {hand, hand + 1, hand + 2};

    // Optional columns at the end: ID_mm of structures, then ID_removed_mm3 of neighbours.
    for (std::size_t n = vibration + 1; n < c.count; ++n) {
      if (!names[n].ends_with("_mm")) continue;
      c.distances.push_back(n);
      out.distances.push_back({std::string(names[n].substr(0, names[n].size() - 3)), {}});
    }
    return c;
  }

  Expected<void> readRow(const std::string& line, std::vector<double>& row) const {
    const std::vector<std::string_view> words = fieldsOf(line);
    if (words.size() != row.size())
      return wrong(fmt::format("{} values", words.size()), fmt::format("{}, as in the header", row.size()));
    for (std::size_t n = 0; n < words.size(); ++n) {
      const auto value = numberIn(words[n]);
      if (!value) return wrong(fmt::format("\"{}\"", words[n]), "a number of at most 1e9");
      row[n] = *value;
    }
    return {};
  }

  static float sizeOf(const std::array<std::size_t, 3>& at, const std::vector<double>& row) {
    return static_cast<float>(Vec3d(row[at[0]], row[at[1]], row[at[2]]).norm());
  }

  static void add(const Columns& c, const std::vector<double>& row, RunSeries& out) {
    out.t_s.push_back(static_cast<float>(row[c.t]));
    out.contact_N.push_back(sizeOf(c.contact, row));
    out.hand_N.push_back(sizeOf(c.hand, row));
    out.speed.push_back(static_cast<float>(row[c.speed]));
    out.drive_load.push_back(static_cast<float>(row[c.load]));
    out.temperature_C.push_back(static_cast<float>(row[c.temperature]));
    out.removed_mm3.push_back(static_cast<float>(row[c.removed]));
    for (std::size_t n = 0; n < c.distances.size(); ++n)
      out.distances[n].mm.push_back(static_cast<float>(row[c.distances[n]]));
  }

  std::string file_, header_;
  std::ifstream in_;
  std::size_t line_number_ = 0;
};

// The file writes the reach in place of distances beyond it.
void markFar(const RunManifest& manifest, RunSeries::Distance& distance) {
  double voxel = manifest.voxel_mm;
  for (std::size_t n = 1; n <= manifest.beside.size(); ++n)
    if (distance.id == neighbourId(n)) voxel = manifest.beside[n - 1].voxel_mm;
  constexpr double kDigits = 1e-4;  // of the file, mm
  const auto reach = static_cast<float>(keepOutReach(voxel).most_distance - kDigits);
  for (float& mm : distance.mm)
    if (mm >= reach) mm = std::numeric_limits<float>::quiet_NaN();
}

// ---- From a log

// Measurements of a replay beside the step: distances of the tool in hand, and its heat.
class SessionMonitor {
 public:
  static Expected<SessionMonitor> make(const internal::Recording& recording, const Model& model) {
    SessionMonitor out(recording, model);
    KERF_TRY(structures, Structures::of(*recording.objects.front()));
    out.structures_ = structures;
    out.heat_->watch(structures);
    for (std::size_t n = 1; n < recording.objects.size(); ++n) {
      const BakedObject& other = *recording.objects[n];
      KERF_TRY(field, KeepOut::ofSolid(other, keepOutReach(other.voxel())));
      out.beside_.push_back(field);
    }
    return out;
  }

  void prepare(RunSeries& series) const {
    for (const Structures::Structure& s : structures_->all()) series.distances.push_back({s.id, {}});
    for (std::size_t n = 0; n < beside_.size(); ++n) series.distances.push_back({neighbourId(n + 1), {}});
  }

  void tick(const Session& session, const DeviceSample& sample, const StepOutput& output, RunSeries& series) {
    const State& state = session.state();
    const ToolSamples& samples = samplesOf(state.tool);
    heat_->tick(state.tool, sample, output, state.objects);
    const double celsius = heat_->report().surface;
    series.temperature_C.push_back(static_cast<float>(celsius));

    StrokePeaks::Distances distances;
    distances.fill(HeatReport::kFarOff);
    const auto& kept = heat_->report().kept_mm;
    std::copy(kept.begin(), kept.end(), distances.begin());
    const std::size_t structures = structures_->all().size();
    for (std::size_t n = 0; n < beside_.size(); ++n) {
      const Rigid3& T_world_object = state.objects[n + 1].T_world_object;
      const auto reading = beside_[n]->read(samples, T_world_object.inverse() * output.T_world_tool);
      const double mm = reading.is_far ? HeatReport::kFarOff : reading.distance;
      if (structures + n < distances.size()) distances[structures + n] = mm;
      series.distances[structures + n].mm.push_back(static_cast<float>(mm));
    }
    for (std::size_t n = 0; n < structures; ++n) series.distances[n].mm.push_back(static_cast<float>(kept[n]));
    peaks_.tick(sample, output, session.undoList(), state.tick - 1, celsius, distances);
  }

  // After the last command.
  SessionPeaks peaks(const Session& session, const RunSeries& series) {
    peaks_.follow(session.undoList());
    SessionPeaks out{peaks_.standing(), peaks_.takenBack(), {}, heat_->report().alarms};
    for (const RunSeries::Distance& distance : series.distances) out.kept.push_back(distance.id);
    out.kept.resize(std::min(out.kept.size(), CutPeaks::kMostKept));
    return out;
  }

 private:
  SessionMonitor(const internal::Recording& recording, const Model& model)
      : recording_(recording),
        model_(model),
        samples_(model.tools.size()),
        heat_(std::make_unique<LiveHeat>(model.tools)) {}

  // Made when a tool is first in hand: tens of ms each, and a rack has many tools.
  const ToolSamples& samplesOf(std::size_t tool) {
    ToolSamples& samples = samples_[tool];
    if (!samples.isEmpty()) return samples;
    samples = ToolSamples(model_.tools[tool].cut, kToolSamples);
    heat_->add(tool, samples, heatSource(recording_.tools[tool]));
    return samples;
  }

  const internal::Recording& recording_;
  const Model& model_;
  std::vector<ToolSamples> samples_;
  std::unique_ptr<LiveHeat> heat_;
  std::shared_ptr<const Structures> structures_;
  std::vector<std::shared_ptr<const KeepOut>> beside_;
  StrokePeaks peaks_;
};

// Volume removed from the case since the run began, all its pieces together.
double removedOffCase(const Session& session) {
  double out = 0;
  for (const CutObject& object : session.state().objects)
    if (session.loadedIndexOf(object) == 0)
      out += internal::sumOf(object.removed_before_mm3) + internal::sumOf(object.removed_mm3);
  return out;
}

Expected<RunSeries> replaySeries(const fs::path& run_folder, const RunManifest& manifest, const Progress& progress) {
  KERF_TRY(recording, internal::loadRecording(run_folder, manifest, progress));
  const std::string file = recording.log_file.string();
  Rigid3 place;
  KERF_CHECK(restoreSettings(recording.log, file, recording.model, place));
  if (!report(progress, 0, "measuring distances")) return cancelled();
  KERF_TRY(monitor, SessionMonitor::make(recording, recording.model));

  RunSeries out;
  out.source = std::string(internal::kRunLog) + ", replayed";
  out.strokes = strokesOf(recording.log);
  monitor.prepare(out);

  internal::LogPlayer player(recording.log, file, recording.model, place, recording.objects, {});
  const std::size_t count = recording.log.samples.size();
  StepOutput tick;
  out.has_spinning_tool = false;
  while (!player.isAtEnd()) {
    const std::size_t n = player.nextSample();
    if (n % 64 == 0 && !report(progress, static_cast<double>(n) / static_cast<double>(count), "replaying"))
      return cancelled();
    KERF_CHECK(player.tick(tick));
    const State& state = player.session().state();
    const bool strokes = motionOf(recording.tools[state.tool]) == ToolMotion::kStroke;
    (strokes ? out.has_reciprocating_tool : out.has_spinning_tool) = true;

    out.t_s.push_back(static_cast<float>(static_cast<double>(recording.log.samples[n].tick + 1) * kTick));
    out.contact_N.push_back(static_cast<float>(tick.contact.force.norm()));
    out.hand_N.push_back(static_cast<float>(tick.force.force.norm()));
    out.speed.push_back(static_cast<float>(tick.speed));
    out.drive_load.push_back(static_cast<float>(tick.drive_load));
    out.removed_mm3.push_back(static_cast<float>(removedOffCase(player.session())));
    monitor.tick(player.session(), recording.log.samples[n].sample, tick, out);
  }

  KERF_CHECK(player.handleEvents());
  out.peaks = monitor.peaks(player.session(), out);
  Replay found = player.found();
  internal::compareEnd(recording.log, manifest, std::numeric_limits<double>::infinity(), found);
  if (found.is_same) return out;
  return fail({.code = Error::Code::kBadValue,
               .file = file,
               .place = fmt::format("tick {}", found.differs_at),
               .found = "a replay that differs from the recording",
               .expected = "the same bits",
               .hint = "kerf replay " + run_folder.string()});
}

}  // namespace

std::vector<StrokeSpan> strokesOf(const SessionLog& log) {
  std::vector<StrokeSpan> out;
  const auto timeOf = [&log](std::size_t sample) {
    if (log.samples.empty()) return 0.0;
    const std::size_t n = std::min(sample, log.samples.size() - 1);
    return static_cast<double>(log.samples[n].tick) * kTick;
  };
  bool is_open = false;
  for (const SessionEvent& event : log.events) {
    const auto* mark = std::get_if<StrokeMark>(&event.what);
    if (!mark) continue;
    if (*mark == StrokeMark::kBegin) {
      out.push_back({timeOf(event.samples_before), timeOf(log.samples.size())});
      is_open = true;
    } else if (is_open) {
      out.back().to_s = timeOf(event.samples_before);
      is_open = false;
    }
  }
  return out;
}

Expected<RunSeries> readRunSeries(const fs::path& run_folder, const Progress& progress) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_CHECK(requireEnded(run_folder, manifest));
  if (manifest.mode == kModeGeometry)
    return fail({.code = Error::Code::kUnsupported,
                 .file = run_folder.string(),
                 .place = "mode " + manifest.mode,
                 .found = "a geometry run: it has neither time nor force",
                 .expected = "a run cut against resistance, or a session of the window",
                 .hint = "kerf cut CASE --hand force ..."});

  const fs::path table = run_folder / internal::kRunForces;
  std::error_code ignored;
  if (!fs::is_regular_file(table, ignored)) return replaySeries(run_folder, manifest, progress);

  KERF_TRY(series, ForcesFile(table).read(progress));
  for (RunSeries::Distance& distance : series.distances) markFar(manifest, distance);
  KERF_TRY(log, readSessionLog(run_folder / internal::kRunLog));
  series.strokes = strokesOf(log);
  KERF_TRY(tool, readTool(run_folder / internal::kRunToolCopy));
  series.has_reciprocating_tool = motionOf(tool) == ToolMotion::kStroke;
  series.has_spinning_tool = !series.has_reciprocating_tool;
  return series;
}

}  // namespace kerf
