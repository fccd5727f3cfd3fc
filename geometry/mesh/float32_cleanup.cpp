#include "geometry/mesh/float32_cleanup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <queue>
#include <span>

#include "geometry/mesh/crossing_pairs.h"

namespace kerf {
namespace {

constexpr double kNeedleExempt = 2e-4;           ///< mm: below this height a triangle's normal is meaningless
constexpr double kCollapseTurn = 0.5;            ///< cos 60 degrees
constexpr double kFlipTurn = 0.906307787036650;  ///< cos 25 degrees
constexpr int kMaxRounds = 8;
constexpr std::uint32_t kNoVertex = ~0u;

tl::unexpected<Error> badInput(std::string place, std::string found, std::string expected) {
  Error e;
  e.code = Error::Code::kBadValue;
  e.place = std::move(place);
  e.found = std::move(found);
  e.expected = std::move(expected);
  return fail(std::move(e));
}

/// The triangles of every vertex, in the order of addition. A clean-up changes few of these lists, so one array holds
/// the others: separate lists would take half the time of a clean-up.
class TrianglesAround {
 public:
  explicit TrianglesAround(const Mesh& mesh)
      : begin_(mesh.vertices.size() + 1), all_(3 * mesh.triangles.size()), own_(mesh.vertices.size(), kNoVertex) {
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) ++begin_[v + std::size_t{1}];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) all_[next[v]++] = t;
  }

  std::size_t size() const { return own_.size(); }
  std::span<const std::uint32_t> operator[](std::uint32_t v) const {
    if (own_[v] != kNoVertex) return changed_[own_[v]];
    return {all_.data() + begin_[v], all_.data() + begin_[v + std::size_t{1}]};
  }
  /// The list, to be changed.
  std::vector<std::uint32_t>& change(std::uint32_t v) {
    if (own_[v] == kNoVertex) {
      const std::span<const std::uint32_t> before = (*this)[v];
      changed_.emplace_back(before.begin(), before.end());
      own_[v] = static_cast<std::uint32_t>(changed_.size() - 1);
    }
    return changed_[own_[v]];
  }

 private:
  std::vector<std::uint32_t> begin_, all_;  // per vertex, where its triangles begin
  std::vector<std::uint32_t> own_;          // per vertex: its list in changed_, or kNoVertex
  std::deque<std::vector<std::uint32_t>> changed_;
};

/// Collapses and flips on an indexed mesh with the triangles of every vertex at hand. Dead triangles keep their slot.
class Cleaner {
 public:
  Cleaner(Mesh& mesh, const std::vector<char>& fixed)
      : mesh_(mesh),
        fixed_(fixed),
        alive_(mesh.triangles.size(), 1),
        around_(mesh),
        focus_(alive_),
        changed_(alive_.size(), 0) {}

  CleanupReport report;
  const std::vector<char>& alive() const { return alive_; }
  const std::vector<char>& changed() const { return changed_; }
  void focusOn(std::vector<char> faces) { focus_ = std::move(faces); }

  void collapseShort(double length) {
    struct Item {
      double length;
      std::uint32_t u, v;
      bool operator>(const Item& o) const {
        return length != o.length ? length > o.length : u != o.u ? u > o.u : v > o.v;
      }
    };

    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    const auto offer = [&](std::uint32_t u, std::uint32_t v) {
      const double d = (mesh_.vertices[u] - mesh_.vertices[v]).norm();
      if (d < length && !(fixed_[u] && fixed_[v])) queue.push({d, std::min(u, v), std::max(u, v)});
    };
    for (std::uint32_t t = 0; t < alive_.size(); ++t)
      if (alive_[t] && focus_[t])
        for (std::size_t k = 0; k < 3; ++k) offer(mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3]);

