// Whether the step obeys its laws: numbers, not times, the same on every machine.
#include <fmt/format.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/tool_file.h"
#include "sim/load_scene.h"
#include "sim/practice_block.h"
#include "sim/virtual_hand.h"
#include "ui/cli/bench.h"

namespace kerf::cli {
namespace {

auto cancelled() { return fail({Error::Code::kCancelled, "", "", "cancelled", "", ""}); }

Expected<Tool> toolOfRack(const std::string& id) {
  KERF_TRY(file, findToolFile(id, defaultToolFolders()));
  return readTool(file);
}

double percentOff(double a, double b) { return 100 * (a / b - 1); }

// Means over the steady part of a straight feed, and the largest change of force from tick to tick.
struct Feed {
  double force = 0, normal = 0, rate = 0, jump = 0;
  std::vector<double> jumps;
};
Feed feed(const Model& model, State& state, const Rigid3& frame, const Rigid3& from, const Vec3d& way, double speed,
          double steady_from) {
  Feed out;
  StepOutput tick;
  const int ticks = static_cast<int>(way.norm() / (speed * kTick));
  int steady = 0;
  Vec3d last = Vec3d::Zero();
  for (int n = 0; n <= ticks; ++n) {
    DeviceSample sample;
    sample.T_world_device = frame * Rigid3{from.rotation, from.translation + way * n / ticks};
    sample.pedal = 1;
    if (state.objects[0].freeBricks() < 2048) state.objects[0].reserve(4096);
    step(model, state, sample, tick);
    if (n >= steady_from * ticks) {
      ++steady;
      out.force += tick.contact.force.norm(), out.normal += tick.normal_load, out.rate += tick.removed_mm3 / kTick;
      if (steady > 1) out.jumps.push_back((tick.contact.force - last).norm());
    }
    last = tick.contact.force;
  }
  out.force /= steady, out.normal /= steady, out.rate /= steady;
  std::sort(out.jumps.begin(), out.jumps.end());
  out.jump = out.jumps.back();
  return out;
}

// Slot: ball of 0.8 mm, 0.6 mm deep, 2 mm/s.
Expected<Feed> slot(double voxel, const Rigid3& frame) {
  Model model;
  model.tools = {practiceBall(0.8, 840)};
  model.tissues.fill({200, 0.5f, 1e-3f, true});
  model.settings.rendering = Rendering::kRigid;
  KERF_TRY(block, practiceBlock({8, 5, 3}, voxel, frame));
  State state;
  state.objects.emplace_back(block, 8192);
  return feed(model, state, frame, {Eigen::Quaterniond::Identity(), {-2, 0.01, -0.6}}, {2.2, 0, 0}, 2, 0.6);
}

}  // namespace

Expected<Result> benchInvariance(const Progress& progress) {
  Result r{"invariance", "a ball of 1.6 mm draws a slot, 0.6 mm deep, 2 mm/s, through a block", {}, "", 0, ""};
  const Rigid3 askew{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vec3d(1, 2, 3).normalized())), Vec3d::Zero()};
  double least = 1e9, most = 0, least_rate = 1e9, most_rate = 0, law = 0;
  for (const double h : {0.1, 0.05, 0.025}) {
    if (!report(progress, 0.1 * (0.1 / h), "voxels")) return cancelled();
    KERF_TRY(f, slot(h, askew));
    least = std::min(least, f.force), most = std::max(most, f.force);
    least_rate = std::min(least_rate, f.rate), most_rate = std::max(most_rate, f.rate);
    if (!(f.normal > 0)) return fail({Error::Code::kEmpty, "", "slot", "no contact", "a cut", "report this"});
    law = std::max(law, std::abs(percentOff(f.rate, 0.5 * f.normal * 840 / 1000)));
    r.measured.push_back({fmt::format("force at {} mm", h), f.force, "N", 0, false});
    r.measured.push_back({fmt::format("removal at {} mm", h), f.rate, "mm3/s", 0, false});
    r.measured.push_back({fmt::format("jump of force per ms, eroding, at {} mm", h), f.jump, "N", 0.05});
  }
  r.measured.push_back({"force over three voxels", percentOff(most, least), "%", 5});
  r.measured.push_back({"removal over three voxels", percentOff(most_rate, least_rate), "%", 5});
  r.measured.push_back({"removal against mu N v / u_s", law, "%", 5});

  least = 1e9, most = 0, least_rate = 1e9, most_rate = 0;
  for (int n = 0; n < 24; ++n) {
    if (!report(progress, 0.5 + 0.02 * n, "attitudes")) return cancelled();
    const Rigid3 frame{
        Eigen::Quaterniond(Eigen::AngleAxisd(
            0.37 * n, Vec3d(std::sin(2.0 * n), std::cos(3.0 * n), std::sin(5.0 * n) + 0.1).normalized())),
        0.013 * n * Vec3d(1, -2, 0.5)};
    KERF_TRY(f, slot(0.1, frame));
    least = std::min(least, f.force), most = std::max(most, f.force);
    least_rate = std::min(least_rate, f.rate), most_rate = std::max(most_rate, f.rate);
  }
  r.measured.push_back({"force over 24 attitudes", percentOff(most, least), "%", 3});
  r.measured.push_back({"removal over 24 attitudes", percentOff(most_rate, least_rate), "%", 3});

  // Sliding on an intact ball of 5 mm, about 1 N, at three speeds.
  for (const double speed : {0.5, 5.0, 20.0}) {
    Model model;
    model.tools = {practiceBall(0.8, 840)};
    model.tools[0].drive.speed = 0;
    model.tissues.fill({200, 0, 1e-3f, true});
    model.settings.rendering = Rendering::kRigid;
    const Vec3d center(0.013, 0.027, -5);
    Box3 box;
    box.add(Vec3d(center.array() - 5.1)), box.add(Vec3d(center.array() + 5.1));
    KERF_TRY(ball, bakedFrom([&](const Vec3d& p) { return (p - center).norm() - 5; }, box, 0.05));
    State state;
    state.objects.emplace_back(ball, 64);
    StepOutput tick;
    double jump = 0, force = 0;
    Vec3d last;
    const int ticks = static_cast<int>(2 / (speed * kTick));
    for (int n = 0; n <= ticks; ++n) {
      // The tip's ball rolls over the pole, 0.0475 mm deep.
      const double a = (-1 + 2.0 * n / ticks) / 5;
      DeviceSample sample;
      sample.T_world_device.translation =
          center + (5.8 - 0.0475) * Vec3d(std::sin(a), 0.1 * a, std::cos(a)).normalized() - Vec3d(0, 0, 0.8);
      step(model, state, sample, tick);
      if (n > 0) jump = std::max(jump, (tick.contact.force - last).norm());
      last = tick.contact.force;
      force = std::max(force, last.norm());
    }
    r.measured.push_back(
        {fmt::format("jump of force per ms, sliding {} mm/s at {:.1f} N", speed, force), jump, "N", 0.02});
  }
  return r;
}

