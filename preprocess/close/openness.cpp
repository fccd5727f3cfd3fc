#include "preprocess/close/openness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "preprocess/close/close.h"
#include "preprocess/close/orient.h"

namespace kerf::internal {
namespace {

double lengthOf(const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  return (mesh.vertices[a] - mesh.vertices[b]).norm();
}

double areaOf(const Mesh& mesh, std::size_t t) { return 0.5 * doubleAreaVector(mesh, t).norm(); }

// All but one of the triangles that have the same corners, whichever way round. Returns how many.
std::size_t keepOneOfEach(const std::vector<Triangle>& triangles, std::vector<char>& keep) {
  std::vector<std::pair<Triangle, std::uint32_t>> keys(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    keys[t] = {triangles[t], t};
    sortCorners(keys[t].first);
  }
  std::sort(keys.begin(), keys.end());

  std::size_t dropped = 0;
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first) {
      keep[keys[i].second] = 0;
      ++dropped;
    }
  return dropped;
}

// Length of the edges not met by their opposites as often, each times its excess, mm.
double boundaryLength(const Mesh& mesh, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const EdgeCount& e : countEdges(triangles)) sum += std::abs(e.forth - e.back) * lengthOf(mesh, e.a, e.b);
  return sum;
}

// Triangles connected across edges that two of them share.
struct Sheets {
  Pieces pieces;
  std::vector<double> area;    // mm2
  std::vector<char> has_open;  // it has an edge without another user
  struct BorderEdge {
    std::size_t edge;
    int sign;  // how often the sheet runs forth along it, less how often back
  };
  std::vector<std::vector<BorderEdge>> border;
};

// An edge that more than two triangles use, or one: how long it is, and how unbalanced.
struct Seam {
  double length;
  int net;
};

Sheets sheetsOf(const Mesh& mesh, std::vector<Seam>& seams) {
  const std::vector<EdgeUse> all = edgeUses(mesh.triangles);
  std::vector<EdgeUse> joining;
  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    if (uses.size() == 2) joining.insert(joining.end(), uses.begin(), uses.end());
  });

  Sheets out;
  out.pieces = piecesOf(mesh.triangles.size(), joining);
  out.area.assign(out.pieces.count, 0);
  out.has_open.assign(out.pieces.count, 0);
  out.border.resize(out.pieces.count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) out.area[out.pieces.label[t]] += areaOf(mesh, t);

  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    if (uses.size() == 2) return;
    std::map<std::uint32_t, int> signs;
    int net = 0;
    for (const EdgeUse& use : uses) {
      const int sign = use.forth ? 1 : -1;
      signs[out.pieces.label[use.triangle]] += sign;
      net += sign;
      if (uses.size() == 1) out.has_open[out.pieces.label[use.triangle]] = 1;
    }
    seams.push_back({lengthOf(mesh, uses[0].a, uses[0].b), net});
    for (const auto& [sheet, sign] : signs) out.border[sheet].push_back({seams.size() - 1, sign});
  });
  return out;
}

// How much shorter the boundary gets without the sheet, and how long the sheet's border is; mm.
std::pair<double, double> gainWithout(const std::vector<Sheets::BorderEdge>& border, const std::vector<Seam>& seams) {
  double gain = 0, length = 0;
  for (const auto& [edge, sign] : border) {
    const Seam& seam = seams[edge];
    gain += (std::abs(seam.net) - std::abs(seam.net - sign)) * seam.length;
    length += seam.length;
  }
  return {gain, length};
}

// One round over all sheets, the smallest first. Returns how many were dropped.
std::size_t dropRound(const Mesh& mesh, std::vector<char>& keep) {
  std::vector<Seam> seams;
  const Sheets sheets = sheetsOf(mesh, seams);
  std::vector<std::uint32_t> order(sheets.pieces.count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return sheets.area[a] < sheets.area[b]; });

  std::vector<char> goes(sheets.pieces.count, 0);
  std::size_t dropped = 0;
  for (const std::uint32_t s : order) {
    if (sheets.has_open[s] || sheets.border[s].empty()) continue;
    constexpr double kLeastGain = 0.5;  // of its border: a sheet that belongs to the surface gains nothing, or less
    const auto [gain, length] = gainWithout(sheets.border[s], seams);
    if (!(gain > kLeastGain * length)) continue;
    goes[s] = 1;
    ++dropped;
    for (const auto& [edge, sign] : sheets.border[s]) seams[edge].net -= sign;
  }
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = !goes[sheets.pieces.label[t]];
  return dropped;
}

}  // namespace

double openLength(const Mesh& mesh, const std::vector<Triangle>& triangles) {
  double length = 0;
  forEachEdge(edgeUses(triangles), [&](std::span<const EdgeUse> uses) {
    if (uses.size() == 1) length += lengthOf(mesh, uses[0].a, uses[0].b);
  });
  return length;
}

void dropSheets(Chain& chain, CloseReport& report) {
  std::vector<char> keep(chain.mesh.triangles.size(), 1);
  const double before = boundaryLength(chain.mesh, chain.mesh.triangles);
  if (const std::size_t repeated = keepOneOfEach(chain.mesh.triangles, keep)) {
    Chain fewer = chain;
    keepOnly(fewer, keep);
    if (boundaryLength(fewer.mesh, fewer.mesh.triangles) < before) {
      chain = std::move(fewer);
      report.changes.push_back(counted(repeated, "repeated triangle was", "repeated triangles were") + " dropped");
    }
  }

  std::size_t sheets = 0, triangles = chain.mesh.triangles.size();
  double area = 0;
  constexpr int kMostRounds = 8;  // a sheet on a sheet goes in the next round
  for (int round = 0; round < kMostRounds; ++round) {
    keep.assign(chain.mesh.triangles.size(), 1);
    const std::size_t dropped = dropRound(chain.mesh, keep);
    if (dropped == 0) break;
    sheets += dropped;
    for (std::size_t t = 0; t < keep.size(); ++t)
      if (!keep[t]) area += areaOf(chain.mesh, t);
    keepOnly(chain, keep);
  }
  triangles -= chain.mesh.triangles.size();
  if (sheets)
    report.changes.push_back(fmt::format("{} without thickness {} dropped ({}, {:.1f} mm2): {} nothing",
                                         counted(sheets, "sheet", "sheets"), sheets == 1 ? "was" : "were",
                                         counted(triangles, "triangle", "triangles"), area,
                                         sheets == 1 ? "it encloses" : "they enclose"));
}

}  // namespace kerf::internal
