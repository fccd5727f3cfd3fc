#include "ui/app/workbench/tool_monitor.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "sim/run/session/watched_run.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

constexpr double kStopped = 0.03;  // mm: the closest approach of a held button to its limit

}  // namespace

void ToolMonitor::opened(Opening /*how*/) {
  loop_rate_.clear();
  loop_ = {};
  loop_read_ = {};
  trace_.clear();
  hindrance_ = {};
  has_told_of_pulp_ = has_told_of_bone_ = has_told_of_dead_bone_ = false;
}

void ToolMonitor::update() {
  const Document& document = *bench_.document;
  if (document.hasNews()) {
    addToTrace();
    if (document.isOpen()) {
      const bool cuts_by_hand = bench_.device->isLed() && std::abs(document.report().output.speed) > 0;
      const bool is_cutting = bench_.strokes->isPressed() || bench_.saw->isCutting() || cuts_by_hand;
      hindrance_.update(document.report(), is_cutting, driveShare());
    }
    warnOfHeat();
  }
  if (document.isOpen()) readLoop();
}

std::string ToolMonitor::hindranceShown() const {
  constexpr double kTouches = 0.2;  // mm
  const char* const text = hindrance_.text();
  if (!text[0]) return {};
  if (const auto near = nearNeighbour({}); near && !near->is_far && near->distance_mm < kTouches)
    return phrase(
        "{}, a neighbour, is in the way of the tool. Take it away with Piece > Remove neighbour, or cut from "
        "another side.",
        near->name);
  return shownText(text);
}

void ToolMonitor::readLoop() {
  const Document& document = *bench_.document;
  const auto now = LoopRate::Clock::now();
  const HapticCounts& counts = document.report().counts;
  loop_rate_.add(counts.ticks, now);
  if (now - loop_read_ < std::chrono::seconds(1)) return;
  loop_read_ = now;
  const TimeHistogram& cost = document.times().cost;
  loop_ = {loop_rate_.hz(), {}, counts.overruns, counts.ticks};
  if (cost.count() > 0) loop_.p99_ms = cost.percentileMs(0.99);
}

void ToolMonitor::addToTrace() {
  const HapticReport& report = bench_.document->report();
  trace_.add({.tick = report.tick,
              .force = report.output.force.force.norm(),
              .torque = report.output.force.torque.norm(),
              .load = 100 * driveLoadShare(),
              .spindle = 100 * driveShare(),
              .depth = bench_.strokes->depthNow().value_or(0),
              .penetration = 1000 * report.output.deepest,
              .temperature = report.heat.surface,
              .removed_mm3 = bench_.document->removedMm3(),
              .jumps = report.counts.pauses});
}

// Warns once each: a notice does not interrupt.
void ToolMonitor::warnOfHeat() {
  const HeatAlarms& alarms = bench_.document->report().heat.alarms;
  if (alarms.pulp >= 0 && !std::exchange(has_told_of_pulp_, true))
    bench_.notices->say(
        phrase("The pulp is {:.1f} °C above body temperature and may not recover (Zach & Cohen 1965). Increase "
               "irrigation, push less, or pause.",
               kPulpLimitRise));
  if (alarms.bone_warm >= 0 && !std::exchange(has_told_of_bone_, true))
    bench_.notices->say(
        phrase("The bone under the tool is at {:.0f} °C: after 1 min it dies (Eriksson & Albrektsson). Increase "
               "irrigation, push less, or pause.",
               kBodyCelsius + kBoneLimitRise));
  if (alarms.bone_dead >= 0 && !std::exchange(has_told_of_dead_bone_, true))
    bench_.notices->say(
        phrase("Bone 0.5 mm from the cut stayed at {:.0f} °C or more for {:.0f} s in total: necrosis threshold.",
               kBodyCelsius + kBoneLimitRise, kBoneLimitSeconds));
}

