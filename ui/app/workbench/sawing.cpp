#include "ui/app/workbench/sawing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "geometry/case/case_bundle.h"
#include "sim/hand/guided_hand.h"
#include "sim/run/files/run_manifest.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/saw/plane_words.h"
#include "ui/app/workbench/drilling.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr double kSawDegree = std::numbers::pi / 180;
constexpr double kAboveCut = 0.3;       // mm before the first contact of the teeth
constexpr double kLift = 2;             // mm above the bone, between passes
constexpr double kMostLift = 20;        // mm, to clear an obstacle
constexpr double kAsideIsTold = 0.15;   // mm
constexpr double kMarkEvery = 0.2;      // mm of tool travel
constexpr double kBesidePlane = 8;      // mm: greatest distance of a guided blade from the plane when put down
constexpr double kBesideEdge = 3;       // mm
constexpr double kFromAbove = 30;       // mm above the rectangle: start of the surface search for a guided blade
constexpr int kAlongLine = 21;          // surface samples along a line
constexpr double kBodyTolerance = 0.1;  // mm, of the blade as a mesh
constexpr std::uint64_t kClearEvery = 200, kBeginsWithin = 5000;  // ticks
constexpr auto kSaveAfter = std::chrono::seconds(1);

tl::unexpected<Error> refuse(Error::Code code, std::string found, std::string expected, std::string hint) {
  return fail({.code = code, .found = std::move(found), .expected = std::move(expected), .hint = std::move(hint)});
}

// The ray between two rays of one view; part 0 is the first.
Ray rayBetween(const Ray& from, const Ray& to, double part) {
  const Vec3d apart = to.origin - from.origin, origin = from.origin + part * apart;
  const double cosine = from.direction.dot(to.direction), sine2 = 1 - cosine * cosine;
  if (sine2 < 1e-18) return {origin, from.direction};

  // In perspective all rays come from the eye, where the two lines meet.
  const double back = (apart.dot(from.direction) - cosine * apart.dot(to.direction)) / sine2;
  return {origin, (origin - from.at(back)).normalized()};
}

// v just before the first contact of the teeth on the way down from `above` to the pass.
double firstTissue(const SawPlane& plane, const SawBlade& blade, const BrickField& bone, const SawPass& pass,
                   double above) {
  constexpr double kStep = 0.2;  // mm
  for (double v = above; v < pass.from; v += kStep)
    for (double beside = -0.5 * blade.span; beside <= 0.5 * blade.span; beside += kStep)
      for (const double side : {-0.5, 0.0, 0.5})
        if (bone.sample(plane.fromPlane(pass.u + beside, v) + side * blade.kerf * plane.normal) < 0)
          return v - kAboveCut;
  return pass.from;
}

// In the frame of the piece as loaded.
CutPlanes planesIn(const SceneObject& piece, const CutPlanes& planes) {
  if (!piece.isMoved()) return planes;
  const Rigid3 T_piece_world = piece.T_world_object.inverse();
  const auto turned = [&](const Vec3d& unit) -> Vec3d { return (T_piece_world.rotation * unit).normalized(); };
  CutPlanes out;
  out.kerf_mm = planes.kerf_mm;
  for (const Plane& plane : planes.planes()) out.add({T_piece_world * plane.point, turned(plane.normal)});
  RoundHole hole = planes.hole();
  hole.mouth = T_piece_world * hole.mouth;
  hole.axis = turned(hole.axis);
  if (planes.hasHole()) out.setHole(hole);
  return out;
}

// By its box.
bool isMet(const SceneObject& piece, const CutPlanes& planes) {
  const Box3 box = piece.surface.bounds();
  bool has_below = false;
  for (const Plane& plane : planesIn(piece, planes).planes()) {
    double least = plane.height(box.corner(0)), most = least;
    for (int n = 1; n < 8; ++n) {
      least = std::min(least, plane.height(box.corner(n)));
      most = std::max(most, plane.height(box.corner(n)));
    }
    if (most <= 0) return false;
    has_below |= least < 0;
  }
  return has_below;
}

}  // namespace

