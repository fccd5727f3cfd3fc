#include "preprocess/print/drain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "geometry/boolean/plane_cut.h"
#include "geometry/mesh/box_tree.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/ray_hits.h"
#include "geometry/mesh/solids.h"

namespace kerf {
namespace {

constexpr double kHoleMargin = 0.3;     // mm: the hole begins outside and ends in the cavity by as much
constexpr double kHoleClearance = 0.5;  // mm of material to leave around a hole
constexpr int kCircleRays = 16;         // on the hole's circle

std::string pointText(const Vec3d& p) { return fmt::format("({:.1f}, {:.1f}, {:.1f})", p[0], p[1], p[2]); }

// The model with its cavities, and ways through its walls.
class Walls {
 public:
  Walls(const Mesh& mesh, const Vec3d& up) : mesh_(mesh), up_(up), tree_(boxesOf(mesh)) {
    const Pieces shells = edgeConnectedPieces(mesh);
    std::vector<double> volume(shells.count, 0);
    const Vec3d c = bounds(mesh).center();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      volume[shells.label[t]] += (mesh.corner(t, 0) - c).dot((mesh.corner(t, 1) - c).cross(mesh.corner(t, 2) - c)) / 6;
    std::vector<int> number(shells.count, -1);
    for (std::uint32_t s = 0; s < shells.count; ++s)
      if (volume[s] < 0) {
        number[s] = static_cast<int>(cavities.size());
        cavities.push_back({-volume[s], Vec3d::Zero()});
        triangles.emplace_back();
      }
    cavity_of.resize(mesh.triangles.size());
    for (std::uint32_t t = 0; t < cavity_of.size(); ++t) {
      cavity_of[t] = number[shells.label[t]];
      if (cavity_of[t] >= 0) triangles[static_cast<std::size_t>(cavity_of[t])].push_back(t);
    }
    lowest_ = std::numeric_limits<double>::infinity();
    for (const Vec3d& p : mesh.vertices) lowest_ = std::min(lowest_, up.dot(p));
    for (std::size_t n = 0; n < cavities.size(); ++n) {
      double low = std::numeric_limits<double>::infinity();
      for (const std::uint32_t t : triangles[n])
        for (int k = 0; k < 3; ++k)
          if (const Vec3d p = mesh.corner(t, k); up.dot(p) < low) {
            low = up.dot(p);
            cavities[n].lowest = p;
          }
    }
  }

  std::vector<Cavity> cavities;
  std::vector<std::vector<std::uint32_t>> triangles;  // of each cavity
  std::vector<int> cavity_of;                         // per triangle; -1: another surface

  const Mesh& mesh() const { return mesh_; }
  const Vec3d& up() const { return up_; }
  double lowest() const { return lowest_; }

  // The part of the mesh in a box, with the numbers of its triangles.
  std::pair<Mesh, std::vector<std::uint32_t>> near(const Box3& box) const {
    std::vector<std::uint32_t> found;
    tree_.visit([&](const Box3& b) { return overlap(b, box); },
                [&](std::uint32_t t) {
                  if (overlap(tree_.boxes()[t], box)) found.push_back(t);
                  return true;
                });
    std::sort(found.begin(), found.end());
    Mesh part;
    for (const std::uint32_t t : found) {
      const auto first = static_cast<std::uint32_t>(part.vertices.size());
      for (int k = 0; k < 3; ++k) part.vertices.push_back(mesh_.corner(t, k));
      part.triangles.push_back({first, first + 1, first + 2});
    }
    return {std::move(part), std::move(found)};
  }

