#include "preprocess/close/orient.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "geometry/mesh/box_tree.h"
#include "preprocess/close/close.h"
#include "preprocess/close/winding.h"

namespace kerf::internal {
namespace {

constexpr std::uint32_t kNoTriangle = ~0u;

void flip(Triangle& f) { std::swap(f[1], f[2]); }

// Neighbours across two-sided edges.
struct Neighbours {
  std::vector<std::array<std::uint32_t, 3>> next;  // per triangle: up to three, then kNoTriangle
  std::vector<std::array<char, 3>> differs;        // true if that one faces the other way
};

bool joins(std::span<const EdgeUse> uses) { return uses.size() == 2 && uses[0].triangle != uses[1].triangle; }

Neighbours facesAcross(std::size_t triangles, const std::vector<EdgeUse>& all) {
  Neighbours out{std::vector<std::array<std::uint32_t, 3>>(triangles, {kNoTriangle, kNoTriangle, kNoTriangle}),
                 std::vector<std::array<char, 3>>(triangles, {0, 0, 0})};
  std::vector<int> filled(triangles, 0);
  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    if (!joins(uses)) return;
    const char wrong = uses[0].forth == uses[1].forth;
    for (std::size_t k = 0; k < 2; ++k) {
      const std::uint32_t t = uses[k].triangle;
      const auto slot = static_cast<std::size_t>(filled[t]++);
      out.next[t][slot] = uses[1 - k].triangle;
      out.differs[t][slot] = wrong;
    }
  });
  return out;
}

// The triangles connected with `seed`; turn[t] becomes 0 or 1, by whether t faces as the seed does.
void spread(std::uint32_t seed, const Neighbours& neighbours, std::vector<signed char>& turn,
            std::vector<std::uint32_t>& patch) {
  patch.assign(1, seed);
  turn[seed] = 0;
  for (std::size_t i = 0; i < patch.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t t = patch[i], u = neighbours.next[t][k];
      if (u == kNoTriangle || turn[u] >= 0) continue;
      turn[u] = static_cast<signed char>(turn[t] ^ neighbours.differs[t][k]);
      patch.push_back(u);
    }
}

// @param join_edge  called with the uses of each edge and with join(triangle, triangle).
template <class F>
Pieces joinedPieces(std::size_t triangles, const std::vector<EdgeUse>& uses, const F& join_edge) {
  std::vector<std::uint32_t> parent(triangles);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto join = [&](std::uint32_t s, std::uint32_t t) {
    const std::uint32_t a = find(s), b = find(t);
    if (a != b) parent[std::max(a, b)] = std::min(a, b);
  };
  forEachEdge(uses, [&](std::span<const EdgeUse> edge) { join_edge(edge, join); });
  Pieces pieces;
  pieces.label.resize(triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::uint32_t root = find(t);
    pieces.label[t] = root == t ? pieces.count++ : pieces.label[root];
  }
  return pieces;
}

// Signed volume and box of every piece.
struct PieceSizes {
  std::vector<double> volume;
  std::vector<Box3> box;
};

PieceSizes sizesOf(const Mesh& mesh, const Pieces& pieces) {
  PieceSizes out{std::vector<double>(pieces.count, 0), std::vector<Box3>(pieces.count)};
  const Vec3d center = bounds(mesh).center();
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t l = pieces.label[t];
    const Vec3d a = mesh.corner(t, 0) - center, b = mesh.corner(t, 1) - center, c = mesh.corner(t, 2) - center;
    out.volume[l] += a.dot(b.cross(c)) / 6;
    for (int k = 0; k < 3; ++k) out.box[l].add(mesh.corner(t, k));
  }
  return out;
}

// True if the box of some piece lies in that of another.
bool areNested(const BoxTree& boxes) {
  for (std::uint32_t l = 0; l < boxes.boxes().size(); ++l) {
    const Box3& inner = boxes.boxes()[l];
    if (!boxes.visit([&](const Box3& node) { return holds(node, inner); },
                     [&](std::uint32_t o) { return o == l || !holds(boxes.boxes()[o], inner); }))
      return true;
  }
  return false;
}

