#include "ui/app/tool/tool_look.h"

#include <algorithm>
#include <cmath>

#include "geometry/tool/tool.h"

namespace kerf {

ToolLook lookOf(const Tool& tool) {
  constexpr double kTolerance = 0.02;  // mm
  ToolLook look;
  look.mesh = toolMesh(tool, kTolerance);
  look.cutting = tool.cut->bounds();
  look.approach = tool.plunge_direction;
  look.distance = [cut = tool.cut](const Vec3d& p) { return cut->distance(p); };
  return look;
}

ToolTable toolTable(const ToolLook& look) {
  ToolTable out;
  Vec3d backwards = -look.approach;
  if (!backwards.allFinite() || backwards.norm() < 1e-6) backwards = Vec3d::UnitZ();
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(backwards, Vec3d::UnitZ());
  out.approach_from_tool = turn.toRotationMatrix();

  const Box3 box = look.cutting.isEmpty() ? bounds(look.mesh) : look.cutting;
  out.cutting = box.transformed(turn);
  out.box = out.cutting;
  out.box.grow(ToolTable::kMargin);
  const Vec3d size = out.cutting.size();
  out.is_round = std::abs(size[0] - size[1]) < 0.02 * size[0];

  constexpr int kSide = ToolTable::kSide;
  out.distances.reserve(kSide * kSide * kSide);
  const Vec3d cell = out.box.size() / kSide;
  for (int k = 0; k < kSide; ++k)
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const Vec3d p = turn.conjugate() * (out.box.min + cell.cwiseProduct(Vec3d(i + 0.5, j + 0.5, k + 0.5)));
        const Vec3d outwards = (box.min - p).cwiseMax(p - box.max);
        const double to_box = outwards.cwiseMax(0.0).norm() + std::min(outwards.maxCoeff(), 0.0);
        out.distances.push_back(static_cast<float>(look.distance ? look.distance(p) : to_box));
      }
  return out;
}

}  // namespace kerf
