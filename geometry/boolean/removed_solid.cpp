#include "geometry/boolean/removed_solid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/field/marching_cubes.h"

namespace kerf {
namespace {

struct Place {
  std::size_t brick, node;
};

// The neighbours of a field's nodes, in existing bricks.
class NodesBeside {
 public:
  explicit NodesBeside(const BrickField& field) : bricks_(field.brickCount()) {
    for (std::size_t b = 0; b < bricks_.size(); ++b)
      for (int face = 0; face < 6; ++face)
        bricks_[b][static_cast<std::size_t>(face)] = field.find(beyond(field, b, face));
  }

  // The brick beyond a face: -x, +x, -y, +y, -z, +z.
  static Vec3i beyond(const BrickField& field, std::size_t brick, int face) {
    Vec3i out = field.brickCoord(brick);
    out[face / 2] += face & 1 ? 1 : -1;
    return out;
  }

  std::optional<Place> find(const Place& at, int face) const {
    const int shift = shiftOf(face), along = static_cast<int>(at.node) >> shift & 7;
    const auto step = static_cast<std::size_t>(1 << shift);
    if (face & 1 ? along < 7 : along > 0) return Place{at.brick, face & 1 ? at.node + step : at.node - step};
    const int brick = bricks_[at.brick][static_cast<std::size_t>(face)];
    if (brick < 0) return {};
    return Place{static_cast<std::size_t>(brick), face & 1 ? at.node - 7 * step : at.node + 7 * step};
  }

  // How many nodes there are in the brick beyond a node.
  static int left(std::size_t node, int face) {
    const int along = static_cast<int>(node) >> shiftOf(face) & 7;
    return face & 1 ? 7 - along : along;
  }

 private:
  static int shiftOf(int face) { return 3 * (2 - face / 2); }

  std::vector<std::array<int, 6>> bricks_;  // -1: none
};

float valueAt(const BrickField& field, const Place& at) { return field.brick(at.brick)[at.node]; }

// Finds new values of nodes from those of all, then writes them: visit(place, value), once each.
template <class Find, class Visit>
void replaceValues(const BrickField& field, const Find& find, const Visit& visit) {
  struct Found {
    std::size_t node;
    float value;
  };
  std::vector<std::vector<Found>> found(field.brickCount());
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t b) {
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      if (const std::optional<float> value = find(Place{b, n})) found[b].push_back({n, *value});
  });
  for (std::size_t b = 0; b < found.size(); ++b)
    for (const Found& one : found[b]) visit(Place{b, one.node}, one.value);
}

// MarchingCubesOptions::chord_balance, before the cap: a cap makes a crease, and beside a surface cut by less than a
// voxel a crease weighs more than the chords.
// @param counts  true for places with a value of the meshed surface.
template <class Counts>
void balanceChords(BrickField& field, const NodesBeside& beside, const Counts& counts) {
  const float balance = MarchingCubesOptions{}.chord_balance, near = 1.8f * static_cast<float>(field.voxel());
  replaceValues(
      field,
      [&](const Place& at) -> std::optional<float> {
        const float value = valueAt(field, at);
        if (std::abs(value) >= near || !counts(at)) return {};
        float sum = 0;
        for (int face = 0; face < 6; ++face) {
          const auto other = beside.find(at, face);
          if (!other || !counts(*other) || std::abs(valueAt(field, *other)) >= field.background()) return {};
          sum += valueAt(field, *other);
        }
        return value - balance * (sum - 6 * value);
      },
      [&](const Place& at, float value) { field.brick(at.brick)[at.node] = value; });
}

// rho = max(rho, phi0 - 2h).
template <class Before>
void cap(BrickField& rho, const Before& before) {
  const auto reach = static_cast<float>(2 * rho.voxel());
  tbb::parallel_for(std::size_t{0}, rho.brickCount(), [&](std::size_t b) {
    for (std::size_t n = 0; n < kBrickNodes; ++n) {
      float& value = rho.brick(b)[n];
      value = std::clamp(std::max(value, before(Place{b, n}) - reach), -rho.background(), rho.background());
    }
  });
}