    while (!queue.empty()) {
      const Item item = queue.top();
      queue.pop();
      // An edge may have vanished, or have other triangles, since it was queued.
      if (sharedFaces(item.u, item.v).size() != 2) continue;
      if ((mesh_.vertices[item.u] - mesh_.vertices[item.v]).norm() != item.length) continue;

      std::uint32_t gone = kNoVertex;
      for (const auto& [from, to] : {std::pair(item.v, item.u), std::pair(item.u, item.v)})
        if (!fixed_[from] && tryCollapse(from, to)) {
          gone = from;
          break;
        }
      if (gone == kNoVertex) continue;

      const std::uint32_t left = gone == item.u ? item.v : item.u;
      for (const std::uint32_t t : around_[left])
        for (const std::uint32_t v : mesh_.triangles[t])
          if (v != left) offer(left, v);
    }
  }

  void flipNeedles(double height_limit) {
    for (std::uint32_t t = 0; t < alive_.size(); ++t) {
      if (!alive_[t] || !focus_[t]) continue;
      const Triangle f = mesh_.triangles[t];
      std::size_t longest = 0;
      double best = -1;
      for (std::size_t k = 0; k < 3; ++k) {
        const double d = (mesh_.vertices[f[k]] - mesh_.vertices[f[(k + 1) % 3]]).squaredNorm();
        if (d > best) {
          best = d;
          longest = k;
        }
      }

      const double twice_area = doubleAreaVector(mesh_, t).norm();
      if (!(twice_area < height_limit * std::sqrt(best))) continue;
      if (fixed_[f[0]] && fixed_[f[1]] && fixed_[f[2]] && twice_area > 0) continue;
      if (tryFlip(t, f[longest], f[(longest + 1) % 3], f[(longest + 2) % 3])) ++report.flipped;
    }
  }

  /// Moves the free vertices of the focus towards their neighbours' mean.
  void relax(double step) {
    for (std::uint32_t v = 0; v < around_.size(); ++v) {
      if (fixed_[v] || around_[v].empty()) continue;
      if (std::none_of(around_[v].begin(), around_[v].end(), [&](std::uint32_t t) { return focus_[t] != 0; })) continue;

      Vec3d sum = Vec3d::Zero();
      double count = 0;
      for (const std::uint32_t t : around_[v])
        for (const std::uint32_t w : mesh_.triangles[t])
          if (w != v) {
            sum += mesh_.vertices[w];
            ++count;
          }

      Vec3d move = sum / count - mesh_.vertices[v];
      if (move.norm() > step) move *= step / move.norm();

      const Vec3d to = roundedToFloat(mesh_.vertices[v] + move);
      report.largest_move_mm = std::max(report.largest_move_mm, (to - mesh_.vertices[v]).norm());
      mesh_.vertices[v] = to;
      for (const std::uint32_t t : around_[v]) changed_[t] = 1;
      ++report.relaxed;
    }
  }

 private:
  std::vector<std::uint32_t> sharedFaces(std::uint32_t u, std::uint32_t v) const {
    std::vector<std::uint32_t> faces;
    for (const std::uint32_t t : around_[u]) {
      const Triangle& f = mesh_.triangles[t];
      if (f[0] == v || f[1] == v || f[2] == v) faces.push_back(t);
    }
    return faces;
  }
  std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t t : around_[v])
      for (const std::uint32_t w : mesh_.triangles[t])
        if (w != v) out.push_back(w);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }
  static Vec3d doubleArea(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return (b - a).cross(c - a); }
  static double height(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const double base = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    return base > 0 ? doubleArea(a, b, c).norm() / base : 0;
  }

  bool tryCollapse(std::uint32_t u, std::uint32_t v) {
    const std::vector<std::uint32_t> shared = sharedFaces(u, v);
    if (shared.size() != 2) return false;

    const std::vector<std::uint32_t> nu = neighbours(u), nv = neighbours(v);
    std::vector<std::uint32_t> common;
    std::set_intersection(nu.begin(), nu.end(), nv.begin(), nv.end(), std::back_inserter(common));
    if (common.size() != 2) return false;  // link condition
    for (const std::uint32_t w : common)
      if (around_[w].size() <= 3) return false;  // would fold two triangles onto each other
    for (const std::uint32_t t : around_[u]) {
      if (t == shared[0] || t == shared[1]) continue;
      std::array<Vec3d, 3> now, then;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t w = mesh_.triangles[t][k];
        now[k] = mesh_.vertices[w];
        then[k] = mesh_.vertices[w == u ? v : w];
      }

      const Vec3d before = doubleArea(now[0], now[1], now[2]), after = doubleArea(then[0], then[1], then[2]);
      if (after.isZero(0)) return false;
      if (height(now[0], now[1], now[2]) < kNeedleExempt || height(then[0], then[1], then[2]) < kNeedleExempt) continue;
      if (before.dot(after) < kCollapseTurn * before.norm() * after.norm()) return false;
    }

    report.largest_move_mm = std::max(report.largest_move_mm, (mesh_.vertices[u] - mesh_.vertices[v]).norm());
    for (const std::uint32_t t : shared) remove(t);
    for (const std::uint32_t t : around_[u]) {
      for (std::uint32_t& w : mesh_.triangles[t])
        if (w == u) w = v;
      around_.change(v).push_back(t);
      changed_[t] = 1;
    }
    around_.change(u).clear();
    ++report.collapsed;
    return true;
  }

  /// Replaces edge ab of (a, b, c) and its neighbour (b, a, d) by cd.
  bool tryFlip(std::uint32_t t, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::vector<std::uint32_t> shared = sharedFaces(a, b);
    if (shared.size() != 2) return false;
    const std::uint32_t other = shared[0] == t ? shared[1] : shared[0];

    std::uint32_t d = kNoVertex;
    for (const std::uint32_t w : mesh_.triangles[other])
      if (w != a && w != b) d = w;
    if (d == kNoVertex || d == c || !sharedFaces(c, d).empty()) return false;
    if (around_[a].size() <= 3 || around_[b].size() <= 3) return false;

    const Vec3d &pa = mesh_.vertices[a], &pb = mesh_.vertices[b], &pc = mesh_.vertices[c], &pd = mesh_.vertices[d];
    const Vec3d reference = doubleAreaVector(mesh_, other);
    const double old_height = std::min(height(pa, pb, pc), height(pb, pa, pd));
    if (std::min(height(pa, pd, pc), height(pd, pb, pc)) <= old_height) return false;  // no gain, and no endless loop
    for (const Vec3d& n : {doubleArea(pa, pd, pc), doubleArea(pd, pb, pc)})
      if (n.isZero(0) || n.dot(reference) < kFlipTurn * n.norm() * reference.norm()) return false;

    detach(b, t);
    detach(a, other);
    mesh_.triangles[t] = {a, d, c};
    mesh_.triangles[other] = {d, b, c};
    changed_[t] = changed_[other] = 1;
    around_.change(d).push_back(t);
    around_.change(c).push_back(other);
    return true;
  }

  void detach(std::uint32_t v, std::uint32_t t) {
    std::vector<std::uint32_t>& list = around_.change(v);
    list.erase(std::find(list.begin(), list.end(), t));
  }
  void remove(std::uint32_t t) {
    for (const std::uint32_t v : mesh_.triangles[t]) detach(v, t);
    alive_[t] = 0;
  }

  Mesh& mesh_;
  const std::vector<char>& fixed_;
  std::vector<char> alive_;
  TrianglesAround around_;
  std::vector<char> focus_, changed_;
};

