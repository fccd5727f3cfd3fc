#include "preprocess/close/smooth_base.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>

#include "geometry/mesh/float32_cleanup.h"
#include "preprocess/close/hole.h"
#include "preprocess/close/poll.h"
#include "preprocess/close/smooth_curve.h"

namespace kerf::internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// mm, times the scale of a small object.
constexpr double kWidestBridge = 4;
constexpr double kLeastFjord = 2;         // along the rim
constexpr double kFjordToBridge = 3;      // along the rim, by the width
constexpr double kLargestShare = 0.45;    // of the rim
constexpr double kLeastFacing = 0.3;      // cosine between the bridge and the conormals at its ends
constexpr std::size_t kMostSites = 5000;  // rim vertices where bridges may end
constexpr std::size_t kMostPerSite = 64;
constexpr double kPyramid = 0.1;  // height under a tooth of the rim that a bridge covers

constexpr double kSample = 0.1;
constexpr Index kFewestSamples = 24;
constexpr Index kMostSamples = 20'000;
constexpr Index kMostPoints = 8'000;  // of a curve: longer ones get longer steps
constexpr double kLipWave = 2;
constexpr double kConormalWave = 4;
constexpr double kLeastConormal = 0.3;  // length of the mean before it is made a unit vector
constexpr double kLeastEdge = 0.02;
constexpr double kOutlier = 0.3;  // of the lowest curve
constexpr double kBend = 0.1;     // per mm, of the lowest curve
constexpr double kLipStep = 0.25;

struct WallCurve {
  double depth, wave, step;  ///< mm
};
// The caller gives the wave of the lowest one.
constexpr std::array<WallCurve, 3> kCurves{{{0.5, 2, 0.25}, {1, 4, 0.5}, {2, 0, 0.5}}};

/// Outward conormals of the edges of a rim: in the plane of the rim triangle, square to the edge; zero if undefined.
std::vector<std::vector<Vec3d>> conormals(const Mesh& mesh, const std::vector<Loop>& rims) {
  std::unordered_map<std::uint64_t, std::array<std::size_t, 2>> edge_of;
  std::vector<std::vector<Vec3d>> out;
  for (std::size_t r = 0; r < rims.size(); ++r) {
    out.emplace_back(rims[r].size(), Vec3d::Zero());
    for (std::size_t i = 0; i < rims[r].size(); ++i) {
      const std::uint64_t from = rims[r][i], to = rims[r][(i + 1) % rims[r].size()];
      edge_of[to << 32 | from] = {r, i};  // as the triangle runs
    }
  }

  for (const Triangle& f : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = f[k], b = f[(k + 1) % 3];
      const auto it = edge_of.find(a << 32 | b);
      if (it == edge_of.end()) continue;
      const Vec3d& p = mesh.vertices[f[k]];
      const Vec3d along = (mesh.vertices[f[(k + 1) % 3]] - p).normalized();
      const Vec3d inwards = mesh.vertices[f[(k + 2) % 3]] - p;
      const Vec3d out_of = -(inwards - inwards.dot(along) * along);
      const double length = out_of.norm();
      if (length > 0) out[it->second[0]][it->second[1]] = out_of / length;
    }
  return out;
}

/// Length of the rim up to each vertex; the last entry is the whole.
std::vector<double> runningLength(const Mesh& mesh, const Loop& loop) {
  std::vector<double> out{0};
  for (std::size_t i = 0; i < loop.size(); ++i)
    out.push_back(out.back() + (mesh.vertices[loop[(i + 1) % loop.size()]] - mesh.vertices[loop[i]]).norm());
  return out;
}

/// From entry `from` of the rim forwards to entry `to`.
struct Bridge {
  std::size_t from, to;
  double rim_mm, width_mm;
};

/// Length-weighted mean of the conormals of five edges around each vertex.
std::vector<Vec3d> conormalsAtVertices(const std::vector<Vec3d>& of_edges, const std::vector<double>& length) {
  const std::size_t n = of_edges.size();
  std::vector<Vec3d> out(n, Vec3d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 5; ++k) {
      const std::size_t e = (i + n + k - std::min<std::size_t>(3, n)) % n;
      out[i] += (length[e + 1] - length[e]) * of_edges[e];
    }
    if (const double norm = out[i].norm(); norm > 0) out[i] /= norm;
  }
  return out;
}

