#include "ui/app/session/arm_lead.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "sim/device/record/arm_opener.h"
#include "sim/run/session/live_run.h"

namespace kerf {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr double kBack = 0.3;  // s of presence before the hand leads the tool
constexpr double kGone = 1;    // s without a hand before it counts as gone
// s: 1 ms each for the transport's clock, Kerf's thread and the tick, as in kerf live.
constexpr double kTransport = 0.003;

WorkspaceMap mapOf(const ArmChoice& choice) {
  const double angle = choice.turn_deg * std::numbers::pi / 180;
  return WorkspaceMap(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3d::UnitZ())), choice.scale);
}

tl::unexpected<Error> notNow(std::string found, std::string hint) {
  return fail({.code = Error::Code::kUnsupported,
               .place = "force-feedback device",
               .found = std::move(found),
               .expected = "a device that can give force",
               .hint = std::move(hint)});
}

}  // namespace

ArmLead::~ArmLead() { close(); }

ArmSettings ArmLead::settings() const {
  ArmSettings out;
  out.limits.force = choice_.most_force;
  out.map = mapOf(choice_);
  out.pedal_is_down = choice_.pedal_is_down;
  out.speed = speed_;
  out.irrigation = irrigation_;
  return out;
}

Expected<void> ArmLead::open(const std::string& name) {
  close();
  KERF_TRY(opened, openArm(name, settings()));
  name_ = name;
  arm_ = std::move(opened.arm);
  was_there_ = has_told_of_fault_ = false;
  forgetHand();
  return {};
}

void ArmLead::close() {
  if (!arm_) return;
  disarmForce();
  stopLeading();
  letGo();
  arm_.reset();
  name_.clear();
}

void ArmLead::choose(const ArmChoice& choice) {
  choice_ = choice;
  if (arm_) arm_->set(settings());
  if (isArmed() && !missingForForce().empty()) disarmForce();
  forgetHand();
}

void ArmLead::drive(double speed, double irrigation) {
  if (speed == speed_ && irrigation == irrigation_) return;
  speed_ = speed;
  irrigation_ = irrigation;
  if (arm_) arm_->set(settings());
}

std::optional<CouplingSettings> ArmLead::coupling() const {
  if (!arm_) return {};
  DeviceProfile profile = choice_.profile.value_or(DeviceProfile{});
  profile.delay_s += kTransport;
  CouplingSettings wanted;
  wanted.force_limit = std::min(wanted.force_limit, choice_.most_force);
  if (HandFrame hand; arm_->lastHand(hand)) {
    if (hand.most_stiffness > 0) wanted.stiffness = std::min(wanted.stiffness, hand.most_stiffness / choice_.scale);
    wanted.force_limit = std::min(wanted.force_limit, hand.most_force);
    profile = withTurning(profile, hand);
  }
  return couplingFor(mapOf(choice_).inWorld(profile), wanted).settings;
}

bool ArmLead::hasJustCome() const { return Seconds(Clock::now() - there_since_).count() < 2 * kBack; }

// Reasons with a remedy for the user come first.
std::string ArmLead::missingForForce() const {
  constexpr double kSlack = 1.001;
  if (!run_) return "no object is open: open one to cut";
  const CouplingSettings now = run_->model().settings.coupling;
  const CouplingSettings borne = *coupling();
  HandFrame hand;
  const bool turns = arm_->lastHand(hand) && hand.gives_torque;
  if (turns && now.turn_stiffness > kSlack * borne.turn_stiffness)
    return "the session was opened for a device without torque: device.fit reopens it and keeps your cuts";
  if (now.stiffness > kSlack * borne.stiffness || now.damping > kSlack * std::max(borne.damping, borne.running_damping))
    return fmt::format(
        "the session was opened for a stiffer device, {:.2g} N/mm; this one allows {:.2g}: device.fit reopens it and "
        "keeps your cuts",
        now.stiffness, borne.stiffness);
  return {};
}

Expected<void> ArmLead::armForce() {
  if (!arm_) return notNow("none is open", "device.open bridge, or the path of a device");
  if (const std::string missing = missingForForce(); !missing.empty()) return notNow(missing, "");
  if (!is_leading_) return notNow("it does not control the tool", view().missing);
  if (arm_->felt().has_fault) arm_->enable(false);
  arm_->enable(true);
  return {};
}

void ArmLead::disarmForce() {
  if (arm_) arm_->enable(false);
  has_told_of_fault_ = false;
}

Expected<void> ArmLead::testForce(const Vec3d& newtons) {
  if (!isArmed() || !is_leading_) return notNow("the device is not armed", "use device.arm, with a hand on the device");
  if (is_touching_) return notNow("the tool touches something", "lift the tool off the surface");
  if (newtons.norm() > ForceArm::kMostTestForce)
    return fail({.code = Error::Code::kBadValue,
                 .place = "test force",
                 .found = fmt::format("{:g} N", newtons.norm()),
                 .expected = fmt::format("at most {:g} N", ForceArm::kMostTestForce)});
  arm_->testForce(newtons);
  return {};
}

// ---- A session