Expected<Result> benchForces(const Progress& progress) {
  Result r{"forces", "what a hand feels, by material, tool and feed: training defaults", {}, "", 0, ""};
  // Constant force: removal rates of a round bur, plunged.
  std::map<std::string, double> rates;
  KERF_TRY(bur, toolOfRack("round-014"));
  KERF_TRY(model, makeModel(std::span(&bur, 1)));
  KERF_TRY(table, readDefaultMaterials());
  // Gently in what is soft, so that every plunge takes some tenths of a second.
  for (const auto& [id, force] : {std::pair("enamel", 1.0), std::pair("dentin", 0.5), std::pair("cortical", 0.5),
                                  std::pair("cancellous", 0.05)}) {
    if (!report(progress, 0.1, "constant force")) return cancelled();
    KERF_TRY(row, table.require(id));
    KERF_TRY(block, practiceBlock({3, 3, 4}, 0.1, {}, row.material));
    State state;
    state.objects.emplace_back(block, 4096);
    CutPath path;
    path.poses = {{0, {Eigen::Quaterniond::Identity(), {0.01, 0.02, 0.05}}},
                  {1, {Eigen::Quaterniond::Identity(), {0.01, 0.02, -3}}}};
    path.cuts = {1};
    ForceHand::Options push;
    push.force = force;
    ForceHand hand(path, model.settings.coupling, push);
    state.place(poseAt(path, 0));
    StepOutput tick;
    DeviceSample sample;
    double removed = 0, seconds = 0;
    std::vector<double> parts;
    double part = 0;
    int n = 0;
    while (hand.next(tick, sample)) {
      step(model, state, sample, tick);
      const double z = tick.T_world_tool.translation[2];
      if (z > -1.2 || z < -2.8) continue;
      removed += tick.removed_mm3, seconds += kTick, part += tick.removed_mm3;
      if (++n % 40 == 0) parts.push_back(part), part = 0;
    }
    if (seconds == 0) return fail({Error::Code::kEmpty, "", id, "the bur never got deep enough", "", "report this"});
    rates[id] = removed / seconds / force;
    r.measured.push_back({fmt::format("round 014 in {}", id), rates[id], "mm3/s per N", 0, false});
    if (parts.size() > 2) {
      const auto [low, high] = std::minmax_element(parts.begin(), parts.end());
      r.measured.push_back({fmt::format("  spread of the rate in {}", id), percentOff(*high, *low), "%", 3});
    }
  }
  const auto ratio = [&](const char* hard, const char* soft) {
    const auto of = [&](const char* id) {
      const MaterialProperties row = *table.require(id);
      return row.friction.value / row.specific_cutting_energy.value;
    };
    const double configured = of(soft) / of(hard), measured = rates[soft] / rates[hard];
    r.measured.push_back({fmt::format("{} : {} at the same force", soft, hard), measured, "", 0, false});
    r.measured.push_back({fmt::format("  against {:.3g} as configured", configured),
                          std::abs(percentOff(measured, configured)), "%", 10});
  };
  ratio("enamel", "dentin");
  ratio("cortical", "cancellous");

  // The saw: 3 feeds x 3 rates of strokes in cortical bone, 10 mm wide (J Biomech Eng 2014;136:034501).
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(sawing, makeModel(std::span(&saw, 1)));
  sawing.settings.rendering = Rendering::kRigid;
  Eigen::Matrix3d axes;
  axes.col(0) = Vec3d::UnitZ(), axes.col(1) = -Vec3d::UnitY(), axes.col(2) = Vec3d::UnitX();
  std::vector<std::vector<double>> grid;
  for (const double feed_rate : {20.0, 40.0, 60.0}) {
    grid.emplace_back();
    for (const double cycles : {9800.0, 11200.0, 12600.0}) {
      if (!report(progress, 0.5, "sawing")) return cancelled();
      sawing.tools[0].drive.speed = meanSpeed(saw.stroke_mm, cycles / 60);
      KERF_TRY(block, practiceBlock({10, 4, 4}, 0.05, {}, Material::kCortical));
      State state;
      state.objects.emplace_back(block, 8192);
      const Feed f = feed(sawing, state, {}, {Eigen::Quaterniond(axes), {-12.5, 0.01, 0.05}},
                          {0, 0, -(0.05 + feed_rate / 60 * 1.2)}, feed_rate / 60, 0.7);
      grid.back().push_back(f.force);
      r.measured.push_back(
          {fmt::format("saw, cortical, {} mm/min, {} cycles/min", feed_rate, cycles), f.force, "N", 0, false});
    }
  }
  int wrong = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      if (i > 0) wrong += grid[i][j] <= grid[i - 1][j];
      if (j > 0) wrong += grid[i][j] >= grid[i][j - 1];
    }
  r.measured.push_back(
      {"saw: pairs where force does not grow with feed, fall with strokes", static_cast<double>(wrong), "", 0});
  return r;
}

