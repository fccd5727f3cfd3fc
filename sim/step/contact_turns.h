// Contacts too large for a tick: their bricks are evaluated in turns, which bounds the time of a tick.
//
// The cost of an evaluation of contact grows with the area in contact: a ball of 6 mm sunk 2 mm at voxels of 0.05 mm
// changes 600 bricks. If the work exceeds a budget, the bricks are divided into kGroups by their number, and each
// evaluation of contact takes some of the groups. A cycle of k evaluations gives every group its turn. k follows from
// the work counted in the cycle before, never from a clock: the same input gives the same bits.
//
// At its turn a group is evaluated for the whole time until its next turn: the mean pressure and the erosion of that
// time T (ContactInput::dt). So p T = k_n d (1 - exp(-c T)) / c is the work for the erosion, as in one tick: the
// removal law holds for any k. Until its next turn the group's force goes from one sum to the next in a straight line,
// and follows the tool by its stiffness, to the first order:
//
//   F(t) = F + a (F_next - F) - K x,   a = (t - t0) / T,   x the motion of the tool since t0
//
// F_next, K: ContactSums::force_next, stiffness. At the end of T this nearly equals the result of the next evaluation.
// The difference (nodes that came into contact meanwhile) is blended in until the turn after it. Loads and drag scale
// with the normal load, which follows the same law. A group with a load of zero has lost contact. Between two turns the
// tool moves at most half a voxel or longestSubstep(): a fast tool pays for all its contact. The time of erosion is
// booked, so that each moment counts once.
//
// The shells of a group are repaired at its turn (CutObject::repair(wanted)): nothing else in the step reads them.
//
// Ordinary contacts never take turns: see kEnter.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "sim/step/contact.h"

namespace kerf {

/// The turns of one object's bricks. Belongs to State. All of it is @rt.
class ContactTurns {
 public:
  static constexpr int kGroups = 32;
  /// Most contact evaluations in a cycle: 16 ms.
  static constexpr int kMostInACycle = 16;
  /// Work is in microseconds of a slow core. Above kEnter bricks take turns, with about kBudget an evaluation; below
  /// kLeave they stop.
  static constexpr double kEnter = 800, kBudget = 250, kLeave = 600;

  /// Estimated cost of an evaluation.   @param cut  bricks that erosion changed.
  /// Independent of sleeping bricks: a session restored from a snapshot is awake, and must get the same result.
  static double workOf(int touching, int cut) noexcept { return 0.025 * touching + 3.5 * cut; }
  /// Group of a brick, by its slot: neighbours are in different groups.
  static int groupOf(int slot) noexcept {
    return static_cast<int>(static_cast<std::uint32_t>(slot) * 2654435769u >> 27);
  }

  /// State of a group at its last turn.
  struct Group {
    ContactSums sums;            ///< object frame
    Rigid3 pose;                 ///< T_object_tool
    double way = 0;              ///< Cycle::way
    double from = 0, until = 0;  ///< Cycle::clock at that turn and at the next one, s. It is eroded up to `until`
    double erodes = 0;           ///< duration of erosion in that turn, s
    Wrench jump;                 ///< force before that turn minus force after it; fades until the next one
    double work = 0;             ///< of that turn: workOf()
    std::int64_t due = 0;        ///< number of the evaluation of its next turn: Cycle::count
  };

  /// Whether the next evaluation goes by turns. @param epoch  CutObject::contact_epoch: a change makes earlier
  /// knowledge of the contact void.
  bool begin(std::uint32_t epoch) noexcept;
  /// The work of an evaluation without turns: decides whether the next one takes turns.
  void weigh(double work) noexcept;

  /// One evaluation of contact by turns.
  /// @param near  all bricks near the tool.   @param turn  scratch.   @param limit_mm  see above.
  /// @param sums  current, of all groups.   @return the evaluation's groups, a bit each.
  std::uint32_t sum(CutObject& object, const NearBricks& near, NearBricks& turn, const ContactInput& in,
                    double limit_mm, ContactSums& sums) noexcept;
  /// Erodes those groups, and ends the evaluation.
  CutResult erode(CutObject& object, const NearBricks& near, NearBricks& turn, const ContactInput& in,
                  std::uint32_t groups) noexcept;