// Separates pieces that meet along an edge by file order, if each piece runs once forth and once back along the edge.
// Otherwise triangles that share an edge are one piece.
Pieces bodiesOf(std::size_t triangles, const std::vector<EdgeUse>& uses) {
  return joinedPieces(triangles, uses, [](std::span<const EdgeUse> edge, const auto& join) {
    bool are_pairs = edge.size() % 2 == 0;
    for (std::size_t i = 0; are_pairs && i < edge.size(); i += 2) are_pairs = edge[i].forth != edge[i + 1].forth;
    for (std::size_t i = 1; i < edge.size(); ++i)
      if (!are_pairs || i % 2 == 1) join(edge[i - 1].triangle, edge[i].triangle);
  });
}

// Which way round each closed piece belongs.
class Bodies {
 public:
  Bodies(const Mesh& mesh, const Pieces& pieces, const PieceSizes& sizes, const BoxTree& boxes)
      : mesh_(mesh), pieces_(pieces), volume_(sizes.volume), boxes_(boxes), sign_(pieces.count, 1) {}

  // Per piece: true to turn it. Pieces face outwards, except a piece inside others without crossing them: it bounds a
  // cavity of the nearest one if the two face opposite ways in the file.
  std::vector<char> turns() {
    std::vector<std::uint32_t> order(pieces_.count);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [this](std::uint32_t a, std::uint32_t b) { return std::abs(volume_[a]) > std::abs(volume_[b]); });
    std::vector<char> turn(pieces_.count, 0);
    for (const std::uint32_t l : order) {
      if (volume_[l] == 0) break;
      sign_[l] = signOf(l, turn);
      turn[l] = (volume_[l] < 0) != (sign_[l] < 0);
    }
    return turn;
  }

 private:
  int signOf(std::uint32_t l, const std::vector<char>& turn) {
    std::vector<std::uint32_t> around;
    bool is_asked = volume_[l] < 0, is_in_open = false;
    const Box3& inner = boxes_.boxes()[l];
    boxes_.visit([&](const Box3& node) { return holds(node, inner); },
                 [&](std::uint32_t o) {
                   if (o == l || !holds(boxes_.boxes()[o], inner)) return true;
                   is_in_open = is_in_open || volume_[o] == 0;
                   if (!(std::abs(volume_[o]) > std::abs(volume_[l]))) return true;
                   around.push_back(o);
                   is_asked = is_asked || turn[o] != 0;
                   return true;
                 });
    if (!is_asked) return 1;
    if (is_in_open) return volume_[l] < 0 ? -1 : 1;  // unchanged until the outer piece is closed: it may be its cavity

    std::erase_if(around, [&](std::uint32_t o) { return !liesInside(l, o); });
    int winding = 0;
    for (const std::uint32_t o : around) winding += sign_[o];
    if (winding == 0) return 1;
    const std::uint32_t nearest = *std::min_element(
        around.begin(), around.end(), [this](auto a, auto b) { return std::abs(volume_[a]) < std::abs(volume_[b]); });
    return (volume_[l] < 0) == (volume_[nearest] < 0) ? sign_[nearest] : -sign_[nearest];
  }

  // True if no part of piece `l` lies outside piece `o`, tested at corners and middles of its triangles.
  bool liesInside(std::uint32_t l, std::uint32_t o) {
    if (!rays_) sortTriangles();
    bool is_inside = false;
    for (const std::uint32_t t : std::span(sorted_).subspan(first_[l], first_[l + 1] - first_[l])) {
      const Vec3d middle = (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2)) / 3;
      for (const Vec3d& p : {mesh_.corner(t, 0), middle}) {
        const auto winding = rays_->at(p, [&](std::uint32_t other) { return pieces_.label[other] != o; });
        if (winding && *winding == 0) return false;
        is_inside = is_inside || winding.has_value();
      }
    }
    return is_inside;
  }

  void sortTriangles() {
    rays_.emplace(mesh_);
    first_.assign(pieces_.count + 1, 0);
    for (const std::uint32_t l : pieces_.label) ++first_[l + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    sorted_.resize(pieces_.label.size());
    for (std::uint32_t t = 0; t < sorted_.size(); ++t) sorted_[next[pieces_.label[t]]++] = t;
  }

  const Mesh& mesh_;
  const Pieces& pieces_;
  const std::vector<double>& volume_;
  const BoxTree& boxes_;
  std::vector<int> sign_;  // correct orientations
  std::optional<RayWinding> rays_;
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> sorted_;  // triangles of piece l: sorted_[first_[l] .. first_[l + 1])
};

}  // namespace

