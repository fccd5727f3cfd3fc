#include "preprocess/close/close.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>

#include "geometry/mesh/crossing_pairs.h"
#include "geometry/mesh/float32_cleanup.h"
#include "geometry/mesh/solids.h"
#include "preprocess/close/arrangement.h"
#include "preprocess/close/boundary.h"
#include "preprocess/close/chain.h"
#include "preprocess/close/guard.h"
#include "preprocess/close/losses.h"
#include "preprocess/close/made_crumbs.h"
#include "preprocess/close/manifold.h"
#include "preprocess/close/orient.h"
#include "preprocess/close/pinholes.h"
#include "preprocess/close/poll.h"
#include "preprocess/close/wrap.h"

namespace kerf {
namespace {

using internal::Chain;
using internal::counted;
using internal::handlesOf;
using internal::lostPlaces;

constexpr std::size_t kMostCrossings = 500'000;  ///< a mesh with more is no surface, and would take minutes
constexpr double kSeparation = 4e-4;  ///< mm: how far touching parts are moved apart; 100 float32 steps at 60 mm

Error makeError(Error::Code code, std::string found, std::string expected = {}, std::string hint = {}) {
  Error e;
  e.code = code;
  e.found = std::move(found);
  e.expected = std::move(expected);
  e.hint = std::move(hint);
  return e;
}

/// The fixed lengths suit dental objects, 3 mm across and more. On a smaller one (most often a wrong unit) they shrink
/// with it, since a base or a seam larger than the object would bury it.
double lengthScale(const Mesh& mesh) {
  constexpr double kSmallestDental = 3;
  const double scale = bounds(mesh).size().norm() / kSmallestDental;
  return scale > 0 && scale < 1 ? scale : 1;
}

/// Drops unused vertices, keeping the order; `label` follows.
void compact(Mesh& mesh, std::vector<char>& label) {
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f) used[v] = 1;
  std::vector<char> kept;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) kept.push_back(label[v]);
  mesh = subset(mesh, std::vector<char>(mesh.triangles.size(), 1));
  label = std::move(kept);
}

struct Result {
  Mesh mesh;
  std::vector<std::uint32_t> source;
};

/// Colour of a new point in a chain triangle, from the triangle's corners.
Rgba8 blend(const Mesh& mesh, std::uint32_t t, const Vec3d& p) {
  const Vec3d n = doubleAreaVector(mesh, t);
  std::array<double, 4> sum{0.5, 0.5, 0.5, 0.5};
  for (int k = 0; k < 3; ++k) {
    const Vec3d a = mesh.corner(t, (k + 1) % 3), b = mesh.corner(t, (k + 2) % 3);
    const double w = std::clamp((a - p).cross(b - p).dot(n) / n.squaredNorm(), 0.0, 1.0);
    for (std::size_t c = 0; c < 4; ++c)
      sum[c] += w * mesh.vertex_colors[mesh.triangles[t][static_cast<std::size_t>(k)]][c];
  }
  Rgba8 out{};
  for (std::size_t c = 0; c < 4; ++c) out[c] = static_cast<std::uint8_t>(std::clamp(sum[c], 0.0, 255.0));
  return out;
}

/// The kept triangles of the arrangement as a mesh, with the normal and source of each.
Result assemble(const Chain& chain, const internal::Arrangement& arrangement, const std::vector<char>& keep,
                std::vector<Vec3d>& normals) {
  Result r;
  r.mesh.vertices = arrangement.points;
  if (chain.mesh.hasVertexColors()) {
    r.mesh.vertex_colors = chain.mesh.vertex_colors;
    r.mesh.vertex_colors.resize(arrangement.points.size(), internal::kNeutral);
  }
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (!keep[t]) continue;
    const std::uint32_t parent = arrangement.parent[t];
    r.mesh.triangles.push_back(arrangement.triangles[t]);
    r.source.push_back(chain.source[parent]);
    normals.push_back(doubleAreaVector(chain.mesh, parent));
    if (chain.mesh.hasFaceColors()) r.mesh.face_colors.push_back(chain.mesh.face_colors[parent]);
    if (chain.mesh.hasVertexColors() && chain.source[parent] != kAdded)  // where added triangles meet: neutral
      for (const std::uint32_t v : arrangement.triangles[t])
        if (v >= chain.mesh.vertices.size()) r.mesh.vertex_colors[v] = blend(chain.mesh, parent, arrangement.points[v]);
  }
  return r;
}

bool isWhole(const Mesh& imported, const Result& r, std::size_t t) {
  using Corners = std::array<Vec3d, 3>;
  const auto corners = [](const Mesh& mesh, std::size_t triangle) {
    Corners c{mesh.corner(triangle, 0), mesh.corner(triangle, 1), mesh.corner(triangle, 2)};
    for (Vec3d& p : c) p = roundedToFloat(p);
    std::sort(c.begin(), c.end(), [](const Vec3d& p, const Vec3d& q) {
      return p.x() != q.x() ? p.x() < q.x() : p.y() != q.y() ? p.y() < q.y() : p.z() < q.z();
    });
    return c;
  };
  return r.source[t] != kAdded && corners(r.mesh, t) == corners(imported, r.source[t]);
}

/// Per triangle: true for a whole triangle of the source.
std::vector<char> wholeOnes(const Mesh& imported, const Result& r) {
  std::vector<char> out;
  for (std::size_t t = 0; t < r.mesh.triangles.size(); ++t) out.push_back(isWhole(imported, r, t));
  return out;
}

/// The solid around a part of it.
struct Surroundings {
  std::vector<char> has_vertex;  ///< of a triangle outside of the part
  double volume_mm3 = 0;         ///< of the whole solid
  bool meets(const Triangle& f) const {
    return std::any_of(f.begin(), f.end(), [&](std::uint32_t v) { return v < has_vertex.size() && has_vertex[v]; });
  }
};