  // A drain along an axis from a point below or outside the wall, if it passes through one wall into the cavity. The
  // point lies outside of the material.
  // @param is_strict  the whole circle of the hole has to meet the cavity; else its middle is enough.
  // @param deepest_entry  the hole's circle has to meet the model's surface no farther from the point.
  std::optional<Drain> through(const Vec3d& from, const Vec3d& axis, double reach, double radius, int cavity,
                               bool is_strict, double deepest_entry = std::numeric_limits<double>::infinity()) const {
    // First the middle alone, which rejects most places.
    Box3 line;
    line.add(from);
    line.add(from + reach * axis);
    {
      const auto [part, number] = near(line);
      const std::vector<RayHit> h = rayHits(part, from, axis);
      if (h.size() < 2 || !h[0].enters || h[0].way > deepest_entry || h[1].enters ||
          cavity_of[number[h[1].triangle]] != cavity)
        return {};
    }
    const Vec3d u = axis.unitOrthogonal(), v = axis.cross(u);
    std::vector<Vec3d> starts{from};
    for (const double r : {radius, radius + kHoleClearance})
      for (int n = 0; n < kCircleRays; ++n) {
        const double angle = 2 * std::numbers::pi * n / kCircleRays;
        starts.push_back(from + r * (std::cos(angle) * u + std::sin(angle) * v));
      }
    Box3 box;
    for (const Vec3d& p : starts) {
      box.add(p);
      box.add(p + reach * axis);
    }
    const auto [part, number] = near(box);

    double first = std::numeric_limits<double>::infinity(), highest = 0, last = 0;
    std::vector<std::vector<RayHit>> hits;
    for (std::size_t n = 0; n < starts.size(); ++n) {
      hits.push_back(rayHits(part, starts[n], axis));
      const std::vector<RayHit>& h = hits.back();
      const auto leaves = [&](std::size_t i) { return cavity_of[number[h[i].triangle]]; };
      // Outwards into the open, or beside the model.
      if (h.empty() || !h[0].enters || leaves(0) >= 0) return {};
      const bool is_in = h.size() > 1 && !h[1].enters && leaves(1) == cavity;
      if (n == 0 && !is_in) return {};
      first = std::min(first, h[0].way);
      if (n > kCircleRays) continue;
      // Steep walls of the cavity do not lengthen the hole.
      const bool is_met = is_in && h[1].way <= hits[0][1].way + radius;
      if (is_strict && !is_met) return {};
      if (is_met) last = std::max(last, h[1].way);
      highest = std::max(highest, h[0].way);
    }
    if (highest > deepest_entry) return {};
    const double end = last + kHoleMargin;
    for (std::size_t n = 0; n < hits.size(); ++n) {
      const std::vector<RayHit>& h = hits[n];
      const bool is_in = h.size() > 1 && leavesInto(number[h[1].triangle], cavity);
      // Any other wall within the hole's reach: it would come out there.
      for (std::size_t i = is_in ? 2 : 1; i < h.size(); ++i)
        if (h[i].way < end + kHoleClearance) return {};
    }
    const double before = std::max(0.0, first - kHoleMargin);
    Drain out;
    out.hole = {from + before * axis, axis, 2 * radius, end - before};
    out.cavity = static_cast<std::size_t>(cavity);
    out.wall_mm = hits[0][1].way - hits[0][0].way;
    if (!out.hole.isUsable()) return {};
    return out;
  }

 private:
  static std::vector<Box3> boxesOf(const Mesh& mesh) {
    std::vector<Box3> out(mesh.triangles.size());
    for (std::size_t t = 0; t < out.size(); ++t)
      for (int k = 0; k < 3; ++k) out[t].add(mesh.corner(t, k));
    return out;
  }
  bool leavesInto(std::uint32_t triangle, int cavity) const { return cavity_of[triangle] == cavity; }

