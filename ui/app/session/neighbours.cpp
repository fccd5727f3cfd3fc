#include "ui/app/session/neighbours.h"

#include <algorithm>

#include "sim/monitor/structures.h"
#include "ui/app/base/language.h"

namespace kerf {
namespace {

constexpr double kMostApart = 15;  // mm between the boxes: as for a pair of jaws
// Ratio of the diagonals: a tooth of 12 mm fits a jaw of 80, but an inch is 25.4 mm and a metre 1000.
constexpr double kMostRatio = 12;
constexpr double kDeep = 0.5;        // mm inside the object
constexpr double kMostInside = 0.1;  // of the neighbour's surface: touching teeth and jaws in occlusion have less
constexpr std::size_t kSamples = 20000;

double gapToNeighbour(const Box3& a, const Box3& b) {
  const Vec3d apart = (a.min - b.max).cwiseMax(b.min - a.max).cwiseMax(Vec3d::Zero());
  return apart.norm();
}

// Share of a surface's vertices that lie deep in the object.
double shareInside(const BrickField& object, const Mesh& solid) {
  const std::size_t stride = solid.vertices.size() / kSamples + 1;
  std::size_t all = 0, inside = 0;
  const double deep = std::max(-kDeep, 0.99 * static_cast<double>(object.interior()));
  for (std::size_t v = 0; v < solid.vertices.size(); v += stride) {
    ++all;
    inside += static_cast<double>(object.sample(solid.vertices[v])) < deep;
  }
  return all > 0 ? static_cast<double>(inside) / static_cast<double>(all) : 0;
}

}  // namespace

Expected<NeighbourFields> neighbourFields(const LiveRun& run, const Progress& progress) {
  constexpr double kReach = 3;  // mm: farther gives no news and costs memory
  NeighbourFields out;
  for (const LiveNeighbour& other : run.neighbours()) {
    if (!report(progress, static_cast<double>(out.size()) / static_cast<double>(run.neighbours().size()),
                "measuring distances to neighbours"))
      return fail({.code = Error::Code::kCancelled, .found = "cancelled"});
    // As in its case: cuts do not make it farther.
    KERF_TRY(whole, BakedObject::make(*other.original, static_cast<const MaterialField*>(nullptr)));
    KeepOutOptions options = keepOutReach(whole->voxel());
    options.most_distance = std::min(options.most_distance, kReach);
    options.most_depth = std::min(options.most_depth, options.most_distance);
    KERF_TRY(field, KeepOut::ofSolid(*whole, options));
    out.push_back(std::move(field));
  }
  return out;
}

std::optional<std::string> misfitOf(const BrickField& object, const Box3& box, const std::string& name,
                                    const Mesh& solid) {
  const Box3 other = bounds(solid);
  const double ratio = other.size().norm() / std::max(box.size().norm(), 1e-9);
  if (ratio > kMostRatio || ratio < 1 / kMostRatio)
    return phrase("{} is {:.3g} times as large as the object you cut. Check the units of both.", name, ratio);
  if (const double gap = gapToNeighbour(box, other); gap > kMostApart)
    return phrase("{} is {:.0f} mm away from the object you cut. Check that both are in the same scan frame.", name,
                  gap);
  if (const double inside = shareInside(object, solid); inside > kMostInside)
    return phrase(
        "{:.0f} % of the surface of {} lies inside the object you cut. Check that both are in the same scan frame and "
        "are different objects.",
        100 * inside, name);
  return {};
}

}  // namespace kerf
