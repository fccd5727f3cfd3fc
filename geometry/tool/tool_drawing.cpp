#include "geometry/tool/tool_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "geometry/tool/drawing_sheet.h"

namespace kerf {
namespace {

using internal::Sheet;

// Every triangle from the side, those towards the eye last: the shadow of the solid with its facets.
std::string drawMesh(const Tool& tool) {
  const Mesh& mesh = *tool.mesh;
  Box3 box = bounds(mesh);
  Sheet sheet(box.size()[0], box.max[2], 480, 0);
  sheet.moveTo(60 - sheet.scale() * box.min[0]);

  std::vector<std::size_t> order;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (doubleAreaVector(mesh, t)[1] < 0) order.push_back(t);  // seen from -y
  const auto depth = [&](std::size_t t) { return mesh.corner(t, 0)[1] + mesh.corner(t, 1)[1] + mesh.corner(t, 2)[1]; };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return std::pair(-depth(a), a) < std::pair(-depth(b), b); });

  for (const std::size_t t : order) {
    std::vector<Sheet::Point> outline;
    double highest = 0;
    for (int k = 0; k < 3; ++k) {
      outline.emplace_back(mesh.corner(t, k)[0], mesh.corner(t, k)[2]);
      highest = std::max(highest, mesh.corner(t, k)[2]);
    }
    sheet.polygon(outline, highest <= tool.cut_below_mm + 1e-9 ? Sheet::kCutting : Sheet::kBody,
                  "stroke-opacity=\"0.25\"");
  }

  const double right = sheet.x(box.max[0]) + 24;
  sheet.tall(0, 0, box.max[2], right, internal::mm(box.max[2]));
  sheet.tall(0, 0, tool.cut_below_mm, right + 70, internal::mm(tool.cut_below_mm) + " cuts");
  return sheet.finished(tool, fmt::format("{}, mesh of {} triangles", tool.id, mesh.triangles.size()));
}

std::string drawBur(const Tool& tool) {
  return internal::drawRevolved(tool, fmt::format("{}, {}, cuts with {}", tool.id, tool.shape,
                                                  tool.cuts_side && tool.cuts_end ? "side and end"
                                                  : tool.cuts_end                 ? "its end"
                                                                                  : "its side"));
}

}  // namespace

std::string toolDrawing(const Tool& tool) {
  switch (tool.kind) {
    case ToolKind::kBur:
      return drawBur(tool);
    case ToolKind::kBlade:
      return tool.motion->drawing(tool);
    case ToolKind::kMesh:
      return drawMesh(tool);
  }
  return {};
}

}  // namespace kerf
