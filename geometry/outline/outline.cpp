#include "geometry/outline/outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "geometry/base/text.h"
#include "geometry/formats/mesh_source.h"

namespace kerf {
namespace {

using internal::kJoint;
using Pieces = std::vector<OutlinePiece>;

bool areOne(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).norm() <= kJoint; }
bool isOnAxis(const OutlinePiece& piece) {
  return piece.bulge == 0 && std::abs(piece.from[0]) <= kJoint && std::abs(piece.to[0]) <= kJoint;
}

// Moves pieces from `loose` to the end of the chain as long as one begins or ends there.
void extend(Pieces& chain, Pieces& loose) {
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t n = 0; n < loose.size(); ++n) {
      const Eigen::Vector2d& end = chain.back().to;
      if (!areOne(loose[n].from, end) && !areOne(loose[n].to, end)) continue;
      OutlinePiece next = areOne(loose[n].from, end) ? loose[n] : loose[n].reversed();
      next.from = end;
      chain.push_back(next);
      loose.erase(loose.begin() + static_cast<std::ptrdiff_t>(n));
      grows = true;
      break;
    }
  }
}

void reverse(Pieces& chain) {
  std::reverse(chain.begin(), chain.end());
  for (OutlinePiece& piece : chain) piece = piece.reversed();
}

Expected<std::vector<OutlinePiece>> joined(Pieces loose, const std::string& file) {
  const auto refuse = [&](std::size_t line, std::string found, std::string expected, std::string hint = "") {
    return fail({.code = Error::Code::kBadValue,
                 .file = file,
                 .place = line > 0 ? fmt::format("line {}", line) : "",
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = std::move(hint)});
  };
  std::erase_if(loose,
                [](const OutlinePiece& p) { return (areOne(p.from, p.to) && std::abs(p.bulge) <= 1) || isOnAxis(p); });
  if (loose.empty()) return refuse(0, "no curve", "a curve of lines and arcs");
  for (const OutlinePiece& p : loose)
    if (std::min(p.from[0], p.to[0]) < -kJoint)
      return refuse(p.line, fmt::format("a point at x = {:.4g} mm, beyond the axis", std::min(p.from[0], p.to[0])),
                    "half a profile: x is the distance from the axis, 0 or more",
                    "mirror the drawing, or keep one half");

  Pieces chain{loose.front()};
  loose.erase(loose.begin());
  extend(chain, loose);
  reverse(chain);
  extend(chain, loose);
  if (!loose.empty())
    return refuse(loose[0].line,
                  fmt::format("a piece from ({:.4g}, {:.4g}) to ({:.4g}, {:.4g}) mm that does not join the rest, which "
                              "ends at ({:.4g}, {:.4g})",
                              loose[0].from[0], loose[0].from[1], loose[0].to[0], loose[0].to[1], chain.back().to[0],
                              chain.back().to[1]),
                  "one curve, its pieces end to end within 0.001 mm", "no second curve, no gap, no branch");
  if (areOne(chain.front().from, chain.back().to))
    return refuse(chain.front().line, "a closed curve that has no side on the axis",
                  "half a profile, open or closed along the axis x = 0");

  if (chain.front().from[1] > chain.back().to[1]) reverse(chain);
  const double lowest = chain.front().from[1];
  for (OutlinePiece& piece : chain)
    for (Eigen::Vector2d* p : {&piece.from, &piece.to}) *p = {std::max(0.0, (*p)[0]), (*p)[1] - lowest};
  return chain;
}

}  // namespace

Eigen::Vector2d OutlinePiece::center() const {
  const Eigen::Vector2d chord = to - from, left(-chord[1], chord[0]);
  return 0.5 * (from + to) + (1 - bulge * bulge) / (4 * bulge) * left;
}

Expected<std::vector<OutlinePiece>> readOutline(const std::filesystem::path& file) {
  constexpr std::size_t kMostBytes = std::size_t{16} << 20;
  KERF_TRY(text, readSmallFile(file, kMostBytes));
  internal::MeshSource source{file.string(), std::make_unique<char[]>(text.size()), text.size()};
  std::copy(text.begin(), text.end(), source.bytes.get());
  const bool is_dxf = source.hasExtension(".dxf");
  if (!is_dxf && !source.hasExtension(".svg"))
    return fail({.code = Error::Code::kUnsupported,
                 .file = file.string(),
                 .found = "a file \"" + source.extension() + "\"",
                 .expected = "a drawing: .dxf or .svg"});
  KERF_TRY(pieces, is_dxf ? internal::readDxf(source) : internal::readSvg(source));
  if (pieces.size() > internal::kMostPieces)
    return fail({.code = Error::Code::kUnsupported,
                 .file = file.string(),
                 .found = fmt::format("{} pieces", pieces.size()),
                 .expected = fmt::format("at most {}", internal::kMostPieces),
                 .hint = "arcs in place of curves"});
  for (const OutlinePiece& piece : pieces)
    if (!((piece.from.array().abs() < internal::kFarthest).all() &&
          (piece.to.array().abs() < internal::kFarthest).all() && std::isfinite(piece.bulge)))
      return fail({.code = Error::Code::kBadValue,
                   .file = file.string(),
                   .place = piece.line > 0 ? fmt::format("line {}", piece.line) : "",
                   .found = "a point farther than 10 m from the origin",
                   .expected = "half the profile of a bur, in mm or with its unit"});
  return joined(std::move(pieces), file.string());
}

}  // namespace kerf