  const Mesh& mesh_;
  Vec3d up_;
  BoxTree tree_;
  double lowest_ = 0;
};

// ---- Candidates

// Places on the cavity's wall about `step` apart: the lowest of each cell of a grid.
std::vector<Vec3d> placesOf(const Walls& walls, std::size_t cavity, double step, bool is_floor) {
  constexpr int kMostParts = 100;  // of a large triangle's side
  std::map<std::array<int, 3>, Vec3d> cells;
  const Vec3d u = walls.up().unitOrthogonal(), v = walls.up().cross(u);
  const auto cell = [&](double x) { return static_cast<int>(std::floor(x / step)); };
  for (const std::uint32_t t : walls.triangles[cavity]) {
    if (is_floor && doubleAreaVector(walls.mesh(), t).normalized().dot(walls.up()) < 0.5) continue;
    const Vec3d a = walls.mesh().corner(t, 0), b = walls.mesh().corner(t, 1) - a, c = walls.mesh().corner(t, 2) - a;
    const double longest = std::max({b.norm(), c.norm(), (c - b).norm()});
    const int parts = std::clamp(static_cast<int>(std::ceil(longest / step)), 1, kMostParts);
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        const Vec3d p = a + (i + 1.0 / 3) / parts * b + (j + 1.0 / 3) / parts * c;
        const double height = walls.up().dot(p);
        const auto [it, is_new] = cells.try_emplace({cell(u.dot(p)), cell(v.dot(p)), is_floor ? 0 : cell(height)}, p);
        if (!is_new && height < walls.up().dot(it->second)) it->second = p;
      }
  }
  std::vector<Vec3d> out;
  for (const auto& [at, p] : cells) out.push_back(p);
  return out;
}

double stepOf(const Walls& walls, std::size_t cavity) {
  double area = 0;
  for (const std::uint32_t t : walls.triangles[cavity]) area += 0.5 * doubleAreaVector(walls.mesh(), t).norm();
  constexpr double kMost = 600;  // places
  return std::max(0.7, std::sqrt(area / kMost));
}

std::optional<Drain> fromBelow(const Walls& walls, const Vec3d& place, std::size_t cavity, const DrainOptions& options,
                               bool is_strict) {
  constexpr double kLowestFace = 0.5, kBelow = 1;  // mm
  const double rise = walls.up().dot(place) - walls.lowest() + kBelow;
  auto drain = walls.through(place - rise * walls.up(), walls.up(), rise + options.diameter_mm + 2,
                             0.5 * options.diameter_mm, static_cast<int>(cavity), is_strict, kBelow + kLowestFace);
  if (drain) drain->is_below = true;
  return drain;
}

std::optional<Drain> fromNearest(const Walls& walls, const MeshDistance& outside, const Vec3d& place,
                                 std::size_t cavity, const DrainOptions& options, bool is_strict) {
  constexpr double kBefore = 1;  // mm
  const NearestOnMesh near = outside.nearest(place);
  if (!near.isFound() || near.distance_mm < 1e-6) return {};
  const Vec3d axis = (place - near.point) / near.distance_mm;
  return walls.through(near.point - kBefore * axis, axis, near.distance_mm + options.diameter_mm + 3,
                       0.5 * options.diameter_mm, static_cast<int>(cavity), is_strict);
}

// The lowest place that a drain can have, then the ones farthest from those before.
template <class Try>
std::vector<Drain> chosen(std::vector<Vec3d> places, const Vec3d& up, std::size_t count, double apart_mm,
                          const Try& drainAt, const std::function<bool()>& stops) {
  constexpr double kSameHeight = 0.05;  // mm: then the order of the places decides
  constexpr double kNoPlace = -1;
  std::vector<Drain> out;
  std::stable_sort(places.begin(), places.end(), [&](const Vec3d& a, const Vec3d& b) {
    return std::floor(up.dot(a) / kSameHeight) < std::floor(up.dot(b) / kSameHeight);
  });
  std::vector<double> away(places.size(), std::numeric_limits<double>::infinity());
  while (out.size() < count) {
    std::optional<Drain> drain;
    std::size_t at = 0;
    for (; at < places.size() && !drain && away[at] > apart_mm && !stops(); ++at) {
      drain = drainAt(places[at]);
      if (!drain) away[at] = kNoPlace;  // not tried again
    }
    if (!drain) break;
    out.push_back(*drain);
    const Vec3d taken = places[at - 1];
    std::vector<std::pair<double, Vec3d>> rest;
    for (std::size_t n = 0; n < places.size(); ++n)
      rest.emplace_back(std::min(away[n], (places[n] - taken).norm()), places[n]);
    std::stable_sort(rest.begin(), rest.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t n = 0; n < rest.size(); ++n) std::tie(away[n], places[n]) = rest[n];
  }
  return out;
}

std::vector<Drain> drainsOf(const Walls& walls, const MeshDistance& outside, std::size_t cavity,
                            const DrainOptions& options, const std::function<bool()>& stops) {
  const double apart = options.diameter_mm + 2 * kHoleClearance, step = stepOf(walls, cavity);
  for (const bool is_strict : {true, false}) {
    std::vector<Drain> out;
    if (options.side == DrainSide::kUnderside)
      out = chosen(
          placesOf(walls, cavity, step, true), walls.up(), options.count, apart,
          [&](const Vec3d& p) { return fromBelow(walls, p, cavity, options, is_strict); }, stops);
    if (out.empty())
      out = chosen(
          placesOf(walls, cavity, step, false), walls.up(), options.count, apart,
          [&](const Vec3d& p) { return fromNearest(walls, outside, p, cavity, options, is_strict); }, stops);
    if (!out.empty()) return out;
  }
  return {};
}

Expected<Drain> byHand(const Walls& walls, const MeshDistance& outside, const MeshDistance& inside,
                       const std::vector<std::uint32_t>& inner, const Vec3d& place, const DrainOptions& options) {
  if (!place.allFinite())
    return fail({.code = Error::Code::kBadValue,
                 .place = "place of a drain",
                 .found = "a number that is not finite",
                 .expected = "a point, mm"});
  const NearestOnMesh mouth = outside.nearest(place);
  constexpr double kNear = 2;  // mm
  if (mouth.distance_mm > kNear)
    return fail({.code = Error::Code::kBadValue,
                 .place = "drain at " + pointText(place),
                 .found = fmt::format("a place {:.1f} mm from the surface", mouth.distance_mm),
                 .expected = fmt::format("at most {} mm", kNear),
                 .hint = "the nearest place, " + pointText(mouth.point)});
  std::vector<Vec3d> axes;
  if (options.side == DrainSide::kUnderside) axes.push_back(walls.up());
  const NearestOnMesh behind = inside.nearest(mouth.point);
  axes.push_back((behind.point - mouth.point).normalized());
  for (const bool is_strict : {true, false})
    for (const Vec3d& axis : axes) {
      if (axis.dot(outside.normal(mouth.triangle)) > -0.3) continue;  // along the surface, or out of it
      const Vec3d from = mouth.point - axis;
      const double reach = bounds(walls.mesh()).size().norm();
      // The cavity that the axis meets.
      Box3 box;
      box.add(from);
      box.add(from + reach * axis);
      const auto [part, number] = walls.near(box);
      const std::vector<RayHit> hits = rayHits(part, from, axis);
      if (hits.size() < 2) continue;
      const int cavity = walls.cavity_of[number[hits[1].triangle]];
      if (cavity < 0) continue;
      auto drain = walls.through(from, axis, hits[1].way + options.diameter_mm + 2, 0.5 * options.diameter_mm, cavity,
                                 is_strict);
      if (!drain) continue;
      drain->is_below = axis == walls.up();
      drain->is_by_hand = true;
      return *drain;
    }
  const std::size_t nearest = static_cast<std::size_t>(walls.cavity_of[inner[behind.triangle]]);
  return fail({.code = Error::Code::kGeometry,
               .place = "drain at " + pointText(place),
               .found = fmt::format("no way of {} mm through one wall into a cavity; the nearest, cavity {}, begins "
                                    "{:.1f} mm away at {}",
                                    options.diameter_mm, nearest + 1, behind.distance_mm, pointText(behind.point)),
               .expected = "a place on the wall of a cavity, 0.5 mm away from other walls",
               .hint = "another place, or a smaller diameter"});
}

Expected<void> checkOptions(const DrainOptions& o) {
  if (!(o.diameter_mm >= RoundHole::kLeastDiameter && o.diameter_mm <= RoundHole::kMostDiameter))
    return fail({.code = Error::Code::kBadValue,
                 .place = "diameter of the drains",
                 .found = fmt::format("{} mm", o.diameter_mm),
                 .expected = fmt::format("{} to {} mm", RoundHole::kLeastDiameter, RoundHole::kMostDiameter),
                 .hint = "3.5 mm"});
  if (o.count < 1 || o.count > kMostDrains)
    return fail({.code = Error::Code::kBadValue,
                 .place = "number of drains per cavity",
                 .found = fmt::format("{}", o.count),
                 .expected = fmt::format("1 to {}", kMostDrains)});
  if (!o.build_direction.allFinite() || !(o.build_direction.norm() > 0))
    return fail({.code = Error::Code::kBadValue,
                 .place = "printing direction",
                 .found = "a direction of length 0, or a number that is not finite",
                 .expected = "a direction from the plate into the model"});
  return {};
}

// ---- Drilling

// Shells of cavities, and handles of all shells together: the Euler characteristic is twice the shells less the
// handles.
struct Topology {
  std::size_t pieces = 0, cavities = 0;
  long handles = 0;
};

Topology topologyOf(const Mesh& mesh) {
  const PieceCount count = countPieces(mesh);
  const auto shells = static_cast<long>(count.pieces + count.cavities);
  const auto vertices = static_cast<long>(mesh.vertices.size()), triangles = static_cast<long>(mesh.triangles.size());
  return {count.pieces, count.cavities, shells - (vertices - triangles / 2) / 2};
}

// Numbers of triangles as colours, which withHole() carries through the cut. Its cut faces get kNoSource.
Rgba8 colourOf(std::uint32_t n) {
  return {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n >> 16),
          static_cast<std::uint8_t>(n >> 24)};
}
std::uint32_t numberOf(const Rgba8& c) {
  return c[0] | static_cast<std::uint32_t>(c[1]) << 8 | static_cast<std::uint32_t>(c[2]) << 16 |
         static_cast<std::uint32_t>(c[3]) << 24;
}

