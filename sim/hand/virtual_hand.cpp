#include "sim/hand/virtual_hand.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

Rigid3 between(const Rigid3& a, const Rigid3& b, double s) {
  return {a.rotation.slerp(s, b.rotation), a.translation + s * (b.translation - a.translation)};
}

constexpr double kSharpTurn = 0.87;   // cosine of 30 degrees
constexpr double kUnheld = 0.3;       // mm: ahead of a tool that touches nothing
constexpr double kAheadOfTurn = 0.3;  // mm: a hand that goes for more runs past a corner
constexpr double kLeanRate = 10;      // 1/s: how fast a hand leans against what keeps the tool off its line
// Nearer than this part of `off_line` a hand leans no more: the drag of a bur turns what pushes it, and a hand that
// answers late to the last micrometre makes it walk round its hole, wider and wider.
constexpr double kNearLine = 0.6;
constexpr double kHold = 2;         // mm that a hand holds against each mm the tool is off its line, at once
constexpr double kSideways = 2;     // a hand holds sideways with up to this times its push
constexpr double kTurnRate = 1;     // rad/s: turns on the spot
constexpr double kStalled = 0.02;   // of the highest speed of the drive: a hand lets go
constexpr double kRecovered = 0.5;  // and pushes again
constexpr double kLetsGo = 0.1;     // mm that it draws back, and no farther to a side

constexpr double kNoWay = 1e-9;  // mm: shorter stretches are turns on the spot

Vec3d shortened(const Vec3d& v, double most) {
  const double size = v.norm();
  return size > most ? Vec3d(v * (most / size)) : v;
}

double duration(const CutPath& path) { return path.poses.back().t - path.poses.front().t; }

}  // namespace

Rigid3 poseAt(const CutPath& path, double t, bool* cuts) {
  const double at = path.poses.front().t + t;
  const auto after = std::upper_bound(path.poses.begin(), path.poses.end(), at,
                                      [](double time, const PathPose& pose) { return time < pose.t; });
  if (after == path.poses.begin() || after == path.poses.end()) {
    if (cuts) *cuts = after == path.poses.begin() ? path.cuts.front() != 0 : path.cuts.back() != 0;
    return after == path.poses.begin() ? path.poses.front().T_object_tool : path.poses.back().T_object_tool;
  }
  const PathPose &a = *(after - 1), &b = *after;
  if (cuts) *cuts = path.cuts[static_cast<std::size_t>(after - path.poses.begin() - 1)] != 0;
  return between(a.T_object_tool, b.T_object_tool, (at - a.t) / (b.t - a.t));
}

bool FeedHand::next(const StepOutput&, DeviceSample& sample) {
  if (is_over_) return false;
  sample = DeviceSample{};
  bool cuts = true;
  sample.T_world_device = poseAt(path_, t_, &cuts);
  sample.pedal = cuts ? 1 : 0;
  is_over_ = t_ >= duration(path_);
  t_ += kTick;
  return true;
}

double FeedHand::progress() const { return duration(path_) > 0 ? std::min(1.0, t_ / duration(path_)) : 1; }

ForceHand::ForceHand(const CutPath& path, const CouplingSettings& coupling, const Options& options)
    : path_(path),
      options_(options),
      lead_(options.force / coupling.stiffness),
      stiffness_(coupling.stiffness),
      farthest_(coupling.force_limit / coupling.stiffness) {
  double sum = 0;
  for (std::size_t n = 0; n < path.poses.size(); ++n) {
    if (n > 0) sum += (path.poses[n].T_object_tool.translation - path.poses[n - 1].T_object_tool.translation).norm();
    length_.push_back(sum);
  }
}

double ForceHand::progress() const { return length_.back() > 0 ? at_ / length_.back() : 1; }

