// Whether the step obeys its laws: numbers, not times, the same on every machine.
#include <fmt/format.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "sim/hand/virtual_hand.h"
#include "sim/run/load_scene.h"
#include "sim/run/practice_block.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

double percentOff(double a, double b) { return 100 * (a / b - 1); }

// Means over the steady part of a straight feed, and the largest change of force from tick to tick.
struct Feed {
  double force = 0, normal = 0, rate = 0;
  double thrust = 0, drag = 0;     // N: against the way; what the drive works against
  double jump = 0, turn_jump = 0;  // N, N mm a tick, at most
};
Feed feed(const Model& model, State& state, const Rigid3& frame, const Rigid3& from, const Vec3d& way, double speed,
          double steady_from) {
  Feed out;
  StepOutput tick;
  const int ticks = static_cast<int>(way.norm() / (speed * kTick));
  int steady = 0;
  Wrench last;
  const Vec3d along = frame.rotation * way.normalized();
  for (int n = 0; n <= ticks; ++n) {
    DeviceSample sample;
    sample.T_world_device = frame * Rigid3{from.rotation, from.translation + way * n / ticks};
    sample.pedal = 1;
    if (state.objects[0].freeBricks() < 2048) state.objects[0].reserve(4096);
    step(model, state, sample, tick);
    if (n >= steady_from * ticks) {
      ++steady;
      out.force += tick.contact.force.norm();
      out.normal += tick.normal_load;
      out.rate += tick.removed_mm3 / kTick;
      out.thrust -= tick.contact.force.dot(along);
      out.drag += tick.drive_load;
      if (steady > 1) {
        out.jump = std::max(out.jump, (tick.contact.force - last.force).norm());
        out.turn_jump = std::max(out.turn_jump, (tick.contact.torque - last.torque).norm());
      }
    }
    last = tick.contact;
  }
  out.force /= steady;
  out.normal /= steady;
  out.rate /= steady;
  out.thrust /= steady;
  out.drag /= steady;
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

// One voxel above a block, held by the coupling: force the hand feels, and where the tool is against it.
Expected<void> measureAir(Result& r) {
  constexpr double kVoxel = 0.05;
  KERF_TRY(bur, toolOfRack("round-014"));
  KERF_TRY(model, makeModel(std::span(&bur, 1)));
  KERF_TRY(block, practiceBlock({20, 4, 2}, kVoxel));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.4, Vec3d(1, 2, 3).normalized()));
  // The tip's ball is 0.7 mm: its lowest point, turned, one voxel above z = 0.
  const Vec3d tip = Vec3d(0, 0, kVoxel + 0.7) - turn * Vec3d(0, 0, 0.7);
  const auto measure = [&](const char* name, const auto& place, double goal) {
    State state;
    state.objects.emplace_back(block, 64);
    state.place({turn, tip + place(0)});
    StepOutput tick;
    double force = 0, drift = 0;
    int touching = 0;
    for (int n = 0; n < 5000; ++n) {
      DeviceSample sample;
      sample.T_world_device = {turn, tip + place(n)};
      sample.pedal = 1;
      step(model, state, sample, tick);
      touching += tick.touching > 0;
      if (n < 500) continue;  // until the motion is steady
      force = std::max(force, tick.force.force.norm());
      drift = std::max(drift, (tick.T_world_tool.translation - sample.T_world_device.translation).norm());
    }
    r.measured.push_back({fmt::format("in air, {}: force", name), force, "N", goal, goal > 0});
    r.measured.push_back({fmt::format("  tool off the hand by ({})", name), 1000 * drift, "um", 0, false});
    r.measured.push_back({fmt::format("  ticks with contact ({})", name), static_cast<double>(touching), "", 0});
  };
  measure(
      "still, 5 s", [](int) { return Vec3d(Vec3d::Zero()); }, 0.01);
  measure(
      "at 3 mm/s", [](int n) { return Vec3d(-7.5 + 0.003 * n, 0, 0); }, 0.01);
  // An encoder's steps of 20 um at that speed, as a device sends them.
  measure(
      "at 3 mm/s in steps of 0.02 mm", [](int n) { return Vec3d(-7.5 + 0.02 * std::floor(0.15 * n), 0, 0); }, 0);
  // A tool of 20 g thrown to and fro 1 Hz wide and 5 Hz narrow weighs in the hand: by F = m a, 0.004 and 0.02 N.
  measure(
      "to and fro, 5 mm at 1 Hz", [](int n) { return Vec3d(5 * std::sin(2e-3 * M_PI * n), 0, 0); }, 0.01);
  measure(
      "to and fro, 1 mm at 5 Hz", [](int n) { return Vec3d(std::sin(1e-2 * M_PI * n), 0, 0); }, 0);
  return {};
}