/// Bridges over the fjords of one rim; none overlap.
Expected<std::vector<Bridge>> findBridges(const Mesh& mesh, const Loop& rim, const std::vector<Vec3d>& edge_conormals,
                                          double scale, Poll& poll) {
  const std::vector<double> length = runningLength(mesh, rim);
  const std::vector<Vec3d> conormal = conormalsAtVertices(edge_conormals, length);
  const double whole = length.back(), widest = kWidestBridge * scale;
  const std::size_t stride = (rim.size() + kMostSites - 1) / kMostSites;
  const auto shorter = [](const Bridge& x, const Bridge& y) {
    return x.rim_mm != y.rim_mm ? x.rim_mm > y.rim_mm : x.from != y.from ? x.from < y.from : x.to < y.to;
  };

  std::vector<Bridge> found;
  for (std::size_t i = 0; i < rim.size(); i += stride) {
    if (poll.stop()) return cancelled();
    std::vector<Bridge> here;
    for (std::size_t j = i + stride; j < rim.size(); j += stride) {
      const Vec3d across = mesh.vertices[rim[j]] - mesh.vertices[rim[i]];
      const double width = across.norm();
      if (!(width <= widest) || !(width > 0)) continue;
      const double forth = length[j] - length[i], way = std::min(forth, whole - forth);
      if (!(way > std::max(kFjordToBridge * width, kLeastFjord * scale)) || way > kLargestShare * whole) continue;
      if (conormal[i].dot(across) < kLeastFacing * width || conormal[j].dot(-across) < kLeastFacing * width) continue;
      here.push_back(forth <= whole - forth ? Bridge{i, j, way, width} : Bridge{j, i, way, width});
    }
    std::sort(here.begin(), here.end(), shorter);
    here.resize(std::min(here.size(), kMostPerSite));
    found.insert(found.end(), here.begin(), here.end());
  }
  std::sort(found.begin(), found.end(), shorter);

  std::vector<char> taken(rim.size(), 0);
  std::vector<Bridge> chosen;
  for (const Bridge& b : found) {
    const std::size_t steps = (b.to + rim.size() - b.from) % rim.size();
    // Two that do not overlap are free of each other at both ends, or one holds the other: the longer comes first.
    if (taken[b.from] || taken[b.to]) continue;
    for (std::size_t k = 0; k <= steps; ++k) taken[(b.from + k) % rim.size()] = 1;
    chosen.push_back(b);
  }
  return chosen;
}

Triangle sorted(Triangle f) {
  std::sort(f.begin(), f.end());
  return f;
}

/// Triangles with all corners on the rims, their corners sorted.
std::set<Triangle> trianglesOnRims(const Mesh& mesh, const std::vector<Loop>& rims) {
  std::vector<char> on_rim(mesh.vertices.size(), 0);
  for (const Loop& rim : rims)
    for (const std::uint32_t v : rim) on_rim[v] = 1;
  std::set<Triangle> out;
  for (const Triangle& f : mesh.triangles)
    if (on_rim[f[0]] && on_rim[f[1]] && on_rim[f[2]]) out.insert(sorted(f));
  return out;
}

Loop pathAlong(const Loop& rim, const Bridge& b) {
  Loop out;
  for (std::size_t i = b.from; i != b.to; i = (i + 1) % rim.size()) out.push_back(rim[i]);
  out.push_back(rim[b.to]);
  return out;
}