namespace {

// Where phi passes zero on a line, mm from its start; NaN: nowhere.
double crossing(const BrickField& phi, const Vec3d& from, const Vec3d& along, double length) {
  constexpr double kStep = 0.005;
  double before = phi.sample(from);
  for (double at = kStep; at <= length; at += kStep) {
    const double here = phi.sample(from + at * along);
    if (before > 0 && here <= 0) return at - kStep * here / (here - before);
    before = here;
  }
  return std::nan("");
}

BrickField currentField(const CutObject& object) {
  BrickField field = object.baked().phi0();
  const BrickField changed = object.changedField();
  for (std::size_t b = 0; b < changed.brickCount(); ++b)
    field.brick(field.touch(changed.brickCoord(b))) = changed.brick(b);
  return field;
}

struct Kerf {
  double width_error = 0, plane_degrees = 0;  // mean width; angle between wall and blade
};
// Walls of a kerf along y = 0 of `frame`, seen from its middle.
Kerf measureKerf(const CutObject& object, const Rigid3& frame, double expected) {
  const BrickField phi = currentField(object);
  double width = 0, sx = 0, sz = 0, sxx = 0, szz = 0, sxz = 0, sw = 0, swx = 0, swz = 0;
  int n = 0;
  for (double x = -4; x <= 4; x += 0.5)
    for (double z = -0.85; z <= -0.15; z += 0.1) {  // above the toothed edge of a blade 1.5 mm deep
      const Vec3d middle = frame * Vec3d(x, 0, z), side = frame.rotation * Vec3d::UnitY();
      const double right = crossing(phi, middle, side, 1), left = crossing(phi, middle, -side, 1);
      // A wall that is not found is no kerf of the right width.
      if (std::isnan(right) || std::isnan(left)) return {1e3, 90};
      width += right + left, ++n;
      sx += x, sz += z, sxx += x * x, szz += z * z, sxz += x * z, sw += right, swx += right * x, swz += right * z;
    }
  // Slopes of the right wall over x and z by least squares.
  Eigen::Matrix3d a;
  a << sxx, sxz, sx, sxz, szz, sz, sx, sz, n;
  const Vec3d slope = a.ldlt().solve(Vec3d(swx, swz, sw));
  return {std::abs(width / n - expected), std::atan(std::hypot(slope[0], slope[1])) * 180 / M_PI};
}

}  // namespace

