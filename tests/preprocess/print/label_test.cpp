#include "preprocess/print/label.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "geometry/boolean/plane_cut.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/solids.h"
#include "preprocess/print/flat_shape.h"
#include "tests/preprocess/solid_checks.h"
#include "tests/support/places.h"

namespace kerf::label_test {
namespace {

void expectPrintable(const Mesh& mesh) {
  const MeshReport report = checkMesh(mesh);
  EXPECT_TRUE(report.print_ready) << (report.reasons.empty() ? "" : report.reasons.front());
  for (const Vec3d& p : mesh.vertices) ASSERT_EQ(p, roundedToFloat(p));
}

// Every character of Latin-1 that draws something.
std::vector<std::string> latinCharacters() {
  std::vector<std::string> out;
  for (int c = 0x21; c < 0x7F; ++c) out.push_back(std::string(1, static_cast<char>(c)));
  for (int c = 0xA1; c < 0x100; ++c)
    if (c != 0xAD) out.push_back({static_cast<char>(0xC0 | (c >> 6)), static_cast<char>(0x80 | (c & 0x3F))});
  return out;
}

Mesh moved(Mesh mesh, const Rigid3& pose) {
  for (Vec3d& p : mesh.vertices) p = roundedToFloat(pose * p);
  return mesh;
}

TEST(Label, TakesTheLettersVolumeOutOfABlock) {
  const Mesh block = box({0, 0, 0}, {60, 20, 8});
  for (const bool embossed : {false, true}) {
    const LabelOptions label{.text = "Nr. 17 36 öß", .embossed = embossed, .point = {30, 10, 8}};
    const auto done = withLabel(block, label);
    ASSERT_TRUE(done) << done.error().message();
    expectPrintable(done->part.mesh);
    EXPECT_NEAR(done->report.volume_mm3 / (done->report.area_mm2 * label.depth_mm), 1, 0.001);
    EXPECT_GT(done->report.area_mm2, 40);
    EXPECT_NEAR(done->report.least_depth_mm, 0.6, 1e-6);
    EXPECT_TRUE(done->report.warnings.empty());
    EXPECT_EQ(signedVolume(done->part.mesh) > signedVolume(block), embossed);
    for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(done->part.mesh.vertices[v], block.vertices[v]);
  }
}

TEST(Label, AHyphenHasTheAreaOfItsRectangle) {
  // Inter Bold: a rectangle. The only shape here whose area needs no font reader.
  const auto done = withLabel(box({0, 0, 0}, {20, 20, 8}), {.text = "-", .height_mm = 6, .point = {10, 10, 8}});
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_NEAR(done->report.volume_mm3, done->report.width_mm * done->report.height_mm * 0.6, 1e-3);
  EXPECT_NEAR(done->report.least_stroke_mm, done->report.height_mm, 1e-6);
}

TEST(Label, EveryCharacterCanBeCutAndPutOn) {
  const Mesh block = box({0, 0, 0}, {10, 12, 5});
  std::size_t tried = 0;
  for (const std::string& character : latinCharacters())
    for (const bool embossed : {false, true}) {
      const auto done = withLabel(block, {.text = character, .embossed = embossed, .point = {5, 6, 5}});
      ASSERT_TRUE(done) << character << ": " << done.error().message();
      const MeshReport report = checkMesh(done->part.mesh);
      EXPECT_TRUE(report.print_ready) << character << (report.reasons.empty() ? "" : report.reasons.front());
      EXPECT_EQ(report.pieces, 1u) << character;
      EXPECT_NEAR(done->report.volume_mm3 / (done->report.area_mm2 * 0.6), 1, 0.01) << character;
      ++tried;
    }
  EXPECT_EQ(tried, 2u * (94 + 94));
}

// Material at a point of the text's plane, in mm right and up of the label's point, just above or below the face.
bool isFilled(const Mesh& mesh, const LabelOptions& label, double x, double y) {
  const Vec3d n = label.normal.normalized(), up = label.up.normalized(), right = up.cross(n);
  return isInside(mesh, label.point + x * right + y * up + (label.embossed ? 0.3 : -0.3) * n);
}

TEST(Label, IsReadFromOutsideAndUprightOnEverySide) {
  const Mesh cube = box(-6, 6);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (const bool embossed : {false, true}) {
        LabelOptions label{.text = "F", .height_mm = 5, .embossed = embossed};
        label.normal = 2 * side * Vec3d::Unit(axis);
        label.point = 6 * side * Vec3d::Unit(axis);
        label.up = 3 * Vec3d::Unit((axis + 1) % 3);
        const auto done = withLabel(cube, label);
        ASSERT_TRUE(done) << done.error().message();
        // F: a stem on the left, a bar at the top right, nothing at the bottom right. 1: letter.
        const double x = done->report.width_mm / 2 - 0.4, y = done->report.height_mm / 2 - 0.4;
        const auto isLetter = [&](double u, double v) { return isFilled(done->part.mesh, label, u, v) == embossed; };
        EXPECT_TRUE(isLetter(-x, y) && isLetter(-x, -y) && isLetter(-x, 0) && isLetter(x, y));
        EXPECT_FALSE(isLetter(x, -y) || isLetter(0, -y));
      }
}

TEST(Label, LinesStandBelowEachOtherAndKeepTheirSide) {
  const Mesh block = box({-20, -10, -4}, {20, 10, 0});
  for (const TextAlign align : {TextAlign::kLeft, TextAlign::kCentre, TextAlign::kRight}) {
    LabelOptions label{.text = "HHHHH\r\nI", .align = align};
    const auto done = withLabel(block, label);
    ASSERT_TRUE(done) << done.error().message();
    expectPrintable(done->part.mesh);
    EXPECT_NEAR(done->report.height_mm, 4 * 2.6, 0.01);
    // The I in the second line.
    const double y = -done->report.height_mm / 2 + 1, width = done->report.width_mm;
    double low = width, high = -width;
    for (double x = -width / 2; x < width / 2; x += 0.05)
      if (!isFilled(done->part.mesh, label, x, y)) {
        low = std::min(low, x);
        high = std::max(high, x);
      }
    const double middle = (low + high) / 2;
    if (align == TextAlign::kLeft) {
      EXPECT_LT(middle, -width / 2 + 1);
    } else if (align == TextAlign::kCentre) {
      EXPECT_NEAR(middle, 0, 0.1);
    } else {
      EXPECT_GT(middle, width / 2 - 1);
    }
  }
}

TEST(Label, AnyFrameAndFarFromTheOriginTheSameVolume) {
  const Mesh block = box({-20, -5, -4}, {20, 5, 0});
  int tried = 0;
  for (const double away : {0.0, 200.0, 1000.0})
    for (const double angle : {0.3, 1.1, 2.7})
      for (const bool embossed : {false, true}) {
        const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3d(0.3, -0.5, 0.8).normalized())),
                          away * Vec3d(1, -0.7, 0.4)};
        const Mesh solid = moved(block, pose);
        const LabelOptions label{.text = "Größe 8&%",
                                 .embossed = embossed,
                                 .point = pose * Vec3d::Zero(),
                                 .normal = pose.rotation * Vec3d::UnitZ(),
                                 .up = pose.rotation * Vec3d::UnitY()};
        const auto done = withLabel(solid, label);
        ASSERT_TRUE(done) << away << " " << angle << ": " << done.error().message();
        expectPrintable(done->part.mesh);
        EXPECT_NEAR(done->report.volume_mm3 / (done->report.area_mm2 * 0.6), 1, 0.01) << away;
        for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(done->part.mesh.vertices[v], solid.vertices[v]);
        ++tried;
      }
  EXPECT_EQ(tried, 18);
}

