#include "ui/window/draw/saw_view.h"

#include <numbers>

#include "ui/app/document/document.h"
#include "ui/app/saw/saw_contour.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

constexpr auto kContourEvery = std::chrono::milliseconds(250);

LiveSlab slabOf(const SawPlane& plane, double kerf, const LiveScene& scene) {
  LiveSlab out;
  out.corners = plane.corners();
  out.thickness = kerf;
  out.contour = contourOf(plane, scene);
  return out;
}

// The pin hole: its ends as rings, and lines along it.
void addHole(LivePlan& to, const RoundHole& hole) {
  constexpr int kSides = 24, kLines = 4;
  const Vec3d u = hole.axis.unitOrthogonal(), v = hole.axis.cross(u);
  const auto at = [&](int n, double along) -> Vec3d {
    const double angle = 2 * std::numbers::pi * n / kSides;
    return hole.mouth + along * hole.axis + 0.5 * hole.diameter * (std::cos(angle) * u + std::sin(angle) * v);
  };
  for (int n = 0; n < kSides; ++n) {
    for (const double along : {0.0, hole.depth}) to.lines.push_back({at(n, along), at(n + 1, along)});
    if (n % (kSides / kLines) == 0) to.lines.push_back({at(n, 0), at(n, hole.depth)});
  }
}

}  // namespace

void SawView::findSlabs(const Workbench& bench) {
  slabs_.clear();
  const SawPlan& plan = bench.saw->plan();
  const double kerf = bench.saw->blade().kerf;
  for (std::size_t n = 0; n < plan.planes().size(); ++n) {
    slabs_.push_back(slabOf(plan.planes()[n], kerf, bench.document->scene()));
    slabs_.back().is_chosen = n == plan.chosenIndex();
  }
}

LivePlan SawView::planOf(const Workbench& bench, const Camera& camera) {
  LivePlan out;
  if (!bench.document->isOpen()) return out;
  const Sawing& saw = *bench.saw;
  const auto now = std::chrono::steady_clock::now();
  const bool is_new =
      saw.plan().version() != version_ || bench.document->generation() != generation_ || bench.tools->inHand() != tool_;
  if (is_new || (is_outdated_ && now - found_ > kContourEvery)) {
    findSlabs(bench);
    version_ = saw.plan().version();
    generation_ = bench.document->generation();
    tool_ = bench.tools->inHand();
    found_ = now;
    is_outdated_ = false;
  }
  const bool is_spent = saw.isPlanSpent();
  if (!is_spent) out.slabs = slabs_;

  if (saw.die.isPlanned() && !is_spent)
    if (const auto& pin = saw.die.pin(); pin && *pin) addHole(out, **pin);

  // Picked points, in front of everything.
  const SawPicking& picking = saw.picking;
  out.dots = picking.points();
  if (const auto& from = picking.lineFrom()) {
    const auto inView = [&](const Ray& ray) -> Vec3d {
      const Vec3d back = camera.backwards();
      return ray.at(back.dot(camera.target - ray.origin) / back.dot(ray.direction));
    };
    out.lines.push_back({inView(*from), inView(picking.lineTo())});
  }
  return out;
}

}  // namespace kerf