// The removed field of a cut, from phi alone.
//
// Let c = phi - phi0 be the depth of the cut at a node. Where c > 0, phi is minus the distance from the tool, in the
// air too: rho = -phi. Beyond the rim c is 0: the tool is farther away than the surface. There rho continues in a
// straight line, for two nodes. The distance from a convex tool bends up, so the largest of such lines is the best
// estimate. Parts of the cut nowhere deeper than eps stay.
class RemovedByField {
 public:
  // @param sign  -1: of negated fields, which turn an addition into a cut.
  RemovedByField(const BrickField& phi0, const BrickField& phi, float sign)
      : sign_(sign), h_(static_cast<float>(phi0.voxel())), rho_(phi0.voxel(), 4 * h_) {
    rho_.reserve(phi.brickCount());
    for (std::size_t b = 0; b < phi.brickCount(); ++b) add(phi.brickCoord(b), phi0, &phi.brick(b));
    addBesideRim(phi0);
  }

  BrickField field() {
    const NodesBeside beside(rho_);
    for (std::uint8_t ring = 1; ring <= kRings; ++ring)
      replaceValues(
          rho_, [&](const Place& at) { return valueBeside(at, beside); },
          [&](const Place& at, float value) {
            bricks_[at.brick].ring[at.node] = ring;
            rho_.brick(at.brick)[at.node] = value;
          });
    balanceChords(rho_, beside, [&](const Place& at) { return ringOf(at) != kNone; });
    keepOffSource();
    cap(rho_, [&](const Place& at) { return before(at); });
    return std::move(rho_);
  }

 private:
  static constexpr std::uint8_t kRings = 2, kNone = 0xff;

  struct Brick {
    const BrickValues *phi0, *phi;  // null: `constant`; as phi0
    float constant;
    std::array<std::uint8_t, kBrickNodes> ring;  // 0: cut deeper than eps; n: n nodes away from that; kNone: farther
  };

  // Away from the cut the surface of rho keeps a distance from that of phi0, in creases of the source too.
  void keepOffSource() {
    tbb::parallel_for(std::size_t{0}, bricks_.size(), [&](std::size_t b) {
      for (std::size_t n = 0; n < kBrickNodes; ++n) {
        const Place at{b, n};
        const std::uint8_t ring = ringOf(at);
        if (ring == 0 || ring == kNone || after(at) > before(at)) continue;
        float& value = rho_.brick(b)[n];
        value = std::max(value, eps() - before(at));
      }
    });
  }

  float eps() const { return 0.1f * h_; }
  float before(const Place& at) const {
    const Brick& brick = bricks_[at.brick];
    return sign_ * (brick.phi0 ? (*brick.phi0)[at.node] : brick.constant);
  }
  float after(const Place& at) const {
    const Brick& brick = bricks_[at.brick];
    return brick.phi ? sign_ * (*brick.phi)[at.node] : before(at);
  }
  std::uint8_t ringOf(const Place& at) const { return bricks_[at.brick].ring[at.node]; }
  bool isNearSurface(const Place& at) const { return std::abs(before(at)) < 3 * h_; }

  // @param phi  null: no change there.
  void add(const Vec3i& coord, const BrickField& phi0, const BrickValues* phi) {
    const std::size_t b = rho_.touch(coord);
    bricks_.push_back({phi0.valuesAt(coord), phi, phi0.constantAt(coord), {}});
    for (std::size_t n = 0; n < kBrickNodes; ++n) {
      const float now = after({b, n}), depth = now - before({b, n});
      const bool is_deep = depth >= eps();
      rho_.brick(b)[n] = is_deep ? -now : std::max(-now, eps() - depth);
      bricks_[b].ring[n] = is_deep ? 0 : kNone;
    }
  }

  // The bricks into which rings reach.
  void addBesideRim(const BrickField& phi0) {
    const std::size_t count = bricks_.size();
    for (std::size_t b = 0; b < count; ++b)
      for (int face = 0; face < 6; ++face) {
        const Vec3i coord = NodesBeside::beyond(rho_, b, face);
        if (rho_.find(coord) < 0 && reaches(b, face)) add(coord, phi0, nullptr);
      }
  }

  // Whether the cut comes within the rings of a face, near the surface.
  bool reaches(std::size_t b, int face) const {
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      if (NodesBeside::left(n, face) < kRings && ringOf({b, n}) == 0 && isNearSurface({b, n})) return true;
    return false;
  }