/// Drops dead triangles and the vertices without one.
void compact(Mesh& mesh, const std::vector<char>& alive, std::vector<char>& fixed, std::vector<std::uint32_t>* tag) {
  std::vector<char> used(fixed);
  for (std::size_t t = 0; t < alive.size(); ++t)
    if (alive[t])
      for (const std::uint32_t v : mesh.triangles[t]) used[v] = 1;

  std::vector<std::uint32_t> index(used.size(), kNoVertex);
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    mesh.vertices[count] = mesh.vertices[v];
    fixed[count] = fixed[v];
    if (mesh.hasVertexColors()) mesh.vertex_colors[count] = mesh.vertex_colors[v];
    index[v] = count++;
  }
  mesh.vertices.resize(count);
  fixed.resize(count);
  if (mesh.hasVertexColors()) mesh.vertex_colors.resize(count);

  std::size_t faces = 0;
  for (std::size_t t = 0; t < alive.size(); ++t) {
    if (!alive[t]) continue;
    const Triangle f = mesh.triangles[t];
    mesh.triangles[faces] = {index[f[0]], index[f[1]], index[f[2]]};
    if (mesh.hasFaceColors()) mesh.face_colors[faces] = mesh.face_colors[t];
    if (tag) (*tag)[faces] = (*tag)[t];
    ++faces;
  }
  mesh.triangles.resize(faces);
  if (mesh.hasFaceColors()) mesh.face_colors.resize(faces);
  if (tag) tag->resize(faces);
}

