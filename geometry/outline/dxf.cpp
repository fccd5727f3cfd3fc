// DXF: pairs of lines, a group code and a value. Sections, and in ENTITIES one entity after the other, each from its
// code 0 to the next.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "geometry/formats/mesh_source.h"
#include "geometry/outline/outline.h"

namespace kerf::internal {
namespace {

struct Group {
  std::int64_t code = 0;
  std::string_view value;
  const char* at = nullptr;  ///< in the text, of the code
};

std::string_view trimmedValue(std::string_view text) {
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

Expected<std::vector<Group>> groupsOf(const MeshSource& source) {
  std::vector<Group> out;
  Lines lines(source.text());
  std::string_view code, value;
  while (true) {
    const char* const at = lines.position();
    if (!lines.next(code)) return out;
    if (code.empty() && source.text().data() + source.size == lines.position()) return out;
    Group group{0, {}, at};
    if (const char* wrong = parseInteger(trimmedValue(code), group.code))
      return fail(source.atLine(at, Error::Code::kBadFormat, "the group code " + inQuotes(code) + ": " + wrong,
                                "DXF as text: a group code, and its value on the next line"));
    if (!lines.next(value))
      return fail(source.atLine(at, Error::Code::kBadFormat, "no value", "a value below each group code",
                                "export the drawing again"));
    group.value = trimmedValue(value);
    out.push_back(group);
  }
}

// mm of a drawing's unit, by $INSUNITS. Empty: not supported.
std::optional<double> unitOf(std::int64_t units) {
  switch (units) {
    case 0:
    case 4:
      return 1;
    case 1:
      return 25.4;
    case 5:
      return 10;
    case 6:
      return 1000;
    case 13:
      return 0.001;
    default:
      return std::nullopt;
  }
}

class DxfReader {
 public:
  explicit DxfReader(const MeshSource& source) : source_(source) {}
  Expected<std::vector<OutlinePiece>> read();

 private:
  using Point = Eigen::Vector2d;
  struct Corner {
    Point at = Point::Zero();
    double bulge = 0;
  };
  Expected<void> readUnit(std::size_t value);
  // One entity, the groups [begin, end).
  Expected<void> readEntity(std::size_t begin, std::size_t end);
  Expected<void> addCorners(bool is_closed);
  tl::unexpected<Error> unfinished() const {
    return fail({.code = Error::Code::kBadFormat,
                 .file = source_.file,
                 .place = fmt::format("line {}", line_),
                 .found = "a POLYLINE without an end",
                 .expected = "VERTEX entities and SEQEND"});
  }
  Error atGroup(std::size_t n, Error::Code code, std::string found, std::string expected, std::string hint = "") const {
    return source_.atLine(groups_[n].at, code, std::move(found), std::move(expected), std::move(hint));
  }
  /// The numbers of an entity by group code, the first of each; a missing one is 0.
  Expected<double> number(std::size_t begin, std::size_t end, std::int64_t code) const;
  bool is(std::size_t n, std::int64_t code, std::string_view value) const {
    return groups_[n].code == code && groups_[n].value == value;
  }

  const MeshSource& source_;
  std::vector<Group> groups_;
  double scale_ = 1;
  std::optional<double> height_;  // z of the drawing
  std::vector<OutlinePiece> pieces_;
  std::vector<Corner> corners_;  // of the polyline being read
  bool is_polyline_ = false, is_closed_ = false;
  std::size_t line_ = 0;
};

Expected<double> DxfReader::number(std::size_t begin, std::size_t end, std::int64_t code) const {
  for (std::size_t n = begin; n < end; ++n)
    if (groups_[n].code == code) {
      double out = 0;
      if (const char* wrong = parseNumber(groups_[n].value, out))
        return fail(atGroup(n, Error::Code::kBadFormat, inQuotes(groups_[n].value) + ": " + wrong, "a number",
                            numberHint(groups_[n].value)));
      return out;
    }
  return 0;
}

Expected<void> DxfReader::readUnit(std::size_t value) {
  std::int64_t units = 0;
  const bool is_number = value < groups_.size() && !parseInteger(groups_[value].value, units);
  if (const auto scale = is_number ? unitOf(units) : std::nullopt) {
    scale_ = *scale;
    return {};
  }
  return fail(atGroup(std::min(value, groups_.size() - 1), Error::Code::kUnsupported,
                      fmt::format("$INSUNITS {}", units), "1 inches, 4 mm, 5 cm, 6 m, 13 um, or 0 for mm",
                      "set the unit of the drawing to mm"));
}

Expected<void> DxfReader::addCorners(bool is_closed) {
  const std::size_t count = corners_.size();
  for (std::size_t n = 0; n + (is_closed ? 0 : 1) < count; ++n)
    pieces_.push_back({scale_ * corners_[n].at, scale_ * corners_[(n + 1) % count].at, corners_[n].bulge, line_});
  corners_.clear();
  is_polyline_ = false;
  if (pieces_.size() <= kMostPieces) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = source_.file,
               .place = fmt::format("line {}", line_),
               .found = fmt::format("more than {} pieces", kMostPieces),
               .expected = "half the profile of a bur"});
}

Expected<void> DxfReader::readEntity(std::size_t begin, std::size_t end) {
  const std::string_view kind = groups_[begin].value;
  const auto code = [&](std::int64_t wanted) { return number(begin + 1, end, wanted); };
  KERF_TRY(paper, code(67));
  if (paper == 1) return {};
  KERF_TRY(out_x, code(210));
  KERF_TRY(out_y, code(220));
  KERF_TRY(out_z, code(230));
  if (out_z < 0 || out_x != 0 || out_y != 0)
    return fail(atGroup(begin, Error::Code::kUnsupported, std::string(kind) + " drawn in another plane",
                        "a drawing in the plane z = 0, seen from above", "draw it again in the top view"));
  KERF_TRY(flags, code(70));
  KERF_TRY(x, code(10));
  KERF_TRY(y, code(20));
  if (kind != "VERTEX" && kind != "SEQEND") {
    if (is_polyline_) return unfinished();
    line_ = 2 * begin + 1;  // two lines a group
  }

  // All of it at one height. A POLYLINE has its height in its corners.
  if (kind == "LINE" || kind == "ARC" || kind == "LWPOLYLINE" || kind == "VERTEX") {
    KERF_TRY(z, code(kind == "LWPOLYLINE" ? 38 : 30));
    KERF_TRY(to_z, code(31));
    constexpr double kSame = 1e-6;
    if (!height_) height_ = z;
    if (std::abs(z - *height_) > kSame || (kind == "LINE" && std::abs(to_z - *height_) > kSame))
      return fail(atGroup(begin, Error::Code::kUnsupported, std::string(kind) + " at another height z",
                          "a flat drawing: all of it at one height", "project it to z = 0, in the top view"));
  }

  if (kind == "LINE") {
    KERF_TRY(to_x, code(11));
    KERF_TRY(to_y, code(21));
    corners_ = {{{x, y}, 0}, {{to_x, to_y}, 0}};
    return addCorners(false);
  }
  if (kind == "ARC") {
    KERF_TRY(radius, code(40));
    KERF_TRY(from, code(50));
    KERF_TRY(to, code(51));
    double angle = std::fmod(to - from, 360.0);
    if (angle <= 0) angle += 360;
    const auto at = [&](double degrees) {
      const double a = degrees * std::numbers::pi / 180;
      return Point(x + radius * std::cos(a), y + radius * std::sin(a));
    };
    corners_ = {{at(from), std::tan(angle * std::numbers::pi / 720)}, {at(to), 0}};
    return addCorners(false);
  }
  if (kind == "LWPOLYLINE") {
    for (std::size_t n = begin + 1; n < end; ++n) {
      const std::int64_t c = groups_[n].code;
      if (c != 10 && c != 20 && c != 42) continue;
      KERF_TRY(value, number(n, n + 1, c));
      if (c == 10) corners_.push_back({{value, 0}, 0});
      if (corners_.empty())
        return fail(atGroup(n, Error::Code::kBadFormat, "a corner without x", "group 10 before 20 and 42"));
      if (c == 20) corners_.back().at[1] = value;
      if (c == 42) corners_.back().bulge = value;
    }
    return addCorners((static_cast<std::int64_t>(std::min(std::abs(flags), 1e6)) & 1) != 0);
  }
  if (kind == "POLYLINE") {
    constexpr std::int64_t kCurved = 2 | 4 | 8 | 16 | 64;  // fitted, spline, 3D, meshes
    const auto bits = static_cast<std::int64_t>(std::min(std::abs(flags), 1e6));
    if (bits & kCurved)
      return fail(atGroup(begin, Error::Code::kUnsupported, "POLYLINE that is a fitted curve, 3D or a mesh",
                          "a plain polyline of lines and arcs", "explode it, or convert it to arcs"));
    corners_.clear();
    is_polyline_ = true;
    is_closed_ = (bits & 1) != 0;
    return {};
  }
  if (kind == "VERTEX" && is_polyline_) {
    KERF_TRY(bulge, code(42));
    corners_.push_back({{x, y}, bulge});
    return {};
  }
  if (kind == "SEQEND" && is_polyline_) return addCorners(is_closed_);
  return fail(atGroup(begin, Error::Code::kUnsupported, "the entity " + inQuotes(kind),
                      "LINE, ARC, LWPOLYLINE and POLYLINE only",
                      kind == "INSERT"   ? "explode the block"
                      : kind == "SPLINE" ? "convert the spline to a polyline with arcs"
                                         : "delete it, or convert it to a polyline"));
}

Expected<std::vector<OutlinePiece>> DxfReader::read() {
  if (source_.text().starts_with("AutoCAD Binary DXF"))
    return fail(
        source_.atByte(0, Error::Code::kUnsupported, "binary DXF", "DXF as text", "save the drawing as ASCII DXF"));
  KERF_TRY(groups, groupsOf(source_));
  groups_ = std::move(groups);
  std::string_view section;
  bool has_entities = false;
  for (std::size_t n = 0; n < groups_.size();) {
    std::size_t end = n + 1;
    while (end < groups_.size() && groups_[end].code != 0) ++end;
    if (is(n, 0, "SECTION")) {
      section = n + 1 < end && groups_[n + 1].code == 2 ? groups_[n + 1].value : "";
      has_entities = has_entities || section == "ENTITIES";
      for (std::size_t k = n; section == "HEADER" && k < end; ++k)
        if (is(k, 9, "$INSUNITS")) KERF_CHECK(readUnit(k + 1));
    } else if (is(n, 0, "ENDSEC") || is(n, 0, "EOF")) {
      section = "";
    } else if (section == "ENTITIES" && groups_[n].code == 0) {
      KERF_CHECK(readEntity(n, end));
    }
    n = end;
  }
  if (!has_entities)
    return fail({.code = Error::Code::kBadFormat,
                 .file = source_.file,
                 .found = "no section ENTITIES",
                 .expected = "a DXF drawing as text"});
  if (is_polyline_) return unfinished();
  return std::move(pieces_);
}

}  // namespace

Expected<std::vector<OutlinePiece>> readDxf(const MeshSource& source) { return DxfReader(source).read(); }

}  // namespace kerf::internal
