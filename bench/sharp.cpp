// Tools with edges and points: dependence of force and removal on the voxels and on the block's attitude to their grid.
// Machine-independent numbers, no times.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "bench/scenes/feed.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/scenes/sink.h"
#include "bench/spread.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

constexpr double kOverlap = 0.05;                              // mm, of a pressed tool
constexpr double kLean = 0.2;                                  // rad, of a pressed bur: its rim leads
constexpr double kSlide = 0.4;                                 // mm, along the surface
constexpr double kSlotDepth = 0.6;                             // mm, of a bur's slot
constexpr double kKerfDepth = 0.3;                             // mm, of a blade's kerf at the start
constexpr double kFeedLength = 0.5;                            // mm; means cover the last four fifths
constexpr double kAttitudeFine = 0.05, kAttitudeCoarse = 0.1;  // voxels, mm
constexpr int kAttitudes = 24;
constexpr int kRackAttitudes = 6;  // of every tool of the rack
constexpr double kRackFeed = 1;    // mm/s

// From the rack: a tool of every form with an edge or a point, and a ball for comparison.
struct Subject {
  std::string id;
  double feed;  // mm/s, of the cut: some newtons
};
const std::vector<Subject> kTwelve{
    Subject{"805-014", 1},    // inverted cone
    Subject{"837-012", 1},    // cylinder, flat end
    Subject{"847-012", 1},    // taper, flat end
    Subject{"850-014", 1},    // taper, round end
    Subject{"862-016", 1},    // flame
    Subject{"859-012", 1},    // needle
    Subject{"round-014", 1},  // ball
    Subject{"drill-20", 1},   // lips
    Subject{"saw-reciprocating-25", 1},
    Subject{"saw-sagittal-10", 1},
    Subject{"saw-piezo-050", 0.5},
    Subject{"disc-22", 1},
};

// ---- Poses in the frame of the block, whose top is z = 0

// The plunge direction points down, `depth` below the surface, over the middle of the block.
Rigid3 placed(const ToolModel& tool, double lean, double depth) {
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(tool.plunge_direction, -Vec3d::UnitZ());
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(lean, Vec3d(0.8, 0.6, 0)) * upright;
  const Vec3d lowest = turn * foremost(tool, turn.conjugate() * -Vec3d::UnitZ());
  const Vec3d middle = turn * tool.cut.bounds().center();
  const Vec3d over = lean > 0 ? lowest : middle;
  return {turn, Vec3d(0.011 - over[0], 0.013 - over[1], -depth - lowest[2])};
}

// ---- One tool

struct Tried {
  double pressed = 0, cutting = 0, removal = 0;  // N, N, mm^3/s
};

class Trial {
 public:
  Trial(Model model, double feed_speed) : model_(std::move(model)), feed_speed_(feed_speed) {
    ToolModel& tool = model_.tools[0];
    tool.drive.stall_load = 0;  // holds its speed: compares the law, not a stall
    speed_ = tool.drive.speed;
    const bool is_blade = tool.plunge_direction[2] > -0.9 || tool.motion != ToolMotion::kSpin;
    const bool goes_down = is_blade || tool.lips.areThere();
    pressed_ = placed(tool, is_blade ? 0 : kLean, kOverlap);
    const double slot = std::min(kSlotDepth, 0.8 * tool.cut.bounds().size()[2]);  // non-cutting parts stay above
    depth_ = is_blade ? kKerfDepth : tool.lips.areThere() ? tool.lips.height + kKerfDepth : slot;
    cutting_ = placed(tool, 0, depth_);
    way_ = kFeedLength * (goes_down ? Vec3d(-Vec3d::UnitZ()) : Vec3d(Vec3d::UnitX()));
    if (!goes_down) cutting_.translation -= 0.5 * way_;
  }

  Tried on(const std::shared_ptr<const BakedObject>& block, const Rigid3& frame) {
    Tried out;
    out.pressed = press(block, frame);
    const Feed f = cut(block, frame);
    out.cutting = f.force;
    out.removal = f.rate;
    return out;
  }

 private:
  // At a fixed overlap, the drive off, slid along an intact surface.
  double press(const std::shared_ptr<const BakedObject>& block, const Rigid3& frame) {
    model_.tools[0].drive.speed = 0;
    State state;
    state.objects.emplace_back(block, 64);
    const Vec3d way = kSlide * Vec3d(0.8, 0.6, 0);
    const Rigid3 from{pressed_.rotation, pressed_.translation - 0.5 * way};
    return feed(model_, state, frame, from, way, 4, 0).force;
  }