struct Sawing::Cutting {
  GuidedCut order;
  SawnSection section;
  SawPlane plane;
  Vec3d front;                           // of the blade, tool frame
  double kerf = 0;                       // mm
  double removed_before = 0;             // mm^3
  Rigid3 last;                           // of the tool
  double aside = 0;                      // greatest distance of the blade from its plane, mm
  std::uint64_t began = 0, cleared = 0;  // ticks
  bool is_begun = false, is_undone_after = false;
};

Sawing::Sawing(Workbench& bench) : die(bench), bench_(bench) {}

Sawing::~Sawing() = default;

// ---- Planes

SawBlade Sawing::blade() const {
  for (std::size_t n = 0; n <= bench_.tools->count(); ++n) {
    const std::size_t which = n == 0 ? bench_.tools->inHand() : n - 1;
    if (which >= bench_.tools->count()) continue;
    if (const auto blade = SawBlade::of(bench_.tools->at(which))) return *blade;
  }
  return {};
}

Expected<void> Sawing::requireOpen() const {
  if (bench_.document->isOpen()) return {};
  return refuse(Error::Code::kEmpty, "nothing is open", "an object to saw", "open a scan first");
}

bool Sawing::isMoved() const {
  const auto shown = bench_.document->scene().shown();
  return std::any_of(shown.begin(), shown.end(), [](const SceneObject* piece) { return piece->isMoved(); });
}

// A plan applies to the object as loaded: at a moved piece it would saw air.
Expected<void> Sawing::requireUnmoved() const {
  if (!isMoved()) return {};
  return refuse(Error::Code::kUnsupported, "a piece was moved", "all pieces at their scan positions",
                "put the pieces back (piece.put-back), or saw free-hand");
}

Expected<SurfaceHit> Sawing::hit(const Ray& ray) const {
  KERF_CHECK(requireOpen());
  if (const auto at = bench_.document->scene().hit(ray)) return at->on_surface;
  return refuse(Error::Code::kEmpty, "nothing is there", "a pixel of the object", "point at the surface");
}

Expected<SawPlane> Sawing::chosen() const {
  if (const SawPlane* const plane = plan_.chosen()) return *plane;
  return refuse(Error::Code::kEmpty, "no planned plane", "a plane to saw",
                "draw a line across the bone (saw.line), or pick three points of it");
}

Expected<void> Sawing::addFitted(SawPlane plane, FitOptions options) {
  KERF_CHECK(requireUnmoved());
  KERF_CHECK(requireOpen());
  KERF_TRY(fitted, fitToBone(std::move(plane), *bench_.document->run()->original(), blade(), options));
  plan_.add(fitted);
  return {};
}

Expected<void> Sawing::addThrough(const std::array<Ray, 3>& rays) {
  std::array<Vec3d, 3> points;
  Vec3d outward = Vec3d::Zero();
  for (std::size_t n = 0; n < 3; ++n) {
    KERF_TRY(at, hit(rays[n]));
    points[n] = at.point;
    outward += at.normal;
  }
  KERF_TRY(plane, planeThrough(points, outward));
  return addFitted(plane, {});
}

Expected<void> Sawing::addAlongLine(const Ray& from, const Ray& to) {
  KERF_CHECK(requireOpen());
  // The surface under the line, nearest to its middle.
  std::optional<SurfaceHit> nearest;
  double best = 1;
  for (int n = 0; n < kAlongLine; ++n) {
    const double part = static_cast<double>(n) / (kAlongLine - 1), away = std::abs(part - 0.5);
    if (away >= best) continue;
    const auto at = bench_.document->scene().hit(rayBetween(from, to, part));
    if (!at) continue;
    nearest = at->on_surface;
    best = away;
  }
  if (!nearest)
    return refuse(Error::Code::kEmpty, "a line that misses the object", "a line across the bone",
                  "draw it from one side of the bone to the other");

  // The ends of the line at the depth of the surface.
  const Vec3d view = rayBetween(from, to, 0.5).direction;
  const auto atDepth = [&](const Ray& ray) {
    return ray.at(view.dot(nearest->point - ray.origin) / view.dot(ray.direction));
  };
  KERF_TRY(plane, planeAlongView(atDepth(from), atDepth(to), view));
  const Vec3d under = plane.toPlane(nearest->point);
  plane.point = plane.fromPlane(under[0], under[1]);
  const double half = 0.5 * plane.width;
  return addFitted(plane, {.across = {{-half - under[0], half - under[0]}}, .keeps_approach = true});
}