double ToolMonitor::driveShare() const {
  const Document& document = *bench_.document;
  if (!document.isShown()) return 0;
  const Model& model = document.run() ? document.run()->model() : document.watched()->model();
  const double free_speed = model.tools[bench_.tools->inHand()].drive.speed;
  return free_speed > 0 ? document.report().output.speed / free_speed : 0;
}

double ToolMonitor::driveLoadShare() const {
  const LiveRun* const run = bench_.document->run();
  if (!run) return 0;
  const double stall_load = run->model().tools[bench_.tools->inHand()].drive.stall_load;
  return stall_load > 0 ? bench_.document->report().output.drive_load / stall_load : 0;
}

// ---- Depth and distances

std::optional<ToolFront> ToolMonitor::toolFront() const {
  const Document& document = *bench_.document;
  const bool is_pressed = bench_.strokes->isPressed();
  if (!document.isOpen() || (!is_pressed && !bench_.device->isLed() && !bench_.saw->isCutting())) return {};
  const HapticReport& report = document.report();
  const Rigid3 T_object_world =
      (is_pressed ? bench_.strokes->surfacePose() : report.objects[0].T_world_object).inverse();
  const Rigid3 tool = T_object_world * report.output.T_world_tool;
  const Plunge& plunge = bench_.tools->plunge();
  ToolFront out{tool * Vec3d(plunge.reach * plunge.direction), tool.rotation * plunge.direction};
  const auto depth = depthBelow(*document.run()->original(), out.point, -out.into);
  if (!depth) return {};
  out.depth = *depth;
  return out;
}

std::optional<double> ToolMonitor::tipDepth() const {
  const auto front = toolFront();
  return front ? std::optional(front->depth) : std::nullopt;
}

std::optional<NearStructure> ToolMonitor::nearStructure(const std::optional<ToolOverSurface>& over) const {
  const Document& document = *bench_.document;
  const bool is_pressed = bench_.strokes->isPressed(), is_led = bench_.device->isLed();
  if (!document.isOpen() || document.structures()->isEmpty() || (!is_pressed && !over && !is_led)) return {};
  const HapticReport& report = document.report();
  const Rigid3 tool = is_pressed || is_led ? report.output.T_world_tool : over->T_world_tool;
  const Rigid3 object = is_pressed ? bench_.strokes->surfacePose()
                        : is_led   ? report.objects[0].T_world_object
                                   : over->T_world_object;
  const Structures& structures = *document.structures();
  const Structures::Nearest nearest = structures.nearest(bench_.tools->samples(), object.inverse() * tool);

  NearStructure out;
  out.name = document.nameOf(structures.all()[nearest.structure].material);
  out.distance_mm = nearest.reading.distance;
  out.is_far = nearest.reading.is_far;
  const auto limit = bench_.strokes->stop_short_mm;
  out.is_stopped = is_pressed && limit && !out.is_far && out.distance_mm <= *limit + kStopped;
  return out;
}

std::optional<NearNeighbour> ToolMonitor::nearNeighbour(const std::optional<ToolOverSurface>& over) const {
  const Document& document = *bench_.document;
  const NeighbourFields& fields = document.neighbourFields();
  const bool is_at_work = bench_.strokes->isPressed() || bench_.saw->isCutting();
  if (!document.isOpen() || fields.empty() || (!is_at_work && !over)) return {};
  const Rigid3 tool = is_at_work ? document.report().output.T_world_tool : over->T_world_tool;

  std::optional<NearNeighbour> out;
  for (std::size_t n = 0; n < fields.size(); ++n) {
    const KeepOut::Reading reading = fields[n]->read(bench_.tools->samples(), tool);
    if (out && reading.distance >= out->distance_mm) continue;
    out = NearNeighbour{document.run()->neighbours()[n].known.name, reading.distance, reading.is_far};
  }
  const auto limit = bench_.strokes->stop_short_beside_mm;
  out->is_stopped = bench_.strokes->isPressed() && limit && !out->is_far && out->distance_mm <= *limit + kStopped;
  return out;
}

}  // namespace kerf
