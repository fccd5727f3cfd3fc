// SVG: one path of the drawing, in user units. Their size comes from viewBox, width and height of the root.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "geometry/formats/mesh_source.h"
#include "geometry/formats/xml_parser.h"
#include "geometry/outline/outline.h"

namespace kerf::internal {
namespace {

using Point = Eigen::Vector2d;

// Numbers and letters of a path, a viewBox or a length.
class SvgText {
 public:
  explicit SvgText(std::string_view text) : text_(text) {}
  void skip() {
    while (!text_.empty() && (isBlank(text_[0]) || isLineEnd(text_[0]) || text_[0] == ',')) text_.remove_prefix(1);
  }
  bool atEnd() {
    skip();
    return text_.empty();
  }
  bool atNumber() {
    skip();
    return !text_.empty() && (std::string_view("+-.0123456789").find(text_[0]) != std::string_view::npos);
  }
  /// False: no finite number is next.
  bool number(double& value) {
    if (!atNumber()) return false;
    if (text_[0] == '+') text_.remove_prefix(1);
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return false;
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return true;
  }
  /// A flag of an arc may stand without a space before the next number.
  bool flag(bool& value) {
    skip();
    if (text_.empty() || (text_[0] != '0' && text_[0] != '1')) return false;
    value = text_[0] == '1';
    text_.remove_prefix(1);
    return true;
  }
  char letter() {
    const char c = text_[0];
    text_.remove_prefix(1);
    return c;
  }
  std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
};

// Pieces of a path, y up.
class PathReader {
 public:
  PathReader(double scale, std::vector<OutlinePiece>& out) : scale_(scale), out_(out) {}
  /// Empty, or the fault.
  std::string read(std::string_view d);

 private:
  bool command(char c, SvgText& text);
  bool point(SvgText& text, bool is_relative, Point& p) const {
    if (!text.number(p[0]) || !text.number(p[1])) return false;
    if (is_relative) p += at_;
    return true;
  }
  void lineTo(const Point& p) { add(p, 0); }
  void curveTo(const Point& a, const Point& b, const Point& end);
  void arcTo(double radius, bool is_large, bool is_sweep, const Point& end);
  void add(const Point& to, double bulge) {
    if (!to.allFinite()) fault_ = "a point farther than numbers reach";
    if (out_.size() > kMostPieces) fault_ = fmt::format("more than {} pieces", kMostPieces);
    if (!fault_.empty()) return;
    const auto up = [&](const Point& p) { return Point(scale_ * p[0], -scale_ * p[1]); };
    out_.push_back({up(at_), up(to), bulge, 0});
    at_ = to;
  }

  double scale_;
  std::vector<OutlinePiece>& out_;
  Point at_ = Point::Zero(), start_ = Point::Zero();
  std::string fault_;
};

void PathReader::curveTo(const Point& a, const Point& b, const Point& end) {
  constexpr double kFlat = 0.001, kMostChords = 1e4;  // mm
  if (!(a.allFinite() && b.allFinite() && end.allFinite())) return lineTo(end);
  // A chord of 1/n of the curve is off by at most |B''| / (8 n^2).
  const Point begin = at_;
  const double bend = scale_ * 6 * std::max((begin - 2 * a + b).norm(), (a - 2 * b + end).norm());
  const auto chords = static_cast<int>(std::clamp(std::ceil(std::sqrt(bend / (8 * kFlat))), 1.0, kMostChords));
  for (int n = 1; n <= chords; ++n) {
    const double t = static_cast<double>(n) / chords, s = 1 - t;
    lineTo(n == chords ? end : Point(s * s * s * begin + 3 * s * s * t * a + 3 * s * t * t * b + t * t * t * end));
  }
}

void PathReader::arcTo(double radius, bool is_large, bool is_sweep, const Point& end) {
  const double half = 0.5 * (end - at_).norm();
  if (half == 0 || radius == 0) {
    return lineTo(end);
  }
  double angle = 2 * std::asin(std::min(1.0, half / radius));  // a radius that is too small grows to fit
  if (is_large) angle = 2 * std::numbers::pi - angle;
  add(end, (is_sweep ? -1 : 1) * std::tan(angle / 4));
}

bool PathReader::command(char c, SvgText& text) {
  const bool is_relative = c >= 'a';
  Point p, a, b;
  switch (c) {
    case 'M':
    case 'm':
      if (!point(text, is_relative, p)) return false;
      at_ = start_ = p;
      return true;
    case 'L':
    case 'l':
      if (!point(text, is_relative, p)) return false;
      lineTo(p);
      return true;
    case 'H':
    case 'h':
    case 'V':
    case 'v': {
      double value = 0;
      if (!text.number(value)) return false;
      const int axis = c == 'H' || c == 'h' ? 0 : 1;
      p = at_;
      p[axis] = is_relative ? at_[axis] + value : value;
      lineTo(p);
      return true;
    }
    case 'C':
    case 'c':
      if (!point(text, is_relative, a) || !point(text, is_relative, b) || !point(text, is_relative, p)) return false;
      curveTo(a, b, p);
      return true;
    default: {  // A, a
      double rx = 0, ry = 0, turn = 0;
      bool is_large = false, is_sweep = false;
      if (!text.number(rx) || !text.number(ry) || !text.number(turn) || !text.flag(is_large) || !text.flag(is_sweep) ||
          !point(text, is_relative, p))
        return false;
      rx = std::abs(rx);
      ry = std::abs(ry);
      if (std::abs(rx - ry) > 1e-6 * std::max(rx, ry))
        fault_ = fmt::format("an elliptical arc, radii {} and {}", rx, ry);
      arcTo(rx, is_large, is_sweep, p);
      return true;
    }
  }
}

std::string PathReader::read(std::string_view d) {
  SvgText text(d);
  char c = 0;
  while (!text.atEnd()) {
    if (!text.atNumber()) {
      const char next = text.letter();
      if (next == 'Z' || next == 'z') {
        if (c == 0) return "a path that does not begin with M";
        lineTo(start_);
        if (!fault_.empty()) return fault_;
        c = 'Z';
        continue;
      }
      if (std::string_view("MmLlHhVvCcAa").find(next) == std::string_view::npos)
        return "the command " + inQuotes(std::string_view(&next, 1));
      if (c == 0 && next != 'M' && next != 'm') return "a path that does not begin with M";
      c = next;
    } else if (c == 0 || c == 'Z') {
      return "a number without a command";
    } else if (c == 'M' || c == 'm') {
      c = c == 'M' ? 'L' : 'l';  // more points of a move are lines
    }
    if (!command(c, text))
      return fmt::format("no number that \"{}\" takes at {}", c, inQuotes(text.rest().substr(0, 20)));
    if (!fault_.empty()) return fault_;
  }
  return "";
}

class SvgReader final : public XmlParser::Handler {
 public:
  explicit SvgReader(const MeshSource& source)
      : name_(std::filesystem::path(source.file).filename().string()), parser_(source, name_, *this) {}
  Expected<std::vector<OutlinePiece>> read(const MeshSource& source) {
    KERF_CHECK(parser_.feed(source.text(), true));
    if (has_path_) return std::move(pieces_);
    return fail(parser_.here(Error::Code::kEmpty, "no path", "one <path>", "convert the drawing to a path"));
  }