/// Fills the loop. A triangle back to back with one of the scan would cancel it, and lose a tip of the rim: it becomes
/// a flat pyramid below.
void fillWithoutFolds(Chain& chain, const std::set<Triangle>& teeth, const Loop& loop, double height_mm) {
  const std::size_t before = chain.mesh.triangles.size();
  fillHole(chain, loop);
  const std::size_t filled = chain.mesh.triangles.size();
  for (std::size_t t = before; t < filled; ++t) {
    const Triangle f = chain.mesh.triangles[t];
    if (!teeth.count(sorted(f))) continue;
    const Vec3d normal = doubleAreaVector(chain.mesh, t).normalized();
    const Vec3d middle = (chain.mesh.corner(t, 0) + chain.mesh.corner(t, 1) + chain.mesh.corner(t, 2)) / 3;
    const std::uint32_t top = chain.addVertex(roundedToFloat(Vec3d(middle + height_mm * normal)));
    chain.mesh.triangles[t] = {f[0], f[1], top};
    chain.addTriangle(f[1], f[2], top);
    chain.addTriangle(f[2], f[0], top);
  }
}

/// The bridge made of the triangles from `first` on, which fill the loop. `spans` gets those above `wide_mm`.
BridgedPlace placeOf(const Mesh& mesh, std::size_t first, const Loop& loop, double wide_mm,
                     std::vector<WideSpan>& spans) {
  std::unordered_map<std::uint32_t, std::size_t> number;
  for (std::size_t k = 0; k < loop.size(); ++k) number[loop[k]] = k;
  const auto isAcross = [&](std::uint32_t a, std::uint32_t b) {
    const auto from = number.find(a), to = number.find(b);
    if (from == number.end() || to == number.end()) return false;
    return from->second + 1 != to->second && to->second + 1 != from->second;
  };

  BridgedPlace out;
  for (std::size_t t = first; t < mesh.triangles.size(); ++t) {
    const double area = 0.5 * doubleAreaVector(mesh, t).norm();
    out.area_mm2 += area;
    out.middle += area / 3 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
    const Triangle& f = mesh.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = f[k], b = f[(k + 1) % 3];
      if (!isAcross(a, b)) continue;
      const double span = (mesh.vertices[a] - mesh.vertices[b]).norm();
      out.span_mm = std::max(out.span_mm, span);
      if (span > wide_mm) spans.push_back({0.5 * (mesh.vertices[a] + mesh.vertices[b]), span});
    }
  }
  if (out.area_mm2 > 0)
    out.middle /= out.area_mm2;
  else
    out.middle = mesh.vertices[loop[0]];
  return out;
}

/// A closed curve in space, the rim's parameter of each point (rising, from 0 to below 1), and its vertices.
struct Ring {
  std::vector<std::uint32_t> vertex;
  std::vector<double> parameter;
};

/// Adds vertices; one place is one vertex.
class Places {
 public:
  explicit Places(Chain& chain) : chain_(chain) {
    vertex_at_.reserve(chain.mesh.vertices.size());
    for (std::uint32_t v = 0; v < chain.mesh.vertices.size(); ++v) vertex_at_.emplace(key(chain.mesh.vertices[v]), v);
  }
  std::uint32_t vertex(const Vec3d& exact) {
    const Vec3d p = roundedToFloat(exact);
    const auto [it, fresh] = vertex_at_.try_emplace(key(p), 0);
    if (fresh) it->second = chain_.addVertex(p);
    return it->second;
  }

 private:
  using Key = std::array<double, 3>;
  struct Hash {
    std::size_t operator()(const Key& k) const {
      std::size_t h = 0;
      for (const double x : k) h = h * 1'000'003 ^ std::hash<double>()(x);
      return h;
    }
  };
  static Key key(const Vec3d& p) { return {p.x(), p.y(), p.z()}; }
  Chain& chain_;
  std::unordered_map<Key, std::uint32_t, Hash> vertex_at_;
};

/// A strip of triangles between two rings, by their parameters.
void stitchRings(Chain& chain, const Ring& upper, const Ring& lower) {
  const auto parameterAt = [](const Ring& r, std::size_t i) { return i < r.parameter.size() ? r.parameter[i] : 1.0; };
  const auto vertexAt = [](const Ring& r, std::size_t i) { return r.vertex[i % r.vertex.size()]; };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != b && b != c && c != a) chain.addTriangle(a, b, c);
  };
  for (std::size_t i = 0, j = 0; i < upper.vertex.size() || j < lower.vertex.size();) {
    const bool upper_goes =
        j == lower.vertex.size() || (i < upper.vertex.size() && parameterAt(upper, i + 1) <= parameterAt(lower, j + 1));
    if (upper_goes) {
      add(vertexAt(upper, i), vertexAt(upper, i + 1), vertexAt(lower, j));
      ++i;
    } else {
      add(vertexAt(upper, i), vertexAt(lower, j + 1), vertexAt(lower, j));
      ++j;
    }
  }
}