bool ForceHand::next(const StepOutput& last, DeviceSample& sample) {
  sample = DeviceSample{};
  sample.pedal = 1;
  if (!has_begun_) {
    has_begun_ = true;
    sample.T_world_device = poseAt(path_, 0);
    return true;
  }

  // How far the tool has come along this stretch, never backwards; a stretch is done a micrometre before its end.
  const auto pose = [&](std::size_t n) -> const Rigid3& { return path_.poses[n].T_object_tool; };
  Vec3d along = Vec3d::Zero(), beside = Vec3d::Zero();
  double whole = 0, done = 0, turn = 0;
  for (;; ++stretch_, turned_ = 0) {
    if (stretch_ + 1 >= path_.poses.size()) {
      at_ = length_.back();
      return false;
    }
    whole = length_[stretch_ + 1] - length_[stretch_];
    beside = last.T_world_tool.translation - pose(stretch_).translation;
    const bool is_turn = whole < kNoWay;
    along =
        is_turn ? Vec3d(Vec3d::Zero()) : Vec3d((pose(stretch_ + 1).translation - pose(stretch_).translation) / whole);
    turn = is_turn ? pose(stretch_).rotation.angularDistance(pose(stretch_ + 1).rotation) : 0;
    done = along.dot(beside);
    beside -= done * along;
    if (is_turn) {
      if (turned_ < turn) break;
      continue;
    }
    // A tool that was kept off its line has not been where the stretch ends.
    if (done < whole - 1e-3 || beside.norm() > 2 * options_.off_line) break;
  }
  done = std::clamp(done, 0.0, whole);
  at_ = std::max(at_, length_[stretch_] + done);

  // Whoever feels the drive stall lets go until it is back.
  const double speed = std::abs(last.speed);
  fastest_ = std::max({fastest_, speed, options_.free_speed});
  is_stalled_ = path_.cuts[stretch_] && speed < (is_stalled_ ? kRecovered : kStalled) * fastest_;
  const bool is_coming_up = is_stalled_ && speed > last_speed_;
  last_speed_ = speed;

  const double off = beside.norm();
  if (!is_coming_up) gave_up_ = !moves(turn > 0, off);
  if (gave_up_) return false;

  // Hold the tool on its line: at once as a spring, and leaning more and more. Where nothing touches the tool the hand
  // does not stand far beside it or ahead of it: a tool that breaks through must not fly.
  const double touched = last.contact.force.norm() / stiffness_ + kUnheld;
  const double most_beside = is_stalled_ ? kLetsGo : std::min({kSideways * lead_, touched, farthest_});
  const double beyond = std::max(0.0, 1 - kNearLine * options_.off_line / std::max(off, 1e-9));
  lean_ -= kLeanRate * std::max(1.0, lead_) * kTick * beyond * beside;
  lean_ -= along.dot(lean_) * along;
  lean_ = shortened(lean_, most_beside);
  const Vec3d hold = shortened(lean_ - kHold * beside, most_beside);

  // Push on, the less the farther the tool is off its line.
  const double on_line = std::clamp(2 - off / options_.off_line, 0.0, 1.0);
  const double left = std::sqrt(std::max(0.0, farthest_ * farthest_ - hold.squaredNorm()));
  double forward = std::min({touched, on_line * lead_, left});
  if (turnsAfter(stretch_)) forward = std::min(forward, whole - done + kAheadOfTurn);
  if (is_stalled_) forward = last.touching > 0 ? -kLetsGo : 0;

  turned_ += kTurnRate * kTick;
  const double part = turn > 0 ? std::min(1.0, turned_ / turn) : done / whole;
  if (turn > 0) forward = 0;
  ahead_ = std::min(at_ + forward, std::max(ahead_, at_) + options_.feed_limit * kTick);
  sample.T_world_device = between(pose(stretch_), pose(stretch_ + 1), part);
  sample.T_world_device.translation = pose(stretch_).translation + (ahead_ - length_[stretch_]) * along + hold;
  sample.pedal = path_.cuts[stretch_] ? 1 : 0;
  return true;
}

// False: nothing has moved for `patience` seconds, neither along the way nor back to it. A tool that goes to and fro
// beside its line comes no nearer: what counts is how far off it is at most, in the later half against the earlier.
bool ForceHand::moves(bool is_turning, double off) {
  if (is_turning || at_ > watched_ + options_.stillness) {
    watched_ = at_;
    waited_ = off_early_ = off_late_ = 0;
    return true;
  }
  double& most = waited_ < 0.5 * options_.patience ? off_early_ : off_late_;
  most = std::max(most, off);
  waited_ += kTick;
  if (waited_ <= options_.patience) return true;

  const bool comes_nearer = off_late_ < 0.95 * off_early_ - options_.stillness;
  waited_ = off_early_ = off_late_ = 0;
  return comes_nearer;
}

// Whether the path takes a sharp turn where a stretch ends. Arcs are many stretches with small ones.
bool ForceHand::turnsAfter(std::size_t stretch) const {
  const auto way = [&](std::size_t n) -> Vec3d {
    return path_.poses[n + 1].T_object_tool.translation - path_.poses[n].T_object_tool.translation;
  };
  const Vec3d before = way(stretch);
  for (std::size_t n = stretch + 1; n + 1 < path_.poses.size(); ++n)
    if (const Vec3d after = way(n); after.norm() > kNoWay)
      return before.dot(after) < kSharpTurn * before.norm() * after.norm();
  return false;
}

DeviceHand::DeviceHand(const CutPath& path, const Options& options)
    : path_(path), options_(options), position_(poseAt(path, 0).translation) {
  late_.assign(static_cast<std::size_t>(std::max(options.delay_ticks, 0)), Vec3d::Zero());
}

bool DeviceHand::next(const StepOutput& last, DeviceSample& sample) {
  if (is_over_) return false;
  late_.push_back(last.force.force);
  const Vec3d force = late_.front();
  late_.erase(late_.begin());

  constexpr int kParts = 20;
  const double dt = kTick / kParts, mass = 1e-3 * options_.mass_kg;  // tonnes
  for (int n = 0; n < kParts; ++n) {
    const double t = t_ + n * dt;
    const Vec3d wanted = poseAt(path_, t).translation;
    const Vec3d speed = (poseAt(path_, t + dt).translation - wanted) / dt;
    // Spring and dampers implicitly; Coulomb friction takes what it can without turning the motion round.
    const double k = options_.hand_stiffness, b = options_.hand_damping + options_.damping;
    Vec3d v = (mass * velocity_ + dt * (force + k * (wanted - position_) + options_.hand_damping * speed)) /
              (mass + dt * b + dt * dt * k);

    const double most = dt * options_.friction / mass;
    const double moving = v.norm();
    const Vec3d after = moving <= most ? Vec3d(Vec3d::Zero()) : Vec3d(v * (1 - most / moving));

    const Vec3d way = dt * after;
    work_ += force.dot(way);
    lost_ += options_.damping * after.squaredNorm() * dt + options_.friction * way.norm();
    velocity_ = after;
    position_ += way;
  }
  t_ += kTick;
  is_over_ = t_ >= duration(path_);

  // What the encoder says; the turn and the pedal are the path's.
  sample = DeviceSample{};
  bool cuts = true;
  sample.T_world_device = poseAt(path_, t_, &cuts);
  sample.pedal = cuts ? 1 : 0;
  sample.T_world_device.translation = position_;
  if (const double q = options_.encoder_mm; q > 0)
    sample.T_world_device.translation = q * (position_ / q).array().round().matrix();
  return true;
}

double DeviceHand::progress() const { return duration(path_) > 0 ? std::min(1.0, t_ / duration(path_)) : 1; }

}  // namespace kerf
