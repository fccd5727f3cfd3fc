#include "ui/app/import/tool_plan.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/tool_file.h"
#include "geometry/tool/tool_template.h"
#include "preprocess/close/close.h"
#include "ui/app/base/language.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr double kMostGuessedCut = 4;  // mm: a bur cuts that far or less; the user gives a longer head
constexpr double kPlanStep = 0.25;     // mm, between measured heights
constexpr double kWider = 1.6;         // times the width near the tip: ends the head
constexpr double kDoubt = 1.5;         // times the width of the tip: below it another end may be the tip

// The longest direction through the surface, unit.
Vec3d toolLengthOf(const Mesh& mesh) {
  double area = 0;
  Vec3d centre = Vec3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = doubleAreaVector(mesh, t).norm();
    area += a;
    centre += a * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
  }
  if (!(area > 0)) return Vec3d::UnitZ();
  centre /= area;

  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = doubleAreaVector(mesh, t).norm();
    for (int k = 0; k < 3; ++k) {
      const Vec3d p = mesh.corner(t, k) - centre;
      spread += a * p * p.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  if (solver.info() != Eigen::Success) return Vec3d::UnitZ();
  return solver.eigenvectors().col(2).normalized();
}

// The part of a mesh near its lowest end along an axis, upright: the axis is z, the end at 0.
struct LowEnd {
  std::vector<std::array<Vec3d, 3>> triangles;
  Eigen::Quaterniond to_file;  // rotation back to the file
  double lowest = 0;           // in the file
  double length = 0;           // of the whole mesh
};
LowEnd lowEnd(const Mesh& mesh, const Vec3d& axis) {
  LowEnd out;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(axis, Vec3d::UnitZ()).normalized();
  out.to_file = upright.conjugate();
  double highest = -std::numeric_limits<double>::infinity();
  out.lowest = -highest;
  for (const Vec3d& p : mesh.vertices) {
    out.lowest = std::min(out.lowest, axis.dot(p));
    highest = std::max(highest, axis.dot(p));
  }
  out.length = highest - out.lowest;

  const double top = out.lowest + kMostGuessedCut;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<Vec3d, 3> corners = {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
    if (std::min({axis.dot(corners[0]), axis.dot(corners[1]), axis.dot(corners[2])}) > top) continue;
    auto& made = out.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) made[k] = upright * corners[k] - Vec3d(0, 0, out.lowest);
  }
  return out;
}

// Visits the points where edges cross a height.
template <class Visit>
void crossings(const LowEnd& end, double height, const Visit& visit) {
  for (const std::array<Vec3d, 3>& triangle : end.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d &a = triangle[k], &b = triangle[(k + 1) % 3];
      const double low = a[2] - height, high = b[2] - height;
      if ((low < 0) != (high < 0)) visit(Vec3d(a + low / (low - high) * (b - a)));
    }
}

// @pre  `way` has its name and axis.
void measure(const Mesh& mesh, ToolWay& way) {
  const LowEnd end = lowEnd(mesh, way.axis);

  // The tip is in the middle of the end as seen along the axis: of its corners and of its section at `top`.
  const double top = std::min(ToolWay::kTipLength, 0.5 * end.length);
  std::vector<Vec3d> points;
  for (const std::array<Vec3d, 3>& triangle : end.triangles)
    for (const Vec3d& p : triangle)
      if (p[2] <= top) points.push_back(p);
  crossings(end, top, [&](const Vec3d& p) { points.push_back(p); });
  Box3 box;
  for (const Vec3d& p : points) box.add(p);
  const Eigen::Vector2d middle = box.center().head<2>();
  double radius = 0;
  for (const Vec3d& p : points) radius = std::max(radius, (p.head<2>() - middle).norm());
  way.tip = end.to_file * Vec3d(middle[0], middle[1], end.lowest);
  way.tip_width_mm = 2 * radius;

  // The cutting part ends where it becomes clearly wider.
  way.cut_below_mm = std::min(kMostGuessedCut, end.length);
  for (double above = top; above < way.cut_below_mm; above += kPlanStep) {
    double reach = 0;
    crossings(end, above, [&](const Vec3d& p) { reach = std::max(reach, (p.head<2>() - middle).norm()); });
    if (reach > kWider * radius) way.cut_below_mm = above;
  }
}

