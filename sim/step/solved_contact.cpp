// Contact by constraints and by impulses. Methods and sources: sim/step/response.h.

#include <algorithm>
#include <cmath>

#include "sim/step/contact_evaluation.h"
#include "sim/step/contact_points.h"

namespace kerf {
namespace {

constexpr double kTakenBack = 0.2;       // fraction of the overlap beyond the skin, per evaluation
constexpr double kMostTakenBack = 0.02;  // mm per evaluation
constexpr double kEven = 0.2;            // softness of the recovery: between two walls the middle
constexpr double kDeepest = 0.1;         // mm: largest overlap of a cutting part, for enough to remove

// The diagonal of a matrix of the coupling: translation three times, rotation three times.
Vector6d sixOf(double along, double about) {
  Vector6d d;
  d << along, along, along, about, about, about;
  return d;
}

/// One evaluation of contact. Its phases, in order, are the public functions.
class ContactSolver {
 public:
  ContactSolver(const Model& model, State& state, const Substep& substep, bool is_proxy)
      : model_(model),
        state_(state),
        tool_(model.tools[state.tool]),
        is_proxy_(is_proxy),
        start_(state.body.pose),
        dt_(substep.dt),
        longest_(substep.longest_mm),
        device_way_(substep.device_way_mm),
        coupling_(substep.coupling),
        reach_(tool_.cut.reach()),
        per_(is_proxy_ ? 1 : substep.dt) {
    erosions_.fill({});
  }

  /// Without contact: A y = b, y a motion (proxy) or a velocity (body).
  void setUp() {
    const CouplingSettings& c = coupling_;
    const double damped = is_proxy_ && model_.settings.rendering == Rendering::kDirect ? 0 : 1;
    const Vector6d stiffness = sixOf(c.stiffness, c.turn_stiffness);
    const Vector6d damping = damped * sixOf(c.damping, c.turn_damping);
    Vector6d device_twist;
    device_twist << state_.device.velocity, state_.device.angular;
    twist_ << state_.body.velocity, state_.body.angular;
    metric_ = sixOf(c.mass(), c.inertia());
    b_ = springPull(start_, state_.device, c) + damping.cwiseProduct(device_twist);
    a_.setZero();

    if (!is_proxy_) {
      b_ = metric_.cwiseProduct(twist_) + dt_ * b_;
      a_.diagonal() = metric_ + dt_ * damping + dt_ * dt_ * stiffness;
      return;
    }

    metric_ = stiffness;
    a_.diagonal() = stiffness + damping / dt_;
    // Without a limit a proxy, which has no mass, would look ahead as far as the hand pulls it. It looks ahead only as
    // far as its speed and the device's may take it, so that few bricks are near, and twice that, so that it can catch
    // up.
    double way = 2 * std::max(device_way_, dt_ * wayOf(twist_));
    for (const CutObject& object : state_.objects) way = std::max(way, 4 * contactSkin(object.voxel()));
    longest_ = std::min(longest_, way);
  }

  /// Finds the points that the tool touches or would meet on its way without contact.
  void gather() {
    ahead_ = per_ * b_.cwiseQuotient(a_.diagonal());
    if (const double way = wayOf(ahead_); way > longest_) ahead_ *= longest_ / way;

    state_.body.pose = {rotated(start_.rotation, ahead_.tail<3>()), start_.translation + ahead_.head<3>()};
    countTravelFrom(start_);
    for (std::size_t n = 0; n < state_.objects.size(); ++n) {
      const ContactInput in = inputOf(n);
      out_.sums.tested += points_.gather(state_.objects[n], static_cast<int>(n), nearOf(n, in), in);
    }

    const Rigid3 there = state_.body.pose;
    state_.body.pose = start_;
    countTravelFrom(there);
    near_of_ = kNone;
    for (int n = 0; n < points_.size(); ++n) {
      Erosion& erosion = *erosionOf(static_cast<std::size_t>(points_[n].object));
      erosion.allowed = contactSkin(state_.objects[static_cast<std::size_t>(points_[n].object)].voxel());
    }
  }

