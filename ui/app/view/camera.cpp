#include "ui/app/view/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// The whole of `text` as a finite number.
bool parseNumber(std::string_view text, double& value) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

}  // namespace

Vec3d Camera::right() const {
  const Vec3d level = upright.transpose() * Vec3d(std::cos(azimuth), std::sin(azimuth), 0);
  if (roll == 0) return level;
  return std::cos(roll) * level + std::sin(roll) * backwards().cross(level);
}
Vec3d Camera::backwards() const {
  return upright.transpose() *
         Vec3d(std::sin(azimuth) * std::cos(elevation), -std::cos(azimuth) * std::cos(elevation), std::sin(elevation));
}
Vec3d Camera::up() const { return backwards().cross(right()); }

Eigen::Matrix3d Camera::rotation() const {
  Eigen::Matrix3d m;
  m << right().transpose(), up().transpose(), backwards().transpose();
  return m;
}

double Camera::shrinkAt(const Vec3d& point) const {
  if (!isPerspective()) return 1;
  return std::max(1 - backwards().dot(point - target) / eyeDistance(), kNearest);
}

Vec3d Camera::towardsViewer(const Vec3d& point) const {
  if (!isPerspective()) return backwards();
  const Vec3d eye = target + eyeDistance() * backwards();
  return (eye - point).norm() > 1e-9 ? Vec3d((eye - point).normalized()) : backwards();
}

const std::vector<NamedView>& namedViews() {
  static const std::vector<NamedView> views = {{"front", 0, 0}, {"back", 180, 0},   {"left", -90, 0}, {"right", 90, 0},
                                               {"top", 0, 90},  {"bottom", 0, -90}, {"iso", 35, 35}};
  return views;
}

Expected<Camera> cameraFromView(std::string_view view) {
  Camera camera;
  if (view == "occlusal") view = "top";
  for (const NamedView& v : namedViews())
    if (v.name == view) {
      camera.azimuth = v.azimuth_deg * kDegree;
      camera.elevation = v.elevation_deg * kDegree;
      return camera;
    }

  double azimuth = 0, elevation = 0;
  const std::size_t comma = view.find(',');
  if (comma != std::string_view::npos && parseNumber(view.substr(0, comma), azimuth) &&
      parseNumber(view.substr(comma + 1), elevation) && std::abs(elevation) <= 90) {
    camera.azimuth = std::remainder(azimuth, 360.0) * kDegree;
    camera.elevation = elevation * kDegree;
    return camera;
  }

  std::string names;
  for (const NamedView& v : namedViews()) names += std::string(v.name) + ", ";
  return fail({.code = Error::Code::kBadValue,
               .file = {},
               .place = "--view",
               .found = "\"" + std::string(view) + "\"",
               .expected = "one of " + names + "occlusal (= top), or AZ,EL in degrees with EL from -90 to 90",
               .hint = "--view iso, or --view 35,20"});
}

Eigen::Matrix3d uprightFrame(const Vec3d& up) {
  int axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  const Vec3d z = (up[axis] < 0 ? -1.0 : 1.0) * Vec3d::Unit(axis);
  Eigen::Matrix3d m;
  if (axis == 0)
    m << Vec3d::UnitY().cross(z).transpose(), Vec3d::UnitY().transpose(), z.transpose();
  else
    m << Vec3d::UnitX().transpose(), z.cross(Vec3d::UnitX()).transpose(), z.transpose();
  return m;
}

Expected<Vec3d> axisFromName(std::string_view name) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const Vec3d direction = sign * Vec3d::Unit(axis);
      const std::string full = nameOfAxis(direction);
      if (name == full || (sign > 0 && name == full.substr(1))) return direction;
    }
  return fail({.code = Error::Code::kBadValue,
               .file = {},
               .place = {},
               .found = "\"" + std::string(name) + "\"",
               .expected = "one of +x, -x, +y, -y, +z, -z",
               .hint = "+z"});
}