// A tool pressed straight down into a block with constant force: means over a stretch of depth.
struct Plunge {
  double rate = 0, load = 0;  // mm^3/s, N
  std::vector<double> parts;  // removed in each 40 ms, mm^3
};
Expected<Plunge> plunge(const Model& model, std::shared_ptr<const BakedObject> block, double force, double from,
                        double to) {
  State state;
  state.objects.emplace_back(std::move(block), 8192);
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
  Plunge out;
  double seconds = 0, part = 0;
  for (int n = 0; hand.next(tick, sample);) {
    step(model, state, sample, tick);
    const double depth = -tick.T_world_tool.translation[2];
    if (depth < from || depth > to) continue;
    out.rate += tick.removed_mm3;
    out.load += tick.normal_load * kTick;
    seconds += kTick;
    part += tick.removed_mm3;
    if (++n % 40 == 0) {
      out.parts.push_back(part);
      part = 0;
    }
  }
  if (seconds == 0)
    return fail({Error::Code::kEmpty, "", "a plunge", fmt::format("never {} mm deep with {} N", from, force),
                 "to get there", "report this"});
  out.rate /= seconds;
  out.load /= seconds;
  return out;
}

// A ball whose whole surface moves at one speed, pressed into dentin with eight forces: the rate of removal over the
// normal load is a line through the origin whose slope is mu v / u_s.
Expected<void> fitRemoval(Result& r, const Progress& progress) {
  constexpr double kRadius = 0.8, kSpeed = 840;
  Model model;
  model.tools = {practiceBall(kRadius, kSpeed)};
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(tissues, tissueTable(materials));
  model.tissues = tissues;
  KERF_TRY(block, practiceBlock({4, 4, 4}, 0.05, {}, Material::kDentin));
  double nn = 0, nr = 0, rr = 0, sum_n = 0, sum_r = 0;
  int count = 0;
  for (const double force : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0}) {
    if (!report(progress, 0.15, "removal over load")) return cancelled();
    KERF_TRY(pressed, plunge(model, block, force, 1.2, 2.4));
    const double n = pressed.load, rate = pressed.rate;
    nn += n * n;
    nr += n * rate;
    rr += rate * rate;
    sum_n += n;
    sum_r += rate;
    ++count;
  }
  const Tissue& dentin = model.tissues[static_cast<std::size_t>(Material::kDentin)];
  const double slope = nr / nn;
  const double law = static_cast<double>(dentin.friction * dentin.inverse_energy) * kSpeed;
  // R^2 of the straight line with the best intercept: what it leaves unexplained.
  const double m = count, sxx = nn - sum_n * sum_n / m, sxy = nr - sum_n * sum_r / m, syy = rr - sum_r * sum_r / m;
  r.measured.push_back({"removal over normal load, 8 forces: slope", slope, "mm3/s per N", 0, false});
  r.measured.push_back({"  against mu v / u_s", std::abs(percentOff(slope, law)), "%", 5});
  r.measured.push_back({"  1 - R^2", 1 - sxy * sxy / (sxx * syy), "", 0.02});
  return {};
}

}  // namespace