Expected<void> Sawing::addFromView(const Ray& at, const Vec3d& right) {
  KERF_TRY(under, hit(at));
  KERF_TRY(plane, planeSquareTo(under.point, right, at.direction));
  return addFitted(plane, {.keeps_approach = true});
}

Expected<void> Sawing::addAlongFace(const Ray& at, double below_mm) {
  KERF_CHECK(hit(at));
  // The mean normal around the point, as a tool stands there.
  const auto over = toolOver(bench_.document->scene(), *bench_.document->run()->original(), at, Plunge{});
  const Vec3d normal = over ? over->normal : Vec3d(-at.direction);
  KERF_TRY(under, hit(at));
  KERF_TRY(plane, planeSquareTo(under.point - below_mm * normal, normal));
  return addFitted(plane, {});
}

Expected<void> Sawing::addAt(const Vec3d& point, const Vec3d& normal) {
  KERF_TRY(plane, planeSquareTo(point, normal));
  auto added = addFitted(plane, {});
  if (added || added.error().code != Error::Code::kEmpty || !bench_.document->isOpen()) return added;

  // The point lies beside the object, but the plane may pass through it: bounds it where the surface is nearest.
  KERF_TRY(solid, readCaseSolid(bench_.document->run()->caseFolder()));
  const Plane wanted{plane.point, plane.normal};
  const auto away = [&](const Vec3d& p) {  // from the plane, then from the point
    constexpr double kInPlane = 0.2;       // mm
    return std::pair(std::max(std::abs(wanted.height(p)), kInPlane), (p - point).norm());
  };
  const auto nearest = std::min_element(solid.vertices.begin(), solid.vertices.end(),
                                        [&](const Vec3d& a, const Vec3d& b) { return away(a) < away(b); });
  if (nearest == solid.vertices.end()) return added;
  plane.point = *nearest - wanted.height(*nearest) * plane.normal;
  return addFitted(plane, {});
}

Expected<void> Sawing::move(double mm) {
  KERF_TRY(plane, chosen());
  movePlane(plane, mm);
  plan_.replaceChosen(plane);
  return {};
}

Expected<void> Sawing::turn(double about_approach_deg, double about_across_deg) {
  KERF_TRY(plane, chosen());
  turnPlane(plane, about_approach_deg * kSawDegree, about_across_deg * kSawDegree);
  plan_.replaceChosen(plane);
  return {};
}

Expected<void> Sawing::turnApproach(double deg) {
  KERF_TRY(plane, chosen());
  kerf::turnApproach(plane, deg * kSawDegree);
  plan_.replaceChosen(plane);
  return {};
}

Expected<void> Sawing::resize(std::optional<double> width_mm, std::optional<double> depth_mm) {
  KERF_TRY(plane, chosen());
  const SawBlade now = blade();
  if (width_mm) plane.width = std::min(*width_mm, now.most_width);
  if (depth_mm) plane.depth = std::min(*depth_mm, now.most_depth);
  plan_.replaceChosen(plane);
  return {};
}

std::optional<SawClearance> Sawing::clearance() {
  const SawPlane* const plane = plan_.chosen();
  const Structures* const structures = bench_.document->structures();
  if (!plane || !structures || structures->isEmpty()) return {};
  const double kerf = blade().kerf;
  if (measured_.version != plan_.version() || measured_.kerf != kerf || measured_.of != structures)
    measured_ = {plan_.version(), kerf, structures, clearanceOf(*plane, kerf, *structures)};
  return measured_.clearance;
}

std::optional<SawCoverage> Sawing::coverage() {
  const SawPlane* const plane = plan_.chosen();
  if (!plane || !bench_.document->isOpen()) return {};
  const SawBlade now = blade();
  if (covered_.version != plan_.version() || covered_.most_depth != now.most_depth)
    covered_ = {plan_.version(), now.most_depth, coverageOf(*plane, *bench_.document->run()->original(), now)};
  return covered_.coverage;
}