  // The value of a node beside those that have one, unless it has one itself.
  std::optional<float> valueBeside(const Place& at, const NodesBeside& beside) const {
    if (ringOf(at) != kNone || !isNearSurface(at)) return {};
    const float was = before(at), now = after(at);
    if (now < was) return {};
    float line = eps() - was;  // the surface of rho keeps off that of phi0
    bool is_beside = false;
    for (int face = 0; face < 6; ++face)
      if (const auto near = beside.find(at, face); near && ringOf(*near) != kNone) {
        is_beside = true;
        line = std::max(line, lineFrom(*near, face, was, beside));
      }
    if (!is_beside) return {};
    return now > was ? -now : line;
  }

  // Extrapolates the line through a node and the one behind it. Without the latter, the cut is as far above the surface
  // here as below it there.
  float lineFrom(const Place& near, int face, float was, const NodesBeside& beside) const {
    const float rho = valueAt(rho_, near);
    if (const auto far = beside.find(near, face)) {
      const bool is_cut = after(*far) > before(*far);
      if (ringOf(*far) != kNone || is_cut)
        return rho + std::min(rho - (is_cut ? -after(*far) : valueAt(rho_, *far)), h_);
    }
    return std::abs(rho + before(near)) - was;
  }

  const float sign_, h_;
  BrickField rho_;
  std::vector<Brick> bricks_;  // as in rho_
};

}  // namespace

BrickField removedFieldFromSweep(const BrickField& phi0, const BrickField& sweep) {
  BrickField rho(phi0.voxel(), static_cast<float>(4 * phi0.voxel()));
  rho.reserve(sweep.brickCount());
  for (std::size_t b = 0; b < sweep.brickCount(); ++b) {
    BrickValues values = sweep.brick(b);
    for (float& value : values) value = std::clamp(value, -rho.background(), rho.background());
    rho.add(sweep.brickCoord(b), values);
  }
  balanceChords(rho, NodesBeside(rho), [](const Place&) { return true; });
  std::vector<const BrickValues*> loaded(rho.brickCount());
  for (std::size_t b = 0; b < loaded.size(); ++b) loaded[b] = phi0.valuesAt(rho.brickCoord(b));
  cap(rho, [&](const Place& at) {
    return loaded[at.brick] ? (*loaded[at.brick])[at.node] : phi0.constantAt(rho.brickCoord(at.brick));
  });
  return rho;
}

BrickField removedFieldFromCut(const BrickField& phi0, const BrickField& phi) {
  return RemovedByField(phi0, phi, 1).field();
}

BrickField addedFieldFromFill(const BrickField& phi0, const BrickField& phi) {
  return RemovedByField(phi0, phi, -1).field();
}

void clearAwayFromInside(BrickField& rho) {
  std::vector<char> has_inside(rho.brickCount());
  for (std::size_t b = 0; b < rho.brickCount(); ++b)
    has_inside[b] = std::any_of(rho.brick(b).begin(), rho.brick(b).end(), [](float v) { return v < 0; });
  for (std::size_t b = 0; b < rho.brickCount(); ++b) {
    bool is_near = false;
    for (int n = 0; n < 27 && !is_near; ++n) {
      const int near = rho.find(rho.brickCoord(b) + Vec3i{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1});
      is_near = near >= 0 && has_inside[static_cast<std::size_t>(near)];
    }
    if (!is_near) rho.brick(b).fill(rho.background());
  }
}

RemovedSolid meshRemovedSolid(const BrickField& rho) {
  RemovedSolid out;
  const Mesh all = marchingCubes(rho, {.chord_balance = 0});  // rho is balanced already
  const Pieces pieces = edgeConnectedPieces(all);
  std::vector<double> volume(pieces.count, 0);
  if (!all.vertices.empty()) {
    const Vec3d c = bounds(all).center();
    for (std::size_t t = 0; t < all.triangles.size(); ++t)
      volume[pieces.label[t]] += (all.corner(t, 0) - c).dot((all.corner(t, 1) - c).cross(all.corner(t, 2) - c)) / 6;
  }

  const double crumb = std::pow(rho.voxel(), 3);
  std::vector<char> keep(all.triangles.size(), 1);
  for (std::uint32_t p = 0; p < pieces.count; ++p)
    if (std::abs(volume[p]) < crumb) {
      ++out.parts_dropped;
      out.dropped_volume_mm3 += std::abs(volume[p]);
    }

  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = std::abs(volume[pieces.label[t]]) >= crumb;
  out.mesh = out.parts_dropped ? subset(all, keep) : all;
  return out;
}

}  // namespace kerf
