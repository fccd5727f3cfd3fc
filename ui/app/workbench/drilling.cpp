#include "ui/app/workbench/drilling.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "geometry/case/case_bundle.h"
#include "sim/hand/guided_hand.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

constexpr double kOutsideBox = 20;                                        // mm beyond the model's box
constexpr double kAlongFace = 0.1;                                        // cosine: less is along the surface
constexpr double kReached = 0.025;                                        // mm before the depth
constexpr std::uint64_t kHoleClearEvery = 200, kHoleBeginsWithin = 5000;  // ticks

tl::unexpected<Error> refuseHole(Error::Code code, std::string found, std::string expected, std::string hint) {
  return fail({.code = code, .found = std::move(found), .expected = std::move(expected), .hint = std::move(hint)});
}

}  // namespace

struct Drilling::Running {
  GuidedCut order;
  Hole hole;
  double deepest = 0;                    // of the tip, mm
  std::uint64_t began = 0, cleared = 0;  // ticks
  bool is_through = false, is_undone_after = false;
};

Drilling::Drilling(Workbench& bench) : bench_(bench) {}

Drilling::~Drilling() = default;

// ---- The plan

Expected<void> Drilling::setPlanning(bool is_on) {
  if (is_on) {
    if (!bench_.document->isOpen())
      return refuseHole(Error::Code::kEmpty, "nothing is open", "a model to drill", "open a scan first");
    KERF_TRY(shape, DrillShape::of(bench_.tools->held()));
    shape_ = std::move(shape);
    bench_.strokes->release();
  }
  is_planning_ = is_on;
  planAgain();
  return {};
}

void Drilling::setAxis(DrillAxis axis, const Camera& camera) {
  axis_ = axis;
  upright_ = camera.upright;
  if (place_) place_->to_viewer = camera.towardsViewer(place_->point);
  planAgain();
}

void Drilling::setDepth(std::optional<double> mm) {
  is_through_ = !mm;
  if (mm) depth_ = *mm;
  planAgain();
}

Box3 Drilling::boxIn(const Camera& camera) const {
  Box3 out;
  const Box3& box = bench_.document->run()->caseManifest().box;
  for (int n = 0; n < 8; ++n) out.add(camera.upright * box.corner(n));
  return out;
}

Expected<void> Drilling::placeAt(double x, double y, std::optional<double> z, const Camera& camera) {
  const Box3 box = boxIn(camera);
  const Eigen::Matrix3d to_world = camera.upright.transpose();
  const bool is_from_below = (camera.upright * camera.backwards())[2] < -0.2;
  const double outside = is_from_below ? box.min[2] - kOutsideBox : box.max[2] + kOutsideBox;
  const Vec3d from = {box.min[0] + x, box.min[1] + y, z ? box.min[2] + *z : outside};
  const Ray ray{to_world * from, to_world * Vec3d(0, 0, is_from_below ? 1 : -1)};
  if (auto placed = place(ray, camera); placed || placed.error().code != Error::Code::kEmpty) return placed;
  return refuseHole(
      Error::Code::kBadValue, fmt::format("no model at {:g}, {:g} mm", x, y),
      fmt::format("a place on the model, within 0 to {:.1f} and 0 to {:.1f} mm", box.size()[0], box.size()[1]),
      "measure from the left front corner of the model, seen from above, or click the place");
}

Expected<void> Drilling::placeUnder(const Ray& ray, const Camera& camera) { return place(ray, camera); }

Expected<void> Drilling::place(const Ray& ray, const Camera& camera) {
  if (!is_planning_) KERF_CHECK(setPlanning(true));
  place_.reset();
  hole_.reset();
  const LiveScene& scene = bench_.document->scene();
  const auto hit = scene.hit(ray);
  if (!hit) return refuseHole(Error::Code::kEmpty, "nothing is there", "a place on the model", "click the surface");
  const auto over = toolOver(scene, *bench_.document->run()->original(), ray, bench_.tools->plunge());
  if (!over)
    return refuseHole(Error::Code::kUnsupported, "a neighbour", "a place on the model itself",
                      "switch to the neighbour (neighbour.work-on) to drill it");
  upright_ = camera.upright;
  return plan({hit->id, hit->on_surface.point, over->normal, camera.towardsViewer(hit->on_surface.point)});
}

