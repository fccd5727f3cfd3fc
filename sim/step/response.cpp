#include "sim/step/response.h"

#include <algorithm>
#include <cmath>

#include "sim/step/contact_points.h"

namespace kerf {
namespace {

constexpr double kTakenBack = 0.2;       // of an overlap beyond the skin, a look
constexpr double kMostTakenBack = 0.02;  // mm a look
constexpr double kEven = 0.2;            // softness of taking back: between two walls the middle
constexpr double kDeepest = 0.1;         // mm that a cutting part may overlap so that there is enough to remove
constexpr double kMostRelaxed = 4;       // rate times time, at which all but 2 % of an overlap is gone

// The diagonal of a matrix of the coupling: translation three times, rotation three times.
Vector6d sixOf(double along, double about) {
  Vector6d d;
  d << along, along, along, about, about, about;
  return d;
}

/// One look, in the order of its functions.
class Responder {
 public:
  Responder(const Model& model, State& state, double dt, double longest, double device_way)
      : model_(model),
        state_(state),
        tool_(model.tools[state.tool]),
        is_proxy_(model.settings.response == Response::kConstraint),
        start_(state.body.pose),
        dt_(dt),
        longest_(longest),
        device_way_(device_way),
        reach_(tool_.cut.reach()),
        per_(is_proxy_ ? 1 : dt) {
    shapes_.fill({});
  }

  /// Without contact: A y = b, y a motion (proxy) or a velocity (body).
  void setUp() {
    const CouplingSettings& c = model_.settings.coupling;
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
    // Without mass it would look as far ahead as the hand pulls it: no farther than its speed and the device's may take
    // it, so that few bricks are near, and twice that, so that it can catch up.
    double way = 2 * std::max(device_way_, dt_ * wayOf(twist_));
    for (const CutObject& object : state_.objects) way = std::max(way, 4 * contactSkin(object.voxel()));
    longest_ = std::min(longest_, way);
  }

  /// The points are those the tool would meet on its way but for contact: what it touches, and what comes before it.
  void gather() {
    ahead_ = per_ * b_.cwiseQuotient(a_.diagonal());
    if (const double way = wayOf(ahead_); way > longest_) ahead_ *= longest_ / way;
    state_.body.pose = {rotated(start_.rotation, ahead_.tail<3>()), start_.translation + ahead_.head<3>()};
    travelledFrom(start_);
    for (std::size_t n = 0; n < state_.objects.size(); ++n) {
      const ContactInput in = inputOf(n);
      look_.sums.tested += points_.gather(state_.objects[n], static_cast<int>(n), nearOf(n, in), in);
    }
    const Rigid3 there = state_.body.pose;
    state_.body.pose = start_;
    travelledFrom(there);
    near_of_ = kNone;
    for (int n = 0; n < points_.size(); ++n) {
      Shape& shape = *shapeOf(static_cast<std::size_t>(points_[n].object));
      shape.allowed = contactSkin(state_.objects[static_cast<std::size_t>(points_[n].object)].voxel());
    }
  }

  void solve() {
    for (int n = 0; n < points_.size(); ++n) {
      const auto at = static_cast<std::size_t>(n);
      const ContactPoint& p = points_[n];
      const Vector6d u = p.direction();
      const auto object = static_cast<std::size_t>(p.object);
      const double allowed = p.cuts ? shapeOf(object)->allowed : contactSkin(state_.objects[object].voxel());
      // How far it has to move out here, from where it is; negative: how far it may come in.
      const double out = u.dot(ahead_) - (p.gap + allowed) / p.slope;
      // What overlaps already makes no load: walls on both sides would make any.
      overlap_[at] = std::max(out, 0.0);
      least_[at] = std::min(out, 0.0) / per_;
      if (const double coming = u.dot(twist_); !is_proxy_ && coming < least_[at])
        least_[at] = std::max(least_[at], -model_.settings.restitution * coming);
    }
    loads_.solve(a_, b_, points_, least_, 0);
  }