TEST(Label, SameInputSameBits) {
  const Mesh solid = ball(60, 90, 20);
  const LabelOptions label{.text = "AB", .depth_mm = 1.5, .point = {0, 0, 20}};
  const auto a = withLabel(solid, label), b = withLabel(solid, label);
  ASSERT_TRUE(a && b) << a.error().message();
  EXPECT_EQ(a->part.mesh.vertices, b->part.mesh.vertices);
  EXPECT_EQ(a->part.mesh.triangles, b->part.mesh.triangles);
}

TEST(Label, RefusesWithNumbers) {
  const Mesh block = box({0, 0, 0}, {30, 10, 2});
  const LabelOptions good{.text = "Fall 17", .point = {15, 5, 2}};
  ASSERT_TRUE(withLabel(block, good));
  const auto refusal = [&](auto&& change) {
    LabelOptions label = good;
    change(label);
    const auto done = withLabel(block, label);
    EXPECT_FALSE(done);
    return done ? Error{} : done.error();
  };
  EXPECT_EQ(refusal([](auto& l) { l.text = ""; }).code, Error::Code::kEmpty);
  EXPECT_EQ(refusal([](auto& l) { l.text = " \n "; }).code, Error::Code::kEmpty);
  EXPECT_EQ(refusal([](auto& l) { l.text = "a\xFF"; }).code, Error::Code::kBadFormat);
  const Error missing = refusal([](auto& l) { l.text = "a牙b\U0001F9B7牙"; });
  EXPECT_EQ(missing.code, Error::Code::kUnsupported);
  EXPECT_NE(missing.message().find("牙 (U+7259), \U0001F9B7 (U+1F9B7);"), std::string::npos) << missing.message();
  EXPECT_NE(refusal([](auto& l) { l.text = "Gro\xCC\x88"; }).hint.find("NFC"), std::string::npos);
  EXPECT_NE(refusal([](auto& l) { l.text = "a\tb"; }).found.find("U+0009"), std::string::npos);
  EXPECT_EQ(refusal([](auto& l) { l.font = "/nowhere/Inter.otf"; }).code, Error::Code::kNotFound);
  EXPECT_EQ(refusal([](auto& l) { l.font = "/etc/passwd"; }).code, Error::Code::kUnreadable);
  EXPECT_EQ(refusal([](auto& l) { l.up = l.normal; }).code, Error::Code::kBadValue);
  EXPECT_EQ(refusal([](auto& l) { l.height_mm = NAN; }).code, Error::Code::kBadValue);
  EXPECT_EQ(refusal([](auto& l) { l.depth_mm = 0; }).code, Error::Code::kBadValue);
  EXPECT_EQ(refusal([](auto& l) { l.bend_radius_mm = 3; }).code, Error::Code::kBadValue);
  EXPECT_NE(refusal([](auto& l) { l.height_mm = 9; }).found.find("reaches beyond the face"), std::string::npos);
  EXPECT_NE(refusal([](auto& l) { l.point.z() = 9; }).found.find("reaches beyond the face"), std::string::npos);
  EXPECT_NE(refusal([](auto& l) { l.depth_mm = 1.2; }).found.find("a wall of 0.80 mm"), std::string::npos);
  EXPECT_NE(refusal([](auto& l) { l.depth_mm = 3; }).found.find("break through a wall of 2.00 mm"), std::string::npos);
  // A surface that is too round, and one that is too rough.
  const auto round = withLabel(ball(60, 90, 6), {.text = "36", .point = {0, 0, 6}});
  ASSERT_FALSE(round);
  EXPECT_NE(round.error().found.find("slopes by"), std::string::npos) << round.error().message();
  // A lip in front.
  Mesh lipped = both(box({0, 0, 0}, {30, 10, 5}), box({10, 2, 5.3}, {12, 6, 9}));
  const auto hidden = withLabel(lipped, good);
  ASSERT_FALSE(hidden);
  // Cancelled.
  const auto cancelled = withLabel(block, good, [](double, std::string_view) { return false; });
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, Error::Code::kCancelled);
}