// Out of the material. A held axis counts before all others.
Expected<Vec3d> Drilling::axisAt(const Place& at, const Eigen::Matrix3d& upright) const {
  Vec3d out = upright.transpose() * Vec3d::UnitZ();
  if (bench_.strokes->heldAxis())
    out = *bench_.strokes->heldAxis();
  else if (axis_ == DrillAxis::kFace)
    out = at.normal;
  else if (axis_ == DrillAxis::kView)
    out = at.to_viewer;
  else if (axis_ == DrillAxis::kOcclusal)
    out = bench_.document->occlusal().normal.value_or(out);
  const double cosine = out.dot(at.normal);
  if (std::abs(cosine) < kAlongFace)
    return refuseHole(Error::Code::kUnsupported, "a surface along the axis of the drill", "a surface across it",
                      "choose the axis of the surface (drill.axis face) or of the view (drill.axis view)");
  return cosine > 0 ? out : Vec3d(-out);
}

Expected<void> Drilling::plan(const Place& at) {
  KERF_TRY(axis, axisAt(at, upright_));
  KERF_TRY(shape, DrillShape::of(bench_.tools->held()));
  shape_ = std::move(shape);
  const LiveScene& scene = bench_.document->scene();
  Hole hole{at.object, at.point, axis, depth_};
  if (is_through_) {
    const auto depth = depthThrough(hole, shape_, scene);
    if (!depth)
      return refuseHole(Error::Code::kGeometry, "no other side along the axis", "a closed model", "type a depth");
    hole.depth = *depth;
  }
  place_ = at;
  hole_ = hole;
  walls_ = wallsOf(hole, shape_, scene);
  seen_ = seen();
  return {};
}

Drilling::Seen Drilling::seen() const {
  return {bench_.tools->inHand(), bench_.document->scene().triangleCount(), bench_.strokes->heldAxis()};
}

void Drilling::planAgain() {
  if (!place_ || !is_planning_) return;
  hole_.reset();
  if (!bench_.document->scene().find(place_->object)) return place_.reset();
  if (const auto planned = plan(Place(*place_)); !planned) bench_.notices->complain(planned.error());
}

std::optional<HoleReadout> Drilling::readout(const Camera& camera) const {
  if (!hole_) return {};
  return HoleReadout{camera.upright * hole_->entry - boxIn(camera).min, 2 * shape_.radius,
                     std::max(hole_->depth - shape_.point, 0.0), walls_};
}

// ---- Drilling

Expected<void> Drilling::go() {
  if (!hole_)
    return refuseHole(Error::Code::kEmpty, "no place for a hole", "a place",
                      "click the model, or type x and y (drill.at)");
  if (bench_.saw->isCutting() || bench_.strokes->isPressed() || bench_.steps->isMoving())
    return refuseHole(Error::Code::kUnsupported, "the tool is in use", "a tool at rest",
                      "wait, or stop it (drill.stop)");
  if (bench_.device->isLed())
    return refuseHole(Error::Code::kUnsupported, "a force-feedback device holds the tool", "no device",
                      "disconnect it (device.close)");
  KERF_CHECK(plan(Place(*place_)));
  Document& document = *bench_.document;
  const Hole hole = *hole_;
  const HoleRoom room = roomFor(hole, shape_, document.scene());
  if (hole.depth > room.most_depth)
    return refuseHole(Error::Code::kGeometry,
                      fmt::format("{:.1f} mm deep, but a wider part of {} meets the model at {:.1f} mm", hole.depth,
                                  bench_.tools->held().id, std::max(room.most_depth, 0.0)),
                      "room for the shank", "drill less deep, choose a longer drill, or turn the axis");

  GuidedCut order;
  order.id = bench_.saw->nextOrder();
  order.is_wanted = true;
  order.start = {attitudeAlong(bench_.tools->plunge(), hole.axis), hole.entry + room.start * hole.axis};
  order.back = hole.axis;
  order.ways[order.count++] = {hole.entry - hole.depth * hole.axis, true};
  order.ways[order.count++] = {order.start.translation, false};
  order.force = kForce;
  order.feed = kFeed;
  order.past = kForce / document.run()->model().settings.coupling.stiffness;
  order.irrigation = bench_.strokes->irrigation;
  if (document.report().is_latched) document.send(ClearLatch{});
  document.hands().guided->order(order);
  const Vec3d& p = order.start.translation;
  const Eigen::Quaterniond& q = order.start.rotation;
  if (!document.send(PlaceTool{{p[0], p[1], p[2]}, {q.w(), q.x(), q.y(), q.z()}})) {
    order.is_wanted = false;
    document.hands().guided->order(order);
    return refuseHole(Error::Code::kUnsupported, "the 1 kHz thread is busy", "a free place in its queue", "try again");
  }
  ++holes_;
  const std::uint64_t now = document.report().tick;
  drilling_ = std::make_unique<Running>(
      Running{.order = order, .hole = hole, .began = now, .cleared = now, .is_through = is_through_});
  bench_.steps->beginPlannedCut(phrase("hole {}", holes_));
  last_depth_ = 0;
  return {};
}

