#include <fmt/format.h>

#include "geometry/tool/handpiece.h"
#include "geometry/tool/tool_kinds.h"

namespace kerf {
namespace {

void explainDriveWords(TomlTable& t, const DriveKeys& keys) {
  const std::string speed = keys.speed, stall = keys.stall;
  for (const char* word : {"speed", "rpm", "speed_rpm", "cycles_per_min", "frequency_khz", "spindle_speed", "cpm",
                           "spm", "strokes_per_min", "speed_krpm"})
    if (word != speed)
      t.explain(word, fmt::format("{}, in {}{}", speed, keys.unit,
                                  speed == "cycles_per_min" ? "; a cycle is one stroke there and one back" : ""));
  for (const char* word : {"frequency", "frequency_hz"})
    t.explain(word, fmt::format("{} = {:g} times the frequency in Hz", speed, 1 / keys.per_second));
  for (const char* word :
       {"stall", "stall_load", "stall_torque", "stall_force", "torque", "stall_torque_Nmm", "stall_force_N"})
    if (word != stall) t.explain(word, fmt::format("{}, in {}", stall, keys.stall_unit));
  if (stall == kTurns.stall) t.explain("stall_torque_Ncm", "stall_torque_Nmm, 10 times as many");
  for (const char* word : {"time_constant", "time_constant_ms", "inertia"})
    t.explain(word, "time_constant_s, in seconds");
  for (const char* word : {"stroke_mm", "swing_deg", "stroke", "swing"})
    t.explain(word, "stroke or swing of the tool itself, above [drive]: its shape is made of it");
}

void readHandpiece(TomlTable& t, Tool& tool) {
  const bool turns = !tool.motion || tool.motion->form == ToolMotion::kSpin;
  if (!turns) {
    t.explain("handpiece", "none: a saw's motion says what drives it; speed and stall may be given");
    return;
  }
  t.allow("handpiece");
  if (!t.has("handpiece")) return;

  const auto name = t.get<std::string>("handpiece", ("one of " + handpieceNames()).c_str());
  tool.drive.handpiece = findHandpiece(name);
  if (!tool.drive.handpiece && !t.failed())
    t.reject("handpiece", fmt::format("\"{}\"", name), fmt::format("one of {}", handpieceNames()));
}

}  // namespace

Expected<void> readDrive(const TomlTable& top, const std::filesystem::path& file, Tool& tool) {
  const toml::node* node = top.node("drive");
  if (!node) return {};
  const DriveKeys& keys = tool.motion ? tool.motion->drive_keys : kTurns;
  if (!node->is_table())
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .place = fmt::format("line {}, key drive", node->source().begin.line),
                 .found = "a value of another type",
                 .expected = "a table of numbers",
                 .hint = fmt::format("[drive] on a line of its own, and below it {} = ...", keys.speed)});

  TomlTable t(*node->as_table(), file, "drive");
  explainDriveWords(t, keys);
  const auto optional = [&](const char* key, double low, double high, const char* unit) -> std::optional<double> {
    t.allow(key);
    if (!t.has(key)) return std::nullopt;
    return t.number(key, low, high, unit);
  };

  readHandpiece(t, tool);
  if (const auto speed = optional(keys.speed, keys.low, keys.high, keys.unit))
    tool.drive.frequency_hz = *speed * keys.per_second;
  tool.drive.stall_load = optional(keys.stall, 0.1, 1e5, keys.stall_unit);
  tool.drive.time_constant_s = optional("time_constant_s", 0.001, 10, "s");
  tool.drive.energy_factor = optional("energy_factor", 0.01, 100, "(1: as in the table of materials)");
  tool.drive.drag_factor = optional("drag_factor", 0.01, 100, "(1: as in the table of materials)");
  return t.finish();
}

}  // namespace kerf
