#include "sim/hand/virtual_hand.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

Rigid3 between(const Rigid3& a, const Rigid3& b, double s) {
  return {a.rotation.slerp(s, b.rotation), a.translation + s * (b.translation - a.translation)};
}

constexpr double kEnd = 1e-3;       // mm: nearer than this to its end a stretch is done
constexpr double kOnLine = 0.03;    // mm: a tool nearer to its line goes on to the next stretch
constexpr double kArrived = 0.01;   // mm from the end of the path
constexpr double kUnheld = 0.3;     // N: least force that moves and brakes a tool without contact
constexpr double kLeanRate = 60;    // 1/s: rate at which a hand leans against forces that push the tool off its line
constexpr double kLeanWait = 10;    // 1/s: the same while the tool hardly moves
constexpr double kTurnRate = 1;     // rad/s: turns on the spot
constexpr double kStalled = 0.02;   // of the highest speed of the drive: below it a hand lets go
constexpr double kRecovered = 0.5;  // above it the hand pushes again
constexpr double kLetsGo = 0.1;     // N of drawing back, and of holding to a side
constexpr double kFront = 0.75;     // of the overlap: a stretch ends when this share of it is cut
constexpr double kMean = 0.03;      // mm of the way: averaging length of the removed and the remaining volume
constexpr double kQuick = 0.1;      // largest new part of a mean in a tick
constexpr double kSlow = 0.005;     // and the smallest
constexpr double kNothing = 1e-8;   // mm^3 a tick: a tool that leaves less hardly moves, and does not skid
constexpr double kFriction = 0.15;  // of a spinning tool: this share of a force may be drag, without pressure
constexpr double kSkids = 0.46;     // a tool that removes a smaller share of its way is pushed down instead of on

constexpr double kNoWay = 1e-9;  // mm: shorter stretches are turns on the spot

Vec3d shortened(const Vec3d& v, double most) {
  const double size = v.norm();
  return size > most ? Vec3d(v * (most / size)) : v;
}

Vec3d across(const Vec3d& v, const Vec3d& unit) { return v - unit.dot(v) * unit; }

double duration(const CutPath& path) { return path.poses.back().t - path.poses.front().t; }

double lengthAfter(const CutPath& path, double t) {
  double sum = 0;
  Vec3d at = poseAt(path, t).translation;
  for (const PathPose& pose : path.poses) {
    if (pose.t <= path.poses.front().t + t) continue;
    sum += (pose.T_object_tool.translation - at).norm();
    at = pose.T_object_tool.translation;
  }
  return sum;
}

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

double FeedHand::left() const { return lengthAfter(path_, t_); }

ForceHand::ForceHand(const CutPath& path, const CouplingSettings& coupling, const Options& options)
    : path_(path),
      options_(options),
      stiffness_(coupling.stiffness),
      lead_(options.force / coupling.stiffness),
      tip_(path.poses.front().T_object_tool.translation) {
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
  const Vec3d moved = last.T_world_tool.translation - tip_;
  tip_ = last.T_world_tool.translation;

  // Progress of the tool along this stretch, never backwards. With tissue in front of it, the tool goes on until the
  // stretch is cut to its end.
  const auto pose = [&](std::size_t n) -> const Rigid3& { return path_.poses[n].T_object_tool; };
  Vec3d along = Vec3d::Zero(), beside = Vec3d::Zero();
  double whole = 0, done = 0, turn = 0, left = 0;
  for (;; ++stretch_, turned_ = 0) {
    if (stretch_ + 1 >= path_.poses.size()) return settle(last, sample);
    whole = length_[stretch_ + 1] - length_[stretch_];
    beside = tip_ - pose(stretch_).translation;
    const bool is_turn = whole < kNoWay;
    along =
        is_turn ? Vec3d(Vec3d::Zero()) : Vec3d((pose(stretch_ + 1).translation - pose(stretch_).translation) / whole);
    turn = is_turn ? pose(stretch_).rotation.angularDistance(pose(stretch_ + 1).rotation) : 0;
    done = along.dot(beside);
    beside = across(beside, along);
    left = is_turn ? 0 : whole - done + kFront * std::max(0.0, -along.dot(overlapOf(last)));
    if (is_turn) {
      if (turned_ < turn) break;
      continue;
    }
    // A tool kept off its line has not reached the end of the stretch.
    if (left > kEnd || (beside + across(film_, along)).norm() > kOnLine) break;
  }
  const double gone = std::clamp(whole - left, 0.0, whole);
  at_ = std::max(at_, length_[stretch_] + gone);

  // Lets go when the drive stalls, until it is back.
  const double speed = std::abs(last.speed);
  fastest_ = std::max({fastest_, speed, options_.free_speed});
  is_stalled_ = path_.cuts[stretch_] && speed < (is_stalled_ ? kRecovered : kStalled) * fastest_;
  const bool is_coming_up = is_stalled_ && speed > last_speed_;
  last_speed_ = speed;
  has_come_up_ = path_.cuts[stretch_] && (has_come_up_ || !is_stalled_);

  const double share = feelFilm(last, along, moved);
  const Vec3d off = beside + film_;
  if (has_come_up_ || !is_coming_up) gave_up_ = !moves(turn > 0, off.norm());
  if (gave_up_) return false;

  // Hold the tool where it cuts on its line: at once as a spring, and leaning more and more. The coupling is the
  // spring.
  const double least = last.touching > 0 ? 0 : kUnheld / stiffness_;
  const double most = is_stalled_ ? kLetsGo / stiffness_ : std::max(lead_, least);
  lean_ -= std::min(kLeanRate * kTick, kLeanWait * kTick + moved.norm() / lead_) * off;
  lean_ = shortened(across(lean_, along), most);
  const bool pushes = turn == 0 && left > kEnd;
  Vec3d hold = shortened(lean_ - off + (pushes ? 0 : left) * along, most);

  // Push on with the rest of the force. A skidding tool is pushed into the tissue instead of along it.
  double forward = along.dot(hold);
  if (pushes) {
    const double rest = std::sqrt(std::max(0.0, most * most - hold.squaredNorm()));
    const double moves_on = std::clamp(along.dot(moved), 0.0, options_.feed_limit * kTick);
    const Vec3d under = across(overlap_, along);
    const double skids = std::max(0.0, 1 - (1 - share) / kSkids) * under.norm() / std::max(overlap_.norm(), kNoWay);
    forward = (1 - skids) * (rest + moves_on);
    const double pull = forward - moves_on;
    const Vec3d press = -std::sqrt(std::max(0.0, rest * rest - pull * pull)) * under.normalized();
    hold = shortened(hold + press, std::sqrt(std::max(0.0, most * most - pull * pull)));
  }
  if (is_stalled_) forward = last.touching > 0 ? -most : 0;

  turned_ += kTurnRate * kTick;
  const double part = turn > 0 ? std::min(1.0, turned_ / turn) : gone / whole;
  const double now = length_[stretch_] + done;
  ahead_ = std::min(now + forward, std::max(ahead_, now) + options_.feed_limit * kTick);
  sample.T_world_device = between(pose(stretch_), pose(stretch_ + 1), part);
  sample.T_world_device.translation =
      pose(stretch_).translation + (ahead_ - length_[stretch_]) * along + beside + across(hold, along);
  sample.pedal = path_.cuts[stretch_] ? 1 : 0;
  return true;
}