TEST(Label, WarnsOfThinStrokesAndShallowLetters) {
  const Mesh block = box({0, 0, 0}, {30, 10, 5});
  const auto small = withLabel(block, {.text = "Nr. 8", .height_mm = 2, .depth_mm = 0.2, .point = {15, 5, 5}});
  ASSERT_TRUE(small) << small.error().message();
  EXPECT_EQ(small->report.warnings.size(), 2u);
  const auto large = withLabel(block, {.text = "Nr. 8", .height_mm = 4, .point = {15, 5, 5}});
  ASSERT_TRUE(large);
  EXPECT_TRUE(large->report.warnings.empty());
  EXPECT_NEAR(large->report.least_stroke_mm, 2 * small->report.least_stroke_mm, 0.03);
  EXPECT_GT(large->report.least_stroke_mm, 0.4);
  EXPECT_LT(large->report.least_stroke_mm, 0.9);
}

// ---- Shapes

using internal::Contour, internal::united;

Contour square(double x, double y, double side, bool clockwise = false) {
  Contour out{{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
  if (clockwise) std::reverse(out.begin(), out.end());
  return out;
}

TEST(FlatShape, OverlapsCountOnceAndTurnedContoursAreHoles) {
  const auto overlapping = united({square(0, 0, 2), square(1, 1, 2)});
  ASSERT_TRUE(overlapping);
  EXPECT_NEAR(overlapping->area(), 7, 1e-9);
  const auto hole = united({square(0, 0, 3), square(1, 1, 1, true)});
  ASSERT_TRUE(hole);
  EXPECT_NEAR(hole->area(), 8, 1e-9);
  EXPECT_NEAR(hole->leastStroke(9), 1, 1e-9);
  const auto twice = united({square(0, 0, 3), square(0, 0, 3)});
  ASSERT_TRUE(twice);
  EXPECT_NEAR(twice->area(), 9, 1e-9);
  // Clockwise fonts: TrueType.
  const auto turned = united({square(0, 0, 3, true), square(1, 1, 1)});
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->area(), 8, 1e-9);
  EXPECT_FALSE(united({{{0, 0}, {1, 1}, {2, 2}}}));
}

TEST(FlatShape, PartsThatTouchInAPointAreJoined) {
  for (const bool clockwise : {false, true}) {
    // Two squares corner to corner; a hole that touches the border; four squares around a point.
    const std::vector<std::vector<Contour>> cases{
        {square(0, 0, 1, clockwise), square(1, 1, 1, clockwise)},
        {square(0, 0, 3, clockwise), {{0, 1.5}, {1, clockwise ? 1.0 : 2.0}, {1, clockwise ? 2.0 : 1.0}}},
        {square(0, 0, 1, clockwise), square(1, 1, 1, clockwise), square(-1, 1, 1, clockwise),
         square(0, 2, 1, clockwise)}};
    for (const auto& contours : cases) {
      const auto shape = united(contours);
      ASSERT_TRUE(shape);
      std::vector<int> leaving(shape->points.size(), 0);
      for (const auto& edge : shape->border()) ++leaving[edge[0]];
      EXPECT_EQ(*std::max_element(leaving.begin(), leaving.end()), 1);
    }
    EXPECT_NEAR(united(cases[0])->area(), 2, 0.002);
    EXPECT_NEAR(united(cases[1])->area(), 8.5, 0.002);
  }
}

TEST(FlatShape, SquaresLimitTheSizeOfTriangles) {
  const auto shape = united({square(0, 0, 10)}, 1);
  ASSERT_TRUE(shape);
  EXPECT_NEAR(shape->area(), 100, 1e-5);
  for (const Triangle& t : shape->triangles)
    for (int k = 0; k < 3; ++k) EXPECT_LT(std::abs(shape->points[t[k]].x() - shape->points[t[(k + 1) % 3]].x()), 1.01);
}

// ---- Places

// The polygons as a solid from z = low to z = high.
Mesh extruded(const std::vector<Contour>& contours, double low, double high) {
  const auto shape = united(contours).value();
  Mesh out;
  for (const double z : {low, high})
    for (const auto& p : shape.points) out.vertices.push_back(roundedToFloat(Vec3d(p.x(), p.y(), z)));
  const auto top = static_cast<std::uint32_t>(shape.points.size());
  for (const Triangle& t : shape.triangles) {
    out.triangles.push_back({t[0], t[2], t[1]});
    out.triangles.push_back({top + t[0], top + t[1], top + t[2]});
  }
  for (const auto& [from, to] : shape.border()) {
    out.triangles.push_back({from, to, top + to});
    out.triangles.push_back({from, top + to, top + from});
  }
  return out;
}

// An arc of a ring of `radius` around the origin, open towards -y; 360 degrees: the outline of a disc.
Contour arc(double inner, double outer, double degrees) {
  Contour out;
  const int steps = static_cast<int>(degrees);
  const auto add = [&](double r, int n) {
    const double angle = std::numbers::pi * (90 + (n / double(steps) - 0.5) * degrees) / 180;
    out.push_back({r * std::cos(angle), r * std::sin(angle)});
  };
  for (int n = 0; n < steps + (degrees < 360); ++n) add(outer, n);
  if (inner > 0)
    for (int n = steps; n >= 0; --n) add(inner, n);
  return out;
}

TEST(LabelPlace, TheUndersideOfAHorseshoeTakesTheTextInOneLeg) {
  const Mesh shoe = extruded({arc(14, 27, 200)}, 0, 12);
  const LabelOptions wanted{.text = "Fall 17"};
  const auto place = placeLabel(shoe, {0, 0, -2}, LabelFace::kUnderside, wanted);
  ASSERT_TRUE(place) << place.error().message();
  EXPECT_EQ(place->label.height_mm, 4);
  EXPECT_TRUE(place->note.empty());
  EXPECT_NEAR(place->label.point.z(), 0, 1e-9);
  const auto done = withLabel(shoe, place->label);
  ASSERT_TRUE(done) << done.error().message();
  expectPrintable(done->part.mesh);
  EXPECT_NEAR(done->report.volume_mm3 / (done->report.area_mm2 * 0.6), 1, 0.001);
  // All corners have 1 mm of face around them.
  const Vec3d right = place->label.up.cross(place->label.normal);
  for (const double x : {-1, 1})
    for (const double y : {-1, 1}) {
      const Vec3d corner = place->label.point + x * (done->report.width_mm / 2 + 1) * right +
                           y * (done->report.height_mm / 2 + 1) * place->label.up;
      EXPECT_GT(corner.head<2>().norm(), 14 - 0.02);
      EXPECT_LT(corner.head<2>().norm(), 27);
    }
}

TEST(LabelPlace, ATextThatDoesNotFitGetsSmallerAndSaysSoOrIsRefused) {
  const Mesh bar = box({0, 0, 0}, {20, 8, 6});
  const auto smaller = placeLabel(bar, {0, 0, -1}, LabelFace::kUnderside, {.text = "Fall 17-4711"});
  ASSERT_TRUE(smaller) << smaller.error().message();
  EXPECT_LT(smaller->label.height_mm, 4);
  EXPECT_GT(smaller->label.height_mm, 2);
  EXPECT_EQ(smaller->wanted_height_mm, 4);
  EXPECT_NE(smaller->note.find("4 mm do not fit"), std::string::npos) << smaller->note;
  const auto done = withLabel(bar, smaller->label);
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_LT(done->report.width_mm, 18.1);
  EXPECT_GT(done->report.width_mm, 17);

  const std::string endless(60, 'W');
  for (const LabelFace face : {LabelFace::kUnderside, LabelFace::kSide}) {
    const auto none = placeLabel(bar, {0, 0, -1}, face, {.text = endless});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, Error::Code::kGeometry) << none.error().message();
  }
  EXPECT_FALSE(placeLabel(bar, {0, 0, 0}, LabelFace::kUnderside, {.text = "a"}));
  EXPECT_FALSE(placeLabel(bar, {0, 0, -1}, LabelFace::kUnderside, {.text = ""}));
  // No flat face at the end of a ball.
  EXPECT_FALSE(placeLabel(ball(60, 90, 20), {0, 0.3, -1}, LabelFace::kUnderside, {.text = "Fall 17"}));
}