// Kept vertices stand first and in order, at their old coordinates.
std::vector<char> sourceFlags(const Mesh& before, const std::vector<char>& was_source, const PostOpMesh& after) {
  std::vector<char> out(after.is_source.size(), 0);
  std::size_t at = 0;
  for (std::size_t v = 0; v < out.size(); ++v) {
    if (!after.is_source[v]) continue;
    while (at < before.vertices.size() && before.vertices[at] != after.mesh.vertices[v]) ++at;
    if (at < before.vertices.size()) out[v] = was_source[at];
  }
  return out;
}

Error noDrain(std::size_t n, const RoundHole& hole, std::string found, const char* hint) {
  return {.code = Error::Code::kGeometry,
          .place = fmt::format("drain {} at {}", n + 1, pointText(hole.mouth)),
          .found = std::move(found),
          .expected = "a hole through one wall into a cavity",
          .hint = hint};
}

// A drain opens a closed cavity, or adds a handle to an open one.
Expected<void> checkDrain(std::size_t n, const RoundHole& hole, const Topology& before, const Topology& after) {
  const auto opened = static_cast<long>(before.cavities) - static_cast<long>(after.cavities);
  const long handles = after.handles - before.handles;
  if (after.pieces != before.pieces)
    return fail(noDrain(n, hole, "it cuts a piece off", "another place, or a smaller diameter"));
  if (opened <= 0 && handles <= 0)
    return fail(noDrain(n, hole, "it reaches no cavity", "a deeper hole, or another place"));
  if (opened + handles > 1)
    return fail(noDrain(n, hole, "it comes out on another side, or joins several cavities",
                        "a shallower hole, or another place"));
  return {};
}

}  // namespace