  /// Solves for the loads at the points and for the motion.
  void solve() {
    for (int n = 0; n < points_.size(); ++n) {
      const auto at = static_cast<std::size_t>(n);
      const ContactPoint& p = points_[n];
      const Vector6d u = p.direction();
      const auto object = static_cast<std::size_t>(p.object);
      const double allowed = p.cuts ? erosionOf(object)->allowed : contactSkin(state_.objects[object].voxel());
      // How far the tool must move out here, from its place; negative: how far it may come in.
      const double out = u.dot(ahead_) - (p.gap + allowed) / p.slope;
      // Existing overlap makes no load: walls on both sides would make any load.
      overlap_[at] = std::max(out, 0.0);
      least_[at] = std::min(out, 0.0) / per_;
      if (const double coming = u.dot(twist_); !is_proxy_ && coming < least_[at])
        least_[at] = std::max(least_[at], -model_.settings.restitution * coming);
    }

    loads_.solve(a_, b_, points_, least_, 0);
  }

  /// Sums pressure and drag at the tool's place, scaled to the solved load. Then puts the drag into A and b, and allows
  /// a cutting part the overlap it needs.
  void sumContacts() {
    for (std::size_t n = 0; n < state_.objects.size(); ++n) {
      CutObject& object = state_.objects[n];
      const ContactInput in = inputOf(n);
      ContactSums sums;
      sumContact(object, nearOf(n, in), in, sums);

      if (Erosion* erosion = erosionOf(n)) {
        erosion->still = sums.erodible_load;
        erosion->rate = relaxationRate(sums.cutting_load, sums.erodible_load);
        // Deep enough for half of it to go in an evaluation: volume grows with the square of the depth of a ball.
        const double share = erosion->still > 0 ? cuttingOf(n) * erosion->rate / erosion->still : 0;
        const double wanted = 1.5 * sums.deepest * std::sqrt(2 * std::min(share, 2.0));
        erosion->allowed = std::max(erosion->allowed, std::min(wanted, kDeepest));
      }

      if (sums.touching > 0 || loadOf(n) > 0) out_.objects_touched |= objectBit(n);
      sums.scale(sums.normal_load > 0 ? loadOf(n) / sums.normal_load : 0);
      out_.sums.add(sums.rotated(object.T_world_object.rotation.toRotationMatrix()));
    }

    own_ = ownDrag(tool_, start_, state_.speed, out_.sums);
    drag_ = out_.sums.dragMatrix();
    a_ += (is_proxy_ ? 1 / dt_ : dt_) * drag_;
    b_.head<3>() += per_ * own_.force;
    b_.tail<3>() += per_ * own_.torque;
  }

  /// Erodes by the solved load. Last object first: its bricks were found last.
  void erodeAll() {
    for (std::size_t n = state_.objects.size(); n-- > 0;) {
      CutObject& object = state_.objects[n];
      ContactInput in = inputOf(n);
      if (!in.geometry_only) {
        const double cutting = cuttingOf(n);
        if (!(cutting > 0)) continue;  // a load has a point, and so an Erosion
        const Erosion& erosion = *erosionOf(n);
        in.load_scale = erosionScale(cutting, erosion.rate, erosion.still);
      }
      finishCut(object, erode(object, nearOf(n, in), in), out_);
    }
  }

  /// Moves the tool by the solution, and reduces the overlap by a part.
  void move() {
    const auto setVelocity = [&](const Vector6d& v) {
      state_.body.velocity = v.head<3>();
      state_.body.angular = v.tail<3>();
    };

    ContactLoads back;
    for (std::size_t n = 0; n < overlap_.size(); ++n)
      least_[n] = std::min(kTakenBack * overlap_[n], kMostTakenBack) / per_;
    back.solve(metric_.asDiagonal(), Vector6d::Zero(), points_, least_, kEven / metric_[0]);

    setVelocity(per_ / dt_ * (loads_.motion() + back.motion()));
    const double kept = travel(state_.body, reach_, longest_, dt_);
    out_.is_free = kept == 1 && loads_.total() == 0 && out_.sums.drag == 0;
    setVelocity(kept * per_ / dt_ * loads_.motion());  // the recovery from overlap is no velocity
    countTravelFrom(start_);
  }

