#include "sim/live/stroke_peaks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::stroke_peaks_test {
namespace {

using test::block;
using test::oneTissue;
using test::sampleAt;

Rigid3 at(double x, double z) { return {Eigen::Quaterniond::Identity(), Vec3d(x, 0, z)}; }

// A block with its top at z = 0, a ball, and a counter of its peaks. The kept structure lies 1 mm below the top.
class Person {
 public:
  Person() : session_(model(), {block({4, 3, 2}, 0.1)}, at(0, 1)) {}

  // Down to a depth at x, and out again; in air if the depth is negative.
  void stroke(double x, double depth) {
    const int steps = static_cast<int>(1000 * (depth + 0.2));
    for (int n = 0; n < 250; ++n) tick(at(x, 2.7 - 0.01 * n), 0);
    for (int n = 0; n < steps; ++n) tick(at(x, 0.2 - 0.001 * n), 1);
    for (int n = 0; n < 300; ++n) tick(at(x, -depth + 0.01 * n), 0);
  }
  void give(const Command& command) { EXPECT_TRUE(session_.apply(command)); }
  double nearest(const CutPeaks& peaks) const {
    return peaks.nearest_mm[0].isKnown() ? peaks.nearest_mm[0].value : NAN;
  }
  double standing() { return nearest(now().standing()); }
  double takenBack() { return nearest(now().takenBack()); }
  const StrokePeaks& now() {
    peaks_.follow(session_.undoList());
    return peaks_;
  }
  std::size_t steps() const { return session_.undoList().undoable; }

 private:
  static Model model() {
    Model out;
    out.tools.push_back(practiceBall(0.5, 2000));
    out.tissues = oneTissue(60, 0.1, 1e3);
    return out;
  }
  void tick(const Rigid3& place, double pedal) {
    const DeviceSample sample = sampleAt(place, pedal);
    session_.tick(sample, output_);
    StrokePeaks::Distances kept;
    kept.fill(NAN);
    kept[0] = output_.T_world_tool.translation[2] - 0.5 + 1;
    const AllocationGuard guard;
    peaks_.tick(sample, output_, session_.undoList(), session_.state().tick - 1, NAN, kept);
  }

  Session session_;
  StrokePeaks peaks_;
  StepOutput output_;
};

TEST(StrokePeaks, AreOfStrokesThatStandUntilOthersComeInTheirPlace) {
  Person p;
  EXPECT_TRUE(std::isnan(p.standing()));
  p.stroke(0, 0.2);
  const double first = p.standing();
  EXPECT_TRUE(std::isnan(p.takenBack()));
  p.stroke(1, 0.5);
  const double second = p.standing();
  ASSERT_LT(second, first - 0.05) << "or the test says nothing";
  ASSERT_EQ(p.steps(), 2u);

  p.give(Undo{});
  EXPECT_EQ(p.standing(), first);
  EXPECT_EQ(p.takenBack(), second);
  p.give(Redo{});
  EXPECT_EQ(p.standing(), second);
  EXPECT_TRUE(std::isnan(p.takenBack()));
  p.give(Undo{});
  p.give(Undo{});
  EXPECT_GT(p.standing(), first) << "the way there alone";
  p.give(Redo{});
  p.stroke(-1, 0.3);  // in the place of the second
  const double third = p.standing();
  EXPECT_LT(third, first);
  EXPECT_GT(third, second);
  EXPECT_EQ(p.takenBack(), second);
  p.give(Undo{});
  p.give(Undo{});
  EXPECT_EQ(p.takenBack(), second) << "dropped, and the nearest of all";
}

TEST(StrokePeaks, OfAStrokeInAirStandWhateverIsTakenBack) {
  Person p;
  p.stroke(0, 0.3);
  p.stroke(1, -0.1);
  ASSERT_EQ(p.steps(), 1u);
  const double cut = p.standing();
  p.give(Undo{});
  EXPECT_GT(p.standing(), 0.5);
  EXPECT_EQ(p.takenBack(), cut);
}

TEST(StrokePeaks, OfAMoveBetweenStrokesAreNone) {
  Person p;
  p.stroke(0, 0.3);
  const double cut = p.standing();
  p.give(MoveObject{0, {0, 0, -1}});
  p.stroke(1, -0.1);
  p.give(Undo{});
  EXPECT_EQ(p.standing(), cut);
  p.give(Undo{});
  EXPECT_EQ(p.takenBack(), cut);
}

}  // namespace
}  // namespace kerf::stroke_peaks_test
