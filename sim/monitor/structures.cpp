#include "sim/monitor/structures.h"

#include <algorithm>
#include <array>

namespace kerf {

KeepOutOptions keepOutReach(double voxel) {
  KeepOutOptions out;
  out.most_distance = std::clamp(out.most_distance, 2 * voxel, KeepOut::kMostVoxels * voxel);
  out.most_depth = std::max(out.most_depth, 2 * voxel);
  return out;
}

Expected<std::shared_ptr<const Structures>> Structures::of(const BakedObject& object, const Progress& progress) {
  const std::shared_ptr<Structures> out(new Structures);
  const KeepOutOptions options = keepOutReach(object.voxel());
  // As float, like the fields: their value for a far place is then not below the reach.
  out->reach_ = static_cast<double>(static_cast<float>(options.most_distance));
  for (const auto& [material, id] :
       {std::pair(Material::kPulp, "pulp"), std::pair(Material::kNerveCanal, "nerve_canal")}) {
    auto field = KeepOut::make(object, std::array{material}, options, progress);
    if (!field && field.error().code == Error::Code::kNotFound) continue;
    if (!field) return fail(field.error());
    out->all_.push_back({material, id, std::move(*field)});
  }
  return out;
}

Structures::Nearest Structures::nearest(const ToolSamples& samples, const Rigid3& T_object_tool) const noexcept {
  Nearest out;
  for (std::size_t n = 0; n < all_.size(); ++n) {
    const KeepOut::Reading reading = all_[n].field->read(samples, T_object_tool);
    if (n == 0 || reading.distance < out.reading.distance) out = {n, reading};
  }
  return out;
}

double Structures::distance(const Vec3d& p) const noexcept {
  double out = reach_;
  for (const Structure& s : all_) out = std::min(out, static_cast<double>(s.field->distance(p.cast<float>())));
  return out;
}

}  // namespace kerf
