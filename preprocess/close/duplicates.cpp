#include "preprocess/close/duplicates.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "preprocess/close/close.h"
#include "preprocess/close/edges.h"
#include "preprocess/close/orient.h"

namespace kerf::internal {
namespace {

// A triangle by its corners, whichever way round it is.
struct Key {
  Triangle sorted;
  bool even;  // which way round
  std::uint32_t t;
};

// Sorted by corners, then number: buckets by the smallest corner, then small sorts.
std::vector<Key> sortedKeys(const std::vector<Triangle>& triangles) {
  std::uint32_t vertices = 0;
  for (const Triangle& f : triangles) vertices = std::max({vertices, f[0] + 1, f[1] + 1, f[2] + 1});
  std::vector<std::uint32_t> begin(vertices + 1, 0);
  for (const Triangle& f : triangles) ++begin[std::min({f[0], f[1], f[2]}) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  std::vector<Key> keys(triangles.size());
  std::vector<std::uint32_t> place(begin.begin(), begin.end());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    Triangle f = triangles[t];
    const bool even = sortCorners(f);
    keys[place[f[0]]++] = {f, even, t};
  }
  for (std::uint32_t v = 0; v < vertices; ++v)
    std::sort(keys.begin() + begin[v], keys.begin() + begin[v + 1],
              [](const Key& x, const Key& y) { return x.sorted != y.sorted ? x.sorted < y.sorted : x.t < y.t; });
  return keys;
}

// Removes opposite copies in pairs. Returns the number of removed triangles.
// @param copies  out: remaining members of groups of equal triangles, except the first of each.
std::size_t cancelOpposites(const std::vector<Key>& keys, std::vector<char>& keep, std::vector<std::uint32_t>& copies) {
  std::size_t cancelled = 0;
  for (std::size_t i = 0, j = 0; i < keys.size(); i = j) {
    while (j < keys.size() && keys[j].sorted == keys[i].sorted) ++j;
    if (j - i < 2) continue;
    std::array<std::vector<std::uint32_t>, 2> sides;
    for (std::size_t k = i; k < j; ++k) sides[keys[k].even].push_back(keys[k].t);
    while (!sides[0].empty() && !sides[1].empty()) {
      for (auto& side : sides) {
        keep[side.back()] = 0;
        side.pop_back();
      }
      cancelled += 2;
    }
    for (const auto& side : sides)
      for (std::size_t k = 1; k < side.size(); ++k) copies.push_back(side[k]);
  }
  return cancelled;
}

// Drops copies that are too many for at least two of their edges. Returns how many.
std::size_t dropCopies(const std::vector<Triangle>& triangles, const std::vector<std::uint32_t>& copies,
                       std::vector<char>& keep) {
  if (copies.empty()) return 0;
  // How many times too often each of their edges is run through, in its direction from the smaller vertex.
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> net;
  const auto edge = [&](std::uint32_t t, std::size_t k) {
    const std::uint32_t p = triangles[t][k], q = triangles[t][(k + 1) % 3];
    return std::pair(std::pair(std::min(p, q), std::max(p, q)), p < q ? 1 : -1);
  };
  for (const std::uint32_t t : copies)
    for (std::size_t k = 0; k < 3; ++k) net[edge(t, k).first] = 0;

  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; keep[t] && k < 3; ++k) {
      const auto [key, sign] = edge(t, k);
      if (const auto found = net.find(key); found != net.end()) found->second += sign;
    }