/// Drops splinters and pockets left by cutting: small pieces with a triangle that is not whole in the source.
/// @param is_whole  wholeOnes(), before the separation of touching parts, which cuts nothing; triangles it halves come
/// last.
/// @param more      the solid around `r` if `r` is a part of one.
void dropDebris(Result& r, const std::vector<char>& is_whole, const CloseOptions& options, CloseReport& report,
                const Surroundings* more = nullptr) {
  const Pieces pieces = edgeConnectedPieces(r.mesh);
  if (pieces.count < 2) return;
  std::vector<double> volume(pieces.count, 0);
  std::vector<char> made(pieces.count, 0);
  const Vec3d c = bounds(r.mesh).center();
  double total = 0;
  for (std::size_t t = 0; t < r.mesh.triangles.size(); ++t) {
    const double v = (r.mesh.corner(t, 0) - c).dot((r.mesh.corner(t, 1) - c).cross(r.mesh.corner(t, 2) - c)) / 6;
    volume[pieces.label[t]] += v;
    total += v;
    if (t < is_whole.size() && !is_whole[t]) made[pieces.label[t]] = 1;
  }
  if (more) {
    total = more->volume_mm3;
    for (std::size_t t = 0; t < r.mesh.triangles.size(); ++t)
      if (more->meets(r.mesh.triangles[t])) made[pieces.label[t]] = 0;
  }

  std::size_t count = 0;
  double dropped = 0;
  std::vector<char> debris(pieces.count, 0);
  for (std::uint32_t l = 0; l < pieces.count; ++l)
    if (made[l] && std::abs(volume[l]) < options.debris_fraction * total) {
      debris[l] = 1;
      ++count;
      dropped += std::abs(volume[l]);
    }
  if (count == 0) return;

  std::size_t kept = 0;
  for (std::size_t t = 0; t < r.mesh.triangles.size(); ++t) {
    if (debris[pieces.label[t]]) continue;
    r.mesh.triangles[kept] = r.mesh.triangles[t];
    r.source[kept] = r.source[t];
    if (r.mesh.hasFaceColors()) r.mesh.face_colors[kept] = r.mesh.face_colors[t];
    ++kept;
  }
  r.mesh.triangles.resize(kept);
  r.source.resize(kept);
  if (r.mesh.hasFaceColors()) r.mesh.face_colors.resize(kept);

  report.debris_dropped = count;
  report.changes.push_back(fmt::format("{} beside or inside the solid dropped ({:.3f} mm3 in all)",
                                       counted(count, "splinter or pocket", "splinters and pockets"), dropped));
}

/// The triangles of `r` that have keep != 0, and the vertices they use.
void keepTriangles(Result& r, const std::vector<char>& keep) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < keep.size(); ++t)
    if (keep[t]) r.source[kept++] = r.source[t];
  r.source.resize(kept);
  r.mesh = subset(r.mesh, keep);
}

/// Drops closed pieces smaller than the limit, with their cavities; never the largest.
void dropSpecks(Result& r, double limit_mm3, CloseReport& report) {
  const Solids solids = solidsOf(r.mesh);
  std::vector<double> volume(solids.count, 0);
  const Vec3d c = bounds(r.mesh).center();
  for (std::size_t t = 0; t < r.mesh.triangles.size(); ++t)
    volume[solids.label[t]] +=
        (r.mesh.corner(t, 0) - c).dot((r.mesh.corner(t, 1) - c).cross(r.mesh.corner(t, 2) - c)) / 6;

  const auto largest = std::max_element(volume.begin(), volume.end()) - volume.begin();
  std::vector<char> goes(solids.count, 0);
  for (std::size_t n = 0; n < volume.size(); ++n) {
    goes[n] = volume[n] < limit_mm3 && static_cast<std::ptrdiff_t>(n) != largest;
    report.specks_dropped += goes[n] != 0;
    if (goes[n]) report.specks_dropped_mm3 += volume[n];
  }
  if (report.specks_dropped == 0) return;

  std::vector<char> keep(solids.label.size());
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = !goes[solids.label[t]];
  keepTriangles(r, keep);
  report.changes.push_back(fmt::format("{} smaller than {} mm3 {} dropped, as asked ({:.3g} mm3 in all)",
                                       counted(report.specks_dropped, "piece", "pieces"), limit_mm3,
                                       report.specks_dropped == 1 ? "was" : "were", report.specks_dropped_mm3));
}

/// Drops crumbs below a thousandth of a voxel that closing made. Cutting is not all that makes them: parts that touched
/// were moved apart, and rounding collapses edges.
void dropMadeCrumbs(const Mesh& imported, const CloseOptions& options, Result& r, CloseReport& report) {
  const double tenth_of_voxel = 10 * options.cleanup_length_mm;
  const internal::MadeCrumbs crumbs = internal::findMadeCrumbs(imported, r.mesh, r.source, std::pow(tenth_of_voxel, 3));
  if (crumbs.count == 0) return;
  keepTriangles(r, crumbs.keep);
  report.debris_dropped += crumbs.count;
  report.changes.push_back(crumbs.count == 1
                               ? fmt::format("1 crumb of {:.2g} mm3 that closing made was dropped", crumbs.volume_mm3)
                               : fmt::format("{} crumbs that closing made were dropped ({:.2g} mm3 in all)",
                                             crumbs.count, crumbs.volume_mm3));
}

/// Makes the surface a 2-manifold by separating parts that only touch. `fixed` follows the vertices.
void separateParts(const Mesh& imported, const Chain& chain, std::vector<Vec3d>& normals, Result& r,
                   std::vector<char>& fixed, CloseReport& report) {
  const double separation = kSeparation * lengthScale(imported);
  const internal::SplitReport split = internal::splitNonManifold(r.mesh, normals, r.source, separation);
  fixed.resize(r.mesh.vertices.size(), 0);
  if (split.places == 0) return;
  for (const std::uint32_t v : split.copy_of) report.vertices_moved += v < chain.source_vertices;
  report.changes.push_back(fmt::format("parts that touched in {} were moved apart by {:.1g} mm",
                                       counted(split.places, "vertex", "vertices"), separation));
  report.largest_move_mm = std::max(report.largest_move_mm, separation);
}

