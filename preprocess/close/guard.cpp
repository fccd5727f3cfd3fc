#include "preprocess/close/guard.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "preprocess/close/kept_parts.h"
#include "preprocess/close/losses.h"
#include "preprocess/close/openness.h"
#include "preprocess/close/winding.h"

namespace kerf::internal {
namespace {

// Corners at the same place are one: STL has no others. `used` counts the places.
std::vector<Triangle> weldedTriangles(const Mesh& mesh, std::size_t& used) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](std::uint32_t v) {
    const Vec3d p = weldPlace(roundedToFloat(mesh.vertices[v]));
    return std::array{p.x(), p.y(), p.z()};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  std::vector<std::uint32_t> first(mesh.vertices.size());
  for (std::size_t n = 0; n < order.size(); ++n)
    first[order[n]] = n > 0 && place(order[n]) == place(order[n - 1]) ? first[order[n - 1]] : order[n];

  std::vector<char> is_used(mesh.vertices.size(), 0);
  std::vector<Triangle> out;
  out.reserve(mesh.triangles.size());
  for (const Triangle& f : mesh.triangles) {
    const Triangle welded{first[f[0]], first[f[1]], first[f[2]]};
    for (const std::uint32_t v : welded) is_used[v] = 1;
    if (welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0]) out.push_back(welded);
  }
  used = static_cast<std::size_t>(std::count(is_used.begin(), is_used.end(), 1));
  return out;
}

// Other remedies. A wrap is the last resort, because it fills spaces out of its reach, such as cavities.
std::string otherWays(const CloseReport& report) {
  return report.exact ? "--close repair, --close wrap, or repair the mesh in another program"
                      : "--close repair, or repair the mesh in another program: a wrap fills cavities and spaces that "
                        "it cannot enter";
}

Error refusalOf(std::string found, std::string expected, const CloseReport& report) {
  return {.code = Error::Code::kGeometry,
          .found = std::move(found),
          .expected = std::move(expected),
          .hint = otherWays(report) + "; --accept-doubtful accepts the solid"};
}

// Reference for the volume of a solid, mm3.
struct Expectation {
  double volume = 0;
  const char* of = nullptr;  // null: nothing
};

Expectation expectationOf(const Mesh& mesh, bool is_hardly_open, const CloseReport& report) {
  if (!report.exact && report.volume_closed_mm3 > 0) return {report.volume_closed_mm3, "the closed mesh encloses"};
  if (is_hardly_open) return {std::abs(signedVolume(mesh)), "the mesh encloses"};
  return {};
}

/// A wrap encloses any input: around a sheet, or copies of one triangle, it is a closed skin of twice the offset, with
/// some volume.
void judgeSkin(const Mesh& solid, const CloseReport& report, Judgement& out) {
  if (report.exact || !(report.wrap_offset_mm > 0)) return;
  const double volume = std::abs(signedVolume(solid)), area = surfaceArea(solid);
  if (volume > kSkin * report.wrap_offset_mm * area || report.volume_closed_mm3 > 0.5 * volume) return;

  const std::string found = fmt::format("a wrap of {:.3g} mm3, {:.2g} mm thick, around a surface that encloses nothing",
                                        volume, 2 * volume / area);
  const std::string way =
      "--close base if it is a scan whose underside is missing, or close the surface in another "
      "program";
  out.warnings.push_back("THE SOLID IS A SKIN: it is " + found + ". Check it before cutting; try " + way);
  out.refusal = Error{.code = Error::Code::kGeometry,
                      .found = found,
                      .expected = "a surface with an inside, or a scan that is open below",
                      .hint = way + "; --accept-doubtful accepts the skin"};
}

/// "it reaches 5.4 mm beyond the scan on the +z side"; empty if the solid reaches as far as the scan.
std::string extentSentence(const Mesh& solid, const CloseReport& report, const Chain& closed) {
  std::vector<Vec3d> scan;
  for (std::size_t t = 0; t < closed.source.size(); ++t)
    if (closed.source[t] != kAdded)
      for (const std::uint32_t v : closed.mesh.triangles[t]) scan.push_back(closed.mesh.vertices[v]);
  if (scan.empty() || solid.vertices.empty()) return {};

  Box3 box;
  for (const Vec3d& p : scan) box.add(p);
  constexpr double kSmallestDental = 3;  // mm: lengths shrink with smaller objects
  const double diagonal = box.size().norm();
  const double most = std::max(kMostReach * diagonal, kLeastReach * std::min(1.0, diagonal / kSmallestDental));
  std::string text;
  for (const SideChange& change : sideChanges(scan, solid, report.base_direction)) {
    if (std::abs(change.mm) <= most) continue;
    text += text.empty() ? "it " : ", ";
    text += fmt::format("{} {:.2g} mm {} the scan on the {} side", change.mm > 0 ? "reaches" : "ends",
                        std::abs(change.mm), change.mm > 0 ? "beyond" : "short of", nameOfSide(change.side));
  }
  return text;
}