void ArmLead::opened(LiveRun& run, std::shared_ptr<HandSwitch> hands) {
  run_ = &run;
  hands_ = std::move(hands);
  is_leading_ = false;
  disarmForce();
}

void ArmLead::closing() {
  disarmForce();
  stopLeading();
  if (arm_) letGo();
  run_ = nullptr;
  hands_.reset();
}

// The haptic thread changes hands at its next read(). A guide or a pause that holds the tool can delay this read; until
// then the disarmed arm is kept.
void ArmLead::letGo() {
  constexpr int kMostMs = 100;
  for (int n = 0; hands_ && hands_->isInUse(arm_.get()) && n < kMostMs; ++n)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (hands_ && hands_->isInUse(arm_.get())) kept_.emplace_back(hands_, arm_);
}

void ArmLead::stopLeading() {
  if (hands_) hands_->lead(nullptr);
  is_leading_ = false;
}

void ArmLead::forgetHand() { reached_ = {}; }

// Looks once a second for an unplugged device.
void ArmLead::openAnew() {
  const Clock::time_point now = Clock::now();
  if (now < next_try_ || (hands_ && hands_->isInUse(arm_.get()))) return;
  next_try_ = now + std::chrono::seconds(1);
  auto opened = openArm(name_, settings());
  if (opened) arm_ = std::move(opened->arm);
}

ArmLead::News ArmLead::update(const HapticReport& report, bool may_lead) {
  News out;
  std::erase_if(kept_, [](const Kept& kept) { return kept.first.use_count() == 1; });  // the session has ended
  if (!arm_) return out;
  may_lead = may_lead && !is_paused_;
  arm_->update();
  arm_->updateAges();
  is_touching_ = report.output.touching > 0;
  const Clock::time_point now = Clock::now();
  HandFrame hand;
  const bool is_there = arm_->counts().is_talking && arm_->lastHand(hand) && hand.is_ready;
  if (is_there) reached_.add(hand.pose.translation);
  if (is_there != was_there_) (is_there ? there_since_ : gone_since_) = now;
  was_there_ = is_there;
  const bool is_back = is_there && Seconds(now - there_since_).count() > kBack;
  const bool is_gone = !is_there && Seconds(now - gone_since_).count() > kGone;

  if (arm_->felt().has_fault && isArmed() && !std::exchange(has_told_of_fault_, true))
    out.notices.push_back(
        "The computed force was not a number: Kerf turned the force off. Disarm the device, then arm it again.");
  if (isArmed() && !is_leading_ && is_gone) disarmForce();
  if (const std::string missing = isArmed() ? missingForForce() : std::string(); !missing.empty()) {
    disarmForce();
    out.notices.push_back("The device is disarmed: " + missing + ".");
  }
  if (arm_->isGone() && !is_leading_) openAnew();
  if (!hands_) return out;
  if (is_leading_ && !may_lead) stopLeading();
  if (is_leading_ && is_gone) {
    const bool was_armed = isArmed();
    disarmForce();
    stopLeading();
    out.notices.push_back(
        fmt::format("No data from the {}: force off{}. The mouse controls the tool; your cuts are kept.", arm_->what(),
                    was_armed ? "; arm the device again when it is back" : ""));
    out.wants_go_on = true;
    forgetHand();
    return out;
  }
  if (!is_leading_ && is_back && may_lead) {
    hands_->lead(arm_.get());
    is_leading_ = true;
    out.wants_tool = true;
    out.notices.push_back(fmt::format("The {} controls the tool{}.", arm_->what(),
                                      isArmed() ? "" : ", without force: device.arm turns the force on"));
  }
  out.wants_go_on = report.is_latched && is_leading_ && is_back;
  return out;
}

ArmView ArmLead::view() const {
  ArmView out;
  if (!arm_) {
    out.missing = "no force-feedback device is open: use device.open bridge, or its path or serial number";
    return out;
  }
  out.what = arm_->what();
  out.counts = arm_->counts();
  out.is_there = out.counts.is_talking;
  out.is_leading = is_leading_;
  out.is_armed = isArmed();
  (void)arm_->lastHand(out.hand);
  out.felt = arm_->felt();
  out.age_p50_ms = arm_->ages().percentileMs(0.5);
  out.age_p99_ms = arm_->ages().percentileMs(0.99);
  out.age_p999_ms = arm_->ages().percentileMs(0.999);
  out.reached = reached_;
  out.scale = choice_.scale;
  out.most_force = std::min(choice_.most_force, out.hand.most_force);
  if (!out.counts.trouble.empty())
    out.missing = out.counts.trouble;
  else if (out.is_there && !out.hand.is_ready)
    out.missing = "the device is not ready: switch it on and calibrate it (a bridge: press Enter in its terminal)";
  else if (!is_leading_)
    out.missing =
        !run_ ? "no object is open: open one to cut"
        : hasJustCome()
            ? "it has just become ready: wait a moment"
            : "another input holds the tool, or a question is open: release the button, or answer the question";
  else
    out.missing = missingForForce();
  return out;
}

}  // namespace kerf
