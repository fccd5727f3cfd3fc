#include "ui/app/view/piece_gizmo.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr int kOnRing = 48;
constexpr double kLeastOnScreen = 0.1;  // least visible share of an arrow's length

double distanceToLine(const Pixel& at, const Pixel& a, const Pixel& b) {
  const Pixel along = b - a;
  const double length = along.squaredNorm();
  const double part = length > 0 ? std::clamp((at - a).dot(along) / length, 0.0, 1.0) : 0;
  return (at - a - part * along).norm();
}

GizmoHandle moveAlong(int axis) { return static_cast<GizmoHandle>(axis); }
GizmoHandle turnAbout(int axis) { return static_cast<GizmoHandle>(3 + axis); }

}  // namespace

PieceGizmo::PieceGizmo(const Camera& camera, int width, int height, const Vec3d& center)
    : camera_(camera),
      middle_(0.5 * width, 0.5 * height),
      mm_per_pixel_(camera.mmPerPixelAt(center, height)),
      center_(center) {}

Pixel PieceGizmo::flat(const Vec3d& direction) const {
  return Pixel(camera_.right().dot(direction), -camera_.up().dot(direction)) / mm_per_pixel_;
}

double PieceGizmo::growth(const Vec3d& direction) const {
  if (!camera_.isPerspective()) return 0;
  return camera_.backwards().dot(direction) / (camera_.shrinkAt(center_) * camera_.eyeDistance());
}

Pixel PieceGizmo::onScreen(const Vec3d& direction) const {
  return flat(direction) + growth(direction) * (center() - middle_);
}

Pixel PieceGizmo::center() const { return middle_ + flat(center_ - camera_.target); }

double PieceGizmo::alongAxis(const Vec3d& direction, const Pixel& by) const {
  const Pixel along = onScreen(direction);
  const double length = along.norm();
  if (!(length > 0)) return 0;
  // Seen from the centre, a point s mm along the axis is s length / (1 - s growth) pixels off.
  constexpr double kHorizon = 0.1;
  const double pixels = by.dot(along) / length;
  return pixels / std::max(length + pixels * growth(direction), kHorizon * length);
}

Pixel PieceGizmo::arrowTip(int axis) const { return center() + kArrow * mm_per_pixel_ * onScreen(Vec3d::Unit(axis)); }

std::vector<Pixel> PieceGizmo::ring(int axis) const {
  const Vec3d across = Vec3d::Unit((axis + 1) % 3), along = Vec3d::Unit((axis + 2) % 3);
  std::vector<Pixel> out;
  for (int n = 0; n < kOnRing; ++n) {
    const double angle = 2 * std::numbers::pi * n / kOnRing;
    out.push_back(center() + kRing * mm_per_pixel_ * onScreen(std::cos(angle) * across + std::sin(angle) * along));
  }
  return out;
}

std::optional<GizmoHandle> PieceGizmo::handleAt(const Pixel& at) const {
  if ((at - center()).norm() <= kDisc + 2) return GizmoHandle::kMoveInView;
  std::optional<GizmoHandle> best;
  double least = kReach;
  const auto offer = [&](GizmoHandle handle, double distance) {
    if (distance >= least) return;
    least = distance;
    best = handle;
  };

  for (int axis = 0; axis < 3; ++axis) {
    const Pixel tip = arrowTip(axis);
    if ((tip - center()).norm() < kLeastOnScreen * kArrow) continue;
    offer(moveAlong(axis), distanceToLine(at, center() + 0.2 * (tip - center()), tip));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<Pixel> points = ring(axis);
    for (std::size_t n = 0; n < points.size(); ++n)
      offer(turnAbout(axis), distanceToLine(at, points[n], points[(n + 1) % points.size()]));
  }
  return best;
}

Rigid3 PieceGizmo::dragged(GizmoHandle handle, const Pixel& from, const Pixel& to, const Rigid3& pose) const {
  const Pixel by = to - from;
  const int number = static_cast<int>(handle);
  Rigid3 out = pose;
  if (handle == GizmoHandle::kMoveInView) {
    out.translation += mm_per_pixel_ * (by[0] * camera_.right() - by[1] * camera_.up());
    return out;
  }
  if (number < 3) {
    // The centre follows the cursor's motion, wherever the arrow was grabbed.
    out.translation += alongAxis(Vec3d::Unit(number), by) * Vec3d::Unit(number);
    return out;
  }

  // Along the tangent of the ring at the grabbed place.
  const int axis = number - 3;
  const std::vector<Pixel> points = ring(axis);
  std::size_t nearest = 0;
  for (std::size_t n = 1; n < points.size(); ++n)
    if ((points[n] - from).norm() < (points[nearest] - from).norm()) nearest = n;
  const Pixel tangent = points[(nearest + 1) % points.size()] - points[(nearest + points.size() - 1) % points.size()];
  const double per_step = 4 * std::numbers::pi / kOnRing;  // radians, over the two steps of the ring
  if (!(tangent.squaredNorm() > 1e-6)) return out;
  const double angle = per_step * by.dot(tangent) / tangent.squaredNorm();

  const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3d::Unit(axis))), Vec3d::Zero()};
  const Rigid3 to_center{Eigen::Quaterniond::Identity(), -center_}, back{Eigen::Quaterniond::Identity(), center_};
  return back * turn * to_center * pose;
}

}  // namespace kerf