  /// Pressure and drag where the tool is, scaled to the load. Then what they change: drag, and how deep it may go in.
  void takeShape() {
    for (std::size_t n = 0; n < state_.objects.size(); ++n) {
      CutObject& object = state_.objects[n];
      const ContactInput in = inputOf(n);
      ContactSums sums;
      sumContact(object, nearOf(n, in), in, sums);
      if (Shape* shape = shapeOf(n)) {
        shape->erodible = sums.erodible_load;
        shape->rate = relaxationRate(sums.cutting_load, sums.erodible_load);
        // Deep enough for half of it to go in a look: volume grows with the square of the depth of a ball.
        const double share = shape->erodible > 0 ? cuttingOf(n) * shape->rate / shape->erodible : 0;
        const double wanted = 1.5 * sums.deepest * std::sqrt(2 * std::min(share, 2.0));
        shape->allowed = std::max(shape->allowed, std::min(wanted, kDeepest));
      }
      if (sums.touching > 0) look_.objects_touched |= objectBit(n);
      sums.scale(sums.normal_load > 0 ? loadOf(n) / sums.normal_load : 0);
      look_.sums.add(sums.rotated(object.T_world_object.rotation.toRotationMatrix()));
    }
    own_ = ownDrag(tool_, start_, state_.speed, look_.sums);
    drag_ = look_.sums.dragMatrix();
    a_ += (is_proxy_ ? 1 / dt_ : dt_) * drag_;
    b_.head<3>() += per_ * own_.force;
    b_.tail<3>() += per_ * own_.torque;
  }

  /// Last object first: its bricks are those that were found last.
  void erodeAll() {
    for (std::size_t n = state_.objects.size(); n-- > 0;) {
      CutObject& object = state_.objects[n];
      ContactInput in = inputOf(n);
      if (!in.geometry_only) {
        const double cutting = cuttingOf(n);
        if (!(cutting > 0)) continue;  // then it has a point, and a shape
        const Shape& shape = *shapeOf(n);
        in.load_scale = erosionScale(cutting, shape.rate, shape.erodible);
      }
      const CutResult cut = erode(object, nearOf(n, in), in);
      const bool is_repaired = object.repair();  // also when room ran out: what was cut must be felt
      look_.removed_mm3 += cut.removed_mm3;
      look_.bricks_cut += cut.bricks;
      if (cut.pool_ran_out || !is_repaired) look_.status |= kStepBricksRanOut;
    }
  }

  void move() {
    const auto setVelocity = [&](const Vector6d& v) {
      state_.body.velocity = v.head<3>();
      state_.body.angular = v.tail<3>();
    };
    ContactLoads back;
    for (std::size_t n = 0; n < overlap_.size(); ++n)
      least_[n] = std::min(kTakenBack * overlap_[n], kMostTakenBack) / per_;
    back.solve(metric_.asDiagonal(), Vector6d::Zero(), points_, least_, kEven / metric_[0]);
    setVelocity(per_ / dt_ * (loads_.motion + back.motion));
    const double kept = travel(state_.body, reach_, longest_, dt_);
    look_.is_free = kept == 1 && loads_.total() == 0 && look_.sums.drag == 0;
    setVelocity(kept * per_ / dt_ * loads_.motion);
    travelledFrom(start_);
  }

  /// Loads and drag as they were solved with.
  Look& result() {
    const double solved = loads_.total() / per_;
    double cutting = 0;
    for (std::size_t n = 0; n < state_.objects.size(); ++n) cutting += cuttingOf(n);
    Vector6d twist;
    twist << state_.body.velocity, state_.body.angular;
    const Vector6d push = loads_.push(points_) / per_, feed_drag = drag_ * twist;
    look_.contact.force = push.head<3>() + own_.force - feed_drag.head<3>();
    look_.contact.torque = push.tail<3>() + own_.torque - feed_drag.tail<3>();
    if (look_.sums.normal_load > 0) look_.sums.scale(solved / look_.sums.normal_load);
    look_.sums.normal_load = solved;
    look_.sums.cutting_load = cutting;
    return look_;
  }