  // Straight down from the surface, as in a downward feed: the height of the cutting part leaves its mark.
  void sinkTo(const Rigid3& end, State& state, const Rigid3& frame) {
    constexpr int kTicks = 40;
    StepOutput tick;
    for (int n = 0; n < kTicks; ++n) {
      Rigid3 pose = end;
      pose.translation[2] += depth_ * (1 - static_cast<double>(n) / kTicks);
      step(model_, state, sampleAt(frame * pose), tick);
    }
  }

  // Fed evenly, from a free place.
  Feed cut(const std::shared_ptr<const BakedObject>& block, const Rigid3& frame) {
    model_.tools[0].drive.speed = speed_;
    State state;
    state.objects.emplace_back(block, 8192);
    state.speed = speed_;

    model_.settings.geometry_only = true;
    StepOutput tick;
    if (way_[2] < 0) sinkTo(cutting_, state, frame);
    step(model_, state, sampleAt(frame * cutting_), tick);
    model_.settings.geometry_only = false;
    return feed(model_, state, frame, cutting_, way_, feed_speed_, 0.2);
  }

  Model model_;
  double feed_speed_, speed_ = 0, depth_ = 0;
  Rigid3 pressed_, cutting_;
  Vec3d way_;
};

Expected<Trial> makeTrial(const Tool& tool, double feed_speed) {
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.rendering = Rendering::kRigid;
  return Trial(std::move(model), feed_speed);
}

// One entry per subject.
using Row = std::vector<Tried>;

Expected<Row> tryAll(std::vector<Trial>& trials, const std::vector<Subject>& subjects, double voxel,
                     const Rigid3& frame) {
  KERF_TRY(block, practiceBlock({6, 5, 3}, voxel, frame, Material::kCortical));
  Row row(trials.size());
  tbb::parallel_for(std::size_t{0}, trials.size(), [&](std::size_t t) { row[t] = trials[t].on(block, frame); });
  for (std::size_t t = 0; t < trials.size(); ++t)
    if (!(row[t].pressed > 0 && row[t].cutting > 0 && row[t].removal > 0))
      return brokenScene(subjects[t].id, "no contact", "a cut");
  return row;
}

Rigid3 attitudeOf(int n) {
  return turned(0.37 * n, {std::sin(2.0 * n), std::cos(3.0 * n), std::sin(5.0 * n) + 0.1},
                0.013 * n * Vec3d(1, -2, 0.5));
}

// ---- The table

constexpr std::array<const char*, 3> kQuantities{"force pressed", "force cutting", "removal"};

double quantityOf(const Tried& tried, std::size_t quantity) {
  return std::array{tried.pressed, tried.cutting, tried.removal}[quantity];
}

// Spread of one subject over the rows, %.
double spreadOf(const std::vector<Row>& rows, std::size_t subject, std::size_t quantity) {
  Spread spread;
  for (const Row& row : rows) spread.add(quantityOf(row[subject], quantity));
  return spread.percent();
}

// A column: the spread of each quantity over the rows, per tool, and the maximum of all tools.
void addColumn(Result& r, const std::string& column, const std::vector<Row>& rows) {
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    double most = 0;
    for (std::size_t t = 0; t < kTwelve.size(); ++t) {
      const double apart = spreadOf(rows, t, q);
      r.add(fmt::format("{}: {}, {}", column, kQuantities[q], kTwelve[t].id), apart, "%");
      most = std::max(most, apart);
    }
    r.add(fmt::format("{}: {}, most of all", column, kQuantities[q]), most, "%");
  }
}

void noteMeans(Result& r, const Row& fine) {
  for (std::size_t t = 0; t < kTwelve.size(); ++t)
    r.notes.push_back(fmt::format("{}, 0.025 mm voxels: pressed {:.3g} N; fed at {} mm/s {:.3g} N, {:.3g} mm3/s",
                                  kTwelve[t].id, fine[t].pressed, kTwelve[t].feed, fine[t].cutting, fine[t].removal));
}