void Drilling::stop() {
  if (!drilling_ || !drilling_->order.is_wanted) return;
  drilling_->order.is_wanted = false;
  bench_.document->hands().guided->order(drilling_->order);
}

void Drilling::stopAndUndo() {
  stop();
  if (drilling_) drilling_->is_undone_after = true;
}

std::optional<DrillingStatus> Drilling::status() const {
  if (!drilling_) return {};
  return DrillingStatus{drilling_->deepest, drilling_->hole.depth, !drilling_->order.is_wanted};
}

void Drilling::update() {
  if (!bench_.document->isOpen()) return;
  if (!drilling_) {
    const Seen now = seen();
    if (!is_planning_ || now == seen_) return;
    if (!DrillShape::of(bench_.tools->held())) is_planning_ = false;
    planAgain();
    if (!hole_) place_.reset();
    seen_ = now;
    return;
  }
  Running& d = *drilling_;
  bench_.document->hands().guided->update();
  const GuidedReport report = bench_.document->hands().guided->report();
  const HapticReport& now = bench_.document->report();
  if (report.id != d.order.id) {  // the tool is not there yet
    if (now.tick < d.began + kHoleBeginsWithin) return;
    bench_.notices->complain({.code = Error::Code::kUnsupported,
                              .found = "the drill did not reach its start above the model",
                              .hint = "run drill.go again"});
    stop();
    drilling_.reset();
    bench_.steps->endPlannedCut();
    return;
  }
  if (now.is_latched && now.tick > d.cleared + kHoleClearEvery) {
    bench_.document->send(ClearLatch{});
    d.cleared = now.tick;
  }
  d.deepest = std::max(d.deepest, d.hole.axis.dot(d.hole.entry - now.output.T_world_tool.translation));
  // The turn at the bottom may fall between two reports.
  if (report.way > 0 && report.given_up == 0) d.deepest = std::max(d.deepest, d.hole.depth - kReached);
  if (report.stage == GuidedStage::kOver || report.stage == GuidedStage::kNone) finish();
}

void Drilling::finish() {
  const Running d = *drilling_;
  drilling_.reset();
  last_depth_ = std::max(d.deepest, 0.0);
  bench_.steps->endPlannedCut(
      phrase("hole {}, {:.1f} mm wide, {:.1f} mm deep", holes_, 2 * shape_.radius, last_depth_));
  const bool is_reached = last_depth_ >= d.hole.depth - 2 * kReached;
  if (is_reached && hole_ == d.hole) {  // the next one may be planned already
    place_.reset();
    hole_.reset();
  }
  const std::string name = phrase("Hole {}", holes_);
  if (is_reached && d.is_through)
    bench_.notices->say(phrase("{}: through, {:.1f} mm wide", name, 2 * shape_.radius));
  else if (is_reached)
    bench_.notices->say(phrase("{}: depth reached {:.1f} mm, {:.1f} mm wide", name, d.hole.depth, 2 * shape_.radius));
  else if (!d.order.is_wanted)
    bench_.notices->say(phrase("{}: stopped at {:.1f} of {:.1f} mm", name, last_depth_, d.hole.depth));
  else
    bench_.notices->complain({.code = Error::Code::kUnsupported,
                              .place = name,
                              .found = fmt::format("the tool made no progress at {:.1f} mm", last_depth_),
                              .expected = fmt::format("{:.1f} mm", d.hole.depth),
                              .hint = "choose a drill that cuts this material"});
  if (d.is_undone_after) bench_.steps->undo();
}

// ---- The open document

void Drilling::opened(Opening how) {
  drilling_.reset();
  place_.reset();
  hole_.reset();
  seen_ = {};
  if (how == Opening::kReopened) return;
  is_planning_ = false;
  holes_ = 0;
  last_depth_ = 0;
}

void Drilling::closing() {
  if (!bench_.document->isOpen()) return;
  stop();
  drilling_.reset();
}

}  // namespace kerf
