// The numbers of a session in the header of its log: written by describe(), read by restoreSettings().
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "sim/session/session.h"

namespace kerf {
namespace {

/// Numbers by name, one list for writing and reading, so that both stay complete.
template <class Visit>
void visitNumbers(StepSettings& s, const Visit& visit) {
  CouplingSettings& c = s.coupling;
  visit("coupling.stiffness", c.stiffness);
  visit("coupling.damping", c.damping);
  visit("coupling.turn_stiffness", c.turn_stiffness);
  visit("coupling.turn_damping", c.turn_damping);
  visit("coupling.running_damping", c.running_damping);
  visit("coupling.running_turn_damping", c.running_turn_damping);
  visit("coupling.mass_kg", c.mass_kg);
  visit("coupling.gyration_mm", c.gyration_mm);
  visit("coupling.filter_hz", c.filter_hz);
  visit("coupling.force_limit", c.force_limit);
  visit("coupling.torque_limit", c.torque_limit);
  visit("coupling.force_rate", c.force_rate);
  visit("coupling.torque_rate", c.torque_rate);
  visit("ramp_s", s.ramp_s);

  double rendering = static_cast<double>(s.rendering);
  double geometry = s.geometry_only;
  double substeps = s.most_substeps;
  double response = static_cast<double>(s.response);
  visit("rendering", rendering);
  visit("geometry_only", geometry);
  visit("most_substeps", substeps);
  visit("response", response);
  visit("restitution", s.restitution);

  s.response = static_cast<Response>(static_cast<int>(response));
  s.rendering = static_cast<Rendering>(static_cast<int>(rendering));
  s.geometry_only = geometry != 0;
  s.most_substeps = static_cast<int>(substeps);
}

std::string numbers(std::initializer_list<double> values) {
  std::string out;
  for (const double v : values) out += fmt::format("{}{}", out.empty() ? "" : " ", v);  // shortest that reads back
  return out;
}

// Exactly as many numbers as `out` has, separated by spaces.
bool parseNumbers(std::string_view text, std::span<double> out) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (double& value : out) {
    while (at < end && *at == ' ') ++at;
    const auto [next, failed] = std::from_chars(at, end, value);
    if (failed != std::errc{} || next == at || !(std::abs(value) < 1e9)) return false;
    at = next;
  }
  return at == end;
}

// Reads the numbers of a header, and keeps the first key that is missing or out of range.
class HeaderReader {
 public:
  explicit HeaderReader(const SessionLog& log) : log_(log) {}

  bool has(const std::string& key) const { return !log_.value(key).empty(); }
  bool read(const std::string& key, std::span<double> values) {
    const bool is_good = parseNumbers(log_.value(key), values);
    require(is_good, key);
    return is_good;
  }
  void require(bool holds, const std::string& key) {
    if (!holds && wrong_.empty()) wrong_ = key;
  }
  const std::string& wrong() const { return wrong_; }