/// Lets the fixed vertices around crossings move; returns where they are.
std::vector<Vec3d> freeAroundCrossings(const Mesh& mesh, const std::vector<std::array<std::uint32_t, 2>>& pairs,
                                       std::vector<char>& fixed) {
  std::vector<char> hot(mesh.vertices.size(), 0);
  for (const auto& [i, j] : pairs)
    for (const std::uint32_t t : {i, j})
      for (const std::uint32_t v : mesh.triangles[t]) hot[v] = 1;
  std::vector<Vec3d> freed;
  for (std::size_t v = 0; v < hot.size(); ++v)
    if (hot[v] && fixed[v]) {
      fixed[v] = 0;
      freed.push_back(mesh.vertices[v]);
    }
  return freed;
}

/// How many of these places have no vertex any more.
std::size_t countMoved(const std::vector<Vec3d>& places, const Mesh& mesh) {
  const auto less = [](const Vec3d& p, const Vec3d& q) {
    return p.x() != q.x() ? p.x() < q.x() : p.y() != q.y() ? p.y() < q.y() : p.z() < q.z();
  };
  std::vector<Vec3d> now = mesh.vertices;
  std::sort(now.begin(), now.end(), less);
  std::size_t moved = 0;
  for (const Vec3d& p : places) moved += !std::binary_search(now.begin(), now.end(), p, less);
  return moved;
}

/// Rounds all but the fixed vertices to float32; where that is not enough, a few source vertices as well.
Expected<void> roundNewVertices(Result& r, std::vector<char>& fixed, const CloseOptions& options, CloseReport& report,
                                const Progress& progress) {
  const auto clean = [&] {
    return cleanUpForFloat32(r.mesh, fixed, &r.source, options.cleanup_length_mm, FixedPart::kFreeOfCrossings);
  };
  KERF_TRY(last, clean());
  std::vector<Vec3d> freed;
  for (int round = 0; round < 3 && last.crossings_left; ++round) {
    if (!kerf::report(progress, 0.85 + 0.05 * round, "rounding again")) return cancelled();
    // Only fixed vertices remain: frees the few around the remaining crossings.
    const std::vector<Vec3d> more = freeAroundCrossings(r.mesh, last.pairs_left, fixed);
    freed.insert(freed.end(), more.begin(), more.end());
    KERF_TRY(again, clean());
    last = std::move(again);
  }

  if (!freed.empty()) {
    const std::size_t moved = countMoved(freed, r.mesh);
    report.vertices_moved += moved;
    report.largest_move_mm = std::max(report.largest_move_mm, last.largest_move_mm);
    report.changes.push_back(
        fmt::format("{} moved or merged (by {:.2g} mm at most) because single precision could not "
                    "tell the surfaces apart",
                    counted(moved, "source vertex was", "source vertices were"), last.largest_move_mm));
  }

  if (last.crossings_left)
    return fail(
        makeError(Error::Code::kGeometry,
                  counted(last.crossings_left, "pair of triangles still crosses", "pairs of triangles still cross") +
                      " after rounding to single precision",
                  "none", "--close wrap"));
  return {};
}

/// Arrangement, winding, separation, rounding: steps 4 to 6 of preprocess/README.md. Entered in the report.
Expected<Result> resolve(const Mesh& imported, const Chain& chain,
                         const std::vector<std::array<std::uint32_t, 2>>& pairs, const CloseOptions& options,
                         CloseReport& report, const Progress& progress) {
  if (!kerf::report(progress, 0.4, "resolving crossings")) return cancelled();
  KERF_TRY(arrangement, internal::arrangeChain(chain.mesh, pairs, progress));
  KERF_TRY(kept, internal::keepWindingBoundary(chain.mesh, arrangement, progress));
  if (!kerf::report(progress, 0.8, "rounding")) return cancelled();
  if (kept.patches_kept == 0)
    return fail(makeError(Error::Code::kGeometry, "a surface that encloses nothing", "a mesh with an inside",
                          "check the orientation, or --close wrap"));

  std::vector<Vec3d> normals;
  Result r = assemble(chain, arrangement, kept.keep, normals);
  if (!pairs.empty())
    report.changes.push_back(counted(pairs.size(), "pair of triangles that crossed or touched was",
                                     "pairs of triangles that crossed or touched were") +
                             " resolved exactly");
  report.crossings_resolved = pairs.size();
  if (const std::size_t gone = kept.patches - kept.patches_kept)
    report.changes.push_back(fmt::format("{} of {} dropped: inside the solid, or outside of any",
                                         counted(gone, "patch", "patches"), kept.patches));

  std::vector<char> fixed(r.mesh.vertices.size(), 0);
  std::fill(fixed.begin(), fixed.begin() + static_cast<std::ptrdiff_t>(chain.mesh.vertices.size()), 1);
  const std::vector<char> is_whole = wholeOnes(imported, r);
  separateParts(imported, chain, normals, r, fixed, report);
  dropDebris(r, is_whole, options, report);
  compact(r.mesh, fixed);
  KERF_CHECK(roundNewVertices(r, fixed, options, report, progress));
  return r;
}

Expected<Result> wrap(const Chain& chain, const CloseOptions& options, CloseReport& report, const Progress& progress) {
  KERF_TRY(mesh, internal::wrapSoup(chain.mesh, options.wrap_alpha_mm, options.wrap_offset_mm, progress));
  Result r{std::move(mesh), {}};
  r.source.assign(r.mesh.triangles.size(), kAdded);
  std::vector<char> fixed(r.mesh.vertices.size(), 0);
  KERF_TRY(cleaned, cleanUpForFloat32(r.mesh, fixed, &r.source, options.cleanup_length_mm));
  if (cleaned.crossings_left)
    return fail(makeError(Error::Code::kGeometry, "a wrap that crosses itself after rounding to single precision", {},
                          "a coarser wrap (--wrap-alpha)"));
  report.exact = false;
  report.wrap_offset_mm = options.wrap_offset_mm;
  report.changes.push_back(
      fmt::format("the surface was shrink-wrapped and is an APPROXIMATION: it lies about {} mm outside the "
                  "scan, hollows narrower than {} mm are bridged, no source vertex is preserved, "
                  "colours are lost",
                  options.wrap_offset_mm, options.wrap_alpha_mm));
  return r;
}