TEST(LabelPlace, TheSideOfABlockIsFlatAndTheTextUprightOnIt) {
  const Mesh block = box({-20, -8, 0}, {20, 8, 10});
  const auto place = placeLabel(block, {0, 0, -1}, LabelFace::kSide, {.text = "F-17"});
  ASSERT_TRUE(place) << place.error().message();
  EXPECT_EQ(place->label.bend_radius_mm, 0);
  EXPECT_EQ(place->label.up, Vec3d::UnitZ());
  EXPECT_NEAR(std::abs(place->label.normal.y()), 1, 1e-9);
  EXPECT_NEAR(place->label.point.y(), 8 * place->label.normal.y(), 1e-9);
  EXPECT_LT(place->unevenness_mm, 1e-6);
  const auto done = withLabel(block, place->label);
  ASSERT_TRUE(done) << done.error().message();
  // The hyphen is left of the middle as seen from outside, the 7 at the right end reaches to the top.
  const double x = done->report.width_mm / 2, y = done->report.height_mm / 2;
  EXPECT_FALSE(isFilled(done->part.mesh, place->label, -x + 0.3, -y + 0.3));
  EXPECT_FALSE(isFilled(done->part.mesh, place->label, x - 0.5, y - 0.3));
  EXPECT_TRUE(isFilled(done->part.mesh, place->label, x - 0.3, -y + 0.3));
}