 private:
  const SessionLog& log_;
  std::string wrong_;
};

void readSettings(HeaderReader& header, StepSettings& settings) {
  // Defaults for older logs, which lack these.
  settings.response = Response::kPenalty;
  settings.restitution = 0;
  visitNumbers(settings, [&](const std::string& key, double& value) {
    const bool may_be_missing = key == "response" || key == "restitution" || key.starts_with("coupling.running_");
    if (!may_be_missing || header.has(key)) header.read(key, std::span(&value, 1));
  });
  CouplingSettings& coupling = settings.coupling;
  if (!header.has("coupling.running_damping")) coupling.running_damping = coupling.damping;
  if (!header.has("coupling.running_turn_damping")) coupling.running_turn_damping = coupling.turn_damping;
}

void readStart(HeaderReader& header, Rigid3& start) {
  std::array<double, 7> s{};
  if (!header.read("start", s)) return;
  start.translation = Vec3d(s[0], s[1], s[2]);
  start.rotation.w() = s[3];
  start.rotation.x() = s[4];
  start.rotation.y() = s[5];
  start.rotation.z() = s[6];
}

void readTissues(HeaderReader& header, Model& model) {
  std::array<double, 3> rest{};
  header.read("tissue.0", rest);
  for (std::size_t n = 0; n < 256; ++n) {
    std::array<double, 3> t = rest;
    const std::string key = fmt::format("tissue.{}", n);
    const bool is_in_table = n > 0 && header.has(key);
    if (is_in_table) header.read(key, t);
    model.tissues[n] = {static_cast<float>(t[0]), static_cast<float>(t[1]), static_cast<float>(t[2]), is_in_table};
  }
}

void readDrives(HeaderReader& header, Model& model) {
  for (std::size_t n = 0; n < model.tools.size(); ++n) {
    std::array<double, 8> d{};
    if (!header.read(fmt::format("drive.{}", n), d)) continue;
    const bool is_known = d[5] == 0 || d[5] == 1 || d[5] == 2;
    header.require(is_known, fmt::format("drive.{}", n));
    const auto form = is_known ? static_cast<DriveForm>(static_cast<int>(d[5])) : DriveForm::kLine;
    model.tools[n].drive = {d[0], d[1], d[2], d[3], d[4], form, d[6], d[7]};
  }
}

// Numbers from a file need checking.
void requireInRange(HeaderReader& header, const StepSettings& s, const Rigid3& start) {
  header.require(s.most_substeps >= 1 && s.most_substeps <= 1000, "most_substeps");

  header.require(isKnown(s.rendering), "rendering");
  header.require(isKnown(s.response) && rowOf(s.response).fits(s.rendering), "response");
  header.require(s.restitution >= 0 && s.restitution <= 1, "restitution");

  header.require(s.coupling.mass_kg > 0 && s.coupling.gyration_mm > 0, "coupling.mass_kg");
  header.require(s.coupling.stiffness > 0 && s.coupling.turn_stiffness > 0, "coupling.stiffness");
  header.require(start.translation.allFinite() && std::abs(start.rotation.norm() - 1) < 1e-6, "start");
}

}  // namespace

SessionHeader describe(const Session& session) {
  SessionHeader out;
  StepSettings settings = session.model().settings;
  settings.response = settings.effectiveResponse();
  visitNumbers(settings, [&](const char* name, double& value) { out.emplace_back(name, fmt::format("{}", value)); });

  const Rigid3& start = session.state().body.pose;
  const Eigen::Quaterniond& q = start.rotation;
  out.emplace_back(
      "start", numbers({start.translation[0], start.translation[1], start.translation[2], q.w(), q.x(), q.y(), q.z()}));

  for (std::size_t n = 0; n < 256; ++n) {
    const Tissue& t = session.model().tissues[n];
    if (n == 0 || t.is_in_table)
      out.emplace_back(fmt::format("tissue.{}", n),
                       numbers({static_cast<double>(t.stiffness), static_cast<double>(t.friction),
                                static_cast<double>(t.inverse_energy)}));
  }

  for (std::size_t n = 0; n < session.model().tools.size(); ++n) {
    const ToolDrive& d = session.model().tools[n].drive;
    out.emplace_back(fmt::format("drive.{}", n),
                     numbers({d.speed, d.stall_load, d.time_constant, d.energy_factor, d.drag_factor,
                              static_cast<double>(d.form), d.run_down, d.droop}));
  }
  return out;
}

Expected<void> restoreSettings(const SessionLog& log, const std::string& file, Model& model, Rigid3& start) {
  HeaderReader header(log);
  readSettings(header, model.settings);
  readStart(header, start);
  readTissues(header, model);
  readDrives(header, model);
  requireInRange(header, model.settings, start);

  if (header.wrong().empty()) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = file,
               .place = "header, " + header.wrong(),
               .found = fmt::format("\"{}\"", log.value(header.wrong())),
               .expected = "numbers",
               .hint = "the log was written by another version of Kerf"});
}

}  // namespace kerf