/// With a wrong volume the extent gives the reason; alone it is a separate warning.
void judgeExtent(const Mesh& solid, const CloseReport& report, const Chain& closed, Judgement& out) {
  const std::string extent = extentSentence(solid, report, closed);
  if (extent.empty()) return;
  if (!out.warnings.empty())
    out.warnings.back() += "; " + extent;
  else
    out.warnings.push_back("THE SOLID IS NOT AS LARGE AS THE SCAN: " + extent +
                           ". Check these places before cutting; try " + otherWays(report));
}

void judgePieces(const Mesh& solid, const CloseReport& report, const Chain& closed, Judgement& out) {
  if (!report.exact && !(report.volume_closed_mm3 > 0)) return;  // open triangles in a wrap: pieces of what?
  const PieceChanges pieces = report.exact ? comparePieces(closed, solid) : compareWrappedPieces(closed, solid);
  const auto near = [](const Vec3d& p) { return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", p.x(), p.y(), p.z()); };
  if (pieces.lost > 0)
    out.warnings.push_back(fmt::format(
        "{} OF THE SCAN {} LOST: {} of {} in no part of the solid, such as near {}. Check it before cutting; try {}",
        pieces.lost == 1 ? "A PIECE" : "PIECES", pieces.lost == 1 ? "IS" : "ARE", pieces.lost, pieces.pieces,
        near(pieces.lost_at), otherWays(report)));
  if (pieces.joined == 0) return;
  const std::string joined = fmt::format("{} of the scan that do not touch are one in the solid, such as near {}",
                                         counted(pieces.joined + 1, "piece", "pieces"), near(pieces.joined_at));
  if (report.exact)
    out.notes.push_back(joined);
  else
    out.warnings.push_back("PIECES OF THE SCAN ARE JOINED: " + joined + ". A wrap bridges close parts; try " +
                           otherWays(report));
}

void judgeVolume(const Mesh& mesh, const Mesh& solid, const Expectation& expected, bool is_hardly_open,
                 const CloseReport& report, Judgement& out) {
  if (!expected.of) return;
  const double after = std::abs(signedVolume(solid));
  if (after <= kMostGrowth * expected.volume && after >= kLeastShrink * expected.volume) return;
  // Shells that lie in each other or face different ways count wrong in a sum over triangles.
  const double wound = is_hardly_open && report.exact ? windingVolume(mesh) : expected.volume;
  if (after <= kMostGrowth * wound && after * kMostGrowth >= wound) return;

  const double least = std::min(wound, expected.volume), most = std::max(wound, expected.volume);
  const double before = wound > 0 ? wound : expected.volume;
  if (!(before > 0)) return;
  const std::string found =
      fmt::format("{:.4g} mm3, {:.3g} times the {:.4g} mm3 that {}", after, after / before, before, expected.of);
  out.warnings.push_back("THE SOLID DIFFERS FROM THE SCAN: it has " + found + ". Check it before cutting; try " +
                         otherWays(report));
  if (after > kRefusedGrowth * most || after < kRefusedShrink * least)
    out.refusal =
        refusalOf("a solid of " + found, fmt::format("{} to {} times as much", kRefusedShrink, kRefusedGrowth), report);
}

/// Number of lost vertices inside the solid: a union swallows them, which is no loss. Exception: a whole missing piece
/// inside is a loss, such as the wall of a hollow that faces the wrong way.
std::size_t swallowedBy(const Mesh& solid, const Mesh& mesh) {
  const RayWinding rays(solid);
  const std::vector<Vec3d> lost = lostPlaces(mesh, solid);
  const auto isLost = [&](std::uint32_t v) {
    return std::binary_search(lost.begin(), lost.end(), weldPlace(roundedToFloat(mesh.vertices[v])), lessPlace);
  };
  const Pieces pieces = edgeConnectedPieces(mesh);
  std::vector<char> is_left(pieces.count, 0), is_counted(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) is_left[pieces.label[t]] |= isLost(v) ? 0 : 1;

  std::size_t out = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (!is_left[pieces.label[t]] || std::exchange(is_counted[v], 1) || !isLost(v)) continue;
      out += rays.at(mesh.vertices[v], [](std::uint32_t) { return false; }).value_or(0) > 0 ? 1 : 0;
    }
  return out;
}