/// Points of a closed curve at about equal distances along it. @param parameter  of the given points; follows.
ClosedCurve resampled(const ClosedCurve& curve, const VectorXd& parameter, const VectorXd& edges, double step,
                      VectorXd& new_parameter) {
  const Index n = curve.rows();
  const double whole = edges.sum();
  const double steps = std::min(whole / step, static_cast<double>(kMostPoints));
  const Index count = std::clamp<Index>(static_cast<Index>(std::lround(steps)), 12, n);
  ClosedCurve out(count, curve.cols());
  new_parameter.resize(count);
  Index at = 0;
  double begin = 0;
  for (Index k = 0; k < count; ++k) {
    const double target = whole * static_cast<double>(k) / static_cast<double>(count);
    while (at + 1 < n && begin + edges[at] <= target) {
      begin += edges[at];
      ++at;
    }
    const double f = edges[at] > 0 ? std::clamp((target - begin) / edges[at], 0.0, 1.0) : 0.0;
    const double next = at + 1 < n ? parameter[at + 1] : 1.0;
    out.row(k) = (1 - f) * curve.row(at) + f * curve.row((at + 1) % n);
    new_parameter[k] = (1 - f) * parameter[at] + f * next;
  }
  return out;
}

/// The largest of the values within `reach` along the curve, to either side.
VectorXd largestWithin(const VectorXd& values, const VectorXd& edges, double reach) {
  constexpr Index kFarthest = 500;  // samples
  const Index n = values.size(), most = std::min(n / 2, kFarthest);
  VectorXd out = values;
  for (Index i = 0; i < n; ++i) {
    double forth = 0, back = 0;
    for (Index k = 1; k <= most && (forth += edges[(i + k - 1) % n]) <= reach; ++k)
      out[i] = std::max(out[i], values[(i + k) % n]);
    for (Index k = 1; k <= most && (back += edges[(i + n - k) % n]) <= reach; ++k)
      out[i] = std::max(out[i], values[(i + n - k) % n]);
  }
  return out;
}

/// The rim at equal distances, with the conormal of the edge that each sample lies on.
struct Samples {
  ClosedCurve points, conormals;
  VectorXd parameter;
};

Samples sampleRim(const Mesh& mesh, const Loop& rim, const std::vector<double>& length,
                  const std::vector<Vec3d>& conormals, double step) {
  const double whole = length.back();
  const Index n = std::clamp<Index>(static_cast<Index>(std::min(whole / step, 1e9)), kFewestSamples, kMostSamples);
  Samples s{ClosedCurve(n, 3), ClosedCurve(n, 3), VectorXd(n)};
  std::size_t edge = 0;
  for (Index k = 0; k < n; ++k) {
    s.parameter[k] = static_cast<double>(k) / static_cast<double>(n);
    const double target = whole * s.parameter[k];
    while (edge + 1 < rim.size() && length[edge + 1] <= target) ++edge;
    const double span = length[edge + 1] - length[edge];
    const double f = span > 0 ? std::clamp((target - length[edge]) / span, 0.0, 1.0) : 0.0;
    const Vec3d &p = mesh.vertices[rim[edge]], &q = mesh.vertices[rim[(edge + 1) % rim.size()]];
    s.points.row(k) = ((1 - f) * p + f * q).transpose();
    s.conormals.row(k) = conormals[edge].transpose();
  }
  return s;
}

/// Builds the walls below one rim.
class WallBuilder {
 public:
  WallBuilder(Chain& chain, Places& places, const BaseFrame& frame, const SmoothWalls& walls, double lowest)
      : chain_(chain), places_(places), frame_(frame), walls_(walls), scale_(walls.scale) {
    constexpr double kLeastStep = 0.1;
    step_down_ = std::min(kLeastStep * scale_, (frame.level - lowest) / 6);
  }