  // The state, for storage and hashing.

  struct Cycle {
    std::int32_t length = 1, next = 1;  ///< evaluations in this cycle, in the next
    std::int32_t at = 0;                ///< finished evaluations of this cycle
    std::uint32_t epoch = 0;
    std::int64_t count = 0;  ///< finished evaluations
    double clock = 0;        ///< their time, s
    double way = 0;          ///< largest motion of any part of the tool since the first, mm
    Rigid3 pose;             ///< T_object_tool in the last one
  };
  using Groups = std::array<Group, kGroups>;
  bool isActive() const noexcept { return cycle_.length > 1 || cycle_.next > 1; }
  /// Unless earlier knowledge is void.
  bool isActiveFor(const CutObject& object) const noexcept {
    return isActive() && cycle_.epoch == object.contactEpoch();
  }
  const Cycle& cycle() const noexcept { return cycle_; }
  const Groups& groups() const noexcept { return groups_; }
  /// Calls number(double&) for all of these values in one order: integers become doubles and back, exactly.
  template <class Number>
  void forEachNumber(const Number& number) noexcept;
  /// Whether the numbers are valid for turns. @pre they are finite.
  bool isUsable() const noexcept;
  /// Forgets the contact: another object is in this place. @rt
  void forget() noexcept { cycle_ = {}; }
  /// For an object that was made anew in its current state.
  void belongTo(std::uint32_t epoch) noexcept { cycle_.epoch = epoch; }

 private:
  /// @param way_mm  of the tool since the last evaluation.
  void planTurn(int number, const ContactInput& in, double limit_mm, double way_mm) noexcept;
  ContactSums carried(const Group& group, const Rigid3& pose, double dt) const noexcept;
  static Wrench jumpBetween(const ContactSums& before, const ContactSums& after) noexcept;
  void endEvaluation(double dt) noexcept;

  Cycle cycle_;
  Groups groups_;
  bool is_short_ = false;  // of memory for shells, in the current evaluation
};

template <class Number>
void ContactTurns::forEachNumber(const Number& number) noexcept {
  const auto integer = [&](auto& value) {
    double as_double = static_cast<double>(value);
    number(as_double);
    using Limits = std::numeric_limits<std::remove_reference_t<decltype(value)>>;
    constexpr double kMost = std::min(static_cast<double>(Limits::max()), 1e15);
    as_double = std::clamp(as_double, 0.0, kMost);  // none of them is negative
    value = static_cast<std::remove_reference_t<decltype(value)>>(as_double);
  };
  const auto all = [&](auto& values) {
    for (Eigen::Index n = 0; n < values.size(); ++n) number(values.data()[n]);
  };
  const auto pose = [&](Rigid3& p) {
    all(p.rotation.coeffs());
    all(p.translation);
  };

  integer(cycle_.length);
  integer(cycle_.next);
  integer(cycle_.at);
  integer(cycle_.count);
  number(cycle_.clock);
  number(cycle_.way);
  pose(cycle_.pose);
  for (Group& group : groups_) {
    ContactSums& s = group.sums;
    for (Vec3d* v : {&s.force, &s.torque, &s.force_next, &s.torque_next, &s.drag_moment}) all(*v);
    all(s.stiffness);
    all(s.load_slope);
    all(s.drag_second);
    all(s.normal_drag);
    for (double* v : {&s.load_next, &s.drag, &s.normal_load, &s.cutting_load, &s.erodible_load, &s.bare_load,
                      &s.bare_erodible, &s.bare_drive_load, &s.lip_torque, &s.drive_load, &s.power, &s.area, &s.deepest,
                      &s.material_area, &group.way, &group.from, &group.until, &group.erodes, &group.work})
      number(*v);
    integer(s.tested);
    integer(s.touching);
    integer(s.material);
    integer(group.due);
    all(group.jump.force);
    all(group.jump.torque);
    pose(group.pose);
  }
}

}  // namespace kerf
