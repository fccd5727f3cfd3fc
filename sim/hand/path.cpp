#include "sim/hand/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <string_view>

#include "geometry/base/text.h"
#include "geometry/base/toml_reader.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHeader = "t,x,y,z,qw,qx,qy,qz";
constexpr std::array<const char*, 8> kColumns{"t", "x", "y", "z", "qw", "qx", "qy", "qz"};
constexpr double kRadian = std::numbers::pi / 180;
constexpr double kLargestTurn = 120 * kRadian;  // between rows: beyond, the shorter way is a guess
constexpr double kChordError = 1e-3;            // mm
constexpr double kTurnPerMotion = 2 * kRadian;
constexpr double kTurnSpeed = 45 * kRadian;  // rad/s: a turn about the tip itself has no feed
constexpr double kReach = 1000;              // mm: no part of a patient is farther from its origin

// Reads the rows of a CSV of poses, one after the other.
class PoseTable {
 public:
  explicit PoseTable(const fs::path& file) : file_(file) {}

  Expected<void> add(std::size_t line, std::string_view text) {
    if (!has_header_) {
      if (text != kHeader)
        return bad(line, kWholeLine, fmt::format("\"{}\"", text.substr(0, 60)), "the header " + std::string(kHeader));
      has_header_ = true;
      return {};
    }
    KERF_TRY(numbers, parse(line, text));
    KERF_TRY(pose, poseFrom(line, numbers));
    path_.poses.push_back(pose);
    return {};
  }

  Expected<CutPath> take() {
    if (!has_header_) return bad(1, kWholeLine, "no header", std::string(kHeader));
    if (path_.poses.size() < 2)
      return fail({.code = Error::Code::kEmpty,
                   .file = file_.string(),
                   .found = fmt::format("{} poses", path_.poses.size()),
                   .expected = "at least 2 poses"});
    path_.cuts.assign(path_.poses.size() - 1, 1);
    return std::move(path_);
  }

 private:
  using Row = std::array<double, kColumns.size()>;
  static constexpr std::size_t kWholeLine = kColumns.size();

  tl::unexpected<Error> bad(std::size_t line, std::size_t column, std::string found, std::string expected) const {
    const std::string place = column < kColumns.size()
                                  ? fmt::format("line {}, column {} ({})", line, column + 1, kColumns[column])
                                  : fmt::format("line {}", line);
    return fail({.code = Error::Code::kBadFormat,
                 .file = file_.string(),
                 .place = place,
                 .found = std::move(found),
                 .expected = std::move(expected)});
  }

  Expected<Row> parse(std::size_t line, std::string_view text) const {
    Row v{};
    std::size_t column = 0, at = 0;
    for (bool more = true; more; ++column) {
      const std::size_t comma = std::min(text.find(',', at), text.size());
      if (column < v.size()) {
        const char *first = text.data() + at, *last = text.data() + comma;
        const auto [end, status] = std::from_chars(first, last, v[column]);
        if (status != std::errc() || end != last || !std::isfinite(v[column]))
          return bad(line, column, fmt::format("\"{}\"", text.substr(at, std::min<std::size_t>(comma - at, 40))),
                     "a finite number");
      }
      more = comma < text.size();
      at = comma + 1;
    }
    if (column != v.size())
      return bad(line, kWholeLine, fmt::format("{} columns", column), "8 columns: " + std::string(kHeader));
    return v;
  }

  // Checks the ranges of time, place and attitude, and that the motion from the previous pose is unambiguous.
  Expected<PathPose> poseFrom(std::size_t line, const Row& v) const {
    const PathPose* before = path_.poses.empty() ? nullptr : &path_.poses.back();
    PathPose pose;
    pose.t = v[0];
    if (before && !(pose.t > before->t))
      return bad(line, 0, fmt::format("{} s", pose.t), fmt::format("a time after {} s", before->t));

    for (std::size_t k = 1; k < 4; ++k)
      if (std::abs(v[k]) > kReach) return bad(line, k, fmt::format("{} mm", v[k]), fmt::format("within {} mm", kReach));
    pose.T_object_tool.translation = {v[1], v[2], v[3]};

    const Eigen::Quaterniond q(v[4], v[5], v[6], v[7]);
    if (!(std::abs(q.norm() - 1) <= 1e-3))
      return bad(line, 4, fmt::format("a quaternion of length {:.4f}", q.norm()), "length 1 within 0.001");
    pose.T_object_tool.rotation = q.normalized();
    if (before) {
      const double turn = before->T_object_tool.rotation.angularDistance(pose.T_object_tool.rotation);
      if (turn > kLargestTurn)
        return bad(line, 4, fmt::format("a turn of {:.0f} degrees since the previous row", turn / kRadian),
                   "at most 120 degrees, so that the direction is clear");
    }
    return pose;
  }

