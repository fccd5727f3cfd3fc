#include "preprocess/print/label.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/base/text.h"
#include "geometry/boolean/boolean.h"
#include "preprocess/print/flat_shape.h"
#include "preprocess/print/label_face.h"

namespace kerf {
namespace {

using internal::FlatShape, internal::LabelFrame, internal::Point2d;

constexpr double kFinest = 1;            // mm: squares of letters that follow a surface
constexpr double kCleanupLength = 1e-3;  // mm, as of a plane cut
constexpr double kThinStroke = 0.5, kShallow = 0.3;

Expected<void> requireRange(const char* what, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return fail({.code = Error::Code::kBadValue,
               .place = fmt::format("label, {}", what),
               .found = fmt::format("{} mm", value),
               .expected = fmt::format("{} to {} mm", low, high)});
}

Expected<LabelFrame> frameOf(const LabelOptions& label) {
  const Vec3d n = label.normal.normalized();
  const Vec3d up = label.up - label.up.dot(n) * n;
  if (!label.point.allFinite() || !n.allFinite() || !label.up.allFinite() || !(label.normal.norm() > 0) ||
      !(up.norm() > 1e-6 * label.up.norm()))
    return fail({.code = Error::Code::kBadValue,
                 .place = "label, normal and up",
                 .found = "a number that is not finite, a direction of length 0, or up along the normal",
                 .expected = "two directions across each other, and a point, mm"});
  LabelFrame frame;
  frame.point = label.point;
  frame.normal = n;
  frame.up = up.normalized();
  frame.right = frame.up.cross(n);
  frame.radius_mm = label.bend_radius_mm;
  return frame;
}

// The letters, closed.
Mesh prismOf(const FlatShape& shape, const LabelFrame& frame, const internal::LabelSpan& span, const Point2d& shift) {
  Mesh out;
  for (const double z : {span.low, span.high})
    for (const Point2d& p : shape.points)
      out.vertices.push_back(frame.at(p.x() + shift.x(), p.y() + shift.y(), z + span.ground.at(p)));
  const auto top = static_cast<std::uint32_t>(shape.points.size());
  for (const Triangle& t : shape.triangles) {
    out.triangles.push_back({t[0], t[2], t[1]});
    out.triangles.push_back({top + t[0], top + t[1], top + t[2]});
  }
  for (const auto& [from, to] : shape.border()) {
    out.triangles.push_back({from, to, top + to});
    out.triangles.push_back({from, top + to, top + from});
  }
  return out;
}

}  // namespace

Expected<Labelled> withLabel(const Mesh& solid, const LabelOptions& label, const Progress& progress) {
  KERF_CHECK(requireRange("height", label.height_mm, 0.5, 100));
  KERF_CHECK(requireRange("depth", label.depth_mm, 0.05, 10));
  KERF_CHECK(requireRange("least wall", label.least_wall_mm, 0, 100));
  KERF_TRY(frame, frameOf(label));
  if (!report(progress, 0, "outlines")) return cancelled();
  KERF_TRY(outlines, internal::glyphOutlines(label.text, label.height_mm, label.align, label.font));
  KERF_TRY(shape, internal::united(outlines));

  Labelled out;
  LabelReport& numbers = out.report;
  const Point2d low = shape.low(), high = shape.high();
  numbers.width_mm = high.x() - low.x();
  numbers.height_mm = high.y() - low.y();
  numbers.area_mm2 = shape.area();
  numbers.least_stroke_mm = shape.leastStroke(label.height_mm);
  if (label.bend_radius_mm != 0 &&
      !(std::abs(label.bend_radius_mm) > std::max(2.0 + label.depth_mm, numbers.width_mm / 3)))
    return fail({.code = Error::Code::kBadValue,
                 .place = "label, bend radius",
                 .found = fmt::format("{} mm for a text {:.1f} mm wide", label.bend_radius_mm, numbers.width_mm),
                 .expected = fmt::format("more than {:.1f} mm", std::max(2.0 + label.depth_mm, numbers.width_mm / 3)),
                 .hint = "a smaller text, or more lines"});

  if (!report(progress, 0.1, "measuring the face")) return cancelled();
  const internal::FaceHeights face = internal::faceHeights(solid, frame, low, high, internal::kLabelDeep);
  KERF_TRY(span, internal::spanOn(face, label, numbers));
  if (frame.radius_mm != 0 || !span.ground.z.empty()) {
    KERF_TRY(fine, internal::united(outlines, kFinest));
    shape = std::move(fine);
  }
  if (numbers.least_stroke_mm < kThinStroke)
    numbers.warnings.push_back(
        fmt::format("The narrowest stroke is {:.2f} mm. Below {} mm letters may not print: make "
                    "the text higher than {:.1f} mm.",
                    numbers.least_stroke_mm, kThinStroke, label.height_mm * kThinStroke / numbers.least_stroke_mm));
  if (numbers.least_depth_mm < kShallow)
    numbers.warnings.push_back(
        fmt::format("The text is {:.2f} mm {} in places. Below {} mm it hardly shows in a print.",
                    numbers.least_depth_mm, label.embossed ? "high" : "deep", kShallow));

  // Letters through vertices of the solid, or float32, may spoil a cut: then it is tried some 0.1 um farther.
  constexpr int kAttempts = 8;
  constexpr double kShift = 0.00013;  // mm
  const double crumb = std::min(0.01, label.post_op.crumb_fraction * signedVolume(solid));
  Error last;
  for (int n = 0; n < kAttempts; ++n) {
    if (!report(progress, 0.2 + 0.8 * n / kAttempts, "cutting the letters")) return cancelled();
    const double by = n * kShift;
    internal::LabelSpan reach = span;
    (label.embossed ? reach.low : reach.high) += label.embossed ? -by : by;
    const Mesh letters = prismOf(shape, frame, reach, {3 * by, 2 * by});
    auto cut = label.embossed ? unite(solid, letters) : subtract(solid, letters);
    if (!cut) {
      last = cut.error();
      continue;
    }
    PostOpReport known;
    known.boolean_triangles = cut->triangles_taken;
    KERF_TRY(done,
             internal::finishCut(solid, std::move(*cut), kCleanupLength, crumb, label.post_op, known, label.embossed));
    last = internal::labelError(done.why_not, "a printable mesh",
                                "move it by some hundredths of a millimetre, or kerf check on the solid");
    if (!done.why_not.empty()) continue;
    out.part = std::move(done.result);
    out.part.report.attempts = numbers.attempts = n + 1;
    numbers.volume_mm3 = std::abs(out.part.report.source_volume_mm3 - out.part.report.result_volume_mm3);
    return out;
  }
  return fail(last);
}

Expected<std::string> withPlaceholders(std::string_view text, const std::map<std::string, std::string>& values) {
  std::string out;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c != '{' && c != '}') {
      out += c;
      continue;
    }
    if (at + 1 < text.size() && text[at + 1] == c) {
      out += c;
      ++at;
      continue;
    }
    const std::size_t end = c == '{' ? text.find('}', at) : std::string_view::npos;
    if (end == std::string_view::npos)
      return fail({.code = Error::Code::kBadValue,
                   .place = fmt::format("label text, byte {}", at),
                   .found = fmt::format("a single {}", c),
                   .expected = "{name}",
                   .hint = "{{ and }} for braces"});
    const std::string name(text.substr(at + 1, end - at - 1));
    const auto value = values.find(name);
    if (value == values.end()) {
      std::string known;
      for (const auto& [other, ignored] : values) known += (known.empty() ? "{" : ", {") + other + "}";
      return fail({.code = Error::Code::kBadValue,
                   .place = fmt::format("label text, byte {}", at),
                   .found = fmt::format("{{{}}}", printable(name)),
                   .expected = known.empty() ? "no placeholder" : "one of " + known,
                   .hint = "{{ and }} for braces"});
    }
    out += value->second;
    at = end;
  }
  return out;
}

}  // namespace kerf