  std::size_t dropped = 0;
  for (const std::uint32_t t : copies) {
    int excess = 0;
    for (std::size_t k = 0; k < 3; ++k) excess += net[edge(t, k).first] * edge(t, k).second > 0;
    if (excess < 2) continue;
    keep[t] = 0;
    ++dropped;
    for (std::size_t k = 0; k < 3; ++k) net[edge(t, k).first] -= edge(t, k).second;
  }
  return dropped;
}

// Triangles with the same corners the same way round: keys[begin .. end - 1].
struct Copies {
  std::size_t begin = 0, end = 0;
  std::size_t count() const { return end - begin; }
};

// Sorts the keys of each triangle by the way round.
std::vector<Copies> copiesOf(std::vector<Key>& keys) {
  std::vector<Copies> out;
  for (std::size_t i = 0, j = 0; i < keys.size(); i = j) {
    while (j < keys.size() && keys[j].sorted == keys[i].sorted) ++j;
    const auto first = keys.begin() + static_cast<std::ptrdiff_t>(i),
               last = keys.begin() + static_cast<std::ptrdiff_t>(j);
    const auto middle = std::stable_partition(first, last, [](const Key& key) { return key.even; });
    const auto half = static_cast<std::size_t>(middle - keys.begin());
    if (half > i) out.push_back({i, half});
    if (half < j) out.push_back({half, j});
  }
  return out;
}

// Whether as many of the triangles run along each edge as back.
bool isClosed(const std::vector<Triangle>& triangles) {
  const std::vector<EdgeCount> edges = countEdges(triangles);
  return std::all_of(edges.begin(), edges.end(), [](const EdgeCount& e) { return e.forth == e.back; });
}

// Counts the excess copies of each triangle in a connected group whose closed surface is repeated. Triangles with more
// copies than the rest may form another closed surface, such as a solid that shares a wall with another. That surface
// stays once beside the surface of all triangles.
void countRepeated(const std::vector<Triangle>& triangles, const std::vector<std::size_t>& count,
                   const std::vector<std::uint32_t>& of_piece, std::vector<std::size_t>& too_many) {
  std::vector<std::uint32_t> left = of_piece;
  for (std::size_t below = 0; !left.empty();) {
    std::size_t least = count[left.front()];
    for (const std::uint32_t n : left) least = std::min(least, count[n]);
    const std::size_t extra = least - below - 1;
    if (extra > 0) {
      std::vector<Triangle> surface;
      for (const std::uint32_t n : left) surface.push_back(triangles[n]);
      if (isClosed(surface))
        for (const std::uint32_t n : left) too_many[n] += extra;
    }
    below = least;
    std::erase_if(left, [&](std::uint32_t n) { return count[n] == least; });
  }
}

}  // namespace

void dropRepeatedSurfaces(Chain& chain, CloseReport& report) {
  std::vector<Key> keys = sortedKeys(chain.mesh.triangles);
  const std::vector<Copies> copies = copiesOf(keys);
  if (copies.size() == keys.size()) return;

  std::vector<Triangle> triangles;
  std::vector<std::size_t> count;
  for (const Copies& c : copies) {
    triangles.push_back(chain.mesh.triangles[keys[c.begin].t]);
    count.push_back(c.count());
  }
  const Pieces pieces = piecesOf(triangles.size(), edgeUses(triangles));
  std::vector<std::vector<std::uint32_t>> of_piece(pieces.count);
  for (std::uint32_t n = 0; n < triangles.size(); ++n) of_piece[pieces.label[n]].push_back(n);
  std::vector<std::size_t> too_many(triangles.size(), 0);
  for (const auto& piece : of_piece) countRepeated(triangles, count, piece, too_many);

  std::vector<char> keep(keys.size(), 1);
  std::size_t dropped = 0;
  for (std::size_t n = 0; n < copies.size(); ++n) {
    for (std::size_t k = copies[n].end - too_many[n]; k < copies[n].end; ++k) keep[keys[k].t] = 0;
    dropped += too_many[n];
  }
  if (dropped == 0) return;

  report.changes.push_back(counted(dropped, "duplicate triangle was", "duplicate triangles were") + " dropped");
  keepOnly(chain, keep);
}

void dropDuplicates(Chain& chain, CloseReport& report) {
  const std::vector<Triangle>& triangles = chain.mesh.triangles;
  std::vector<char> keep(triangles.size(), 1);
  std::vector<std::uint32_t> copies;
  std::size_t cancelled = cancelOpposites(sortedKeys(triangles), keep, copies);
  const std::size_t flipped = report.triangles_flipped;
  if (cancelled > 0) turnPieces(chain, report);
  if (report.triangles_flipped > flipped) {  // other triangles lie back to back now
    keep.assign(triangles.size(), 1);
    copies.clear();
    cancelled = cancelOpposites(sortedKeys(triangles), keep, copies);
  }
  const std::size_t merged = dropCopies(triangles, copies, keep);
  if (cancelled + merged == 0) return;

  if (merged)
    report.changes.push_back(counted(merged, "duplicate triangle was", "duplicate triangles were") + " dropped");
  if (cancelled)
    report.changes.push_back(counted(cancelled, "triangle was", "triangles were") +
                             " dropped in pairs that lay back to back");
  keepOnly(chain, keep);
}

}  // namespace kerf::internal
