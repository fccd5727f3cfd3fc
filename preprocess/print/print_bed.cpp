#include "preprocess/print/print_bed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "geometry/base/assets.h"
#include "geometry/base/toml_reader.h"
#include "geometry/mesh/rigid_move.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/mesh/solids.h"
#include "preprocess/print/base_face.h"

namespace kerf {
namespace {

constexpr double kGap = 3;                         // mm between boxes
constexpr double kFlatZ = 5e-5;                    // mm: rounding of a turned base
constexpr double kUpright = 0.906;                 // cosine
constexpr double kTurnStep = 5;                    // degrees
constexpr double kLeastBed = 10, kMostBed = 2000;  // mm

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string sizeOf(const Vec3d& size) { return fmt::format("{:.1f} x {:.1f} x {:.1f} mm", size[0], size[1], size[2]); }

// "145x145x185".
bool readSize(const std::string& words, Vec3d& size) {
  const char* at = words.data();
  const char* const end = at + words.size();
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0 && (at == end || *at++ != 'x')) return false;
    const auto [next, error] = std::from_chars(at, end, size[axis]);
    if (error != std::errc() || !(size[axis] >= kLeastBed && size[axis] <= kMostBed)) return false;
    at = next;
  }
  return at == end;
}

// A piece in its own frame, its box from 0 to `size`.
struct Upright {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Box3 box;
  bool is_on_base = false;
};

Box3 boxOf(const Mesh& mesh, const Eigen::Quaterniond& turn) {
  Box3 out;
  for (const Vec3d& p : mesh.vertices) out.add(turn * p);
  return out;
}

Upright upright(const Mesh& piece, const Vec3d& up, bool keeps_up) {
  Upright out;
  auto base = findBase(piece, -up);
  if (keeps_up && base && base->plane.normal.dot(-up) < kUpright) base.reset();
  out.is_on_base = base.has_value();
  const auto stand = Eigen::Quaterniond::FromTwoVectors(base ? Vec3d(-base->plane.normal) : up, Vec3d::UnitZ());
  double least = std::numeric_limits<double>::infinity();
  for (double degrees = 0; degrees < 90; degrees += kTurnStep) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3d::UnitZ()) * stand);
    const Box3 box = boxOf(piece, turn);
    const double area = box.size()[0] * box.size()[1];
    if (!(area < least * (1 - 1e-9))) continue;
    least = area;
    out.turn = turn;
    out.box = box;
  }
  return out;
}

// Corners of the boxes, in rows: the deepest first. Empty if they do not fit.
std::vector<Vec3d> rowsOf(const std::vector<Upright>& pieces, const Vec3d& bed) {
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return pieces[a].box.size()[1] > pieces[b].box.size()[1]; });
  std::vector<Vec3d> out(pieces.size());
  double x = 0, y = 0, row = 0;
  Vec3d used = Vec3d::Zero();
  for (const std::size_t n : order) {
    const Vec3d size = pieces[n].box.size();
    if (x > 0 && x + size[0] > bed[0]) {
      x = 0;
      y += row + kGap;
      row = 0;
    }
    out[n] = {x, y, 0};
    used = used.cwiseMax(Vec3d(x + size[0], y + size[1], size[2]));
    x += size[0] + kGap;
    row = std::max(row, size[1]);
  }
  if ((used.array() > bed.array()).any()) return {};
  const Vec3d middle(0.5 * (bed[0] - used[0]), 0.5 * (bed[1] - used[1]), 0);
  for (Vec3d& corner : out) corner += middle;
  return out;
}

// The bottom exactly at z = 0, unless that makes the surface cross itself.
void flatten(Mesh& piece) {
  std::vector<Vec3d> flat = piece.vertices;
  for (Vec3d& p : flat)
    if (std::abs(p[2]) < kFlatZ) p[2] = 0;
  if (selfIntersections(flat, piece.triangles, 1).empty() && degenerateTriangles(flat, piece.triangles).empty())
    piece.vertices = std::move(flat);
}

}  // namespace

