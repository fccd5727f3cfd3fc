#include "sim/monitor/contact_area.h"

#include <array>
#include <cmath>

#include "sim/step/step.h"

namespace kerf {
namespace {

// Outward, unit; zero on a ridge.
Vec3f normalOf(const ToolField& field, const Vec3f& p) {
  constexpr float kStep = 0.02f;
  Vec3f gradient;
  for (int c = 0; c < 3; ++c) {
    const Vec3f step = kStep * Vec3f::Unit(c);
    gradient[c] = field.distance(p + step) - field.distance(p - step);
  }
  return gradient.norm() > 0.2f * kStep ? gradient.normalized() : Vec3f(Vec3f::Zero());
}

}  // namespace

ContactArea::ContactArea(const ToolModel& tool, const ToolSamples& samples, const Vec3d& flank) {
  constexpr float kInBody = -0.005f;  // mm: distance of samples from the surface
  const float steep = std::sqrt(0.5f);
  const auto isFront = [&](const Vec3f& normal) {
    if (std::abs(normal.dot(flank.cast<float>())) > steep) return false;
    return tool.motion == ToolMotion::kSpin || normal.dot(tool.plunge_direction.cast<float>()) > -steep;
  };
  for (std::size_t n = 0; n < samples.points().size(); ++n) {
    const Vec3f& p = samples.points()[n];
    if (!tool.body.isEmpty() && tool.body.distance(p) < kInBody) continue;
    if (!flank.isZero() && !isFront(normalOf(tool.cut, p))) continue;
    samples_.push_back({p, samples.areas()[n]});
    whole_ += static_cast<double>(samples.areas()[n]);
  }
}

ContactArea::Reading ContactArea::read(std::span<const CutObject> objects, std::uint64_t touched,
                                       const Rigid3& T_world_tool) noexcept {
  std::array<Rigid3, kMostObjects> to_object;
  std::array<const CutObject*, kMostObjects> object;
  std::size_t count = 0;
  for (std::size_t n = 0; n < objects.size() && n < kMostObjects; ++n) {
    if (!(touched & objectBit(n))) continue;
    to_object[count] = objects[n].T_world_object.inverse() * T_world_tool;
    object[count++] = &objects[n];
  }

  // Rotations as matrices: a quaternion takes three times as long.
  float looked_at = 0, close = 0;
  Vec3f middle = Vec3f::Zero();
  std::array<Eigen::Matrix3d, kMostObjects> rotation;
  for (std::size_t n = 0; n < count; ++n) rotation[n] = to_object[n].rotation.toRotationMatrix();
  for (std::size_t s = turn_; s < samples_.size(); s += kTurn) {
    const Sample& sample = samples_[s];
    looked_at += sample.area;
    for (std::size_t n = 0; n < count; ++n) {
      const Vec3d p = rotation[n] * sample.at.cast<double>() + to_object[n].translation;
      if (!(distanceIn(*object[n], p) < static_cast<float>(kClose))) continue;
      close += sample.area;
      middle += sample.area * sample.at;
      break;
    }
  }
  turn_ = (turn_ + 1) % kTurn;

  Reading out;
  if (!(close > 0)) return out;
  // Each tick's samples represent the same share of the surface.
  out.area = static_cast<double>(close / looked_at) * whole_;
  out.middle = (middle / close).cast<double>();
  return out;
}

float distanceIn(const CutObject& object, const Vec3d& p) noexcept {
  const float air = object.baked().phi0().background();
  const Vec3d u = p / object.voxel();
  if (!(u.cwiseAbs().maxCoeff() < 1e9)) return air;  // not finite, too
  const Vec3d floor = u.array().floor();
  const Vec3i node = floor.cast<int>();
  const Vec3f part = (u - floor).cast<float>();

  const auto valueAt = [&](const float* phi, const Vec3i& at) {
    return phi[static_cast<std::size_t>(nodeOffset(at[0], at[1], at[2]))];
  };
  float value[8];
  const Vec3i brick = brickOf(node);
  if (brick == brickOf(node + Vec3i::Ones())) {
    const int slot = object.find(brick);
    if (slot < 0) return air;
    const float* phi = object.slot(slot).phi;
    for (int c = 0; c < 8; ++c) value[c] = valueAt(phi, node + Vec3i(c >> 2, c >> 1 & 1, c & 1));
  } else {
    for (int c = 0; c < 8; ++c) {
      const Vec3i at = node + Vec3i(c >> 2, c >> 1 & 1, c & 1);
      const int slot = object.find(brickOf(at));
      value[c] = slot < 0 ? air : valueAt(object.slot(slot).phi, at);
    }
  }

  const auto along = [](float a, float b, float s) { return a + s * (b - a); };
  const float low = along(along(value[0], value[1], part[2]), along(value[2], value[3], part[2]), part[1]);
  const float high = along(along(value[4], value[5], part[2]), along(value[6], value[7], part[2]), part[1]);
  return along(low, high, part[0]);
}

}  // namespace kerf