  const fs::path& file_;
  CutPath path_;
  bool has_header_ = false;
};

Expected<CutPath> readCsv(const fs::path& file) {
  constexpr std::size_t kMostBytes = 256 << 20;
  auto content = readSmallFile(file, kMostBytes);
  if (!content) {
    content.error().expected = "a CSV of poses";
    return fail(std::move(content).error());
  }
  std::istringstream in(std::move(*content));

  PoseTable table(file);
  std::string text;
  for (std::size_t line = 1; std::getline(in, text); ++line) {
    if (line == 1 && text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // spreadsheets write it
    if (text.ends_with('\r')) text.pop_back();
    if (text.empty() || text.front() == '#') continue;
    KERF_CHECK(table.add(line, text));
  }
  return table.take();
}

// Turns strokes into poses, one after the other.
class StrokeWriter {
 public:
  StrokeWriter(const Rigid3& start, bool in_tool_frame) : pose_(start), in_tool_frame_(in_tool_frame) {
    path_.poses.push_back({0, start});
  }
  CutPath take() { return std::move(path_); }

  void add(TomlTable& stroke, double feed) {
    const auto kind = stroke.get<std::string>("kind", kKinds);
    feed = stroke.numberOr("feed", feed, 0.001, 1000, "mm/s");

    if (kind == "plunge") {
      const double depth = stroke.number("depth", 1e-6, kReach);
      const Vec3d way =
          stroke.has("direction") ? vector(unit(stroke, "direction")) : pose_.rotation * Vec3d(-Vec3d::UnitZ());
      stroke.allow("direction");
      if (!stroke.failed()) straight(stroke, "depth", pose_.translation + depth * way, feed, true);
    } else if (kind == "retract") {
      const double height = stroke.number("height", 1e-6, kReach);
      if (!stroke.failed())
        straight(stroke, "height", pose_.translation + height * (pose_.rotation * Vec3d::UnitZ()), feed, false);
    } else if (kind == "line" || kind == "move") {
      stroke.allow("to");
      stroke.allow("by");
      if (stroke.has("to") == stroke.has("by")) {
        stroke.reject(stroke.has("to") ? "by" : "to", stroke.has("to") ? "both to and by" : "neither to nor by",
                      "one of to = [x, y, z] and by = [x, y, z]");
        return;
      }

      const char* key = stroke.has("to") ? "to" : "by";
      const Vec3d v = read(stroke, key);
      if (!stroke.failed())
        straight(stroke, key, stroke.has("to") ? point(v) : Vec3d(pose_.translation + vector(v)), feed, kind == "line");
    } else if (kind == "arc" || kind == "sweep") {
      const bool turns = kind == "sweep";
      const char* key = turns ? "pivot" : "center";
      const Vec3d about = point(read(stroke, key)), axis = vector(unit(stroke, "axis"));
      const double angle = stroke.number("angle_deg", -3600, 3600, "degrees") * kRadian;
      if (angle == 0) stroke.reject("angle_deg", "0", "an angle other than 0");
      if (!stroke.failed()) round(stroke, key, about, axis, angle, feed, turns);
    } else {
      // Its keys count as no further mistake.
      stroke.reject("kind", "\"" + kind + "\"", kKinds);
      for (const char* key : {"depth", "direction", "height", "to", "by", "center", "pivot", "axis", "angle_deg"})
        stroke.allow(key);
    }
  }

  static Vec3d read(TomlTable& table, const char* key) {
    const auto v = table.numbers(key, 3);
    const Vec3d p(v[0], v[1], v[2]);
    if (p.cwiseAbs().maxCoeff() > kReach)
      table.reject(key, fmt::format("[{}, {}, {}]", p[0], p[1], p[2]), fmt::format("within {} mm", kReach));
    return p;
  }
  static Vec3d unit(TomlTable& table, const char* key) {
    const Vec3d v = read(table, key);
    if (v.norm() > 1e-9) return v.normalized();
    table.reject(key, "a vector without length", "a direction, any length but 0");
    return Vec3d::UnitZ();
  }

 private:
  static constexpr const char* kKinds = "one of plunge, line, arc, sweep, move, retract";

  Vec3d point(const Vec3d& p) const { return in_tool_frame_ ? pose_ * p : p; }
  Vec3d vector(const Vec3d& v) const { return in_tool_frame_ ? pose_.rotation * v : v; }

  void push(const Rigid3& pose, double seconds, bool cuts) {
    pose_ = pose;
    path_.poses.push_back({path_.poses.back().t + seconds, pose});
    path_.cuts.push_back(cuts ? 1 : 0);
  }
  void straight(TomlTable& stroke, const char* key, const Vec3d& to, double feed, bool cuts) {
    const double length = (to - pose_.translation).norm();
    if (length < 1e-9) {
      stroke.reject(key, "a stroke without length", "a tip position other than the present one");
      return;
    }
    push({pose_.rotation, to}, length / feed, cuts);
  }
  void round(TomlTable& stroke, const char* key, const Vec3d& about, const Vec3d& axis, double angle, double feed,
             bool turns) {
    const Rigid3 start = pose_;
    const double radius = axis.cross(start.translation - about).norm();
    if (!turns && radius < 1e-9) {
      stroke.reject(key, "the tip is on the axis", "a centre off the tip");
      return;
    }

    // Short enough for the chord to stay near the arc.
    double step = turns ? kTurnPerMotion : std::numbers::pi / 4;
    if (radius > 0) step = std::min(step, 2 * std::acos(1 - std::min(0.5, kChordError / radius)));
    const int count = std::max(1, static_cast<int>(std::ceil(std::abs(angle) / step - 1e-9)));
    const double seconds = std::max(std::abs(angle) * radius / feed, turns ? std::abs(angle) / kTurnSpeed : 0.0);
    for (int n = 1; n <= count; ++n) {
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle * n / count, axis));
      push({turns ? (turn * start.rotation).normalized() : start.rotation, about + turn * (start.translation - about)},
           seconds / count, true);
    }
  }

  CutPath path_;
  Rigid3 pose_;
  bool in_tool_frame_;
};