TEST(LabelPlace, TheTextFollowsARoundWall) {
  // A ring of 25 mm outside: the wall of a base. 26 mm of text turn by 60 degrees.
  const Mesh disc = extruded({arc(0, 25, 360)}, 0, 10);
  for (const bool embossed : {false, true}) {
    const auto place = placeLabel(disc, {0, 0, -1}, LabelFace::kSide, {.text = "Fall 17  36", .embossed = embossed});
    ASSERT_TRUE(place) << place.error().message();
    EXPECT_EQ(place->label.height_mm, 4);
    EXPECT_NEAR(place->label.bend_radius_mm, 25, 2);
    const auto done = withLabel(disc, place->label);
    ASSERT_TRUE(done) << done.error().message();
    expectPrintable(done->part.mesh);
    EXPECT_GE(done->report.least_depth_mm, 0.36);
    EXPECT_NEAR(done->report.volume_mm3 / (done->report.area_mm2 * 0.6), 1, 0.05);
    // The floor, all around: 0.36 to 0.6 mm from the wall.
    double low = 99, high = -99;
    for (std::size_t t = 0; t < done->part.mesh.triangles.size(); ++t) {
      if (!done->part.is_cut[t]) continue;
      for (int k = 0; k < 3; ++k) {
        const double off = done->part.mesh.corner(t, k).head<2>().norm() - 25;
        low = std::min(low, off);
        high = std::max(high, off);
      }
    }
    EXPECT_NEAR(embossed ? high : -low, 0.6, 0.06);
    EXPECT_LT(embossed ? -low : high, 0.03);
  }
}