Expected<void> Sawing::fit() {
  KERF_TRY(plane, chosen());
  KERF_CHECK(requireOpen());
  // From a point within the rectangle, whose entering side lies outside the bone.
  plane.point = plane.fromPlane(0, 0.5 * std::min(plane.depth, 6.0));
  const std::array<double, 2> across{-0.5 * plane.width, 0.5 * plane.width};
  KERF_TRY(fitted, fitToBone(plane, *bench_.document->run()->original(), blade(),
                             {.across = across, .limits = false, .keeps_approach = true}));
  plan_.replaceChosen(fitted);
  return {};
}

Expected<void> Sawing::save(const fs::path& file) const { return plan_.save(file); }

Expected<void> Sawing::load(const fs::path& file) {
  std::error_code ignored;
  KERF_TRY(origin, plan_.load(fs::is_directory(file, ignored) ? file / kSawPlanFile : file));
  if (origin.frame.empty()) return {};
  const std::size_t n = plan_.planes().size();
  bench_.notices->say(origin.isTurned() ? phrase("{} planes of 3D Slicer: x and y negated ({})", n, origin.frame)
                                        : phrase("{} planes of 3D Slicer: as written ({})", n, origin.frame));
  return {};
}

// ---- Sawing a plane

std::string Sawing::sawsOfTheRack() const {
  std::string out;
  for (std::size_t n = 0; n < bench_.tools->count(); ++n)
    if (SawBlade::of(bench_.tools->at(n))) out += (out.empty() ? "" : ", ") + bench_.tools->at(n).id;
  return out;
}

// In air, as low above the first pass as the whole blade has room.
Expected<Rigid3> Sawing::startAbove(const SawPlane& plane, const SawBlade& blade, double u, double v,
                                    bool is_turned) const {
  const BrickField& bone = *bench_.document->run()->original();
  const Mesh body = toolMesh(bench_.tools->held(), kBodyTolerance);
  for (double lift = kLift; lift <= kMostLift; lift += 0.5) {
    const Rigid3 pose = blade.poseAt(plane.fromPlane(u, v - lift), plane.normal, plane.approach, is_turned);
    const auto isFree = [&](const Vec3d& p) { return bone.sample(pose * p) > 0; };
    if (std::all_of(body.vertices.begin(), body.vertices.end(), isFree)) return pose;
  }
  return refuse(Error::Code::kGeometry, "other bone above the plane blocks the blade",
                "a free path for the blade from outside",
                "turn the approach (saw.approach DEG), or take a smaller blade");
}

