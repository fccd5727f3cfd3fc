// Leads a stroke beside its pointer: along the tool's axis, in small steps, by a foot pedal. The rest of the workbench:
// workbench.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/tool/handpiece.h"
#include "ui/app/base/language.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

void Workbench::moveAlong(double mm) {
  if (!stroke_) return;
  const double deepest = std::min(depth_mm, mostDepth());
  const double normal_mm = mm / std::sqrt(1 + aim_.slant.squaredNorm());
  along_ = std::clamp(along_.value_or(depthNow().value_or(deepest)) + normal_mm, -MouseHand::kClearance, deepest);
  sendAim();
}

void Workbench::nudge(const Camera& camera, double right_mm, double up_mm) {
  constexpr double kInFront = 6;  // mm: the search for the surface starts so much nearer than the pointer
  if (!stroke_) return;
  const Vec3d beside = aim_.pointer + right_mm * camera.right() + up_mm * camera.up();
  const Vec3d to_viewer = camera.towardsViewer(beside);
  drag({beside + kInFront * to_viewer, -to_viewer});
}

bool Workbench::stepOnPedal(const std::optional<Ray>& at) {
  const std::optional<Ray> ray = at ? at : pointed_;
  if (!stroke_ && !(ray && press(*ray))) return false;
  is_on_pedal_ = true;
  return true;
}

void Workbench::drill(double pedal) {
  if (!stroke_) return;
  drill_ = std::clamp(pedal, 0.0, 1.0);
  sendAim();
}

void Workbench::setSpeed(double of_nominal) {
  speed = std::clamp(of_nominal, 0.0, 1.0);
  if (stroke_) sendAim();
}

void Workbench::setIrrigation(double of_full) {
  irrigation = std::clamp(of_full, 0.0, 1.0);
  if (stroke_) sendAim();
}

bool Workbench::canReverse() const { return run_ && turnsBackwards(run_->model().tools[tool_].drive.form); }

Expected<void> Workbench::setReversed(bool is_reversed) {
  if (is_reversed && !canReverse())
    return fail({.code = Error::Code::kBadValue,
                 .place = "cut.reverse",
                 .found = run_ ? fmt::format("{}, whose drive goes one way", tool(tool_).name) : "no tool in hand",
                 .expected = "a tool that a motor turns",
                 .hint = "take a drill, a bur of a contra-angle or a disc: a turbine does not turn backwards"});
  is_reversed_ = is_reversed;
  if (stroke_) sendAim();
  return {};
}

// ---- By a force-feedback device

bool Workbench::isLed() const { return arm_->isLeading(); }

void Workbench::warnThatItIsLed() {
  if (std::exchange(has_told_that_it_is_led_, true)) return;
  say("A force-feedback device leads the tool: device.close gives it back to the mouse.");
}

Expected<void> Workbench::openDevice(const std::string& name) {
  if (isBusy() || isSawing()) return {};
  release();
  KERF_CHECK(arm_->open(name));
  say(phrase("{} is open: its hand leads the tool when it comes.", arm_->arm()->what()));
  has_told_that_it_is_led_ = false;
  if (run_) reopenWith({});
  return {};
}

Expected<void> Workbench::fitToDevice() {
  if (isBusy() || isSawing()) return {};
  release();
  if (run_) reopenWith({});
  return {};
}

Expected<void> Workbench::placeHand(const Vec3d& tip) {
  if (!isLed())
    return fail({.code = Error::Code::kUnsupported,
                 .place = "device.place",
                 .found = "no device that leads the tool",
                 .expected = "one",
                 .hint = arm_->view().missing});
  const Eigen::Quaterniond& q = report_.output.T_world_tool.rotation;
  send(PlaceTool{{tip[0], tip[1], tip[2]}, {q.w(), q.x(), q.y(), q.z()}});
  return {};
}

// Tells the haptic thread who leads. The tool changes hands at its present pose.
void Workbench::followDevice() {
  arm_->drive((is_reversed_ ? -1 : 1) * speed, irrigation);
  const bool may_lead = !stroke_ && !import_ && !saw_->isCutting() && !wish_;
  const ArmLead::News news = arm_->update(report_, may_lead);
  for (const std::string& notice : news.notices) say(notice);
  if (news.wants_tool) {
    const Rigid3& at = report_.output.T_world_tool;
    const Eigen::Quaterniond& q = at.rotation;
    send(PlaceTool{{at.translation[0], at.translation[1], at.translation[2]}, {q.w(), q.x(), q.y(), q.z()}});
  }
  if ((news.wants_go_on || news.wants_tool) && report_.is_latched && answered() >= sent_) send(ClearLatch{});
}

}  // namespace kerf