TEST(LabelPlace, AHollowWallIsNotBrokenThrough) {
  const Mesh hollow =
      moved(both(box({-20, -8, 0}, {20, 8, 10}), flipped(box({-18.8, -6.8, 1.2}, {18.8, 6.8, 8.8}))), {});
  for (const LabelFace face : {LabelFace::kUnderside, LabelFace::kSide}) {
    LabelOptions label{.text = "F-17", .depth_mm = 0.6};
    const auto thin = placeLabel(hollow, {0, 0, -1}, face, label);
    // On the underside the place is found; cutting refuses it.
    const auto refused = thin ? withLabel(hollow, thin->label).error() : thin.error();
    EXPECT_NE(refused.message().find("a wall of 0.60 mm left"), std::string::npos) << refused.message();
    label.least_wall_mm = 0.5;
    const auto place = placeLabel(hollow, {0, 0, -1}, face, label);
    ASSERT_TRUE(place) << place.error().message();
    const auto done = withLabel(hollow, place->label);
    ASSERT_TRUE(done) << done.error().message();
    EXPECT_NEAR(done->report.wall_mm.value(), 0.6, 1e-5);
    EXPECT_EQ(checkMesh(done->part.mesh).cavities, 1u);
    label.embossed = true;
    label.least_wall_mm = 1;
    const auto raised = placeLabel(hollow, {0, 0, -1}, face, label);
    ASSERT_TRUE(raised) << raised.error().message();
    const auto put_on = withLabel(hollow, raised->label);
    ASSERT_TRUE(put_on) << put_on.error().message();
    expectPrintable(put_on->part.mesh);
    EXPECT_EQ(checkMesh(put_on->part.mesh).cavities, 1u);
  }
}

// ---- A real solid

TEST(LabelPlace, ARealMandibleCutByAPlaneTakesALabel) {
  const char* given = std::getenv("KERF_DATA");
  const std::filesystem::path folder =
      given ? std::filesystem::path(given) : std::filesystem::path(kSourceFolder) / ".." / "shared" / "data";
  const auto file = folder / "mandible-with-teeth-closed.obj";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no data: " << file << " (set KERF_DATA)";
  const auto read = readMesh(file);
  ASSERT_TRUE(read) << read.error().message();
  const Mesh jaw = moved(read->mesh, {});  // float32
  const Box3 box = bounds(jaw);
  const Plane plane{box.min + 0.25 * box.size(), Vec3d::UnitZ()};
  const auto cut = cutByPlanes(jaw, {&plane, 1});
  ASSERT_TRUE(cut) << cut.error().message();
  const auto place = placeLabel(cut->above.mesh, -Vec3d::UnitZ(), LabelFace::kUnderside, {.text = "36"});
  ASSERT_TRUE(place) << place.error().message();
  const auto done = withLabel(cut->above.mesh, place->label);
  ASSERT_TRUE(done) << done.error().message();
  expectPrintable(done->part.mesh);
  EXPECT_EQ(done->part.report.source_vertices_kept, cut->above.mesh.vertices.size());
}

// ---- Placeholders

TEST(Label, PlaceholdersAreReplacedAndUnknownOnesRefused) {
  const std::map<std::string, std::string> values{{"case", "17 {x}"}, {"tooth", "36"}};
  EXPECT_EQ(withPlaceholders("{case} {tooth}{tooth}", values).value(), "17 {x} 3636");
  EXPECT_EQ(withPlaceholders("{{a}}", values).value(), "{a}");
  EXPECT_EQ(withPlaceholders("", values).value(), "");
  const auto unknown = withPlaceholders("a {date}", values);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message().find("one of {case}, {tooth}"), std::string::npos) << unknown.error().message();
  EXPECT_FALSE(withPlaceholders("{case", values));
  EXPECT_FALSE(withPlaceholders("case}", values));
  EXPECT_FALSE(withPlaceholders("{}", values));
}

}  // namespace
}  // namespace kerf::label_test
