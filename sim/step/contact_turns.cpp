#include "sim/step/contact_turns.h"

#include <algorithm>
#include <cmath>

#include "sim/step/coupling.h"

namespace kerf {
namespace {

constexpr bool has(std::uint32_t groups, int group) { return (groups >> group & 1) != 0; }

// The evaluation in a cycle, from 0, that has a group's turn.
constexpr int placeIn(int length, int group) { return group * length / ContactTurns::kGroups; }

int evaluationsFor(double work) {
  const double wanted = std::ceil(work / ContactTurns::kBudget);
  return static_cast<int>(std::clamp(wanted, 2.0, double{ContactTurns::kMostInACycle}));
}

// Elapsed fraction of the time between two turns.
double shareOf(const ContactTurns::Group& group, double clock) {
  const double length = group.until - group.from;
  return length > 0 ? std::clamp((clock - group.from) / length, 0.0, 1.0) : 1;
}

}  // namespace

bool ContactTurns::begin(std::uint32_t epoch) noexcept {
  if (cycle_.epoch != epoch) {
    cycle_ = {};
    cycle_.epoch = epoch;
  }
  return isActive();
}

void ContactTurns::weigh(double work) noexcept {
  if (!(work > kEnter)) return;
  const std::uint32_t epoch = cycle_.epoch;
  cycle_ = {};
  cycle_.epoch = epoch;
  cycle_.next = evaluationsFor(work);
  groups_ = {};  // all groups are due
}

// Plans the group's next turn, and the duration of its erosion.
void ContactTurns::planTurn(int number, const ContactInput& in, double limit_mm, double way_mm) noexcept {
  Group& group = groups_[static_cast<std::size_t>(number)];
  const int place = placeIn(cycle_.length, number);
  int hold = cycle_.at < place ? place - cycle_.at : cycle_.length - cycle_.at + placeIn(cycle_.next, number);
  if (way_mm * hold > limit_mm) hold = std::max(1, static_cast<int>(limit_mm / way_mm));

  const double eroded_until = group.until;
  group.pose = in.T_object_tool;
  group.way = cycle_.way;
  group.from = cycle_.clock;
  group.until = std::max(eroded_until, cycle_.clock + hold * in.dt);
  group.erodes = group.until - eroded_until;
  group.due = cycle_.count + hold;
}

// The group's sums, carried from its last turn to now.
ContactSums ContactTurns::carried(const Group& group, const Rigid3& pose, double dt) const noexcept {
  Vector6d moved;
  moved << pose.translation - group.pose.translation, rotationBetween(group.pose.rotation, pose.rotation);
  const ContactSums& then = group.sums;
  const double now = shareOf(group, cycle_.clock), next = shareOf(group, cycle_.clock + dt);
  const double follows = then.load_slope.dot(moved);
  const auto loadAt = [&](double share) {
    return then.normal_load + share * (then.load_next - then.normal_load) - follows;
  };

  // Scales the values that grow with the pressure; clears all if contact is lost.
  ContactSums out = then;
  const double load = loadAt(now);
  const bool is_lost = !(then.normal_load > 0 && load > 0);
  out.scale(is_lost ? 0 : load / then.normal_load);
  if (is_lost) {
    out.area = out.material_area = out.deepest = 0;
    out.touching = 0;
    return out;
  }

  const Vector6d elastic = then.stiffness * moved;
  const auto at = [](const Vec3d& from, const Vec3d& to, const Vec3d& jump, double share) {
    return Vec3d(from + share * (to - from) + (1 - share) * jump);
  };
  out.force = at(then.force, then.force_next, group.jump.force, now) - elastic.head<3>();
  out.torque = at(then.torque, then.torque_next, group.jump.torque, now) - elastic.tail<3>();
  out.force_next = at(then.force, then.force_next, group.jump.force, next) - elastic.head<3>();
  out.torque_next = at(then.torque, then.torque_next, group.jump.torque, next) - elastic.tail<3>();
  out.stiffness = then.stiffness;
  out.load_slope = then.load_slope;
  out.load_next = loadAt(next);
  return out;
}

// Difference of the sums before a turn and those of the turn; limited to a part of the load.
Wrench ContactTurns::jumpBetween(const ContactSums& before, const ContactSums& after) noexcept {
  constexpr double kMostJump = 0.25;
  Wrench jump{before.force - after.force, before.torque - after.torque};
  const double size = jump.force.norm(), most = kMostJump * after.normal_load;
  if (size > most) {
    jump.force *= most / size;
    jump.torque *= most / size;
  }
  return jump;
}

std::uint32_t ContactTurns::sum(CutObject& object, const NearBricks& near, NearBricks& turn, const ContactInput& in,
                                double limit_mm, ContactSums& sums) noexcept {
  double way = 0;
  if (cycle_.count > 0)
    way = (in.T_object_tool.translation - cycle_.pose.translation).norm() +
          in.tool->reach_mm * rotationBetween(cycle_.pose.rotation, in.T_object_tool.rotation).norm();
  cycle_.way += way;
  cycle_.pose = in.T_object_tool;

  std::uint32_t now = 0;
  for (int g = 0; g < kGroups; ++g) {
    const Group& group = groups_[static_cast<std::size_t>(g)];
    const bool is_due = cycle_.count >= group.due || cycle_.way - group.way > limit_mm;
    now |= std::uint32_t{is_due} << g;
  }

  // Without memory a shell stays dirty; forEachTouching() reads its nodes with current values.
  is_short_ = !object.repair([now](int slot) { return has(now, groupOf(slot)); });

  for (int g = 0; g < kGroups; ++g) {
    Group& group = groups_[static_cast<std::size_t>(g)];
    ContactSums of_group = carried(group, in.T_object_tool, in.dt);
    if (has(now, g)) {
      planTurn(g, in, limit_mm, way);
      ContactInput until_next = in;
      until_next.dt = group.erodes;
      turn.take(near, [g](int slot) { return groupOf(slot) == g; });
      group.sums = {};
      sumContact(object, turn, until_next, group.sums);
      group.jump = cycle_.count > 0 ? jumpBetween(of_group, group.sums) : Wrench{};
      of_group = carried(group, in.T_object_tool, in.dt);
    } else {
      of_group.tested = 0;
      of_group.cut_by_shell = 0;  // of this evaluation alone
    }
    sums.add(of_group);
  }
  return now;
}

CutResult ContactTurns::erode(CutObject& object, const NearBricks& near, NearBricks& turn, const ContactInput& in,
                              std::uint32_t groups) noexcept {
  CutResult out;
  out.pool_ran_out = is_short_;
  for (int g = 0; g < kGroups; ++g) {
    if (!has(groups, g)) continue;
    Group& group = groups_[static_cast<std::size_t>(g)];
    ContactInput until_next = in;
    until_next.dt = group.erodes;
    turn.take(near, [g](int slot) { return groupOf(slot) == g; });
    const CutResult cut = kerf::erode(object, turn, until_next);
    group.work = workOf(group.sums.touching, cut.bricks);
    out.removed_mm3 += cut.removed_mm3;
    out.bricks += cut.bricks;
    out.pool_ran_out |= cut.pool_ran_out;
  }
  endEvaluation(in.dt);
  return out;
}

bool ContactTurns::isUsable() const noexcept {
  const auto isInACycle = [](std::int32_t n) { return n >= 1 && n <= kMostInACycle; };
  bool is_good = isInACycle(cycle_.length) && isInACycle(cycle_.next) && cycle_.at >= 0 && cycle_.at < cycle_.length &&
                 cycle_.count >= 0 && cycle_.pose.isUsable();
  constexpr int kMostNodes = 1 << 24;  // of one group: more than the nodes of all near slots
  constexpr double kLongestTurn = 1;   // s
  for (const Group& group : groups_)
    is_good = is_good && group.pose.isUsable() && group.due >= 0 && group.due <= cycle_.count + 2 * kMostInACycle &&
              group.until <= cycle_.clock + kLongestTurn && group.sums.touching <= kMostNodes &&
              group.sums.tested <= kMostNodes;
  return is_good;
}

void ContactTurns::endEvaluation(double dt) noexcept {
  cycle_.clock += dt;
  ++cycle_.count;
  if (++cycle_.at < cycle_.length) return;

  double work = 0;
  for (const Group& group : groups_) work += group.work;
  cycle_.at = 0;
  cycle_.length = cycle_.next;
  cycle_.next = work < kLeave ? 1 : evaluationsFor(work);
}

}  // namespace kerf