  /// The evaluation, with the solved loads and drag.
  const ContactEvaluation& result() {
    const double solved = loads_.total() / per_;
    double cutting = 0;
    for (std::size_t n = 0; n < state_.objects.size(); ++n) cutting += cuttingOf(n);

    const Vector6d push = loads_.push(points_) / per_;
    out_.contact = contactWrench(state_.body, {push.head<3>(), push.tail<3>()}, own_, drag_);
    if (out_.sums.normal_load > 0) out_.sums.scale(solved / out_.sums.normal_load);
    out_.sums.normal_load = solved;
    out_.sums.cutting_load = cutting;
    return out_;
  }

 private:
  /// Erosion of one object.
  struct Erosion {
    double still = 0;    ///< cutting load before erosion, at a scale of 1, N
    double rate = 0;     ///< rate times time
    double allowed = 0;  ///< overlap, mm
  };

  double wayOf(const Vector6d& motion) const { return motion.head<3>().norm() + reach_ * motion.tail<3>().norm(); }
  ContactInput inputOf(std::size_t object) const { return contactInput(model_, state_, state_.objects[object], dt_); }

  /// Bricks of an object near the tool. Repeated calls for the same object reuse the search.
  const NearBricks& nearOf(std::size_t object, const ContactInput& in) {
    if (object != near_of_) {
      if (!state_.near.find(state_.objects[object], tool_, in.T_object_tool)) out_.status |= kStepNearRanOut;
      out_.bricks_near += static_cast<int>(state_.near.size());
      near_of_ = object;
    }
    return state_.near;
  }

  /// Adds the tool's motion to the objects: see CutObject::odometer.
  void countTravelFrom(const Rigid3& from) {
    const double way = (state_.body.pose.translation - from.translation).norm() +
                       tool_.reach_mm * rotationBetween(from.rotation, state_.body.pose.rotation).norm() + 1e-9;
    for (CutObject& object : state_.objects) object.odometer += way;
  }

  /// Stored with the object's first point; null: the object has no point and no load.
  Erosion* erosionOf(std::size_t object) {
    for (int n = 0; n < points_.size(); ++n)
      if (points_[n].object == static_cast<int>(object)) return &erosions_[static_cast<std::size_t>(n)];
    return nullptr;
  }

  double loadOf(std::size_t object) const { return loads_.ofObject(points_, static_cast<int>(object)) / per_; }
  double cuttingOf(std::size_t object) const { return loads_.ofCutting(points_, static_cast<int>(object)) / per_; }

  static constexpr std::size_t kNone = ~std::size_t{0};
  const Model& model_;
  State& state_;
  const ToolModel& tool_;
  const bool is_proxy_;
  const Rigid3 start_;
  const double dt_;
  double longest_;
  const double device_way_;
  const CouplingSettings& coupling_;
  const double reach_;
  const double per_;  // effect of a load on b
  ContactEvaluation out_;
  std::size_t near_of_ = kNone;  // object of the bricks in state_.near, at the body's pose
  Matrix6d a_, drag_;
  Vector6d b_, metric_, twist_, ahead_;
  Wrench own_;
  ContactPoints points_;
  ContactLoads::Row least_{}, overlap_{};
  ContactLoads loads_;
  std::array<Erosion, ContactPoints::kMost> erosions_;
};

ContactEvaluation evaluate(const Model& model, State& state, const Substep& substep, bool is_proxy) {
  ContactSolver solver(model, state, substep, is_proxy);
  solver.setUp();
  solver.gather();
  solver.solve();
  solver.sumContacts();
  solver.solve();  // once more, with drag and with the overlap that cutting needs
  solver.erodeAll();
  solver.move();
  return solver.result();
}

}  // namespace

ContactEvaluation evaluateConstraint(const Model& model, State& state, const Substep& substep) noexcept {
  return evaluate(model, state, substep, true);
}

ContactEvaluation evaluateImpulse(const Model& model, State& state, const Substep& substep) noexcept {
  return evaluate(model, state, substep, false);
}

}  // namespace kerf