Expected<DrainPlan> placeDrains(const Mesh& hollow, const DrainOptions& options, const Progress& progress) {
  KERF_CHECK(checkOptions(options));
  if (!report(progress, 0, "placing drains")) return cancelled();
  const Walls walls(hollow, options.build_direction.normalized());
  if (walls.cavities.empty())
    return fail({.code = Error::Code::kEmpty,
                 .place = "drains",
                 .found = "a model without a closed cavity",
                 .expected = "a hollow model",
                 .hint = "hollow it first"});
  std::vector<char> is_outer(hollow.triangles.size());
  std::vector<std::uint32_t> inner;
  for (std::uint32_t t = 0; t < is_outer.size(); ++t) {
    is_outer[t] = walls.cavity_of[t] < 0;
    if (!is_outer[t]) inner.push_back(t);
  }
  const MeshDistance outside(subset(hollow, is_outer));

  DrainPlan out;
  out.cavities = walls.cavities;
  std::vector<char> has_drain(out.cavities.size(), 0);
  if (!options.at.empty()) {
    std::vector<char> is_inner(is_outer.size());
    for (std::size_t t = 0; t < is_inner.size(); ++t) is_inner[t] = !is_outer[t];
    const MeshDistance inside(subset(hollow, is_inner));
    for (const Vec3d& place : options.at) {
      KERF_TRY(drain, byHand(walls, outside, inside, inner, place, options));
      has_drain[drain.cavity] = 1;
      out.drains.push_back(drain);
    }
  }
  for (std::size_t n = 0; n < out.cavities.size(); ++n) {
    bool is_stopped = false;
    const auto stops = [&] {
      is_stopped = is_stopped || !report(progress, static_cast<double>(n) / static_cast<double>(out.cavities.size()),
                                         "placing drains");
      return is_stopped;
    };
    if (stops()) return cancelled();
    if (has_drain[n]) continue;
    const std::vector<Drain> drains = drainsOf(walls, outside, n, options, stops);
    if (is_stopped) return cancelled();
    if (drains.empty())
      return fail(
          {.code = Error::Code::kGeometry,
           .place = fmt::format("cavity {} of {}", n + 1, out.cavities.size()),
           .found = fmt::format("no place for a drain of {} mm: the cavity has {:.1f} mm3, its lowest point is {}",
                                options.diameter_mm, out.cavities[n].volume_mm3, pointText(out.cavities[n].lowest)),
           .expected = "a way through one wall, 0.5 mm away from other walls",
           .hint =
               "a smaller diameter, or a larger least_cavity when hollowing; kerf bake --drop-specks for a bubble of "
               "the scan"});
    out.drains.insert(out.drains.end(), drains.begin(), drains.end());
  }
  return out;
}