  Loop build(const Loop& rim, const std::vector<double>& length, const std::vector<Vec3d>& conormals) {
    constexpr double kLeastWaves = 6;  // around a rim: an outline of fewer would be a circle
    wave_ = std::min(walls_.smoothing_mm, length.back() / kLeastWaves);
    Ring upper{rim, {}};
    for (std::size_t i = 0; i < rim.size(); ++i) upper.parameter.push_back(length[i] / length.back());
    const Samples samples = sampleRim(chain_.mesh, rim, length, conormals, kSample * scale_);
    top_ = samples.points;
    parameter_ = samples.parameter;
    if (walls_.lip_mm > 0) upper = addLip(samples, upper);

    // The rim in the plane of the base, and its height.
    plan_ = ClosedCurve(top_.rows(), 2);
    above_ = VectorXd(top_.rows());
    for (Index i = 0; i < top_.rows(); ++i) {
      const Vec3d p = top_.row(i).transpose();
      plan_(i, 0) = p.dot(frame_.u);
      plan_(i, 1) = p.dot(frame_.v);
      above_[i] = p.dot(frame_.w);
    }
    const VectorXd top_heights = above_;

    for (std::size_t j = 0; j < kCurves.size(); ++j) {
      const Ring lower = addCurve(kCurves[j], kCurves.size() - j, top_heights);
      stitchRings(chain_, upper, lower);
      upper = lower;
    }
    upper.vertex.erase(std::unique(upper.vertex.begin(), upper.vertex.end()), upper.vertex.end());
    return upper.vertex;
  }

 private:
  Ring addLip(const Samples& samples, const Ring& rim) {
    const VectorXd edges = edgeLengths(samples.points, kLeastEdge * scale_);
    const ClosedCurve outwards = lowPass(samples.conormals, edges, kConormalWave * scale_);
    ClosedCurve lip = lowPass(samples.points, edges, kLipWave * scale_);
    for (Index i = 0; i < lip.rows(); ++i) {
      Vec3d p = lip.row(i).transpose();
      const Vec3d out = outwards.row(i).transpose();
      p += walls_.lip_mm * out / std::max(kLeastConormal, out.norm());
      const double depth = p.dot(frame_.w), most = frame_.level - 5 * step_down_;
      if (depth > most) p += (most - depth) * frame_.w;
      lip.row(i) = p.transpose();
    }
    top_ = resampled(lip, samples.parameter, edgeLengths(lip, 0), kLipStep * scale_, parameter_);
    const Ring ring = addRing(top_, parameter_);
    stitchRings(chain_, rim, ring);
    return ring;
  }

  /// @param from_below  3, 2, 1: the lowest curve keeps clear of the level by one step, the others by more.
  Ring addCurve(const WallCurve& curve, std::size_t from_below, const VectorXd& top_heights) {
    const double wave = curve.wave > 0 ? std::min(curve.wave * scale_, wave_) : wave_;
    const ClosedCurve t = robustSpline(plan_, {.wave_mm = wave,
                                               .outlier_mm = kOutlier * scale_ * wave / wave_,
                                               .bend_per_mm = kBend / scale_ * wave_ / wave,
                                               .least_edge_mm = kLeastEdge * scale_});
    const VectorXd edges = edgeLengths(t, 0);
    const VectorXd deepest = largestWithin(top_heights, edges, std::min(3 * scale_, 0.3 * wave));
    const ClosedCurve heights =
        firstOrderLowPass((deepest.array() + curve.depth * scale_).matrix(), edgeLengths(t, kLeastEdge * scale_), wave);

    const double most = frame_.level - static_cast<double>(from_below) * step_down_;
    ClosedCurve in_space(t.rows(), 3);
    for (Index i = 0; i < t.rows(); ++i) {
      const double depth = std::max(std::min(heights(i, 0), most), std::min(above_[i] + 0.5 * step_down_, most));
      above_[i] = depth;
      in_space.row(i) = (t(i, 0) * frame_.u + t(i, 1) * frame_.v + depth * frame_.w).transpose();
    }
    VectorXd parameter;
    const ClosedCurve points = resampled(in_space, parameter_, edges, curve.step * scale_, parameter);
    return addRing(points, parameter);
  }