/// Counts kept, split and dropped source triangles.
void countTriangles(const Mesh& imported, const Result& r, CloseReport& report) {
  enum : char { kGone, kPart, kWhole };
  std::vector<char> state(imported.triangles.size(), kGone);
  for (std::size_t t = 0; t < r.source.size(); ++t) {
    if (r.source[t] == kAdded) {
      ++report.triangles_added;
    } else if (isWhole(imported, r, t)) {
      state[r.source[t]] = kWhole;
    } else {
      state[r.source[t]] = std::max(state[r.source[t]], static_cast<char>(kPart));
    }
  }
  for (const char s : state)
    ++(s == kWhole ? report.triangles_kept : s == kPart ? report.triangles_split : report.triangles_dropped);
}

void warn(CloseReport& report, std::string change) {
  report.warnings.push_back(change);
  report.changes.push_back(std::move(change));
}

Expected<void> checkOptions(const CloseOptions& o) {
  const auto bad = [](const char* what, double value, const char* expected) {
    return fail(makeError(Error::Code::kBadValue, fmt::format("{} = {}", what, value), expected));
  };

  if (!(o.base_margin_mm > 0 && o.base_margin_mm < 1000))
    return bad("base_margin_mm", o.base_margin_mm, "above 0, below 1000");
  if (!(o.base_smoothing_mm >= 0 && o.base_smoothing_mm <= 100))
    return bad("base_smoothing_mm", o.base_smoothing_mm, "from 0 to 100");
  if (!(o.base_lip_mm >= 0 && o.base_lip_mm <= 1)) return bad("base_lip_mm", o.base_lip_mm, "from 0 to 1");
  if (!(o.cleanup_length_mm > 0 && o.cleanup_length_mm <= 0.1))
    return bad("cleanup_length_mm", o.cleanup_length_mm, "above 0, at most 0.1");
  if (!(o.trim_rim_mm >= 0 && o.trim_rim_mm <= kWidestTrim))
    return bad("trim_rim_mm", o.trim_rim_mm, fmt::format("from 0 to {}", kWidestTrim).c_str());
  if (!(o.drop_specks_mm3 >= 0)) return bad("drop_specks_mm3", o.drop_specks_mm3, "0 or more");
  if (!(o.crumb_fraction >= 0 && o.crumb_fraction < 1))
    return bad("crumb_fraction", o.crumb_fraction, "from 0 to below 1");
  if (!(o.rim_to_diagonal > 0)) return bad("rim_to_diagonal", o.rim_to_diagonal, "above 0");
  if (!(o.wrap_alpha_mm > 0)) return bad("wrap_alpha_mm", o.wrap_alpha_mm, "above 0");
  if (!(o.wrap_offset_mm > 0)) return bad("wrap_offset_mm", o.wrap_offset_mm, "above 0");
  if (o.base_direction && !(o.base_direction->norm() > 0)) return bad("base_direction", 0, "a direction");
  if (!(o.stitch_mm >= 0 && o.stitch_mm <= kWidestStitch))
    return bad("stitch_mm", o.stitch_mm, fmt::format("from 0 to {}", kWidestStitch).c_str());
  if (o.fill_up_to_mm && !(*o.fill_up_to_mm > 0)) return bad("fill_up_to_mm", *o.fill_up_to_mm, "above 0");
  if (o.base_height_mm && !(*o.base_height_mm > 0 && *o.base_height_mm < 1000))
    return bad("base_height_mm", *o.base_height_mm, "above 0, below 1000");
  if (o.occlusal_plane && !(o.occlusal_plane->normal.norm() > 0 && o.occlusal_plane->normal.allFinite()))
    return bad("the length of the occlusal plane's normal", o.occlusal_plane->normal.norm(), "above 0");
  return {};
}

Box3 boxOfTriangles(const Mesh& mesh) {
  Box3 box;
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f) box.add(mesh.vertices[v]);
  return box;
}

/// Runs before any step: a mesh that is far too large has a wrong unit.
Expected<void> checkObjectSize(const Mesh& mesh) {
  const double across = boxOfTriangles(mesh).size().norm();
  if (across <= kLargestObject) return {};
  Error e = makeError(Error::Code::kBadValue, fmt::format("an object {:.4g} mm across", across),
                      fmt::format("at most {:g} mm: a crown has 10, a skull 300", kLargestObject),
                      "another unit: the object would be closed for nothing");
  e.place = "size";
  return fail(std::move(e));
}

/// The options for this mesh: see lengthScale().
CloseOptions fitted(const CloseOptions& asked, const Mesh& mesh, CloseReport& report) {
  const double scale = lengthScale(mesh);
  CloseOptions o = asked;
  if (scale == 1) return o;
  for (double* length : {&o.stitch_mm, &o.base_margin_mm, &o.base_smoothing_mm, &o.base_lip_mm, &o.cleanup_length_mm,
                         &o.wrap_alpha_mm, &o.wrap_offset_mm})
    *length *= scale;
  warn(report,
       fmt::format("the object is only {:.3g} mm across: base margin ({:.2g} mm now), seams, rounding and wrap were "
                   "scaled down with it. Is the unit right?",
                   bounds(mesh).size().norm(), o.base_margin_mm));
  return o;
}

Error unverified(std::string broken) {
  return makeError(Error::Code::kGeometry, std::move(broken), "a verified solid",
                   "--close wrap, or repair the mesh in a mesh editor");
}