// At the end of the path the tool returns from the tissue that it was pushed into.
bool ForceHand::settle(const StepOutput& last, DeviceSample& sample) {
  at_ = length_.back();
  const Rigid3& end = path_.poses.back().T_object_tool;
  const Vec3d off = tip_ - end.translation;
  if (off.norm() <= kArrived) return false;
  const bool comes_nearer = moves(false, off.norm());
  gave_up_ = !comes_nearer && off.norm() > kOnLine;
  if (!comes_nearer) return false;

  const double most = std::max(lead_, last.touching > 0 ? 0 : kUnheld / stiffness_);
  sample.T_world_device = end;
  sample.T_world_device.translation = tip_ - shortened(off, std::min(most, options_.feed_limit * kTick));
  sample.pedal = path_.cuts.back() ? 1 : 0;
  return true;
}

// Overlap of the tool with the tissue, out of it, mm.
Vec3d ForceHand::overlapOf(const StepOutput& last) {
  const double force = last.contact.force.norm();
  return force > 0 ? Vec3d(last.contact.force * (last.deepest / force)) : Vec3d(Vec3d::Zero());
}

// A pushed tool overlaps with the tissue until that is eroded. It removes a part of the section in its way, and leaves
// the same part of the overlap as of the section. That is the film. A drive that is off leaves none.
// @return the share that the tool leaves, 0 in air.
double ForceHand::feelFilm(const StepOutput& last, const Vec3d& along, const Vec3d& moved) {
  if (!path_.cuts[stretch_]) {
    leaves_ = removed_ = 0;
    overlap_ = film_ = Vec3d::Zero();
    return 0;
  }
  const double fresh = std::clamp(moved.norm() / kMean, kSlow, kQuick);
  leaves_ += fresh * (2 * along.dot(moved) * last.deepest * std::sqrt(last.area) - leaves_);
  removed_ += fresh * (last.removed_mm3 - removed_);
  overlap_ += fresh * (overlapOf(last) - overlap_);
  const double share = leaves_ > 0 ? leaves_ / (leaves_ + std::max(0.0, removed_) + kNothing) : 0;

  // Across the tool's axis the drag of a spinning tool is a part of the force.
  film_ = across(share * overlap_, along);
  const Vec3d axis = last.T_world_tool.rotation * Vec3d::UnitZ();
  const Vec3d aside = across(film_, axis);
  const double pressure = aside.norm() - kFriction * share * overlap_.norm();
  film_ += (pressure > 0 ? pressure / aside.norm() - 1 : -1) * aside;
  return last.touching > 0 ? share : 0;
}

// False: nothing has moved for `patience` seconds, neither along the way nor back to it. A tool that goes to and fro
// beside its line comes no nearer: the largest distance counts, in the later half against the earlier.
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
    // Spring and dampers implicitly; Coulomb friction slows the motion but does not reverse it.
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

  // The encoder's reading; the turn and the pedal are the path's.
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

double DeviceHand::left() const { return lengthAfter(path_, t_); }

}  // namespace kerf