// A column of the whole rack: how many tools meet the goal, and which miss it.
void addRackColumn(Result& r, const std::string& column, const std::vector<Row>& rows,
                   const std::vector<Subject>& subjects, double goal) {
  for (std::size_t q = 1; q < kQuantities.size(); ++q) {
    std::vector<double> apart;
    std::string beyond;
    for (std::size_t t = 0; t < subjects.size(); ++t) {
      apart.push_back(spreadOf(rows, t, q));
      if (apart.back() > goal)
        beyond += fmt::format("{}{} {:.1f}", beyond.empty() ? "" : ", ", subjects[t].id, apart.back());
    }
    const auto within = std::count_if(apart.begin(), apart.end(), [goal](double percent) { return percent <= goal; });
    const std::string name = fmt::format("{}: {}", column, kQuantities[q]);
    r.add(fmt::format("{}, tools within {:g} %", name, goal), static_cast<double>(within));
    r.add(name + ", p50", percentile(apart, 0.5), "%");
    r.add(name + ", p90", percentile(apart, 0.9), "%");
    r.add(name + ", most of all", percentile(apart, 1), "%");
    if (!beyond.empty()) r.notes.push_back(fmt::format("{}, beyond {:g} %: {}", name, goal, beyond));
  }
}

}  // namespace

Expected<Result> benchSharp(const Bench& bench) {
  Result r(
      SceneId::kSharp,
      "twelve tools on a flat block of bone, their drives holding their speed: how far apart force and removal lie");
  r.is_table = true;
  std::vector<Trial> trials;
  for (const Subject& subject : kTwelve) {
    KERF_TRY(tool, toolOfRack(subject.id));
    KERF_TRY(trial, makeTrial(tool, subject.feed));
    trials.push_back(std::move(trial));
  }

  std::vector<Row> over_voxels;
  for (const double voxel : {0.1, 0.05, 0.025}) {
    if (!report(bench.progress, 0.005 / voxel, "voxels")) return cancelled();
    KERF_TRY(row, tryAll(trials, kTwelve, voxel, askew()));
    over_voxels.push_back(row);
  }
  noteMeans(r, over_voxels.back());
  addColumn(r, "over voxels", over_voxels);

  double share = 0.3;
  for (const double voxel : {kAttitudeFine, kAttitudeCoarse}) {
    std::vector<Row> over_attitudes;
    for (int n = 0; n < kAttitudes; ++n) {
      if (!report(bench.progress, share, "attitudes")) return cancelled();
      share += voxel == kAttitudeFine ? 0.02 : 0.009;
      KERF_TRY(row, tryAll(trials, kTwelve, voxel, attitudeOf(n)));
      over_attitudes.push_back(row);
    }
    addColumn(r, fmt::format("24 at {} mm", voxel), over_attitudes);
  }
  return r;
}

Expected<Result> benchSharpRack(const Bench& bench) {
  Result r(SceneId::kSharpRack,
           "every tool of the rack fed through a flat block of bone, its drive holding its speed: how far apart force "
           "and removal lie");
  r.is_table = true;
  KERF_TRY(tools, wholeRack());
  std::vector<Subject> subjects;
  std::vector<Trial> trials;
  for (const Tool& tool : tools) {
    KERF_TRY(trial, makeTrial(tool, kRackFeed));
    trials.push_back(std::move(trial));
    subjects.push_back({tool.id, kRackFeed});
  }
  r.add("0.1 and 0.05 mm: tools", static_cast<double>(tools.size()));

  std::vector<Row> over_voxels;
  for (const double voxel : {0.1, 0.05}) {
    if (!report(bench.progress, 0.015 / voxel, "voxels")) return cancelled();
    KERF_TRY(row, tryAll(trials, subjects, voxel, askew()));
    over_voxels.push_back(row);
  }
  addRackColumn(r, "0.1 and 0.05 mm", over_voxels, subjects, 5);

  double share = 0.5;
  for (const auto& [voxel, goal] : {std::pair(kAttitudeFine, 3.0), std::pair(kAttitudeCoarse, 5.0)}) {
    std::vector<Row> over_attitudes;
    for (int n = 0; n < kRackAttitudes; ++n) {
      if (!report(bench.progress, share, "attitudes")) return cancelled();
      share += voxel == kAttitudeFine ? 0.07 : 0.01;
      KERF_TRY(row, tryAll(trials, subjects, voxel, attitudeOf(n)));
      over_attitudes.push_back(row);
    }
    addRackColumn(r, fmt::format("{} attitudes at {} mm", kRackAttitudes, voxel), over_attitudes, subjects, goal);
  }
  return r;
}

}  // namespace kerf::cli