 private:
  /// Of one object: cutting load before erosion at a scale of 1, N; rate times time; overlap that is allowed, mm.
  struct Shape {
    double erodible = 0, rate = 0, allowed = 0;
  };

  double wayOf(const Vector6d& motion) const { return motion.head<3>().norm() + reach_ * motion.tail<3>().norm(); }
  ContactInput inputOf(std::size_t object) const { return contactInput(model_, state_, state_.objects[object], dt_); }
  /// The same object again: its bricks are not looked for again.
  const NearBricks& nearOf(std::size_t object, const ContactInput& in) {
    if (object != near_of_) {
      if (!state_.near.find(state_.objects[object], tool_, in.T_object_tool)) look_.status |= kStepNearRanOut;
      look_.bricks_near += static_cast<int>(state_.near.size());
      near_of_ = object;
    }
    return state_.near;
  }
  void travelledFrom(const Rigid3& from) {
    const double way = (state_.body.pose.translation - from.translation).norm() +
                       tool_.reach_mm * rotationBetween(from.rotation, state_.body.pose.rotation).norm() + 1e-9;
    for (CutObject& object : state_.objects) object.odometer += way;
  }
  /// Kept by the object's first point; null: it has none, and no load.
  Shape* shapeOf(std::size_t object) {
    for (int n = 0; n < points_.size(); ++n)
      if (points_[n].object == static_cast<int>(object)) return &shapes_[static_cast<std::size_t>(n)];
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
  const double reach_;
  const double per_;  // what a load does to b
  Look look_;
  std::size_t near_of_ = kNone;  // whose bricks state_.near holds, at the body's pose
  Matrix6d a_, drag_;
  Vector6d b_, metric_, twist_, ahead_;
  Wrench own_;
  ContactPoints points_;
  ContactLoads::Row least_{}, overlap_{};
  ContactLoads loads_;
  std::array<Shape, ContactPoints::kMost> shapes_;
};

}  // namespace

ContactInput contactInput(const Model& model, const State& state, const CutObject& object, double dt) noexcept {
  const Rigid3 T_object_world = object.T_world_object.inverse();
  ContactInput in;
  in.tool = &model.tools[state.tool];
  in.tissues = &model.tissues;
  in.T_object_tool = T_object_world * state.body.pose;
  in.speed = state.speed;
  in.dt = dt;
  in.geometry_only = model.settings.geometry_only;
  in.velocity = T_object_world.rotation * state.body.velocity;
  in.angular = T_object_world.rotation * state.body.angular;
  return in;
}

double relaxationRate(double now, double still) noexcept {
  if (!(now > 0 && still > 0)) return 0;
  // g(x) = (1 - exp(-x)) / x falls and is convex: Newton from the left climbs to the root without passing it.
  const double g = std::min(now / still, 1.0);
  double x = 0;
  for (int n = 0; n < 30 && g < 1 - 1e-9; ++n) {
    const double part = -std::expm1(-x);
    const double value = x > 1e-6 ? part / x : 1 - 0.5 * x;
    const double slope = x > 1e-3 ? ((1 - part) - value) / x : -0.5 + x / 3;
    const double step = (g - value) / slope;
    x += step;
    if (step < 1e-12 * (1 + x)) break;
  }
  return x;
}

double erosionScale(double load, double rate, double still) noexcept {
  if (!(load > 0 && still > 0)) return 0;
  if (rate < 1e-9) return load / still;
  const double wanted = load * rate / still;
  return (wanted < -std::expm1(-kMostRelaxed) ? -std::log1p(-wanted) : kMostRelaxed) / rate;
}

Look respond(const Model& model, State& state, double dt, double longest, double device_way) noexcept {
  Responder look(model, state, dt, longest, device_way);
  look.setUp();
  look.gather();
  look.solve();
  look.takeShape();
  look.solve();
  look.erodeAll();
  look.move();
  return look.result();
}

}  // namespace kerf