  Ring addRing(const ClosedCurve& points, const VectorXd& parameter) {
    Ring ring;
    for (Index i = 0; i < points.rows(); ++i) {
      ring.vertex.push_back(places_.vertex(points.row(i).transpose()));
      ring.parameter.push_back(parameter[i]);
    }
    return ring;
  }

  Chain& chain_;
  Places& places_;
  const BaseFrame& frame_;
  const SmoothWalls& walls_;
  double scale_;
  double wave_ = 0;     // mm: of the lowest curve
  double step_down_;    // mm: least distance between the curves where the rim comes near the level
  ClosedCurve top_;     // guide of the curves: the lip, or the rim
  VectorXd parameter_;  // of its points
  ClosedCurve plan_;    // the same along u and v
  VectorXd above_;      // mm along w: the curve above, per point
};

}  // namespace

Expected<std::vector<Loop>> bridgeFjords(Chain& chain, const std::vector<Loop>& rims, double scale, BridgedGaps& gaps,
                                         const Progress& progress) {
  Poll poll(progress, 0.12, "bridging gaps in the rim");
  const std::vector<std::vector<Vec3d>> outwards = conormals(chain.mesh, rims);
  const std::set<Triangle> teeth = trianglesOnRims(chain.mesh, rims);
  std::vector<Loop> left;
  for (std::size_t r = 0; r < rims.size(); ++r) {
    const Loop& rim = rims[r];
    KERF_TRY(bridges, findBridges(chain.mesh, rim, outwards[r], scale, poll));

    constexpr std::size_t kFewest = 6;
    std::size_t edges_left = rim.size();
    std::vector<char> inside(rim.size(), 0);
    for (const Bridge& b : bridges) {
      if (!report(progress, 0.13, "bridging gaps in the rim")) return cancelled();
      const std::size_t steps = (b.to + rim.size() - b.from) % rim.size();
      if (edges_left - steps + 1 < kFewest) continue;
      const Loop path = pathAlong(rim, b);
      const std::size_t filled = chain.mesh.triangles.size();
      fillWithoutFolds(chain, teeth, path, kPyramid * scale);
      edges_left -= steps - 1;
      for (std::size_t k = 1; k < steps; ++k) inside[(b.from + k) % rim.size()] = 1;
      gaps.places.push_back(placeOf(chain.mesh, filled, path, kWidestBridge * scale, gaps.spans));
      gaps.rim_mm += b.rim_mm;
      gaps.widest_mm = std::max(gaps.widest_mm, b.width_mm);
    }

    Loop rest;
    for (std::size_t i = 0; i < rim.size(); ++i)
      if (!inside[i]) rest.push_back(rim[i]);
    left.push_back(std::move(rest));
  }
  return left;
}

Expected<std::vector<Loop>> addSmoothWalls(Chain& chain, const std::vector<Loop>& rims, const BaseFrame& frame,
                                           const SmoothWalls& walls, const Progress& progress) {
  double lowest = -std::numeric_limits<double>::infinity();
  for (const Loop& rim : rims)
    for (const std::uint32_t v : rim) lowest = std::max(lowest, chain.mesh.vertices[v].dot(frame.w));

  const std::vector<std::vector<Vec3d>> outwards = conormals(chain.mesh, rims);
  Places places(chain);
  std::vector<Loop> out;
  for (std::size_t r = 0; r < rims.size(); ++r) {
    if (!report(progress, 0.14, "building the base")) return cancelled();
    const std::vector<double> length = runningLength(chain.mesh, rims[r]);
    if (!(length.back() > 0) || !std::isfinite(length.back()))
      return fail(
          {.code = Error::Code::kGeometry, .found = "a rim without length", .expected = "a rim around some area"});
    WallBuilder builder(chain, places, frame, walls, lowest);
    out.push_back(builder.build(rims[r], length, outwards[r]));
  }
  return out;
}

}  // namespace kerf::internal