Expected<void> verifyButCrossings(const Mesh& mesh) {
  std::string broken;
  if (!internal::isClosedManifold(mesh)) broken = "a surface that is not a closed 2-manifold";
  for (const Vec3d& p : mesh.vertices)
    if (p != roundedToFloat(p)) broken = "a coordinate that is no float32 number";
  if (broken.empty() && !(signedVolume(mesh) > 0)) broken = "a solid without volume";
  if (broken.empty()) return {};
  return fail(unverified(broken));
}

/// Checks the promise of closeMesh() on the result.
Expected<void> verify(const Mesh& mesh) {
  KERF_CHECK(verifyButCrossings(mesh));
  if (!crossingPairs(mesh).empty()) return fail(unverified("a surface that crosses itself"));
  return {};
}

bool wraps(const CloseOptions& o) {
  return o.only.empty() ? o.mode == CloseMode::kWrap : o.only.count(CloseStep::kWrap) > 0;
}

void addPlug(Chain& chain, const Mesh& plug) {
  std::vector<std::uint32_t> number;
  for (const Vec3d& p : plug.vertices) number.push_back(chain.addVertex(p));
  for (const Triangle& f : plug.triangles) chain.addTriangle(number[f[0]], number[f[1]], number[f[2]]);
}

/// The exact way: a closed chain, its pieces turned outwards, to a verified solid.
/// @param nested  result of turnPieces().
Expected<Result> makeExact(const Mesh& imported, Chain& chain, bool nested, const CloseOptions& options,
                           CloseReport& report, const Progress& progress) {
  const auto pairs = crossingPairs(chain.mesh, kMostCrossings);
  if (pairs.size() >= kMostCrossings)
    return fail(makeError(Error::Code::kGeometry,
                          fmt::format("{} pairs of triangles that cross or touch, or more", kMostCrossings),
                          "a surface", "--close wrap, or repair the mesh in a mesh editor"));
  if (!nested && pairs.empty() && internal::isClosedManifold(chain.mesh)) {
    Result r{std::move(chain.mesh), std::move(chain.source)};
    std::vector<char> unused(r.mesh.vertices.size(), 1);
    compact(r.mesh, unused);
    if (!(signedVolume(r.mesh) > 0))
      return fail(makeError(Error::Code::kGeometry, "a solid without volume", "a verified solid"));
    return r;  // just checked: verify() would repeat it
  }

  if (!options.only.empty() && !options.only.count(CloseStep::kUnite))
    return fail(internal::missingStep(pairs.empty() ? std::string("parts that touch, or lie in each other")
                                                    : counted(pairs.size(), "pair of triangles that crosses or touches",
                                                              "pairs of triangles that cross or touch"),
                                      CloseStep::kUnite, options));
  KERF_TRY(r, resolve(imported, chain, pairs, options, report, progress));
  KERF_CHECK(verify(r.mesh));
  return std::move(r);
}

Expected<Result> makeWrap(const Chain& chain, const CloseOptions& options, CloseReport& report,
                          const Progress& progress) {
  if (!internal::hasBoundary(chain)) report.volume_closed_mm3 = internal::windingVolume(chain.mesh);
  KERF_TRY(wrapped, wrap(chain, options, report, progress));
  KERF_CHECK(verify(wrapped.mesh));
  const double volume = signedVolume(wrapped.mesh);
  if (report.volume_closed_mm3 > 0)
    report.changes.push_back(fmt::format("the wrap has {:.4g} mm3, {:.3g} times the {:.3g} mm3 that were wrapped",
                                         volume, volume / report.volume_closed_mm3, report.volume_closed_mm3));
  return std::move(wrapped);
}

/// Adds the triangles that share a vertex with the set, `rings` times, and then at vertices through which the border
/// of the set runs twice, until there are none.
void growAround(const Mesh& mesh, int rings, std::vector<char>& is_in) {
  std::vector<char> at(mesh.vertices.size(), 0);
  const auto addAround = [&] {
    for (std::size_t t = 0; t < is_in.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) is_in[t] |= at[v];
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (std::size_t t = 0; t < is_in.size(); ++t)
      if (is_in[t])
        for (const std::uint32_t v : mesh.triangles[t]) at[v] = 1;
    addAround();
  }

  for (bool is_simple = false; !is_simple;) {
    std::vector<Triangle> inner;
    for (std::size_t t = 0; t < is_in.size(); ++t)
      if (is_in[t]) inner.push_back(mesh.triangles[t]);
    std::vector<int> open(mesh.vertices.size(), 0);
    internal::forEachEdge(internal::edgeUses(inner), [&](std::span<const internal::EdgeUse> uses) {
      if (uses.size() != 1) return;
      ++open[uses[0].a];
      ++open[uses[0].b];
    });
    is_simple = std::none_of(open.begin(), open.end(), [](int n) { return n > 2; });
    for (std::size_t v = 0; v < at.size(); ++v) at[v] = open[v] > 2;
    if (!is_simple) addAround();
  }
}

/// The whole with the replaced triangles exchanged for `changed`, in the order of a cut of the whole.
/// @param changed  its vertices begin with those of the whole. Its `source` are triangles of the whole, ascending.
/// Exception: triangles of the separation of touching parts, at the end.   @param is_new  per triangle: is of
/// `changed`.
Result replaced(const Chain& whole, const std::vector<char>& is_replaced, const Result& changed,
                std::vector<char>& is_new) {
  Result out;
  out.mesh.vertices = changed.mesh.vertices;
  out.mesh.vertex_colors = changed.mesh.vertex_colors;
  const auto add = [&](const Mesh& from, std::size_t t, std::size_t source) {
    out.mesh.triangles.push_back(from.triangles[t]);
    out.source.push_back(whole.source[source]);
    is_new.push_back(&from == &changed.mesh);
    if (from.hasFaceColors()) out.mesh.face_colors.push_back(from.face_colors[t]);
  };
  std::size_t next = 0;
  for (std::size_t t = 0; t < is_replaced.size(); ++t) {
    if (!is_replaced[t]) add(whole.mesh, t, t);
    for (; next < changed.source.size() && changed.source[next] == t; ++next) add(changed.mesh, next, t);
  }
  for (; next < changed.source.size(); ++next) add(changed.mesh, next, changed.source[next]);
  std::vector<char> unused(out.mesh.vertices.size(), 1);
  compact(out.mesh, unused);
  return out;
}