Expected<void> Sawing::cut(double force_n) {
  KERF_CHECK(requireOpen());
  KERF_CHECK(requireUnmoved());
  KERF_TRY(plane, chosen());
  if (isCutting())
    return refuse(Error::Code::kUnsupported, "a planned cut is running", "one at a time", "wait for it, or saw.stop");
  if (bench_.strokes->isPressed() || !bench_.steps->isSettled() || bench_.pieces->isRemoving())
    return refuse(Error::Code::kUnsupported, "the tool is in use", "a tool at rest", "release the button first");

  const Tool& tool = bench_.tools->held();
  const auto blade = SawBlade::of(tool);
  if (!blade) {
    const std::string saws = sawsOfTheRack();
    return refuse(Error::Code::kUnsupported, tool.id + " is not a saw", "a saw as the current tool",
                  saws.empty() ? "start with kerf-sim --tool saw-reciprocating-25" : "one of " + saws);
  }

  const BrickField& bone = *bench_.document->run()->original();
  const bool is_turned = isTurned(plane, *blade, bone.bounds());
  SawPlane reached = plane;
  reached.depth = std::min(plane.depth, blade->most_depth);
  std::vector<SawPass> passes = passesOf(reached, bone, *blade, is_turned);
  if (passes.empty())
    return refuse(Error::Code::kEmpty, "no bone in the plane \"" + plane.name + "\"", "a plane through the object",
                  "move it, or plan another");
  constexpr std::size_t kWaysOfAPass = 4;
  passes.resize(std::min(passes.size(), GuidedCut::kMostWays / kWaysOfAPass));

  const auto highest = std::min_element(passes.begin(), passes.end(),
                                        [](const SawPass& a, const SawPass& b) { return a.from < b.from; });
  KERF_TRY(start, startAbove(plane, *blade, passes.front().u, highest->from, is_turned));
  const double above = plane.toPlane(start * blade->front)[1];

  // Also saws obstacles between there and the plane, such as a crown above the jaw.
  for (SawPass& pass : passes) pass.from = std::min(pass.from, firstTissue(plane, *blade, bone, pass, above));

  GuidedCut order;
  order.id = nextOrder();
  order.is_wanted = true;
  order.start = start;
  order.back = -plane.approach;
  order.force = std::clamp(force_n, kLeastForce, kMostForce);
  order.feed = kFeed;
  order.irrigation = bench_.strokes->irrigation;
  const auto add = [&](double u, double v, bool cuts) {
    const Vec3d front_at = plane.fromPlane(u, v);
    order.ways[order.count++] = {blade->poseAt(front_at, plane.normal, plane.approach, is_turned).translation, cuts};
  };
  for (const SawPass& pass : passes) {
    add(pass.u, above, false);
    add(pass.u, pass.from, false);
    add(pass.u, pass.to, true);
    add(pass.u, above, false);
  }

  if (bench_.document->report().is_latched) bench_.document->send(ClearLatch{});
  bench_.document->hands().guided->order(order);
  const Vec3d& p = start.translation;
  const Eigen::Quaterniond& q = start.rotation;
  if (!bench_.document->send(PlaceTool{{p[0], p[1], p[2]}, {q.w(), q.x(), q.y(), q.z()}})) {
    order.is_wanted = false;
    bench_.document->hands().guided->order(order);
    return refuse(Error::Code::kUnsupported, "the 1 kHz thread is busy", "a free place in its queue", "try again");
  }
  const HapticReport& now = bench_.document->report();
  cutting_ = std::make_unique<Cutting>(Cutting{.order = order,
                                               .section = SawnSection(plane, bone, tool, *blade),
                                               .plane = plane,
                                               .front = blade->front,
                                               .kerf = blade->kerf,
                                               .removed_before = bench_.document->removedMm3(),
                                               .last = start,
                                               .began = now.tick,
                                               .cleared = now.tick});
  if (const auto covered = coverage(); covered && !covered->passesThrough())
    bench_.notices->say(phrase("{}: does not pass through: it covers {:.0f} % of the section", plane.name,
                               std::floor(100 * covered->share)));
  bench_.steps->beginPlannedCut(plane.name);
  last_share_ = 0;
  return {};
}

// ---- Cutting at once

Expected<void> Sawing::addOcclusal(double above_mm) {
  KERF_CHECK(requireOpen());
  KERF_TRY(solid, readCaseSolid(bench_.document->run()->caseFolder()));
  KERF_TRY(plane, planeOfWord(fmt::format("occlusal@{:.17g}", above_mm), solid, "saw.plane-occlusal"));
  return addAt(plane.point, plane.normal);
}

Expected<void> Sawing::cutAtOnce(PlaneKeep keep, double kerf_mm) {
  KERF_CHECK(requireOpen());
  KERF_TRY(plane, chosen());
  CutPlanes planes;
  planes.kerf_mm = kerf_mm;
  planes.add({plane.point, plane.normal});
  return cutAtOnce(keep, planes, plane.name);
}

