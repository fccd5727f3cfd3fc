#include "sim/hand/guided_hand.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kGuideGives = 70;         // mm/s per N of missing or excess force
constexpr double kGovern = 4;              // N per mm of way: force follows the missing feed
constexpr double kFastest = 6;             // mm/s of the hand, forward, on a way that cuts
constexpr double kGuideLetsGo = 200;       // mm/s, back
constexpr double kGuideBrake = 10;         // 1/s: of the remaining way
constexpr double kCreep = 0.1;             // mm/s: least speed before the end
constexpr double kThere = 0.02;            // mm before the end of a way
constexpr double kNearly = 0.1;            // mm: the same for a stuck tool
constexpr double kGuideSmooth = 0.1;       // of the speed, a tick
constexpr double kTouches = 0.15;          // N: less is air
constexpr double kCarryForce = 2;          // N on a way through air: more means an obstacle
constexpr double kLean = ToolLean::kRate;  // 1/s
constexpr double kGetsOn = 0.03;           // mm within kPatience; less is none
constexpr double kPatience = 2;            // s
constexpr double kDrawsBack = 0.4;         // s
constexpr double kBackSpeed = 2;           // mm/s, while it draws back
constexpr double kUnfelt = 0.1;            // mm of the hand without any force: the coupling does not pull
constexpr int kFadeIn = 300;               // ticks after a pause

}  // namespace

void GuidedHand::order(const GuidedCut& cut) noexcept {
  orders_.back() = cut;
  orders_.publish();
}

void GuidedHand::takeNewest() noexcept {
  if (orders_.update()) cut_ = orders_.front();
}

void GuidedHand::placed(const Rigid3& T_world_tool) noexcept {
  takeNewest();
  is_mine_ = cut_.is_wanted && cut_.id != begun_ && cut_.count > 0;
  if (!is_mine_) {
    now_.stage = GuidedStage::kNone;
    publish();
    return free_.placed(T_world_tool);
  }
  begun_ = cut_.id;
  now_ = {.id = cut_.id, .stage = GuidedStage::kCutting};
  felt_.setZero();
  torque_.setZero();
  lean_ = {};
  paused_ = 0;
  was_touching_ = false;
  still_ = 0;
  begin(T_world_tool.translation, cut_.ways[0].to, T_world_tool.translation);
  publish();
}

void GuidedHand::write(const DeviceForce& force) noexcept {
  if (!is_mine_) return free_.write(force);
  felt_ = force.force;
  if (!felt_.isZero(0)) still_ = 0;
  torque_ = force.torque;
  // Zero force while the tool is in contact or the hand moves: the thread has paused, or is latched. The tool stands
  // still until the force has faded in again.
  if (felt_.isZero(0) && (was_touching_ || still_ > kUnfelt)) paused_ = kFadeIn;
}

DeviceSample GuidedHand::read() noexcept {
  if (!is_mine_) return free_.read();
  takeNewest();
  if (now_.stage == GuidedStage::kCutting && (!cut_.is_wanted || cut_.id != begun_)) backOut();

  if (paused_ > 0)
    --paused_;
  else if (now_.stage == GuidedStage::kCutting || now_.stage == GuidedStage::kBack)
    followWay();
  publish();

  DeviceSample out;
  out.T_world_device = {lean_.of(cut_.start.rotation), hand()};
  out.pedal = now_.stage == GuidedStage::kCutting ? 1 : 0;
  out.irrigation = cut_.irrigation;
  return out;
}

// A way from a point of the line, with the hand where it is now.
void GuidedHand::begin(const Vec3d& from, const Vec3d& to, const Vec3d& hand) noexcept {
  const Vec3d way = to - from;
  from_ = from;
  length_ = way.norm();
  direction_ = length_ > 1e-9 ? Vec3d(way / length_) : cut_.back;
  h_ = direction_.dot(hand - from);
  aside_ = hand - from - h_ * direction_;
  at_ = h_ + felt_.dot(direction_) / stiffness_;
  watched_ = at_;
  speed_ = wanted_ = waited_ = recoil_ = 0;
  tries_here_ = 0;
}