std::string nameOfAxis(const Vec3d& direction) {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return {direction[axis] < 0 ? '-' : '+', "xyz"[axis]};
}

void lookFrom(Camera& camera, const Vec3d& direction) {
  const Vec3d d = camera.upright * direction.normalized();
  constexpr double kStraight = 0.999;
  camera.elevation = std::asin(std::clamp(d.z(), -1.0, 1.0));
  camera.azimuth = std::abs(d.z()) > kStraight ? 0 : std::atan2(d.x(), -d.y());
}

void lookFrom(Camera& camera, const Vec3d& direction, const Vec3d& up) {
  const Vec3d d = camera.upright * direction.normalized();
  camera.elevation = std::asin(std::clamp(d.z(), -1.0, 1.0));
  camera.azimuth = std::hypot(d.x(), d.y()) > 1e-9 ? std::atan2(d.x(), -d.y()) : 0;
  camera.roll = 0;

  const Vec3d level = camera.right(), right = up.cross(camera.backwards());
  const double roll = std::atan2(right.dot(camera.backwards().cross(level)), right.dot(level));
  constexpr double kLevel = 1e-9;  // rad: below it is rounding
  if (std::abs(roll) > kLevel) camera.roll = roll;
}

void fitTo(Camera& camera, const Mesh& mesh, int width, int height, double margin) {
  camera.half_height = 5;
  if (mesh.vertices.empty()) {
    camera.target = Vec3d::Zero();
    return;
  }

  const Eigen::Matrix3d to_view = camera.rotation();
  Box3 box;
  for (const Vec3d& p : mesh.vertices) box.add(Vec3d(to_view * p));
  camera.target = to_view.transpose() * box.center();
  const double half_width = 0.5 * box.size().x(), half_height = 0.5 * box.size().y();
  double needed = std::max(half_height, half_width * height / width) / (1 - 2 * margin);
  if (camera.isPerspective()) {
    // At z in front of the target the visible half height is half_height - z tan(field / 2).
    const double slope = std::tan(0.5 * camera.field_of_view);
    needed = 0;
    for (const Vec3d& p : mesh.vertices) {
      const Vec3d q = to_view * (p - camera.target);
      const double off = std::max(std::abs(q.y()), std::abs(q.x()) * height / width) / (1 - 2 * margin);
      needed = std::max(needed, off + slope * q.z());
    }
  }
  if (needed > 0) camera.half_height = needed;
}

void orbit(Camera& camera, double dx, double dy) {
  if (camera.roll != 0) {
    const double c = std::cos(camera.roll), s = std::sin(camera.roll), level = c * dx + s * dy;
    dy = c * dy - s * dx;
    dx = level;
  }
  camera.azimuth = std::remainder(camera.azimuth - 0.5 * kDegree * dx, 2 * std::numbers::pi);
  camera.elevation = std::clamp(camera.elevation + 0.5 * kDegree * dy, -90 * kDegree, 90 * kDegree);
}

void pan(Camera& camera, double dx, double dy, int height) {
  camera.target += camera.mmPerPixel(height) * (dy * camera.up() - dx * camera.right());
}

void zoomBy(Camera& camera, double factor) { camera.half_height = std::clamp(camera.half_height / factor, 1e-4, 1e6); }

void setFieldOfView(Camera& camera, double angle) {
  constexpr double kLeast = Camera::kLeastField * kDegree, kMost = Camera::kMostField * kDegree;
  camera.field_of_view = angle > 0 ? std::clamp(angle, kLeast, kMost) : 0;
}

void focusOn(Camera& camera, const Vec3d& point) {
  if (!camera.isPerspective()) return;
  const double shrink = camera.shrinkAt(point);
  camera.target += (1 - shrink) * camera.eyeDistance() * camera.backwards();
  camera.half_height *= shrink;
}

double scaleBarLength(double mm_per_pixel, int width) {
  const double most = 0.25 * mm_per_pixel * width;
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double step : {5.0, 2.0})
    if (step * power <= most) return step * power;
  return power;
}

}  // namespace kerf