Expected<void> Sawing::cutAtOnce(PlaneKeep keep, const CutPlanes& planes, const std::string& name,
                                 std::optional<std::uint32_t> wanted) {
  KERF_CHECK(requireOpen());
  if (isCutting() || at_once_ || bench_.strokes->isPressed() || bench_.steps->undosLeft() != 0)
    return refuse(Error::Code::kUnsupported, "the tool is in use", "a tool at rest", "release the button first");

  const SceneObject* piece = wanted ? bench_.document->scene().find(*wanted) : bench_.pieces->chosen();
  for (const SceneObject* const other : bench_.document->scene().shown()) {
    if (wanted || bench_.pieces->chosen() || other->isBeside() || !isMet(*other, planes)) continue;
    if (piece)
      return refuse(Error::Code::kUnsupported, "several pieces in the plane", "one piece to cut",
                    "click a piece in Pieces, then cut again");
    piece = other;
  }
  if (wanted && !piece)
    return refuse(Error::Code::kNotFound, "the piece is no longer there", "a piece of the scene",
                  "plan again on a piece that is there");
  if (!piece || !isMet(*piece, planes))
    return refuse(Error::Code::kEmpty, "the plane misses the object", "a plane through it", "move the plane");
  if (piece->isBeside())
    return refuse(Error::Code::kUnsupported, "a neighbour", "a piece of the scan itself",
                  fmt::format("neighbour.work-on {} (Switch to neighbour), then cut", piece->loaded));

  if (bench_.document->report().is_latched) bench_.document->send(ClearLatch{});
  const std::uint64_t refused = bench_.document->report().counts.commands_refused;
  if (!bench_.document->send(CutByPlanes{piece->index, static_cast<std::uint8_t>(keep), planesIn(*piece, planes)}))
    return refuse(Error::Code::kUnsupported, "the 1 kHz thread is busy", "a free place in its queue", "try again");
  at_once_ = AtOnce{name, bench_.document->sent(), refused, bench_.steps->done(), wanted ? "" : neighboursInPlane()};
  return {};
}

std::string Sawing::neighboursInPlane() const {
  std::string out;
  const SawPlane* const chosen = plan_.chosen();
  if (!chosen) return out;
  CutPlanes planes;
  planes.add({chosen->point, chosen->normal});
  for (const SceneObject* const other : bench_.document->scene().shown())
    if (other->isBeside() && isMet(*other, planes)) out += (out.empty() ? "" : ", ") + other->name;
  return out;
}

void Sawing::reportAtOnce() {
  if (!at_once_ || bench_.document->answered() < at_once_->sent) return;
  if (bench_.document->report().counts.commands_refused > at_once_->refused_before)
    bench_.notices->complain({.code = Error::Code::kEmpty,
                              .place = at_once_->plane,
                              .found = "all of the piece lies on one side of the plane",
                              .expected = "a plane through it",
                              .hint = "move the plane, or turn it"});
  else {
    bench_.notices->say(at_once_->beside.empty() ? phrase("{}: cut at once", at_once_->plane)
                                                 : phrase("{}: cut at once; stays whole: {} (neighbour)",
                                                          at_once_->plane, at_once_->beside));
    spent_ = Spent{plan_.version(), at_once_->steps_before};
  }
  at_once_.reset();
}

bool Sawing::isPlanSpent() const {
  if (!spent_ || spent_->version != plan_.version() || bench_.steps->done() <= spent_->steps_before) return false;
  const auto& steps = bench_.steps->timeline().steps();
  return steps.size() <= spent_->steps_before || steps[spent_->steps_before].kind == TimelineStep::Kind::kPlaneCut;
}

void Sawing::choosePlane(std::size_t n) {
  plan_.choose(n);
  spent_.reset();
}

bool Sawing::isCutting() const { return cutting_ || bench_.drill->isDrilling(); }

bool Sawing::isBusy() {
  if (!isCutting()) return false;
  bench_.notices->complain({.code = Error::Code::kUnsupported,
                            .found = "a planned cut is running",
                            .expected = "a tool at rest",
                            .hint = "wait for it, or stop it (saw.stop)"});
  return true;
}

void Sawing::stop() {
  bench_.drill->stop();
  if (!cutting_ || !cutting_->order.is_wanted) return;
  cutting_->order.is_wanted = false;
  bench_.document->hands().guided->order(cutting_->order);
}

// Undo waits: tissue would come back around a blade that is still in it.
void Sawing::stopAndUndo() {
  if (bench_.drill->isDrilling()) return bench_.drill->stopAndUndo();
  stop();
  if (cutting_) cutting_->is_undone_after = true;
}

