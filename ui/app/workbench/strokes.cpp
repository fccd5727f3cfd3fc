#include "ui/app/workbench/strokes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tool/handpiece.h"
#include "ui/app/document/view_state.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

void Strokes::opened(Opening how) {
  aim_ = {};
  stroke_.reset();
  pointed_.reset();
  is_on_pedal_ = is_reversed_ = false;
  if (how == Opening::kReopened) return;
  tilt = {};  // tilt and axis belonged to the other scan
  held_axis_.reset();
  speed = 1;
}

// ---- Values

void Strokes::holdAxis(const std::optional<Vec3d>& axis) {
  held_axis_ = axis ? std::optional<Vec3d>(axis->normalized()) : std::nullopt;
}

void Strokes::setForce(double newtons) {
  force = std::clamp(newtons, kLeastForce, kMostForce);
  aimIfPressed();
}

void Strokes::setSpeed(double of_nominal) {
  speed = std::clamp(of_nominal, 0.0, 1.0);
  aimIfPressed();
}

void Strokes::setIrrigation(double of_full) {
  irrigation = std::clamp(of_full, 0.0, 1.0);
  aimIfPressed();
}

void Strokes::stopShort(std::optional<double> mm) {
  stop_short_mm = mm;
  aimIfPressed();
}

void Strokes::stopShortBeside(std::optional<double> mm) {
  stop_short_beside_mm = mm;
  aimIfPressed();
}

void Strokes::deepen(double mm) {
  depth_mm = std::clamp(depth_mm + mm, 0.0, mostDepth());
  along_.reset();
  aimIfPressed();
}

double Strokes::mostDepth() const { return bench_.saw->isGuiding() ? bench_.saw->plan().chosen()->depth : kMostDepth; }

bool Strokes::canReverse() const {
  const LiveRun* const run = bench_.document->run();
  return run && turnsBackwards(run->model().tools[bench_.tools->inHand()].drive.form);
}

Expected<void> Strokes::setReversed(bool is_reversed) {
  if (is_reversed && !canReverse())
    return fail({.code = Error::Code::kBadValue,
                 .place = "cut.reverse",
                 .found = bench_.document->isOpen()
                              ? fmt::format("{}, whose drive has no reverse", bench_.tools->held().name)
                              : "no tool in hand",
                 .expected = "a tool with a motor",
                 .hint = "choose a drill, a contra-angle bur or a disc: a turbine has no reverse"});
  is_reversed_ = is_reversed;
  aimIfPressed();
  return {};
}

std::optional<ToolOverSurface> Strokes::over(const Ray& ray) const {
  if (!bench_.document->isOpen()) return {};
  const auto seen = bench_.views->behindSection(ray);
  if (!seen) return {};
  if (bench_.saw->isGuiding()) return bench_.saw->over(*seen);
  auto at = toolOver(bench_.document->scene(), *bench_.document->run()->original(), *seen, bench_.tools->plunge());
  if (at && held_axis_ && !holdTool(*at, *held_axis_, bench_.tools->touches())) return {};
  if (at && !held_axis_) tiltTool(*at, tilt, bench_.tools->touches());
  return at;
}

// ---- A stroke

bool Strokes::press(const Ray& ray) {
  // A session behind an import rests.
  if (bench_.imports->isImporting() || bench_.saw->isCutting() || bench_.steps->isMoving()) return false;
  Document& document = *bench_.document;
  if (bench_.device->isLed()) {
    bench_.device->warnThatItLeads();
    return false;
  }
  const auto at = over(ray);
  if (!at) {
    const auto seen = bench_.views->behindSection(ray);
    if (const auto hit = seen ? document.scene().hit(*seen) : std::nullopt)
      if (!bench_.neighbours->isNeighbour(hit->id, "be cut") && held_axis_)
        bench_.notices->say(shownText("This surface is an undercut of the held axis. Release the axis to cut it."));
    return false;
  }
  release();
  pointed_ = ray;
  // A mouse cannot be jerked like an arm: after a late clock it continues at once.
  if (document.report().is_latched) document.send(ClearLatch{});
  const bool is_guided = bench_.saw->isGuiding();
  aim_.guide = is_guided ? bench_.saw->plan().chosen()->normal : Vec3d(Vec3d::Zero());
  stroke_.emplace(*document.run()->original(), *at, bench_.tools->head());
  stroke_->begin(aim_);
  const bool keeps_away = !document.structures()->isEmpty() || !document.neighbourFields().empty();
  aim_.samples = keeps_away ? &bench_.tools->samples() : nullptr;
  aim();

  const Rigid3& start = stroke_->start();
  const Eigen::Quaterniond& q = start.rotation;
  document.send(
      PlaceTool{{start.translation[0], start.translation[1], start.translation[2]}, {q.w(), q.x(), q.y(), q.z()}});
  return true;
}

void Strokes::drag(const Ray& ray) {
  if (!stroke_) return;
  pointed_ = ray;
  aim_.pointer = stroke_->pointerOf(ray);
  aim();
}

void Strokes::release() {
  if (!stroke_) return;
  stroke_.reset();
  along_.reset();
  is_on_pedal_ = false;
  drill_ = 1;
  aim_.is_pressed = false;
  aim();
}

void Strokes::drill(double pedal) {
  if (!stroke_) return;
  drill_ = std::clamp(pedal, 0.0, 1.0);
  aim();
}

void Strokes::pushHarder(double factor) {
  push_factor_ = factor;
  aimIfPressed();
}

void Strokes::moveAlong(double mm) {
  if (!stroke_) return;
  const double deepest = std::min(depth_mm, mostDepth());
  const double normal_mm = mm / std::sqrt(1 + aim_.slant.squaredNorm());
  along_ = std::clamp(along_.value_or(depthNow().value_or(deepest)) + normal_mm, -MouseHand::kClearance, deepest);
  aim();
}

void Strokes::nudge(const Camera& camera, double right_mm, double up_mm) {
  constexpr double kInFront = 6;  // mm: the search for the surface starts so much nearer than the pointer
  if (!stroke_) return;
  const Vec3d beside = aim_.pointer + right_mm * camera.right() + up_mm * camera.up();
  const Vec3d to_viewer = camera.towardsViewer(beside);
  drag({beside + kInFront * to_viewer, -to_viewer});
}

bool Strokes::stepOnPedal(const std::optional<Ray>& at) {
  const std::optional<Ray> ray = at ? at : pointed_;
  if (!stroke_ && !(ray && press(*ray))) return false;
  is_on_pedal_ = true;
  return true;
}

std::optional<double> Strokes::depthNow() const {
  if (!stroke_) return {};
  return stroke_->depthOf(bench_.document->report().output.T_world_tool.translation);
}

void Strokes::aimIfPressed() {
  if (stroke_) aim();
}

void Strokes::aim() {
  aim_.force = std::min(force * push_factor_, kMostForce);
  aim_.depth = std::min({depth_mm, mostDepth(), along_.value_or(depth_mm)});
  aim_.pedal = (is_reversed_ ? -1 : 1) * speed * drill_;
  aim_.irrigation = irrigation;
  aim_.keep = stop_short_mm.value_or(-1);
  aim_.keep_beside = stop_short_beside_mm.value_or(-1);
  bench_.document->hands().mouse->aim(aim_);
}

}  // namespace kerf