// Out of the tissue, to the height where the cut began.
void GuidedHand::backOut() noexcept {
  now_.stage = GuidedStage::kBack;
  const Vec3d tool = hand() + felt_ / stiffness_;
  const double up = std::max(cut_.back.dot(cut_.start.translation - tool), 0.0);
  begin(tool, tool + up * cut_.back, hand());
}

// Target speed of the tool.
double GuidedHand::feedOf(double left, double resists) const noexcept {
  const bool cuts = now_.stage == GuidedStage::kCutting && cut_.ways[now_.way].cuts;
  const double most = !cuts ? kCarried : resists < kTouches ? kThroughAir : cut_.feed;
  return std::clamp(kGuideBrake * left, kCreep, most);
}

// No progress for a while.
bool GuidedHand::isStuck(double at) noexcept {
  if (at > watched_ + kGetsOn) {
    watched_ = at;
    waited_ = 0;
    tries_here_ = 0;
    return false;
  }
  waited_ += kTick;
  return waited_ > kPatience;
}

// On to the next one. A jammed tool stays where it is.
void GuidedHand::endWay(bool gives_up) noexcept {
  const bool is_jammed = gives_up && !(now_.stage == GuidedStage::kCutting && cut_.ways[now_.way].cuts);
  now_.given_up += gives_up;
  const Vec3d end = from_ + (gives_up ? at_ : length_) * direction_;
  if (now_.stage == GuidedStage::kBack || is_jammed || now_.way + 1 >= cut_.count) {
    now_.stage = GuidedStage::kOver;
    return;
  }
  ++now_.way;
  begin(end, cut_.ways[now_.way].to, hand());
}

void GuidedHand::followWay() noexcept {
  const bool cuts = now_.stage == GuidedStage::kCutting && cut_.ways[now_.way].cuts;
  const double resists = -felt_.dot(direction_);
  was_touching_ = felt_.norm() > kTouches;

  const double at = h_ - resists / stiffness_;
  speed_ += kGuideSmooth * ((at - at_) / kTick - speed_);
  at_ = at;
  const double left = length_ - at;
  const bool is_stuck = isStuck(at);

  const bool is_there = left < (is_stuck ? kNearly : kThere);
  const bool gives_up = !is_there && is_stuck && tries_here_ >= kMostTries;
  if (is_there || gives_up) return endWay(gives_up);

  if (is_stuck) {
    waited_ = 0;
    ++tries_here_;
    ++now_.tries;
    recoil_ = kDrawsBack;
  }
  const double past = cuts ? cut_.past : kPast;
  double rate;
  if (recoil_ > 0) {
    recoil_ -= kTick;
    wanted_ = 0;
    rate = std::max(kGuideGives * -resists, -kGuideLetsGo) - kBackSpeed;
  } else {
    const double most = std::min(cuts ? cut_.force : kCarryForce, stiffness_ * (left + past));
    wanted_ = std::clamp(wanted_ + kGovern * (feedOf(left, resists) - speed_) * kTick, 0.0, most);
    rate = std::clamp(kGuideGives * (wanted_ - resists), -kGuideLetsGo, cuts ? kFastest : kCarried);
  }
  still_ += std::abs(kTick * rate);
  h_ = std::min(h_ + kTick * rate, length_ + past);
  leanAgainst();
}

// Holds the tool, not the hand, on the line and in the plane.
void GuidedHand::leanAgainst() noexcept {
  Vec3d off = aside_ + felt_ / stiffness_;
  off -= direction_.dot(off) * direction_;
  aside_ -= direction_.dot(aside_) * direction_;
  aside_ -= kLean * kTick * off;
  if (const double size = aside_.norm(); size > kMostAside) aside_ *= kMostAside / size;

  lean_.against(torque_, turn_stiffness_);
}

void GuidedHand::publish() noexcept {
  reports_.back() = now_;
  reports_.publish();
}

}  // namespace kerf