/// The union of a verified solid with a plug, as by makeExact(), but computed on the triangles around the plug only.
/// None if there is no union, or if vertices of the solid would have to move.
std::optional<Result> withPlug(const Mesh& imported, const Result& solid, const Mesh& plug, double volume_mm3,
                               const CloseOptions& options, CloseReport& report, const Progress& progress) {
  Chain whole{.mesh = solid.mesh,
              .source = solid.source,
              .source_vertices = static_cast<std::uint32_t>(solid.mesh.vertices.size())};
  addPlug(whole, plug);
  std::vector<char> is_near(whole.mesh.triangles.size(), 0);
  std::fill(is_near.begin() + static_cast<std::ptrdiff_t>(solid.mesh.triangles.size()), is_near.end(), 1);
  auto pairs = crossingPairsOf(whole.mesh, is_near);
  if (pairs.empty()) return {};
  for (const auto& [i, j] : pairs) is_near[i] = is_near[j] = 1;
  constexpr int kRings = 3;  // rounded vertices lie in the first ring, their surroundings in the second
  growAround(whole.mesh, kRings, is_near);

  Surroundings more{std::vector<char>(whole.mesh.vertices.size(), 0), volume_mm3};
  Mesh part;
  part.vertices = whole.mesh.vertices;
  std::vector<std::uint32_t> in_whole, in_part(is_near.size());
  for (std::uint32_t t = 0; t < is_near.size(); ++t) {
    const Triangle& f = whole.mesh.triangles[t];
    in_part[t] = static_cast<std::uint32_t>(in_whole.size());
    if (is_near[t]) {
      in_whole.push_back(t);
      part.triangles.push_back(f);
    } else {
      for (const std::uint32_t v : f) more.has_vertex[v] = 1;
    }
  }
  for (auto& [i, j] : pairs) {
    i = in_part[i];
    j = in_part[j];
  }

  auto arrangement = internal::arrangeChain(part, pairs, progress);
  if (!arrangement) return {};
  for (std::uint32_t& t : arrangement->parent) t = in_whole[t];
  for (std::vector<std::uint32_t>& twins : arrangement->twins)
    for (std::uint32_t& t : twins) t = in_whole[t];
  const auto kept = internal::keepWindingBoundary(whole.mesh, *arrangement, progress);
  if (!kept) return {};
  for (std::size_t t = 0; t < kept->keep.size(); ++t)
    if (!kept->keep[t] && more.meets(arrangement->triangles[t])) return {};

  std::vector<Vec3d> normals;
  Result r = assemble(whole, *arrangement, kept->keep, normals);
  const std::vector<char> is_whole = wholeOnes(imported, r);
  std::size_t count = 0;
  for (std::size_t t = 0; t < kept->keep.size(); ++t)
    if (kept->keep[t]) r.source[count++] = arrangement->parent[t];
  std::vector<char> fixed(r.mesh.vertices.size(), 0);
  std::fill(fixed.begin(), fixed.begin() + static_cast<std::ptrdiff_t>(whole.mesh.vertices.size()), 1);
  separateParts(imported, whole, normals, r, fixed, report);
  dropDebris(r, is_whole, options, report, &more);
  if (!roundNewVertices(r, fixed, options, report, progress)) return {};
  const bool is_moved = r.mesh.vertices.size() < whole.mesh.vertices.size() ||
                        !std::equal(whole.mesh.vertices.begin(), whole.mesh.vertices.end(), r.mesh.vertices.begin());
  if (is_moved) return {};
  std::vector<char> is_new;
  Result out = replaced(whole, is_near, r, is_new);
  if (!crossingPairsOf(out.mesh, is_new).empty()) return {};
  return out;
}

/// Plugs the pinholes caused by a base, and cuts the threads. A plug stays if the solid then has one hole less, and
/// loses no more of the scan. Unites each plug with the current solid.
/// @param handles  of the scan.
Expected<void> plugPinholes(const Mesh& imported, const CloseOptions& options, int handles, Result& result,
                            CloseReport& report, const Progress& progress) {
  constexpr double kLongest = 4;  // mm around
  constexpr int kMostTries = 24;
  int now = handlesOf(result.mesh), tries = 0;
  if (now <= handles) return {};
  const int first = now;
  const Mesh solid = result.mesh;  // the loops are numbers of its vertices
  const std::size_t lost = lostPlaces(imported, solid).size();
  double volume = signedVolume(solid);

  const auto helps = [&](const internal::ShortLoop& loop, bool is_left) {
    const Mesh plug = internal::plugOf(solid, loop, is_left);
    if (plug.triangles.empty()) return false;
    CloseReport unused;
    std::optional<Result> r = withPlug(imported, result, plug, volume, options, unused, progress);
    if (!r) return false;
    const int then = handlesOf(r->mesh);
    if (then >= now || lostPlaces(imported, r->mesh).size() > lost || !verifyButCrossings(r->mesh)) return false;
    now = then;
    result = std::move(*r);
    volume = signedVolume(result.mesh);
    report.vertices_moved += unused.vertices_moved;
    report.largest_move_mm = std::max(report.largest_move_mm, unused.largest_move_mm);
    return true;
  };
  // A tunnel of the scan itself is the patient's, and stays.
  std::vector<char> is_beside_added(solid.vertices.size(), 0);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t)
    if (result.source[t] == kAdded)
      for (const std::uint32_t v : solid.triangles[t]) is_beside_added[v] = 1;
  const auto isOfTheBase = [&](const internal::ShortLoop& loop) {
    return std::any_of(loop.vertices.begin(), loop.vertices.end(),
                       [&](std::uint32_t v) { return is_beside_added[v] != 0; });
  };

  for (const internal::ShortLoop& loop : internal::shortLoops(solid, kLongest * lengthScale(imported), progress))
    for (const bool is_left : {true, false}) {
      if (now <= handles || !isOfTheBase(loop) || ++tries > kMostTries) break;
      if (helps(loop, is_left)) break;
    }
  if (now == first) return {};
  KERF_CHECK(verify(result.mesh));

  report.pinholes_mended = static_cast<std::size_t>(first - now);
  report.changes.push_back(counted(report.pinholes_mended, "pinhole", "pinholes") +
                           (first - now == 1 ? " made by the base was repaired" : " made by the base were repaired"));
  return {};
}