// Axis from a thin end in no direction of the file, such as the bur of a contra-angle. Takes the protruding point with
// the thinnest surroundings, and the axis to their middle. None: nothing protrudes.
std::optional<Vec3d> fromThinEnd(const Mesh& mesh) {
  constexpr std::size_t kMostPoints = 20000, kSides = 200, kFewest = 4;
  constexpr double kPoint = 0.4, kNear = 2.5;  // mm
  const std::size_t step = mesh.vertices.size() / kMostPoints + 1;
  std::vector<Vec3d> points;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += step) points.push_back(mesh.vertices[v]);

  std::optional<Vec3d> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < kSides; ++n) {
    // Evenly over a sphere, along a spiral.
    const double height = 1 - (2 * static_cast<double>(n) + 1) / kSides, turn = 2.399963 * static_cast<double>(n);
    const double across = std::sqrt(1 - height * height);
    const Vec3d side(across * std::cos(turn), across * std::sin(turn), height);
    const Vec3d farthest = *std::max_element(points.begin(), points.end(),
                                             [&](const Vec3d& a, const Vec3d& b) { return side.dot(a) < side.dot(b); });
    // The middle of a blunt point.
    Vec3d tip = Vec3d::Zero();
    double at_tip = 0;
    for (const Vec3d& p : points)
      if ((p - farthest).squaredNorm() < kPoint * kPoint) {
        tip += p;
        ++at_tip;
      }
    tip /= at_tip;

    Vec3d sum = Vec3d::Zero();
    std::size_t count = 0;
    const auto isNear = [&](const Vec3d& p) { return (p - tip).squaredNorm() < kNear * kNear; };
    for (const Vec3d& p : points)
      if (isNear(p)) {
        sum += p - tip;
        ++count;
      }
    if (count < kFewest || !(sum.norm() > 1e-6)) continue;
    const Vec3d axis = sum.normalized();
    double radius = 0;
    for (const Vec3d& p : points)
      if (isNear(p)) radius = std::max(radius, (p - tip - axis.dot(p - tip) * axis).norm());
    if (radius >= least) continue;
    least = radius;
    best = axis;
  }
  return best;
}

// Drops vertices without a triangle: they may lie anywhere.
Mesh withoutStrayVertices(const Mesh& mesh) { return subset(mesh, std::vector<char>(mesh.triangles.size(), 1)); }

Mesh scaledTool(const Mesh& mesh, double scale) {
  Mesh out = mesh;
  for (Vec3d& p : out.vertices) p = roundedToFloat(Vec3d(scale * p));
  return out;
}

std::string idOf(const fs::path& file) {
  std::string out;
  for (const char c : file.stem().string()) {
    const auto letter = static_cast<unsigned char>(c);
    if (letter < 128 && std::isalnum(letter))
      out += static_cast<char>(std::tolower(letter));
    else if (!out.empty() && out.back() != '-')
      out += '-';
  }
  while (!out.empty() && out.back() == '-') out.pop_back();
  return out.empty() ? "my-tool" : out;
}

// Makes a text safe within quotes, or behind a # in a line.
std::string plain(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == '"' || c == '\\' || c == 127) c = '_';
  return text;
}

// An id free in both files and all tools: the rack shows only the first of two tools with one id.
std::string freeId(const std::string& wanted, const fs::path& folder, const std::vector<std::string>& ids_taken) {
  std::vector<fs::path> folders = defaultToolFolders();
  folders.push_back(folder);
  std::error_code ignored;
  const auto isTaken = [&](const std::string& id) {
    const bool is_known = std::find(ids_taken.begin(), ids_taken.end(), id) != ids_taken.end();
    const auto has_it = [&](const fs::path& of) { return fs::exists(of / (id + ".toml"), ignored); };
    return is_known || std::any_of(folders.begin(), folders.end(), has_it) ||
           fs::exists(folder / (id + ".ply"), ignored);
  };
  std::string out = wanted;
  for (int n = 2; isTaken(out); ++n) out = fmt::format("{}-{}", wanted, n);
  return out;
}

}  // namespace

std::vector<ToolWay> toolWays(const Mesh& mesh_mm) {
  const Mesh mesh = withoutStrayVertices(mesh_mm);
  const Vec3d length = toolLengthOf(mesh);
  const std::array<std::pair<const char*, Vec3d>, 8> kWays = {{{"+x", Vec3d::UnitX()},
                                                               {"-x", -Vec3d::UnitX()},
                                                               {"+y", Vec3d::UnitY()},
                                                               {"-y", -Vec3d::UnitY()},
                                                               {"+z", Vec3d::UnitZ()},
                                                               {"-z", -Vec3d::UnitZ()},
                                                               {"length", length},
                                                               {"-length", -length}}};
  std::vector<ToolWay> out;
  for (const auto& [name, axis] : kWays) {
    ToolWay way{.name = name, .axis = axis};
    measure(mesh, way);
    out.push_back(way);
  }
  if (const auto axis = fromThinEnd(mesh)) {
    ToolWay way{.name = "thin-end", .axis = *axis};
    measure(mesh, way);
    out.push_back(way);
  }
  // Sorts an axis of the file before an equal length axis, despite rounding.
  constexpr double kSame = 0.02;  // mm
  const auto steps = [](const ToolWay& way) { return std::lround(way.tip_width_mm / kSame); };
  std::stable_sort(out.begin(), out.end(), [&](const ToolWay& a, const ToolWay& b) { return steps(a) < steps(b); });
  return out;
}