std::optional<SawingStatus> Sawing::status() const {
  if (!cutting_) return {};
  SawingStatus out;
  out.plane = cutting_->plane.name;
  out.share = cutting_->section.share();
  out.planned_mm3 = plannedMm3();
  out.removed_mm3 = removedMm3();
  out.seconds = kTick * static_cast<double>(bench_.document->report().tick - cutting_->began);
  out.is_stopping = !cutting_->order.is_wanted;
  if (out.share > 0.03) out.left_s = out.seconds * (1 - out.share) / out.share;
  return out;
}

// Volume of the planned section in the present cut.
double Sawing::plannedMm3() const { return cutting_->section.plannedMm2() * cutting_->kerf; }
double Sawing::removedMm3() const { return bench_.document->removedMm3() - cutting_->removed_before; }

void Sawing::markSawn(const GuidedReport& report) {
  const Rigid3& now = bench_.document->report().output.T_world_tool;
  Cutting& c = *cutting_;
  if (report.stage == GuidedStage::kCutting) {
    const bool cuts = report.way < c.order.count && c.order.ways[report.way].cuts;
    if (cuts && bench_.document->report().output.touching > 0)
      c.aside = std::max(c.aside, std::abs(c.plane.toPlane(now * c.front)[2]));
    const Vec3d way = now.translation - c.last.translation;
    const int steps = std::clamp(static_cast<int>(way.norm() / kMarkEvery), 1, 200);
    for (int n = 1; n <= steps; ++n) {
      const double part = static_cast<double>(n) / steps;
      c.section.mark({c.last.rotation.slerp(part, now.rotation), c.last.translation + part * way});
    }
  }
  c.last = now;
}

void Sawing::update() {
  saveSoon();
  if (bench_.document->isOpen()) reportAtOnce();
  if (!cutting_ || !bench_.document->isOpen()) return;
  Cutting& c = *cutting_;
  bench_.document->hands().guided->update();
  const GuidedReport report = bench_.document->hands().guided->report();
  const HapticReport& now = bench_.document->report();

  if (report.id != c.order.id) {  // the tool is not there yet
    if (now.tick < c.began + kBeginsWithin) return;
    bench_.notices->complain({.code = Error::Code::kUnsupported,
                              .place = c.plane.name,
                              .found = "the blade did not reach its start above the bone",
                              .hint = "run saw.cut again"});
    stop();
    cutting_.reset();
    bench_.steps->endPlannedCut();
    return;
  }
  if (!c.is_begun) c.last = now.output.T_world_tool;
  c.is_begun = true;

  // A mouse cannot be jerked like an arm: after a late clock it continues.
  if (now.is_latched && now.tick > c.cleared + kClearEvery) {
    bench_.document->send(ClearLatch{});
    c.cleared = now.tick;
  }
  markSawn(report);
  if (report.stage == GuidedStage::kOver || report.stage == GuidedStage::kNone) finish(report);
}

void Sawing::finish(const GuidedReport& report) {
  const Cutting& c = *cutting_;
  last_share_ = c.section.share();
  bench_.steps->endPlannedCut();
  const double seconds = kTick * static_cast<double>(bench_.document->report().tick - c.began);
  const double percent = std::floor(1000 * last_share_) / 10;
  const bool is_whole = last_share_ >= 0.995, is_aside = c.aside >= kAsideIsTold;

  const std::string share =
      c.order.is_wanted ? phrase("cut {:.4g} %", percent) : phrase("stopped after {:.4g} %", percent);
  std::string text = phrase("{}: {} of the planned section ({:.0f} mm2) in {:.0f} s", c.plane.name, share,
                            c.section.plannedMm2(), seconds);
  text += phrase("; {:.1f} mm3 planned, {:.1f} mm3 removed", plannedMm3(), removedMm3());
  if (c.order.is_wanted && report.given_up > 0)
    text += shownText("; the blade made no progress in places: push harder (saw.cut 8), or choose another saw");
  else if (c.order.is_wanted && !is_whole && !is_aside)
    text += shownText("; the rest is beyond the blade's reach");
  if (is_aside) text += phrase("; the blade left the plane by up to {:.2f} mm", c.aside);
  if (c.section.beyondMm2() > 0.5)
    text += phrase("; the blade also cut {:.1f} mm2 outside the rectangle", c.section.beyondMm2());
  bench_.notices->say(std::move(text));
  const bool is_undone = c.is_undone_after;
  cutting_.reset();
  if (is_undone) bench_.steps->undo();
}