Expected<std::vector<PrintBed>> printBeds() {
  constexpr const char* kBeds = "print/beds.toml";
  const auto found = findAssets(kBeds);
  if (found.empty())
    return fail({.code = Error::Code::kNotFound,
                 .file = kBeds,
                 .found = "no such file in Kerf's data",
                 .expected = "the list of printers",
                 .hint = "a size in its place, such as 145x145x185, or install Kerf again"});
  KERF_TRY(root, parseToml(found.front()));
  TomlTable top(root, found.front(), "");
  const toml::array* const tables = top.tables("bed");
  KERF_CHECK(top.finish());
  std::vector<PrintBed> out;
  for (const toml::node& node : *tables) {
    TomlTable t(*node.as_table(), found.front(), "bed");
    PrintBed bed;
    bed.name = t.get<std::string>("name", "a name");
    const auto size = t.numbers("size", 3);
    KERF_CHECK(t.finish());
    bed.size_mm = {size[0], size[1], size[2]};
    out.push_back(std::move(bed));
  }
  return out;
}

Expected<PrintBed> printBedOf(const std::string& words) {
  PrintBed bed{words, {}};
  if (readSize(words, bed.size_mm)) return bed;
  KERF_TRY(beds, printBeds());
  std::string names;
  for (const PrintBed& known : beds) {
    if (lower(known.name) == lower(words)) return known;
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", known.name);
  }
  return fail({.code = Error::Code::kNotFound,
               .place = "printer",
               .found = "\"" + words + "\"",
               .expected = "one of " + names + ", or a size",
               .hint = "145x145x185: width, depth and height of its build volume, mm"});
}

Expected<Laid> laidOnBed(const Mesh& mesh, const Vec3d& up, const PrintBed& bed, const Progress& progress,
                         bool keeps_up) {
  const Solids solids = solidsOf(mesh);
  const std::vector<Mesh> pieces = separated(mesh, solids);
  std::vector<Upright> stand;
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    if (!report(progress, 0.4 * static_cast<double>(n) / static_cast<double>(pieces.size()), "laying on the bed"))
      return cancelled();
    stand.push_back(upright(pieces[n], up, keeps_up));
  }
  std::vector<Vec3d> corners = rowsOf(stand, bed.size_mm);
  if (corners.empty()) {  // a quarter of a turn, each
    const Eigen::Quaterniond quarter(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3d::UnitZ()));
    std::vector<Upright> turned = stand;
    for (std::size_t n = 0; n < pieces.size(); ++n) {
      turned[n].turn = quarter * stand[n].turn;
      turned[n].box = boxOf(pieces[n], turned[n].turn);
    }
    corners = rowsOf(turned, bed.size_mm);
    if (!corners.empty()) stand = std::move(turned);
  }
  if (corners.empty()) {
    std::string sizes;
    for (const Upright& piece : stand) sizes += (sizes.empty() ? "" : ", ") + sizeOf(piece.box.size());
    return fail({.code = Error::Code::kBadValue,
                 .place = "bed of " + bed.name,
                 .found = pieces.size() == 1 ? "a model of " + sizes
                                             : fmt::format("{} pieces side by side: {}", pieces.size(), sizes),
                 .expected = "at most " + sizeOf(bed.size_mm),
                 .hint = "a larger printer, or fewer pieces"});
  }

  Laid out;
  std::vector<std::vector<Vec3d>> places;  // of each piece's vertices
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    if (!report(progress, 0.4 + 0.6 * static_cast<double>(n) / static_cast<double>(pieces.size()), "moving"))
      return cancelled();
    LaidPiece piece;
    piece.T_bed_scan = {stand[n].turn, corners[n] - stand[n].box.min};
    piece.size_mm = stand[n].box.size();
    piece.is_on_base = stand[n].is_on_base;
    KERF_TRY(there, rigidlyMoved(pieces[n], piece.T_bed_scan));
    flatten(there);
    places.push_back(std::move(there.vertices));
    out.pieces.push_back(piece);
  }

  // subset() keeps the order of the vertices, so a piece's come one after the other.
  out.mesh = mesh;
  std::vector<std::uint32_t> solid_of(mesh.vertices.size(), solids.count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) solid_of[v] = solids.label[t];
  std::vector<std::size_t> next(pieces.size(), 0);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (const std::uint32_t n = solid_of[v]; n < solids.count) out.mesh.vertices[v] = places[n][next[n]++];
  return out;
}

}  // namespace kerf
