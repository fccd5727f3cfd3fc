#include "ui/window/panels/readings_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cmath>

#include "ui/app/base/language.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/screens/readings.h"

namespace kerf {
namespace {

// Point under the guided tool or the cursor. Without one it keeps as many lines, so that panels below do not move.
void drawPoint(const AppContext& context, bool is_over) {
  std::optional<PointReadout> point = readoutOfTool(context.bench);
  if (is_over && context.pointer) {
    const auto& at = *context.pointer;
    point = readoutAt(context.bench, rayUnder(context.camera, at[0], at[1], context.width, context.height));
  }
  const Vec3d p = point ? point->point : Vec3d(Vec3d::Zero());
  reading("Point", point ? shownNumbers("{:.1f}  {:.1f}  {:.1f}", p[0], p[1], p[2]) : "-", "");
  reading("Thickness", point && point->thickness_mm ? shownNumbers("{:.2f}", *point->thickness_mm) : "-", "mm");
  reading("Tissue", point && !point->tissue.empty() ? point->tissue : "-", "");
}

// A warning that does not interrupt.
void drawNearStructure(const Workbench& bench, const std::optional<ToolOverSurface>& over) {
  constexpr double kClose = 0.5;  // mm
  if (bench.document->structures()->isEmpty()) return;
  const auto near = bench.monitor->nearStructure(over);
  const std::string name =
      near ? near->name : bench.document->nameOf(bench.document->structures()->all().front().material);
  const std::string label = phrase("To {}", shownText(name));
  if (!near) return reading(label.c_str(), "-", "mm");
  if (near->is_far) return reading(label.c_str(), phrase("over {:.0f}", near->distance_mm), "mm");
  if (near->distance_mm < 0)
    return reading(label.c_str(), shownNumbers("{:.2f}", -near->distance_mm), "mm inside", true);
  reading(label.c_str(), shownNumbers("{:.2f}", near->distance_mm), near->is_stopped ? "mm, stopped" : "mm",
          near->is_stopped || near->distance_mm < kClose);
}

// The same for neighbours: distance and removed volume.
void drawNeighbours(const Workbench& bench, const std::optional<ToolOverSurface>& over) {
  constexpr double kClose = 0.2;  // mm
  const std::vector<Neighbour> all = bench.neighbours->list();
  if (all.empty()) return;
  const auto near = bench.monitor->nearNeighbour(over);
  const std::string label = phrase("To {}", near ? near->name : all.front().name);
  if (!near)
    reading(label.c_str(), "-", "mm");
  else if (near->is_far)
    reading(label.c_str(), phrase("over {:.0f}", near->distance_mm), "mm");
  else if (near->distance_mm < 0)
    reading(label.c_str(), shownNumbers("{:.2f}", -near->distance_mm), "mm inside", true);
  else
    reading(label.c_str(), shownNumbers("{:.2f}", near->distance_mm), near->is_stopped ? "mm, stopped" : "mm",
            near->is_stopped || near->distance_mm < kClose);
  for (const Neighbour& other : all)
    if (other.removed_mm3 > 0)
      reading(phrase("Cut off {}", other.name).c_str(), shownNumbers("{:.3f}", other.removed_mm3), "mm3", true);
}

}  // namespace

void drawLoop(PanelFrame& frame) {
  constexpr double kLeastHz = 995;
  const ToolMonitor::Loop& loop = frame.context.bench.monitor->loop();
  reading("Loop", loop.hz ? shownNumbers("{:.0f}", *loop.hz) : "-", "Hz", loop.hz && *loop.hz < kLeastHz);
  if (loop.p99_ms) reading("Tick p99", shownNumbers("{:.2f}", *loop.p99_ms), "ms");
  reading("Overruns", fmt::format("{}", loop.overruns), phrase("of {}", loop.ticks).c_str());
}

void drawReadings(PanelFrame& frame) {
  AppContext& context = frame.context;
  const auto& over = frame.over;
  const Workbench& bench = context.bench;
  const HapticReport& r = bench.document->report();
  const double speed = std::abs(bench.monitor->driveShare());
  const char* const turns = bench.monitor->driveShare() < 0 ? "% reverse" : "%";
  const auto tip = bench.monitor->tipDepth();
  const auto depth = tip ? tip : over ? std::optional(over->depth) : std::nullopt;

  reading(tip ? "Depth of the tip" : "Depth", depth ? shownNumbers("{:.2f}", *depth) : "-", "mm");
  drawNearStructure(bench, over);
  drawNeighbours(bench, over);
  reading("Force", shownNumbers("{:.2f}", r.output.force.force.norm()), "N");
  reading("Spindle", shownNumbers("{:.0f}", 100 * speed), turns,
          bench.strokes->isPressed() && speed < 0.05 && r.output.normal_load > 0);
  drawHeat(bench);
  reading("Removed", shownNumbers("{:.2f}", bench.document->removedMm3()), "mm3");
  drawPoint(context, over.has_value());
  if (r.is_latched)
    ui::textColored(styleColours().warning, bench.device->isLed() ? "Stopped: waiting for the device."
                                                                  : "Stopped: the computer was busy. Press again.");
  const RecorderStatus log = bench.document->run()->recorderStatus();
  if (log.error)
    ui::textWrapped(phrase("Cannot write the log. End the session to keep your cuts. {}", log.error->message()));
}

}  // namespace kerf