void orientTriangles(Chain& chain, CloseReport& report) {
  const std::size_t n = chain.mesh.triangles.size();
  const std::vector<EdgeUse> all = edgeUses(chain.mesh.triangles);
  bool any = false;
  forEachEdge(all,
              [&](std::span<const EdgeUse> uses) { any = any || (joins(uses) && uses[0].forth == uses[1].forth); });
  if (!any) return;

  const Neighbours neighbours = facesAcross(n, all);
  std::vector<signed char> turn(n, -1);
  std::vector<std::uint32_t> patch;
  for (std::uint32_t seed = 0; seed < n; ++seed) {
    if (turn[seed] >= 0) continue;
    spread(seed, neighbours, turn, patch);
    std::size_t turned = 0;
    for (const std::uint32_t t : patch) turned += static_cast<std::size_t>(turn[t]);
    const signed char minority = 2 * turned <= patch.size() ? 1 : 0;
    for (const std::uint32_t t : patch)
      if (turn[t] == minority) {
        flip(chain.mesh.triangles[t]);
        ++report.triangles_flipped;
      }
  }

  if (report.triangles_flipped)
    report.changes.push_back(counted(report.triangles_flipped, "triangle was", "triangles were") +
                             " turned to agree with the neighbours");
}

Pieces piecesOf(std::size_t triangles, const std::vector<EdgeUse>& uses) {
  return joinedPieces(triangles, uses, [](std::span<const EdgeUse> edge, const auto& join) {
    for (std::size_t i = 1; i < edge.size(); ++i) join(edge[0].triangle, edge[i].triangle);
  });
}

bool turnPieces(Chain& chain, CloseReport& report) {
  Mesh& mesh = chain.mesh;
  const std::vector<EdgeUse> uses = edgeUses(mesh.triangles);
  const Pieces pieces = bodiesOf(mesh.triangles.size(), uses);
  PieceSizes sizes = sizesOf(mesh, pieces);
  forEachEdge(uses, [&](std::span<const EdgeUse> edge) {  // an open piece has no volume
    const auto forth = std::count_if(edge.begin(), edge.end(), [](const EdgeUse& use) { return use.forth; });
    if (2 * static_cast<std::size_t>(forth) != edge.size()) sizes.volume[pieces.label[edge[0].triangle]] = 0;
  });
  const BoxTree boxes(sizes.box);
  const bool nested = areNested(boxes);
  if (std::none_of(sizes.volume.begin(), sizes.volume.end(), [](double v) { return v < 0; })) return nested;

  const std::vector<char> turn = Bodies(mesh, pieces, sizes, boxes).turns();
  const auto turned = static_cast<std::size_t>(std::count(turn.begin(), turn.end(), 1));
  for (std::uint32_t t = 0; turned && t < mesh.triangles.size(); ++t)
    if (turn[pieces.label[t]]) {
      flip(mesh.triangles[t]);
      ++report.triangles_flipped;
    }
  if (turned)
    report.changes.push_back(counted(turned, "closed piece was", "closed pieces were") + " inside out and turned");
  return nested;
}

}  // namespace kerf::internal