Expected<Result> benchSaw(const Progress& progress) {
  Result r{"saw", "reciprocating blade 0.4 mm with 0.02 mm set, 1.5 mm deep in a block of cortical bone", {}, "", 0,
           ""};
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(model, makeModel(std::span(&saw, 1)));
  model.settings.rendering = Rendering::kRigid;
  Eigen::Matrix3d axes;
  axes.col(0) = Vec3d::UnitZ(), axes.col(1) = -Vec3d::UnitY(), axes.col(2) = Vec3d::UnitX();
  const Eigen::Quaterniond teeth_down(axes);
  for (const double h : {0.1, 0.05}) {
    double width = 0, plane = 0, least = 1e9, most = 0;
    for (int n = 0; n < 12; ++n) {
      if (!report(progress, (h < 0.1 ? 0.3 : 0) + 0.02 * n, "kerf")) return cancelled();
      const Rigid3 frame{Eigen::Quaterniond(Eigen::AngleAxisd(
                             0.41 * n, Vec3d(std::cos(2.0 * n), std::sin(3.0 * n), 0.7).normalized())),
                         0.017 * n * Vec3d(1, -2, 0.5)};
      KERF_TRY(block, practiceBlock({10, 3, 3}, h, frame, Material::kCortical));
      State state;
      state.objects.emplace_back(block, 8192);
      const Feed f = feed(model, state, frame, {teeth_down, {-12.5, 0, 0.05}}, {0, 0, -1.55}, 2, 0.7);
      const Kerf kerf = measureKerf(state.objects[0], frame, saw.kerfWidth());
      width = std::max(width, kerf.width_error), plane = std::max(plane, kerf.plane_degrees);
      least = std::min(least, f.force), most = std::max(most, f.force);
      if (n > 0) continue;

      // Held in its kerf: moved sideways, the flanks push back, and cut nothing.
      const double volume = state.objects[0].removed_mm3[static_cast<std::size_t>(Material::kCortical)];
      const Kerf before = measureKerf(state.objects[0], frame, saw.kerfWidth());
      StepOutput tick;
      double side = 0;
      for (int i = 0; i < 200; ++i) {
        DeviceSample sample;
        sample.T_world_device = frame * Rigid3{teeth_down, Vec3d(-12.5, 0.0002 * i, -1.5)};
        sample.pedal = 1;
        step(model, state, sample, tick);
        if (i == 199) side = -(frame.rotation.conjugate() * tick.contact.force)[1];
      }
      const Kerf after = measureKerf(state.objects[0], frame, saw.kerfWidth());
      r.measured.push_back({fmt::format("side force at 0.04 mm, {} mm voxels", h), side, "N", 0, false});
      r.measured.push_back({fmt::format("  pushes the wrong way ({} mm)", h), side > 0 ? 0.0 : 1.0, "", 0});
      r.measured.push_back({fmt::format("  kerf widened by the flanks ({} mm)", h),
                            1000 * std::abs(after.width_error - before.width_error), "um", 1});
      r.measured.push_back({fmt::format("  removed by the edge's side ({} mm)", h),
                            state.objects[0].removed_mm3[static_cast<std::size_t>(Material::kCortical)] - volume, "mm3",
                            0, false});
    }
    r.measured.push_back({fmt::format("kerf width, worst of 12 attitudes, {} mm voxels", h), 1000 * width, "um",
                          1000 * std::max(0.5 * h, 0.025)});
    r.measured.push_back({fmt::format("plane of the wall, worst of 12 ({} mm)", h), plane, "degrees", 0.1});
    r.measured.push_back(
        {fmt::format("feed force over 12 attitudes ({} mm)", h), percentOff(most, least), "%", 0, false});
    r.measured.push_back({fmt::format("feed force, most ({} mm)", h), most, "N", 0, false});
  }
  return r;
}