/// Of each triangle: whether one of its corners is free.
std::vector<char> freeOnes(const Mesh& mesh, const std::vector<char>& fixed) {
  std::vector<char> out(mesh.triangles.size());
  for (std::size_t t = 0; t < out.size(); ++t) {
    const Triangle& f = mesh.triangles[t];
    out[t] = !fixed[f[0]] || !fixed[f[1]] || !fixed[f[2]];
  }
  return out;
}

}  // namespace

Expected<CleanupReport> cleanUpForFloat32(Mesh& mesh, std::vector<char>& fixed_vertex,
                                          std::vector<std::uint32_t>* face_tag, double length_mm,
                                          FixedPart fixed_part) {
  if (fixed_vertex.size() != mesh.vertices.size() || (face_tag && face_tag->size() != mesh.triangles.size()))
    return badInput({}, "clean-up labels that do not fit the mesh", "one flag per vertex and one tag per triangle");

  CleanupReport total;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3d r = roundedToFloat(mesh.vertices[v]);
    if (!r.allFinite())
      return badInput(fmt::format("vertex {}", v), "a coordinate that is no single-precision number",
                      "coordinates below 3e38 mm");
    if (r == mesh.vertices[v]) continue;
    if (fixed_vertex[v]) ++total.fixed_moved;
    total.largest_move_mm = std::max(total.largest_move_mm, (r - mesh.vertices[v]).norm());
    mesh.vertices[v] = r;
  }

  // Triangles that may cross another one: no two others do.
  const bool is_known = fixed_part == FixedPart::kFreeOfCrossings && total.fixed_moved == 0;
  std::vector<char> suspect = is_known ? freeOnes(mesh, fixed_vertex) : std::vector<char>(mesh.triangles.size(), 1);
  const auto pass = [&](double length, std::vector<char> focus, bool relax) {
    Cleaner cleaner(mesh, fixed_vertex);
    if (!focus.empty()) cleaner.focusOn(std::move(focus));
    for (int repeat = 0; repeat < 2; ++repeat) {
      cleaner.collapseShort(length);
      cleaner.flipNeedles(0.1 * length);
    }
    if (relax) cleaner.relax(length);
    total.collapsed += cleaner.report.collapsed;
    total.flipped += cleaner.report.flipped;
    total.relaxed += cleaner.report.relaxed;
    total.largest_move_mm = std::max(total.largest_move_mm, cleaner.report.largest_move_mm);
    compact(mesh, cleaner.alive(), fixed_vertex, face_tag);

    std::size_t left = 0;
    for (std::size_t t = 0; t < suspect.size(); ++t)
      if (cleaner.alive()[t]) suspect[left++] = suspect[t] || cleaner.changed()[t];
    suspect.resize(left);
  };

  pass(length_mm, {}, false);
  auto pairs = is_known ? crossingPairsOf(mesh, suspect) : crossingPairs(mesh);
  for (double length = length_mm; !pairs.empty() && total.targeted_rounds < kMaxRounds; ++total.targeted_rounds) {
    length *= 1.6;
    std::vector<char> focus(mesh.triangles.size(), 0);
    for (const auto& [i, j] : pairs) focus[i] = focus[j] = 1;
    suspect = focus;
    pass(length, std::move(focus), total.targeted_rounds >= 2);
    pairs = crossingPairsOf(mesh, suspect);
  }

  total.crossings_left = pairs.size();
  total.pairs_left = std::move(pairs);
  return total;
}

}  // namespace kerf