/// One attempt from the imported mesh, without a fallback. Leaves `chain` closed, or open after a failure.
Expected<Result> attempt(const Mesh& imported, const CloseOptions& options, Chain& chain, CloseReport& report,
                         const Progress& progress) {
  KERF_TRY(built, internal::buildChain(imported, options, report));
  chain = std::move(built);
  if (chain.mesh.triangles.empty())
    return fail(
        makeError(Error::Code::kEmpty, "a mesh whose triangles all have no area or cancel each other", "a surface"));

  if (!kerf::report(progress, 0.1, "closing")) return cancelled();
  chain.handles = wraps(options) ? 0 : handlesOf(chain.mesh);
  Chain closed = chain;
  KERF_CHECK(internal::closeBoundary(closed, options, report, progress));
  chain = std::move(closed);
  if (wraps(options)) return makeWrap(chain, options, report, progress);

  if (!kerf::report(progress, 0.3, "looking for crossings")) return cancelled();
  const std::size_t flipped = report.triangles_flipped;
  const bool nested = internal::turnPieces(chain, report);
  if (report.triangles_flipped > flipped && !options.only.empty() && !options.only.count(CloseStep::kOrient))
    return fail(internal::missingStep("a piece that is inside out", CloseStep::kOrient, options));
  Chain work = chain;
  CloseReport exact = report;
  Expected<Result> r = makeExact(imported, work, nested, options, exact, progress);
  if (!r) return r;
  report = std::move(exact);
  if (report.rims_extruded > 0 && options.base_smoothing_mm > 0)
    KERF_CHECK(plugPinholes(imported, options, chain.handles, *r, report, progress));
  return r;
}

/// As attempt(); if smooth walls can not be resolved, with another lip, then with straight walls. `chain` is that of
/// the attempt that succeeded, or else of the first.
Expected<Result> attemptBases(const Mesh& imported, const CloseOptions& options, Chain& chain, CloseReport& report,
                              const Progress& progress) {
  const CloseReport before = report;
  Expected<Result> first = attempt(imported, options, chain, report, progress);
  const bool is_smooth = options.base_smoothing_mm > 0 && options.base_style == BaseStyle::kHorseshoe;
  if (first || !is_smooth || report.rims_extruded == 0 || first.error().code != Error::Code::kGeometry) return first;

  struct Other {
    double smoothing_mm, lip_mm;
    std::string name;
  };
  const double wider = options.base_lip_mm * 4 / 3;
  const std::array<Other, 3> others{{{options.base_smoothing_mm, wider, fmt::format("a lip of {:.2g} mm", wider)},
                                     {options.base_smoothing_mm, 0, "no lip"},
                                     {0, 0, "straight walls"}}};
  for (const Other& other : others) {
    CloseOptions changed = options;
    changed.base_smoothing_mm = other.smoothing_mm;
    changed.base_lip_mm = other.lip_mm;
    CloseReport again = before;
    Chain other_chain;
    Expected<Result> r = attempt(imported, changed, other_chain, again, progress);
    if (!r && r.error().code == Error::Code::kCancelled) return r;
    if (!r) continue;
    report = std::move(again);
    chain = std::move(other_chain);
    report.base_fallback = other.name;
    warn(report, fmt::format("the base was built with {}, because the requested walls gave {}", other.name,
                             first.error().found));
    return r;
  }
  return first;
}

constexpr std::array<double, 2> kWiderStitches = {0.05, 0.2};  // mm: widths tried by kAuto before it wraps

/// As attempt(); kAuto then stitches wider, and wraps at last.
/// @param chain  out: the source chain of the solid or of the wrap.
Expected<Result> makeSolid(const Mesh& imported, const CloseOptions& options, Chain& chain, CloseReport& report,
                           const Progress& progress) {
  Expected<Result> first = attemptBases(imported, options, chain, report, progress);
  const bool may_wrap = options.only.empty() && (options.mode == CloseMode::kAuto || options.mode == CloseMode::kWrap);
  if (first || !may_wrap || first.error().code == Error::Code::kCancelled || first.error().code == Error::Code::kEmpty)
    return first;
  if (chain.mesh.triangles.empty()) return first;  // no chain to wrap
  // The report notes a requested base that is left out.
  const bool base_asked =
      options.base_height_mm || options.find_occlusal_plane || options.occlusal_plane || options.base_direction;
  if (base_asked && internal::hasBoundary(chain)) return first;

  const std::string why = first.error().found;
  const bool was_open = report.holes_filled + report.rims_extruded > 0 || internal::hasBoundary(chain);
  for (const double wide : kWiderStitches) {
    const double width = wide * lengthScale(imported);
    if (options.mode != CloseMode::kAuto || !was_open || width <= options.stitch_mm) continue;
    CloseOptions wider = options;
    wider.stitch_mm = width;
    CloseReport again;
    Chain wider_chain;
    Expected<Result> r = attemptBases(imported, wider, wider_chain, again, progress);
    if (!r && r.error().code == Error::Code::kCancelled) return r;
    if (!r) continue;
    report = std::move(again);
    chain = std::move(wider_chain);
    warn(report, fmt::format("seams had to be stitched that wide: within {:.2g} mm {}", options.stitch_mm, why));
    return r;
  }

  report.changes.push_back("the exact repair failed: " + why);
  return makeWrap(chain, options, report, progress);
}

