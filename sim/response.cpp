#include "sim/response.h"

#include <algorithm>
#include <cmath>

#include "sim/contact_points.h"

namespace kerf {
namespace {

constexpr double kTakenBack = 0.2;       // of an overlap beyond the skin, a look: impulse
constexpr double kMostTakenBack = 0.02;  // mm a look
constexpr double kMostRelaxed = 4;       // rate times time, at which all but 2 % of an overlap is gone

// The diagonal of a matrix of the coupling: translation three times, rotation three times.
Vector6d sixOf(double along, double about) {
  Vector6d d;
  d << along, along, along, about, about, about;
  return d;
}

// Looks at one object after the other, and at the same one again without finding its bricks again.
class Near {
 public:
  Near(State& state, Look& look) : state_(state), look_(look) {}
  const NearBricks& find(std::size_t object, const ToolModel& tool, const ContactInput& in) {
    if (object != object_) {
      if (!state_.near.find(state_.objects[object], tool, in.T_object_tool)) look_.status |= kStepNearRanOut;
      look_.bricks_near += static_cast<int>(state_.near.size());
      object_ = object;
    }
    return state_.near;
  }
  void toolMoved() { object_ = kNone; }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  State& state_;
  Look& look_;
  std::size_t object_ = kNone;
};

}  // namespace

ContactInput contactInput(const Model& model, const State& state, const CutObject& object, double dt) noexcept {
  const Rigid3 T_object_world = object.T_world_object.inverse();
  ContactInput in;
  in.tool = &model.tools[state.tool], in.tissues = &model.tissues;
  in.T_object_tool = T_object_world * state.body.pose;
  in.speed = state.speed, in.dt = dt, in.geometry_only = model.settings.geometry_only;
  in.velocity = T_object_world.rotation * state.body.velocity;
  in.angular = T_object_world.rotation * state.body.angular;
  return in;
}

double erosionScale(double load, double now, double still) noexcept {
  if (!(load > 0 && now > 0 && still > 0)) return 0;
  // g(x) = (1 - exp(-x)) / x is convex and falls: Newton from the left climbs to the root without passing it.
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
  if (x < 1e-9) return load / still;
  const double wanted = load * x / still;
  return (wanted < -std::expm1(-kMostRelaxed) ? -std::log1p(-wanted) : kMostRelaxed) / x;
}

Look respond(const Model& model, State& state, double dt, double longest) noexcept {
  Look look;
  const StepSettings& settings = model.settings;
  const CouplingSettings& c = settings.coupling;
  const ToolModel& tool = model.tools[state.tool];
  const double reach = tool.cut.reach();
  const bool is_proxy = settings.response == Response::kConstraint;
  const Rigid3 start = state.body.pose;
  const auto travelled = [&](const Rigid3& from) {
    const double way = (state.body.pose.translation - from.translation).norm() +
                       tool.reach_mm * rotationBetween(from.rotation, state.body.pose.rotation).norm() + 1e-9;
    for (CutObject& object : state.objects) object.odometer += way;
  };

  // Without contact: A y = b, y a motion (proxy) or a velocity (body). What a load does to b is 1 or dt of it.
  const double per_load = is_proxy ? 1 : dt;
  const double damped = is_proxy && settings.rendering == Rendering::kDirect ? 0 : 1;
  const Vector6d stiffness = sixOf(c.stiffness, c.turn_stiffness);
  const Vector6d damping = damped * sixOf(c.damping, c.turn_damping);
  Vector6d device_twist, twist;
  device_twist << state.device.velocity, state.device.angular;
  twist << state.body.velocity, state.body.angular;
  Vector6d b = springPull(start, state.device, c) + damping.cwiseProduct(device_twist);
  Matrix6d a = Matrix6d::Zero();
  const Vector6d mass = sixOf(c.mass(), c.inertia());
  if (is_proxy) {
    a.diagonal() = stiffness + damping / dt;
  } else {
    b = mass.cwiseProduct(twist) + dt * b;
    a.diagonal() = mass + dt * damping + dt * dt * stiffness;
  }

  // A proxy without mass would look as far ahead as the hand pulls it: no farther than its speed and the device's may
  // take it, so that few bricks are near, and twice that, so that it can catch up.
  if (is_proxy) {
    double way = 0;
    for (const CutObject& object : state.objects) way = std::max(way, 4 * contactSkin(object.voxel()));
    for (const Vector6d& moving : {twist, device_twist})
      way = std::max(way, 2 * dt * (moving.head<3>().norm() + reach * moving.tail<3>().norm()));
    longest = std::min(longest, way);
  }
  // The points are those the tool would meet on its way, but for contact: what it touches, and what comes before it.
  Near near(state, look);
  const double per_motion = is_proxy ? 1 : dt;
  Vector6d ahead = per_motion * b.cwiseQuotient(a.diagonal());
  if (const double way = ahead.head<3>().norm() + reach * ahead.tail<3>().norm(); way > longest) ahead *= longest / way;
  state.body.pose = {rotated(start.rotation, ahead.tail<3>()), start.translation + ahead.head<3>()};
  travelled(start);
  ContactPoints points;
  points.clear();
  for (std::size_t n = 0; n < state.objects.size(); ++n) {
    const ContactInput in = contactInput(model, state, state.objects[n], dt);
    look.sums.tested += points.gather(state.objects[n], static_cast<int>(n), near.find(n, tool, in), in);
  }
  ContactLoads::Row least{}, overlap{};
  for (int n = 0; n < points.size(); ++n) {
    const auto at = static_cast<std::size_t>(n);
    const ContactPoint& p = points[n];
    const Vector6d u = p.direction();
    const double skin = contactSkin(state.objects[static_cast<std::size_t>(p.object)].voxel());
    // How far it has to move out here, from where it is; negative: how far it may come in.
    const double out = u.dot(ahead) - (p.gap + skin) / p.slope;
    least[at] = out;
    if (is_proxy) continue;
    // What overlaps already is no reason for a velocity.
    overlap[at] = std::max(out, 0.0);
    const double coming = u.dot(twist), most_coming = std::min(out, 0.0) / dt;
    least[at] = coming < most_coming ? std::max(most_coming, -kRestitution * coming) : most_coming;
  }
  ContactLoads loads;
  loads.solve(a, b, points, least);
  const Rigid3 there = state.body.pose;
  state.body.pose = start;
  travelled(there);
  near.toolMoved();

  // Pressure and drag where the tool is, scaled to the load; then the loads again, with drag.
  const auto loadOf = [&](std::size_t object) { return loads.ofObject(points, static_cast<int>(object)) / per_load; };
  struct Shape {
    double all, cutting, erodible;
  };
  std::array<Shape, ContactPoints::kMost> shapes;  // of objects with a load, by their first point
  shapes.fill({0, 0, 0});
  const auto shapeOf = [&](std::size_t object) -> Shape* {
    for (int n = 0; n < points.size(); ++n)
      if (points[n].object == static_cast<int>(object)) return &shapes[static_cast<std::size_t>(n)];
    return nullptr;
  };
  for (std::size_t n = 0; n < state.objects.size(); ++n) {
    CutObject& object = state.objects[n];
    const ContactInput in = contactInput(model, state, object, dt);
    ContactSums sums;
    sumContact(object, near.find(n, tool, in), in, sums);
    if (Shape* shape = shapeOf(n)) *shape = {sums.normal_load, sums.cutting_load, sums.erodible_load};
    sums.scale(sums.normal_load > 0 ? loadOf(n) / sums.normal_load : 0);
    look.sums.add(sums.rotated(object.T_world_object.rotation.toRotationMatrix()));
  }
  Wrench own = ownDrag(tool, start, state.speed, look.sums);
  const Matrix6d drag = look.sums.dragMatrix();
  if (look.sums.drag > 0) {
    a += (is_proxy ? 1 / dt : dt) * drag;
    b.head<3>() += per_load * own.force, b.tail<3>() += per_load * own.torque;
    loads.solve(a, b, points, least);
  }

  // Last object first: its bricks are those that were found last.
  const double solved = loads.total() / per_load;
  for (std::size_t n = state.objects.size(); n-- > 0;) {
    CutObject& object = state.objects[n];
    ContactInput in = contactInput(model, state, object, dt);
    const Shape* shape = shapeOf(n);
    const double cutting = shape && shape->all > 0 ? loadOf(n) * shape->cutting / shape->all : 0;
    if (!in.geometry_only) {
      if (!(cutting > 0)) continue;
      in.load_scale = erosionScale(cutting, shape->cutting, shape->erodible);
    }
    const CutResult cut = erode(object, near.find(n, tool, in), in);
    const bool is_repaired = object.repair();  // also when room ran out: what was cut must be felt
    look.removed_mm3 += cut.removed_mm3, look.bricks_cut += cut.bricks;
    if (cut.room_ran_out || !is_repaired) look.status |= kStepBricksRanOut;
  }

  if (is_proxy) {
    state.body.velocity = loads.motion.head<3>() / dt, state.body.angular = loads.motion.tail<3>() / dt;
    travel(state.body, reach, longest, dt);
  } else {
    ContactLoads back;
    for (std::size_t n = 0; n < overlap.size(); ++n) least[n] = std::min(kTakenBack * overlap[n], kMostTakenBack) / dt;
    back.solve(mass.asDiagonal(), Vector6d::Zero(), points, least);
    const Vector6d both = loads.motion + back.motion;
    state.body.velocity = both.head<3>(), state.body.angular = both.tail<3>();
    travel(state.body, reach, longest, dt);
    state.body.velocity = loads.motion.head<3>(), state.body.angular = loads.motion.tail<3>();
  }
  travelled(start);

  // What the tool's own motion and its feed drag is what the loads were solved with.
  twist << state.body.velocity, state.body.angular;
  const Vector6d push = loads.push(points) / per_load, feed_drag = drag * twist;
  look.contact.force = push.head<3>() + own.force - feed_drag.head<3>();
  look.contact.torque = push.tail<3>() + own.torque - feed_drag.tail<3>();
  look.is_held = solved > 0;
  const double factor = look.sums.normal_load > 0 ? solved / look.sums.normal_load : 0;
  look.sums.scale(factor);
  look.sums.normal_load = solved;
  return look;
}

}  // namespace kerf
