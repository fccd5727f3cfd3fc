#include "ui/app/workbench/force_device.h"

#include <utility>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

ForceDevice::ForceDevice(Workbench& bench) : bench_(bench), arm_(std::make_unique<ArmLead>()) {
  if (bench_.options().device.empty()) return;
  if (const auto opened = arm_->open(bench_.options().device); !opened) bench_.notices->complain(opened.error());
}

ForceDevice::~ForceDevice() = default;

bool ForceDevice::isLed() const { return arm_->isLeading(); }

void ForceDevice::warnThatItLeads() {
  if (std::exchange(has_told_that_it_leads_, true)) return;
  bench_.notices->say("A force-feedback device controls the tool. device.close returns it to the mouse.");
}

void ForceDevice::opened(Opening /*how*/) {
  if (LiveRun* const run = bench_.document->run()) arm_->opened(*run, bench_.document->hands().leading);
}

void ForceDevice::closing() {
  if (bench_.document->isOpen()) arm_->closing();
}

Expected<void> ForceDevice::open(const std::string& name) {
  if (bench_.jobs->isBusy() || bench_.saw->isBusy()) return {};
  bench_.strokes->release();
  KERF_CHECK(arm_->open(name));
  bench_.notices->say(phrase("{} is open. It controls the tool once it is ready.", arm_->arm()->what()));
  has_told_that_it_leads_ = false;
  if (bench_.document->isOpen()) bench_.sessions->reopen({});
  return {};
}

Expected<void> ForceDevice::fit() {
  if (bench_.jobs->isBusy() || bench_.saw->isBusy()) return {};
  bench_.strokes->release();
  if (bench_.document->isOpen()) bench_.sessions->reopen({});
  return {};
}

Expected<void> ForceDevice::place(const Vec3d& tip) {
  if (!isLed())
    return fail({.code = Error::Code::kUnsupported,
                 .place = "device.place",
                 .found = "no device controls the tool",
                 .expected = "one",
                 .hint = arm_->view().missing});
  sendPlace({bench_.document->report().output.T_world_tool.rotation, tip});
  return {};
}

void ForceDevice::sendPlace(const Rigid3& T_world_tool) {
  const Vec3d& p = T_world_tool.translation;
  const Eigen::Quaterniond& q = T_world_tool.rotation;
  bench_.document->send(PlaceTool{{p[0], p[1], p[2]}, {q.w(), q.x(), q.y(), q.z()}});
}

// Tells the haptic thread who leads. The tool changes hands at its present pose.
void ForceDevice::update() {
  Document& document = *bench_.document;
  if (!document.isOpen()) {
    (void)arm_->update(document.report(), false);  // its panel shows it
    return;
  }
  const Strokes& strokes = *bench_.strokes;
  arm_->drive((strokes.isReversed() ? -1 : 1) * strokes.speed, strokes.irrigation);
  const bool may_lead =
      !strokes.isPressed() && !bench_.imports->isImporting() && !bench_.saw->isCutting() && !bench_.steps->isWaiting();
  const ArmLead::News news = arm_->update(document.report(), may_lead);
  for (const std::string& notice : news.notices) bench_.notices->say(notice);
  if (news.wants_tool) sendPlace(document.report().output.T_world_tool);
  if ((news.wants_go_on || news.wants_tool) && document.report().is_latched && document.isAnswered())
    document.send(ClearLatch{});
}

}  // namespace kerf