// Closes the rest of a trimmed scan.
Expected<Solid> closeTrimmed(const Mesh& imported_mm, const CloseOptions& options, const Progress& progress) {
  KERF_TRY(trimmed, trimScan(imported_mm, options.trims));
  CloseOptions rest = options;
  rest.trims.clear();
  KERF_TRY(solid, closeMesh(trimmed.mesh, rest, progress));
  for (std::uint32_t& t : solid.source_triangle)
    if (t != kAdded) t = trimmed.source_triangle[t];
  CloseReport& report = solid.report;
  report.vertices_cut_away = trimmed.vertices_removed;
  report.triangles_cut_away = trimmed.triangles_removed;
  report.cut_away_mm2 = trimmed.removed_mm2;
  report.changes.insert(
      report.changes.begin(),
      fmt::format("{} removed {} ({:.2f} mm2) and {} of the scan before closing; its other {} did not move",
                  counted(options.trims.size(), "cut", "cuts"),
                  counted(trimmed.triangles_removed, "triangle", "triangles"), trimmed.removed_mm2,
                  counted(trimmed.vertices_removed, "vertex", "vertices"),
                  counted(trimmed.mesh.vertices.size(), "vertex", "vertices")));
  return std::move(solid);
}

}  // namespace

Expected<Solid> closeMesh(const Mesh& imported_mm, const CloseOptions& options, const Progress& progress) {
  KERF_CHECK(checkOptions(options));
  if (imported_mm.triangles.empty())
    return fail(makeError(Error::Code::kEmpty, "a mesh without triangles", "a surface",
                          "export the scan as a mesh, not as points"));
  if (degenerateTriangles(imported_mm.vertices, imported_mm.triangles).size() == imported_mm.triangles.size())
    return fail(makeError(Error::Code::kEmpty, "a mesh whose triangles all have no area", "a surface"));
  KERF_CHECK(checkObjectSize(imported_mm));
  if (!options.trims.empty()) return closeTrimmed(imported_mm, options, progress);
  if (!kerf::report(progress, 0.0, "welding")) return cancelled();
  Solid solid;
  CloseReport& report = solid.report;
  const CloseOptions fit = fitted(options, imported_mm, report);
  Chain chain;
  KERF_TRY(result, makeSolid(imported_mm, fit, chain, report, progress));
  dropMadeCrumbs(imported_mm, fit, result, report);

  internal::reportLosses(imported_mm, result.mesh, chain.handles, lengthScale(imported_mm), report);
  internal::Judgement judgement = internal::judgeSolid(imported_mm, result.mesh, report, &chain);
  if (judgement.refusal && !options.accept_doubtful) return fail(std::move(*judgement.refusal));
  for (std::string& note : judgement.notes) report.changes.push_back(std::move(note));
  for (std::string& warning : judgement.warnings) warn(report, std::move(warning));

  if (options.drop_specks_mm3 > 0) {
    const std::size_t before = result.mesh.vertices.size();
    dropSpecks(result, options.drop_specks_mm3, report);
    report.vertices_in_specks = before - result.mesh.vertices.size();
  }
  const std::size_t source_vertices = imported_mm.vertices.size() - report.vertices_welded;
  countTriangles(imported_mm, result, report);
  report.vertices_added =
      result.mesh.vertices.size() > source_vertices ? result.mesh.vertices.size() - source_vertices : 0;
  solid.mesh = std::move(result.mesh);
  solid.source_triangle = std::move(result.source);
  return solid;
}

Expected<OcclusalPlane> findOcclusalPlaneOfScan(const Mesh& imported_mm, const CloseOptions& options) {
  KERF_CHECK(checkObjectSize(imported_mm));
  assert(options.trims.empty());
  CloseReport unused;
  KERF_TRY(chain, internal::buildChain(imported_mm, options, unused));
  return internal::findPlaneOfScan(chain, options);
}

std::string namesOf(const std::set<CloseStep>& steps) {
  std::string names;
  for (const CloseStep step : steps) {
    if (!names.empty()) names += ',';
    names += kCloseStepNames[static_cast<std::size_t>(step)];
  }
  return names;
}

std::string canonicalText(const CloseOptions& o) {
  const auto vector = [](const std::optional<Vec3d>& v) {
    return v ? fmt::format("({} {} {})", v->x(), v->y(), v->z()) : std::string("-");
  };
  // Options off by default stay out of the text, because the ids of existing cases derive from it.
  std::string more;
  if (o.trim_rim_mm > 0) more += fmt::format(" trim {}", o.trim_rim_mm);
  if (!o.trims.empty()) more += '\n' + textOf(o.trims);
  if (o.drop_specks_mm3 > 0) more += fmt::format(" specks {}", o.drop_specks_mm3);
  return fmt::format(
      "{} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {}{}", static_cast<int>(o.mode),
      static_cast<int>(o.base_style), o.base_margin_mm, o.base_height_mm.value_or(0), vector(o.base_direction),
      o.find_occlusal_plane,
      o.occlusal_plane ? vector(o.occlusal_plane->normal) + vector(o.occlusal_plane->point) : std::string("-"),
      o.rim_to_diagonal, o.crumb_fraction, o.debris_fraction, o.cleanup_length_mm, o.wrap_alpha_mm, o.wrap_offset_mm,
      namesOf(o.only), o.stitch_mm, o.fill_up_to_mm.value_or(0), o.base_smoothing_mm, o.base_lip_mm, more);
}

Expected<Solid> closeMeshes(std::span<const Mesh> imported_mm, const CloseOptions& options, const Progress& progress) {
  Mesh all;
  for (const Mesh& mesh : imported_mm) append(all, mesh);
  return closeMesh(all, options, progress);
}

}  // namespace kerf