Expected<Drained> drained(const Mesh& hollow, std::span<const RoundHole> holes, const Progress& progress,
                          const PostOpOptions& options) {
  if (holes.empty())
    return fail({.code = Error::Code::kBadValue, .place = "drains", .found = "none", .expected = "at least one hole"});
  for (std::size_t n = 0; n < holes.size(); ++n)
    if (!holes[n].isUsable())
      return fail({.code = Error::Code::kBadValue,
                   .place = fmt::format("drain {}", n + 1),
                   .found = "a hole with an axis that is no unit vector, or numbers out of range",
                   .expected = fmt::format("a diameter of {} to {} mm, a depth up to {} mm", RoundHole::kLeastDiameter,
                                           RoundHole::kMostDiameter, RoundHole::kMostDepth)});

  PostOpOptions numbers = options;
  numbers.cut_color = colourOf(kNoSource);
  Drained out;
  out.mesh = hollow;
  out.mesh.face_colors.resize(hollow.triangles.size());
  for (std::uint32_t t = 0; t < hollow.triangles.size(); ++t) out.mesh.face_colors[t] = colourOf(t);
  out.is_source.assign(hollow.vertices.size(), 1);
  Topology now = topologyOf(hollow);
  out.cavities_before = now.cavities;

  for (std::size_t n = 0; n < holes.size(); ++n) {
    if (!report(progress, static_cast<double>(n) / static_cast<double>(holes.size()), "drilling drains"))
      return cancelled();
    auto cut = withHole(out.mesh, holes[n], numbers);
    if (!cut) {
      Error error = std::move(cut).error();
      error.place = fmt::format("drain {}: ", n + 1) + error.place;
      return fail(std::move(error));
    }
    if (!*cut) return fail(noDrain(n, holes[n], "it does not meet the model", "a deeper hole, or another place"));
    const Topology then = topologyOf((*cut)->mesh);
    KERF_CHECK(checkDrain(n, holes[n], now, then));
    now = then;
    out.is_source = sourceFlags(out.mesh, out.is_source, **cut);
    out.mesh = std::move((*cut)->mesh);
  }

  out.cavities_left = now.cavities;
  out.removed_mm3 = signedVolume(hollow) - signedVolume(out.mesh);
  out.from_triangle.resize(out.mesh.triangles.size());
  out.is_cut.resize(out.mesh.triangles.size());
  for (std::size_t t = 0; t < out.mesh.triangles.size(); ++t) {
    Rgba8& colour = out.mesh.face_colors[t];
    const std::uint32_t from = out.from_triangle[t] = numberOf(colour);
    out.is_cut[t] = from == kNoSource;
    colour = out.is_cut[t]            ? options.cut_color
             : hollow.hasFaceColors() ? hollow.face_colors[from]
                                      : options.source_color;
  }
  // Cut vertices took the colour of the numbers.
  if (hollow.hasVertexColors()) {
    for (Rgba8& colour : out.mesh.vertex_colors)
      if (colour == numbers.cut_color) colour = options.cut_color;
    if (!hollow.hasFaceColors()) out.mesh.face_colors.clear();
  }
  return out;
}

}  // namespace kerf