// ---- The guide

bool Sawing::isGuiding() const {
  return !isMoved() && guide && plan_.chosen() && bench_.document->isOpen() && SawBlade::of(bench_.tools->held());
}

Vec3d Sawing::tipToFront() const {
  const SawPlane& plane = *plan_.chosen();
  const SawBlade now = blade();
  const bool is_turned = isTurned(plane, now, bench_.document->run()->original()->bounds());
  const Rigid3 pose = now.poseAt(Vec3d::Zero(), plane.normal, plane.approach, is_turned);
  const Vec3d front = -pose.translation;
  return front - plane.approach.dot(front) * plane.approach;
}

std::optional<ToolOverSurface> Sawing::over(const Ray& ray) const {
  const auto pointed = bench_.document->scene().hit(ray);
  if (!pointed) return {};
  const SawPlane& plane = *plan_.chosen();
  const Vec3d at = plane.toPlane(pointed->on_surface.point);
  if (std::abs(at[2]) > kBesidePlane || std::abs(at[0]) > 0.5 * plane.width + kBesideEdge) return {};

  const BrickField& loaded = *bench_.document->run()->original();
  const Ray down{plane.fromPlane(at[0], -kFromAbove), plane.approach};
  const double reach = kFromAbove + plane.depth;
  const auto before = entry(loaded, down, kFromAbove - 2, reach);
  if (!before) return {};
  const auto now = bench_.document->scene().hit({down.at(*before - 1), plane.approach});

  ToolOverSurface out;
  out.point = now && now->on_surface.way < reach ? now->on_surface.point : down.at(*before);
  out.normal = -plane.approach;
  out.depth = std::max(plane.approach.dot(out.point - down.at(*before)), 0.0);
  const SawBlade blade_now = blade();
  out.front = tipToFront();
  out.reach = bench_.tools->plunge().reach;
  out.T_world_tool =
      blade_now.poseAt(out.point, plane.normal, plane.approach, isTurned(plane, blade_now, loaded.bounds()));
  return out;
}

// ---- The open document

void Sawing::opened(Opening how) {
  at_once_.reset();
  spent_.reset();
  cutting_.reset();
  covered_ = {};
  die.clear();
  plan_.clear();
  // One that comes back has versions of its own: it is written again, beside the new session.
  saved_ = seen_ = how == Opening::kReopened ? kNever : plan_.version();
  std::error_code ignored;
  const LiveRun* const run = bench_.document->run();
  if (how == Opening::kNew && run && fs::is_regular_file(run->from() / kSawPlanFile, ignored))
    if (const auto read = plan_.load(run->from() / kSawPlanFile); !read) bench_.notices->complain(read.error());
  last_share_ = 0;
  guide = false;
  picking.begin(SawPicking::What::kNothing);
}

void Sawing::closing() {
  if (!bench_.document->isOpen()) return;
  stop();
  cutting_.reset();
  if (plan_.version() != saved_)
    if (const auto written = plan_.save(bench_.document->sessionFolder() / kSawPlanFile); !written)
      bench_.notices->complain(written.error());
  saved_ = plan_.version();
}

// A second after the last change, so that a held stepper makes one file.
void Sawing::saveSoon() {
  const auto now = std::chrono::steady_clock::now();
  if (plan_.version() != seen_) {
    seen_ = plan_.version();
    changed_ = now;
  }
  if (!bench_.document->isOpen() || seen_ == saved_ || now - changed_ < kSaveAfter) return;
  saved_ = seen_;
  if (const auto written = plan_.save(bench_.document->sessionFolder() / kSawPlanFile); !written)
    bench_.notices->complain(written.error());
}

}  // namespace kerf