void judgeLoss(const Mesh& mesh, const Mesh& solid, std::size_t vertices, bool is_volume_right,
               const CloseReport& report, Judgement& out) {
  const auto share = [&](std::size_t n) { return static_cast<double>(n) / static_cast<double>(vertices); };
  std::size_t count = report.vertices_lost;
  if (!report.exact || vertices == 0 || !(share(count) > kMostLost)) return;
  if (report.rims_extruded == 0) count -= std::min(count, swallowedBy(solid, mesh));  // a base buries
  if (!(share(count) > kMostLost)) return;

  const std::string found =
      fmt::format("{} of its {} vertices ({:.0f} %) are not in the solid", count, vertices, 100 * share(count));
  out.warnings.push_back("MUCH OF THE SCAN IS LOST: " + found + ". Check it before cutting; try " + otherWays(report));
  if (share(count) > kRefusedLost && !is_volume_right && !out.refusal)
    out.refusal =
        refusalOf("a closing that ruins the scan: " + found, "three fifths at most: a double layer loses half", report);
}

}  // namespace

double windingVolume(const Mesh& mesh) {
  constexpr double kMost = 50'000, kLeast = 1000;  // 1 and 7 % of a volume that fills a fifth of the box
  constexpr double kMostWork = 2e8;                // triangles looked at: some 2 s
  const Box3 box = bounds(mesh);
  const RayWinding rays(mesh);
  const auto places = static_cast<std::size_t>(std::clamp(kMostWork / (rays.trianglesOfACell() + 1), kLeast, kMost));
  const auto nothing = [](std::uint32_t) { return false; };
  std::vector<char> is_inside(places, 0);
  tbb::parallel_for(std::size_t{0}, places, [&](std::size_t n) {
    // An even sequence: powers of 1 / x with x^4 = x + 1.
    const Vec3d step(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
    const Vec3d share = (static_cast<double>(n + 1) * step).unaryExpr([](double x) { return x - std::floor(x); });
    const auto winding = rays.at(box.min + share.cwiseProduct(box.size()), nothing);
    is_inside[n] = winding && *winding != 0;
  });
  const auto inside = static_cast<double>(std::count(is_inside.begin(), is_inside.end(), 1));
  return box.size().prod() * inside / static_cast<double>(places);
}

Judgement judgeSolid(const Mesh& imported_mm, const Mesh& solid, const CloseReport& report, const Chain* closed) {
  Judgement out;
  std::size_t used = 0;
  const std::vector<Triangle> triangles = weldedTriangles(imported_mm, used);
  Box3 box;
  for (const Triangle& f : triangles)
    for (const std::uint32_t v : f) box.add(imported_mm.vertices[v]);
  const bool is_hardly_open =
      !triangles.empty() && openLength(imported_mm, triangles) <= kHardlyOpen * box.size().norm();

  // Triangles of a mesh that face different ways enclose no volume that means anything: only the turned ones do.
  const Mesh& compared = closed && report.exact && report.triangles_flipped > 0 ? closed->mesh : imported_mm;
  const Expectation expected = expectationOf(compared, is_hardly_open, report);
  judgeSkin(solid, report, out);
  if (!out.refusal) judgeVolume(compared, solid, expected, is_hardly_open, report, out);
  const bool is_volume_right = is_hardly_open && expected.volume > 0 && out.warnings.empty();
  if (closed) judgeExtent(solid, report, *closed, out);
  if (closed) judgePieces(solid, report, *closed, out);
  judgeLoss(closed ? closed->mesh : imported_mm, solid, used, is_volume_right, report, out);

  if (report.handles_added > kMostHandles)
    out.warnings.push_back(
        fmt::format("THE SOLID IS FULL OF HOLES: {} go right through it that the scan does not have. Check it before "
                    "cutting; try --base-smoothing 16, or repair the mesh in another program",
                    report.handles_added));
  return out;
}

}  // namespace kerf::internal