Expected<Result> benchPassivity(const Progress& progress) {
  Result r{"passivity", "a simulated device pressed on a block that does not give way, 1.8 s, all hands", {}, "", 0,
           ""};
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1));
  const auto press = [&](Rendering rendering, const CouplingSettings& coupling, const DeviceHand::Options& options) {
    Model model;
    model.tools = {practiceBall(0.5, 840)};
    model.tools[0].drive.speed = 0;
    model.tissues.fill({200, 0, 1e-3f, true});
    model.settings.rendering = rendering;
    model.settings.coupling = coupling;
    model.settings.ramp_s = 0;
    State state;
    state.objects.emplace_back(block, 16);
    CutPath path;
    for (const auto& [t, z] : {std::pair(0.0, 1.0), std::pair(0.5, -2.0), std::pair(1.5, -2.0), std::pair(1.8, 1.0)})
      path.poses.push_back({t, {Eigen::Quaterniond::Identity(), {0, 0, z}}});
    path.cuts = {1, 1, 1};
    DeviceHand hand(path, options);
    StepOutput out;
    DeviceSample sample;
    state.place(poseAt(path, 0));
    double energy = -1e9, low = 1e9, high = -1e9;
    for (int n = 0; hand.next(out, sample); ++n) {
      step(model, state, sample, out);
      energy = std::max(energy, hand.portEnergy());
      if (n > 1200 && n < 1490) low = std::min(low, hand.position()[2]), high = std::max(high, hand.position()[2]);
    }
    return std::pair(energy, high - low);
  };
  // Bounds of the literature for b = 0.5 N s/m, one tick of delay: K <= 0.33 N/mm; and K <= 2 f / encoder step, which a
  // device without friction never meets: its encoder's steps make it tremble whatever the coupling.
  double direct_energy = 0;
  int direct_fails = 0, runs = 0;
  for (const double friction : {0.05, 0.0})
    for (const double stiffness : {0.33, 0.7, 1.0, 1.5, 2.0}) {
      double energy = 0, trembling = 0;
      for (const double hand_stiffness : {0.05, 0.1, 0.3, 1.0, 2.0})
        for (const double hand_damping : {0.0005, 0.003, 0.01})
          for (const double encoder : {0.01, 0.03})
            for (const double mass : {0.05, 0.1}) {
              if (!report(progress, 0.2 * stiffness, "hands")) return cancelled();
              DeviceHand::Options options;
              options.hand_stiffness = hand_stiffness, options.hand_damping = hand_damping;
              options.encoder_mm = encoder, options.mass_kg = mass, options.friction = friction;
              CouplingSettings coupling;
              coupling.stiffness = stiffness;
              const auto [e, amplitude] = press(Rendering::kCoupled, coupling, options);
              energy = std::max(energy, e), trembling = std::max(trembling, amplitude);
              ++runs;
              if (stiffness == 1.0 && friction > 0) {
                const double d = press(Rendering::kDirect, coupling, options).first;
                direct_energy = std::max(direct_energy, d), direct_fails += d > 0;
              }
            }
      const std::string what = fmt::format("K {} N/mm, friction {} N", stiffness, friction);
      r.measured.push_back(
          {what + ": energy given away, worst of 60 hands", energy, "mJ", friction > 0 ? 0 : 0.1, stiffness <= 1});
      r.measured.push_back({what + ": trembling", 1000 * trembling, "um", 5, friction > 0 && stiffness <= 1});
    }
  r.measured.push_back({"direct rendering: energy given away, worst of 60 hands", direct_energy, "mJ", 0, false});
  r.measured.push_back(
      {"direct rendering: hands it fails with, of 60", static_cast<double>(direct_fails), "", 0, false});
  r.measured.push_back({"runs", static_cast<double>(runs), "", 0, false});
  return r;
}

}  // namespace kerf::cli