ToolPlan::ToolPlan(fs::path file, std::shared_ptr<const Mesh> mesh, double scale_to_mm)
    : file_(std::move(file)),
      mesh_(std::move(mesh)),
      scale_(scale_to_mm),
      ways_(toolWays(scaledTool(*mesh_, scale_))) {}

void ToolPlan::setScale(double scale_to_mm) {
  if (scale_to_mm == scale_) return;
  const std::string name = way().name;
  scale_ = scale_to_mm;
  ways_ = toolWays(scaledTool(*mesh_, scale_));
  way_ = 0;
  cut_below_mm_ = 0;
  if (is_chosen_) (void)setWay(name);
}

Expected<void> ToolPlan::setWay(const std::string& name) {
  if (name == "auto") {
    way_ = 0;
    is_chosen_ = false;
    return {};
  }
  std::string names;
  for (std::size_t n = 0; n < ways_.size(); ++n) {
    names += ways_[n].name + ", ";
    if (ways_[n].name != name) continue;
    way_ = n;
    is_chosen_ = true;
    return {};
  }
  return fail({.code = Error::Code::kBadValue, .found = "\"" + name + "\"", .expected = "one of " + names + "or auto"});
}

Expected<void> ToolPlan::setCutBelow(double mm) {
  if (!(mm >= kLeastCut && mm <= kMostCut))
    return fail({.code = Error::Code::kBadValue,
                 .found = fmt::format("{:g} mm", mm),
                 .expected = fmt::format("{:g} to {:g} mm above the tip", kLeastCut, kMostCut)});
  cut_below_mm_ = mm;
  return {};
}

bool ToolPlan::isDoubtful() const {
  if (is_chosen_) return false;
  // The same direction under another name is no other end.
  constexpr double kSameWay = 0.98;  // cosine
  return std::any_of(ways_.begin(), ways_.end(), [&](const ToolWay& other) {
    return other.axis.dot(way().axis) < kSameWay && other.tip_width_mm < kDoubt * way().tip_width_mm;
  });
}

std::vector<Finding> ToolPlan::findings() const {
  const ToolWay& now = way();
  std::vector<Finding> out;
  const std::string tip = shownNumbers("{:.3g} mm wide at the tip, shank towards {}", now.tip_width_mm, now.name);
  if (is_chosen_)
    out.push_back({Finding::Weight::kFine, "Axis", tip});
  else if (isDoubtful())
    out.push_back(
        {Finding::Weight::kDoubtful, "Axis", tip + ": a guess, another end is almost as thin. Check the direction"});
  else
    out.push_back({Finding::Weight::kMended, "Axis", tip + ": the thinnest end. Check the direction"});
  return out;
}

std::string ToolPlan::id() const { return idOf(file_); }

Expected<fs::path> writeMeshTool(const MeshToolOrder& order, const fs::path& folder, const Progress& progress) {
  Mesh solid = scaledTool(withoutStrayVertices(*order.mesh), order.scale_to_mm);
  solid.vertex_colors.clear();
  solid.face_colors.clear();
  if (!report(progress, 0, "closing the tool")) return cancelled();
  ToolWay way = order.way;
  if (!checkMesh(solid).print_ready) {
    KERF_TRY(closed, closeMesh(solid, closeOptionsOf(order.closing), progress));
    solid = std::move(closed.mesh);
  }
  // Measures the solid: closing may have moved its end.
  measure(solid, way);

  std::error_code failed;
  fs::create_directories(folder, failed);
  const std::string id = freeId(order.id, folder, order.ids_taken);
  const fs::path mesh_file = folder / (id + ".ply"), tool_file = folder / (id + ".toml");
  MeshToolNumbers numbers;
  numbers.name = plain(order.file.stem().string());
  numbers.origin = plain(fmt::format("{}, read as {}", order.file.string(), order.unit));
  numbers.tip = way.tip;
  numbers.axis = way.axis;
  numbers.cut_below_mm = order.cut_below_mm;

  const auto written = [&]() -> Expected<void> {
    KERF_CHECK(writeMesh(mesh_file, solid));
    KERF_TRY(toml, AtomicFile::create(tool_file));
    toml.stream() << meshToolTemplate(mesh_file.filename().string(), id, numbers);
    KERF_CHECK(toml.commit());
    KERF_CHECK(readTool(tool_file));
    return {};
  }();
  if (written) return tool_file;
  fs::remove(tool_file, failed);
  fs::remove(mesh_file, failed);
  return fail(written.error());
}

}  // namespace kerf