Expected<Result> benchInvariance(const Progress& progress) {
  Result r{"invariance", "a ball of 1.6 mm draws a slot, 0.6 mm deep, 2 mm/s, through a block", {}, "", 0, ""};
  const Rigid3 askew{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vec3d(1, 2, 3).normalized())), Vec3d::Zero()};
  double least = 1e9, most = 0, least_rate = 1e9, most_rate = 0, law = 0;
  for (const double h : {0.1, 0.05, 0.025}) {
    if (!report(progress, 0.1 * (0.1 / h), "voxels")) return cancelled();
    KERF_TRY(f, slot(h, askew));
    least = std::min(least, f.force);
    most = std::max(most, f.force);
    least_rate = std::min(least_rate, f.rate);
    most_rate = std::max(most_rate, f.rate);
    if (!(f.normal > 0)) return fail({Error::Code::kEmpty, "", "slot", "no contact", "a cut", "report this"});
    law = std::max(law, std::abs(percentOff(f.rate, 0.5 * f.normal * 840 / 1000)));
    r.measured.push_back({fmt::format("force at {} mm", h), f.force, "N", 0, false});
    r.measured.push_back({fmt::format("removal at {} mm", h), f.rate, "mm3/s", 0, false});
    r.measured.push_back({fmt::format("jump of force per ms, eroding, at {} mm", h), f.jump, "N", 0.05});
    r.measured.push_back(
        {fmt::format("jump of torque about the tip per ms, eroding, at {} mm", h), f.turn_jump, "N mm", 1});
  }
  r.measured.push_back({"force over three voxels", percentOff(most, least), "%", 5});
  r.measured.push_back({"removal over three voxels", percentOff(most_rate, least_rate), "%", 5});
  r.measured.push_back({"removal against mu N v / u_s", law, "%", 5});

  least = 1e9;
  most = 0;
  least_rate = 1e9;
  most_rate = 0;
  for (int n = 0; n < 24; ++n) {
    if (!report(progress, 0.5 + 0.02 * n, "attitudes")) return cancelled();
    const Rigid3 frame{
        Eigen::Quaterniond(Eigen::AngleAxisd(
            0.37 * n, Vec3d(std::sin(2.0 * n), std::cos(3.0 * n), std::sin(5.0 * n) + 0.1).normalized())),
        0.013 * n * Vec3d(1, -2, 0.5)};
    KERF_TRY(f, slot(0.1, frame));
    least = std::min(least, f.force);
    most = std::max(most, f.force);
    least_rate = std::min(least_rate, f.rate);
    most_rate = std::max(most_rate, f.rate);
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
    box.add(Vec3d(center.array() - 5.1));
    box.add(Vec3d(center.array() + 5.1));
    KERF_TRY(ball, bakedFrom([&](const Vec3d& p) { return (p - center).norm() - 5; }, box, 0.05));
    State state;
    state.objects.emplace_back(ball, 64);
    StepOutput tick;
    double jump = 0, turn_jump = 0, force = 0;
    Wrench last;
    const int ticks = static_cast<int>(2 / (speed * kTick));
    for (int n = 0; n <= ticks; ++n) {
      // The tip's ball rolls over the pole, 0.0475 mm deep.
      const double a = (-1 + 2.0 * n / ticks) / 5;
      DeviceSample sample;
      sample.T_world_device.translation =
          center + (5.8 - 0.0475) * Vec3d(std::sin(a), 0.1 * a, std::cos(a)).normalized() - Vec3d(0, 0, 0.8);
      step(model, state, sample, tick);
      if (n > 0) {
        jump = std::max(jump, (tick.contact.force - last.force).norm());
        turn_jump = std::max(turn_jump, (tick.contact.torque - last.torque).norm());
      }
      last = tick.contact;
      force = std::max(force, last.force.norm());
    }
    r.measured.push_back(
        {fmt::format("jump of force per ms, sliding {} mm/s at {:.1f} N", speed, force), jump, "N", 0.02});
    r.measured.push_back(
        {fmt::format("jump of torque about the tip per ms, sliding {} mm/s", speed), turn_jump, "N mm", 1});
  }
  KERF_CHECK(measureAir(r));
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
    KERF_TRY(pressed, plunge(model, block, force, 1.2, 2.8));
    const std::vector<double>& parts = pressed.parts;
    rates[id] = pressed.rate / force;
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
  if (const auto fitted = fitRemoval(r, progress); !fitted) return fail(fitted.error());

  // The saw: 3 feeds x 3 rates of strokes x 3 densities of bone, 10 mm wide (J Biomech Eng 2014;136:034501). The
  // reference is the law in closed form, cutting energy as the square of the density: N = u_s V' / (mu v), V' the
  // kerf's volume a second.
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(sawing, makeModel(std::span(&saw, 1)));
  sawing.settings.rendering = Rendering::kRigid;
  Eigen::Matrix3d axes;
  axes.col(0) = Vec3d::UnitZ();
  axes.col(1) = -Vec3d::UnitY();
  axes.col(2) = Vec3d::UnitX();
  constexpr double kWide = 10;
  KERF_TRY(block, practiceBlock({kWide, 4, 4}, 0.05, {}, Material::kCortical));
  Tissue& bone = sawing.tissues[static_cast<std::size_t>(Material::kCortical)];
  const float dense = bone.inverse_energy;
  std::array<std::array<std::array<double, 3>, 3>, 3> grid{};  // density, feed, strokes
  double error = 0, worst = 0, jump = 0, turn_jump = 0, least_ratio = 1e9, most_ratio = 0;
  constexpr double kDensities[] = {0.8, 0.9, 1}, kFeeds[] = {20, 40, 60}, kCycles[] = {9800, 11200, 12600};
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        if (!report(progress, 0.2 + 0.8 * static_cast<double>(9 * d + 3 * i + j) / 27, "sawing")) return cancelled();
        bone.inverse_energy = dense / static_cast<float>(kDensities[d] * kDensities[d]);
        ToolDrive& drive = sawing.tools[0].drive;
        drive.speed = meanSpeed(saw.stroke_mm, kCycles[j] / 60);
        State state;
        state.objects.emplace_back(block, 8192);
        const Feed f = feed(sawing, state, {}, {Eigen::Quaterniond(axes), {-12.5, 0.01, 0.05}},
                            {0, 0, -(0.05 + kFeeds[i] / 60 * 1.2)}, kFeeds[i] / 60, 0.7);
        grid[d][i][j] = f.force;
        jump = std::max(jump, f.jump);
        turn_jump = std::max(turn_jump, f.turn_jump);
        // Speed sags with load, as the drive does: the law at the speed there is.
        const double speed = drive.speed * std::max(0.0, 1 - f.drag / drive.stall_load);
        const double reference =
            drive.energy_factor * kFeeds[i] / 60 * kWide * saw.kerfWidth() /
            (static_cast<double>(bone.inverse_energy) * static_cast<double>(bone.friction) * drive.drag_factor * speed);
        const double off = std::abs(percentOff(f.thrust, reference));
        error += off / 27;
        worst = std::max(worst, off);
        least_ratio = std::min(least_ratio, f.thrust / f.drag);
        most_ratio = std::max(most_ratio, f.thrust / f.drag);
        if (d == 2)
          r.measured.push_back(
              {fmt::format("saw, cortical, {} mm/min, {} cycles/min", kFeeds[i], kCycles[j]), f.force, "N", 0, false});
      }
  int wrong = 0;
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        if (d > 0) wrong += grid[d][i][j] <= grid[d - 1][i][j];
        if (i > 0) wrong += grid[d][i][j] <= grid[d][i - 1][j];
        if (j > 0) wrong += grid[d][i][j] >= grid[d][i][j - 1];
      }
  r.measured.push_back({"saw: pairs of 54 where force does not grow with density and feed, fall with strokes",
                        static_cast<double>(wrong), "", 0});
  r.measured.push_back({"saw: jump of force per ms", jump, "N", 0.05});
  r.measured.push_back({"saw: jump of torque about the tip per ms", turn_jump, "N mm", 1});
  r.measured.push_back({"saw: thrust against the law's reference, 27 runs, mean error", error, "%", 10});
  r.measured.push_back({"  the worst of the 27", worst, "%", 0, false});
  r.measured.push_back({"saw: thrust over cutting force, least", least_ratio, "", 0, false});
  r.measured.push_back({"  most over the 27", most_ratio, "", 0, false});
  r.measured.push_back({"  out of 1.4 to 1.8 by", std::max({0.0, 1.4 - least_ratio, most_ratio - 1.8}), "", 0});
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
  const BrickField changed = object.bricks().changedField();
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
      width += right + left;
      ++n;
      sx += x;
      sz += z;
      sxx += x * x;
      szz += z * z;
      sxz += x * z;
      sw += right;
      swx += right * x;
      swz += right * z;
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
  axes.col(0) = Vec3d::UnitZ();
  axes.col(1) = -Vec3d::UnitY();
  axes.col(2) = Vec3d::UnitX();
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
      width = std::max(width, kerf.width_error);
      plane = std::max(plane, kerf.plane_degrees);
      least = std::min(least, f.force);
      most = std::max(most, f.force);
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

}  // namespace kerf::cli