Expected<CutPath> readStrokes(const fs::path& file) {
  KERF_TRY(root, parseToml(file));
  TomlTable top(root, file, "");
  const auto format = top.get<std::string>("format", "\"kerf-path\"");
  if (format != "kerf-path") top.reject("format", "\"" + format + "\"", "\"kerf-path\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (version != 1) top.reject("version", fmt::format("{}", version), "1");
  const auto frame = top.get<std::string>("frame", "\"object\" or \"tool\"");
  if (frame != "object" && frame != "tool") top.reject("frame", "\"" + frame + "\"", "\"object\" or \"tool\"");
  const double feed = top.numberOr("feed", 2, 0.001, 1000, "mm/s");

  top.allow("start");
  const toml::table* start_table = root["start"].as_table();
  if (!start_table) top.reject("start", "missing", "[start] with position and axis");
  const toml::array* strokes = top.tables("stroke");
  KERF_CHECK(top.finish());

  TomlTable start(*start_table, file, "start");
  Rigid3 pose;
  pose.translation = StrokeWriter::read(start, "position");
  const Vec3d z = StrokeWriter::unit(start, "axis");
  // Without an edge: the object's x, or y when the tool points along x.
  Vec3d x = std::abs(z[0]) < 0.9 ? Vec3d::UnitX() : Vec3d::UnitY();
  if (start.has("edge")) x = StrokeWriter::unit(start, "edge");
  start.allow("edge");

  x -= x.dot(z) * z;
  if (x.norm() < 1e-3) start.reject("edge", "along the axis", "a direction across the axis");
  KERF_CHECK(start.finish());
  x.normalize();
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  pose.rotation = Eigen::Quaterniond(axes).normalized();

  StrokeWriter writer(pose, frame == "tool");
  std::size_t number = 0;
  for (const toml::node& node : *strokes) {
    TomlTable stroke(*node.as_table(), file, fmt::format("stroke[{}]", ++number));
    writer.add(stroke, feed);
    KERF_CHECK(stroke.finish());
  }
  return writer.take();
}

}  // namespace

Expected<CutPath> readPath(const fs::path& file) {
  if (file.extension() == ".csv") return readCsv(file);
  if (file.extension() == ".toml") return readStrokes(file);
  return fail({.code = Error::Code::kUnsupported,
               .file = file.string(),
               .found = "extension \"" + file.extension().string() + "\"",
               .expected = ".csv (poses) or .toml (strokes)"});
}

}  // namespace kerf
