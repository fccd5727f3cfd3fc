#include "ui/app/saw/saw_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/base/atomic_file.h"
#include "geometry/base/toml_reader.h"
#include "ui/app/saw/slicer_planes.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr int kFormatVersion = 1;
constexpr double kApart = 0.5;        // mm: nearer points give no direction
constexpr double kFlat = 0.02;        // sine of the least angle between two sides of three points
constexpr double kMostMm = 1e4;       // of a coordinate in a file
constexpr double kUnitWithin = 1e-6;  // directions of a file
constexpr std::size_t kLongestName = 60;

tl::unexpected<Error> noPlane(std::string found, std::string expected, std::string hint) {
  return fail({.code = Error::Code::kGeometry,
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

// Component of a direction in the plane, unit. None: nearly zero.
std::optional<Vec3d> within(const Vec3d& normal, const Vec3d& direction) {
  const double length = direction.norm();
  if (!(length > 1e-12)) return {};
  const Vec3d unit = direction / length;
  const Vec3d part = unit - normal.dot(unit) * normal;
  if (part.norm() < 1e-3) return {};
  return part.normalized();
}

// The plane's direction nearest to `wanted`. If `wanted` is perpendicular: nearest to down, else to y.
Vec3d approachIn(const Vec3d& normal, const Vec3d& wanted) {
  if (const auto part = within(normal, wanted)) return *part;
  if (const auto down = within(normal, -Vec3d::UnitZ())) return *down;
  return *within(normal, Vec3d::UnitY());
}

toml::array listOf(const Vec3d& v) { return toml::array{v[0], v[1], v[2]}; }

Vec3d vectorOf(TomlTable& table, const char* key) {
  const auto numbers = table.numbers(key, 3);
  if (numbers.size() != 3) return Vec3d::Zero();
  return {numbers[0], numbers[1], numbers[2]};
}

Expected<SawPlane> readPlane(const toml::table& table, const fs::path& file, std::size_t n) {
  TomlTable t(table, file, fmt::format("plane {}", n + 1));
  SawPlane out;
  out.name = t.get<std::string>("name", "a name");
  out.point = vectorOf(t, "point");
  out.normal = vectorOf(t, "normal");
  out.approach = vectorOf(t, "approach");
  out.width = t.number("width", SawPlan::kLeastSide, SawPlan::kMostSide);
  out.depth = t.number("depth", SawPlan::kLeastSide, SawPlan::kMostSide);
  if (!t.failed()) {
    if (out.name.empty() || out.name.size() > kLongestName)
      t.reject("name", fmt::format("{} characters", out.name.size()), fmt::format("1 to {}", kLongestName));
    if (!(out.point.cwiseAbs().maxCoeff() < kMostMm)) t.reject("point", "a point far away", "mm of the case's frame");
    if (!(std::abs(out.normal.norm() - 1) < kUnitWithin)) t.reject("normal", "no unit vector", "length 1");
    if (!(std::abs(out.approach.norm() - 1) < kUnitWithin)) t.reject("approach", "no unit vector", "length 1");
    if (!(std::abs(out.approach.dot(out.normal)) < kUnitWithin))
      t.reject("approach", "a direction out of the plane", "square to the normal");
  }
  KERF_CHECK(t.finish());
  return out;
}

}  // namespace

// ---- A plane

std::array<Vec3d, 4> SawPlane::corners() const {
  const double half = 0.5 * width;
  return {fromPlane(-half, 0), fromPlane(half, 0), fromPlane(half, depth), fromPlane(-half, depth)};
}

Vec3d SawPlane::toPlane(const Vec3d& p) const {
  const Vec3d from = p - point;
  return {across().dot(from), approach.dot(from), normal.dot(from)};
}

Expected<SawPlane> planeThrough(const std::array<Vec3d, 3>& points, const Vec3d& outward) {
  const Vec3d a = points[1] - points[0], b = points[2] - points[0], c = points[2] - points[1];
  const double shortest = std::min({a.norm(), b.norm(), c.norm()});
  const double longest = std::max({a.norm(), b.norm(), c.norm()});
  const Vec3d square = a.cross(b);
  if (!(shortest > kApart))
    return noPlane(fmt::format("two points {:.2f} mm apart", shortest), "three points apart by more than 0.5 mm",
                   "choose points far from each other: the plane is then more accurate");
  if (!(square.norm() > kFlat * longest * longest))
    return noPlane("three points on a line", "points that form a triangle", "choose the third point off the line");

  SawPlane out;
  out.normal = square.normalized();
  out.approach = approachIn(out.normal, -outward);
  out.point = (points[0] + points[1] + points[2]) / 3;
  return out;
}

Expected<SawPlane> planeAlongView(const Vec3d& from, const Vec3d& to, const Vec3d& view) {
  Vec3d line = to - from;
  line -= view.dot(line) * view;
  if (!(line.norm() > kApart))
    return noPlane(fmt::format("a line {:.2f} mm long as seen", line.norm()), "more than 0.5 mm",
                   "draw it right across the bone");

  SawPlane out;
  out.approach = view;
  out.normal = view.cross(line).normalized();
  out.point = 0.5 * (from + to);
  out.width = line.norm();
  return out;
}

Expected<SawPlane> planeSquareTo(const Vec3d& point, const Vec3d& normal, const std::optional<Vec3d>& approach) {
  if (!(normal.norm() > 1e-9) || !normal.allFinite() || !point.allFinite())
    return fail({.code = Error::Code::kBadValue,
                 .found = "a normal without a direction",
                 .expected = "NX NY NZ, not all zero",
                 .hint = "1 0 0 for a plane between left and right"});
  SawPlane out;
  out.point = point;
  out.normal = normal.normalized();
  out.approach = approachIn(out.normal, approach.value_or(-Vec3d::UnitZ()));
  return out;
}

// ---- Steps

void movePlane(SawPlane& plane, double mm) { plane.point += mm * plane.normal; }

void turnPlane(SawPlane& plane, double about_approach, double about_across) {
  const Eigen::AngleAxisd first(about_approach, plane.approach);
  plane.normal = (first * plane.normal).normalized();

  const Eigen::AngleAxisd second(about_across, plane.across());
  plane.normal = (second * plane.normal).normalized();
  plane.approach = second * plane.approach;
  plane.approach = (plane.approach - plane.normal.dot(plane.approach) * plane.normal).normalized();
}

void turnApproach(SawPlane& plane, double angle) {
  const Vec3d middle = plane.fromPlane(0, 0.5 * plane.depth);
  plane.approach = Eigen::AngleAxisd(angle, plane.normal) * plane.approach;
  plane.approach = (plane.approach - plane.normal.dot(plane.approach) * plane.normal).normalized();
  plane.point = middle - 0.5 * plane.depth * plane.approach;
}

SawPlane movedPlane(SawPlane plane, const Rigid3& by) {
  plane.point = by * plane.point;
  plane.normal = (by.rotation * plane.normal).normalized();
  plane.approach = by.rotation * plane.approach;
  plane.approach = (plane.approach - plane.normal.dot(plane.approach) * plane.normal).normalized();
  return plane;
}

// ---- The plan

void SawPlan::add(SawPlane plane) {
  if (plane.name.empty() || hasName(plane.name)) plane.name = freeName();
  planes_.push_back(std::move(plane));
  chosen_ = planes_.size() - 1;
  ++version_;
}

void SawPlan::replaceChosen(SawPlane plane) {
  plane.name = planes_[chosen_].name;
  plane.width = std::clamp(plane.width, kLeastSide, kMostSide);
  plane.depth = std::clamp(plane.depth, kLeastSide, kMostSide);
  planes_[chosen_] = std::move(plane);
  ++version_;
}

void SawPlan::choose(std::size_t n) {
  if (n >= planes_.size() || n == chosen_) return;
  chosen_ = n;
  ++version_;
}

Expected<void> SawPlan::choose(const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t n = 0; n < planes_.size(); ++n) {
    if (planes_[n].name == name) {
      choose(n);
      return {};
    }
    names.push_back(planes_[n].name);
  }
  return fail({.code = Error::Code::kNotFound,
               .found = fmt::format("\"{}\"", name),
               .expected = names.empty() ? "a planned plane; the plan is empty"
                                         : fmt::format("one of \"{}\"", fmt::join(names, "\", \"")),
               .hint = names.empty() ? "plan one with saw.line X1 Y1 X2 Y2" : ""});
}

Expected<void> SawPlan::renameChosen(const std::string& name) {
  const bool is_taken = hasName(name) && name != planes_[chosen_].name;
  if (name.empty() || name.size() > kLongestName || is_taken)
    return fail({.code = Error::Code::kBadValue,
                 .found = fmt::format("the name \"{}\"{}", name, is_taken ? ", the name of another plane" : ""),
                 .expected = fmt::format("a unique name of 1 to {} characters", kLongestName)});
  planes_[chosen_].name = name;
  ++version_;
  return {};
}

void SawPlan::removeChosen() {
  if (chosen_ >= planes_.size()) return;
  planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(chosen_));
  if (chosen_ > 0) --chosen_;
  ++version_;
}