  Expected<void> start(std::string_view name, const XmlAttributes& attributes) override {
    constexpr std::string_view kSvg = "http://www.w3.org/2000/svg ";
    const bool is_svg = name.starts_with(kSvg) || name.find(' ') == std::string_view::npos;
    if (name.starts_with(kSvg)) name.remove_prefix(kSvg.size());
    if (skipped_ > 0 || !is_svg || isNotDrawn(name)) {
      ++skipped_;
      return {};
    }
    const std::string_view style = attributes.find("style").value_or("");
    if (style.find("display") != style.npos || style.find("visibility") != style.npos || attributes.find("display") ||
        attributes.find("visibility"))
      return refuse("<" + std::string(name) + "> that may be hidden", "a drawing that is shown", "delete hidden parts");
    if (attributes.find("transform") || style.find("transform") != style.npos)
      return refuse("the attribute transform of <" + std::string(name) + ">", "coordinates without a transform",
                    "apply the transform to the path: ungroup it, then edit its nodes");
    if (scale_ == 0) return readRoot(name, attributes);
    if (name == "g") return {};
    if (name != "path")
      return refuse("the element <" + std::string(name) + ">", "one <path>", "convert it to a path, or delete it");
    if (std::exchange(has_path_, true)) return refuse("a second <path>", "one <path>", "join both, or delete one");
    const std::string fault = PathReader(scale_, pieces_).read(attributes.find("d").value_or(""));
    if (fault.empty()) return {};
    return refuse("the path has " + fault, "M L H V A C Z with their numbers, A with one radius, at most 1000 pieces",
                  "convert the path to lines and arcs");
  }
  Expected<void> end() override {
    if (skipped_ > 0) --skipped_;
    return {};
  }

 private:
  static bool isNotDrawn(std::string_view name) {
    constexpr std::array<std::string_view, 6> kNames = {"defs", "metadata", "title", "desc", "style", "script"};
    return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
  }
  tl::unexpected<Error> refuse(std::string found, std::string expected, std::string hint) const {
    return fail(parser_.here(Error::Code::kUnsupported, std::move(found), std::move(expected), std::move(hint)));
  }
  // mm of width or height; 0: no length with a unit.
  static double lengthOf(std::string_view text) {
    constexpr std::pair<std::string_view, double> kUnits[] = {
        {"mm", 1}, {"cm", 10}, {"in", 25.4}, {"pt", 25.4 / 72}, {"pc", 25.4 / 6}};
    SvgText reader(text);
    double value = 0;
    if (!reader.number(value) || value <= 0) return 0;
    for (const auto& [unit, mm] : kUnits)
      if (reader.rest() == unit) return mm * value;
    return 0;
  }
  Expected<void> readRoot(std::string_view name, const XmlAttributes& attributes) {
    if (name != "svg") return refuse("the element <" + std::string(name) + ">", "an SVG drawing", "");
    std::array<double, 4> box{};
    SvgText numbers(attributes.find("viewBox").value_or(""));
    for (double& value : box)
      if (!numbers.number(value)) return refuse("no viewBox", "viewBox = \"x y width height\"", "");
    const double width = lengthOf(attributes.find("width").value_or("")),
                 height = lengthOf(attributes.find("height").value_or(""));
    if (width == 0 || height == 0)
      return refuse("width or height without a unit", "lengths of the drawing in mm, cm or in, as width=\"20mm\"",
                    "set the unit of the document to mm");
    if (!(box[2] > 0 && box[3] > 0) || std::abs(width / box[2] - height / box[3]) > 1e-3 * width / box[2])
      return refuse("a viewBox of another shape than width and height", "one scale for both", "");
    scale_ = width / box[2];
    return {};
  }

  std::string name_;
  XmlParser parser_;
  double scale_ = 0;  // mm of a user unit; 0: before the root
  bool has_path_ = false;
  std::size_t skipped_ = 0;  // depth in elements that are not drawn
  std::vector<OutlinePiece> pieces_;
};

}  // namespace

Expected<std::vector<OutlinePiece>> readSvg(const MeshSource& source) { return SvgReader(source).read(source); }

}  // namespace kerf::internal