void SawPlan::clear() {
  planes_.clear();
  chosen_ = 0;
  ++version_;
}

bool SawPlan::hasName(const std::string& name) const {
  return std::any_of(planes_.begin(), planes_.end(), [&](const SawPlane& p) { return p.name == name; });
}

std::string SawPlan::freeName() const {
  for (std::size_t n = 1;; ++n)
    if (std::string name = fmt::format("plane {}", n); !hasName(name)) return name;
}

// ---- Files

Expected<void> SawPlan::save(const fs::path& file) const {
  toml::array planes;
  for (const SawPlane& p : planes_)
    planes.push_back(toml::table{{"name", p.name},
                                 {"point", listOf(p.point)},
                                 {"normal", listOf(p.normal)},
                                 {"approach", listOf(p.approach)},
                                 {"width", p.width},
                                 {"depth", p.depth}});
  toml::table root{{"format", "kerf-saw-plan"}, {"version", kFormatVersion}};
  if (!planes.empty()) root.insert("plane", std::move(planes));

  KERF_TRY(out, AtomicFile::create(file));
  out.stream() << "# Kerf saw plan: planes in the case's frame, mm. Training and lab tool, not a medical device.\n"
               << root << "\n";
  return out.commit();
}

Expected<PlanOrigin> SawPlan::load(const fs::path& file) {
  if (isSlicerFile(file)) {
    KERF_TRY(read, readSlicerPlanes(file));
    clear();
    for (SawPlane& plane : read.planes) add(std::move(plane));
    chosen_ = 0;
    return read.origin;
  }
  KERF_TRY(root, parseToml(file));
  TomlTable top(root, file, "");
  const auto format = top.get<std::string>("format", "\"kerf-saw-plan\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (!top.failed() && (format != "kerf-saw-plan" || version != kFormatVersion))
    return fail({.code = Error::Code::kUnsupported,
                 .file = file.string(),
                 .place = "key format / version",
                 .found = fmt::format("{} version {}", format, version),
                 .expected = fmt::format("kerf-saw-plan version {}", kFormatVersion),
                 .hint = "load a file of saw.save, or planes of 3D Slicer (.mrk.json)"});

  std::vector<SawPlane> planes;
  const toml::array* const tables = top.has("plane") ? top.tables("plane") : nullptr;
  KERF_CHECK(top.finish());
  for (std::size_t n = 0; tables && n < tables->size(); ++n) {
    const toml::table* const table = (*tables)[n].as_table();
    if (!table) continue;  // tables() has reported it
    KERF_TRY(plane, readPlane(*table, file, n));
    const auto hasSameName = [&](const SawPlane& other) { return other.name == plane.name; };
    if (std::any_of(planes.begin(), planes.end(), hasSameName))
      return fail({.code = Error::Code::kBadValue,
                   .file = file.string(),
                   .place = fmt::format("plane {}", n + 1),
                   .found = fmt::format("the duplicate name \"{}\"", plane.name),
                   .expected = "unique names"});
    planes.push_back(std::move(plane));
  }
  planes_ = std::move(planes);
  chosen_ = 0;
  ++version_;
  return PlanOrigin{};
}

}  // namespace kerf
