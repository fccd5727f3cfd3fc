// What of an object must be kept: its pulp, its nerve canals. Where they are as loaded, and how far a tool is from
// them.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/monitor/keep_out.h"

namespace kerf {

/// Of a tool. A taper of 8 mm then has a sample every 0.18 mm; between two of them it is nearer to something flat by
/// 0.02 mm. It takes 6 us to read.
inline constexpr int kToolSamples = 1600;

/// Never changes once made; reading is safe from any thread.
class Structures {
 public:
  struct Structure {
    Material material = Material::kNone;
    std::string id;                        ///< "pulp", "nerve_canal"
    std::shared_ptr<const KeepOut> field;  ///< object frame
  };

  /// Those that the object has; none is no error.   Errors: those of KeepOut::make(), but kNotFound;
  /// kCancelled.
  /// @cost  seconds for a mandible's canals; at most 200 MB for each structure.
  static Expected<std::shared_ptr<const Structures>> of(const BakedObject& object, const Progress& progress = {});

  bool isEmpty() const { return all_.empty(); }
  std::span<const Structure> all() const { return all_; }

  struct Nearest {
    std::size_t structure = 0;  ///< of all()
    KeepOut::Reading reading;
  };
  /// To a tool.   @pre samples are not empty, nor is this.   @rt safe.   @cost  below 20 us a structure.
  Nearest nearest(const ToolSamples& samples, const Rigid3& T_object_tool) const noexcept;
  /// Of a point of the object's frame, mm: reach() if all is that far or farther.   @rt safe.
  double distance(const Vec3d& p) const noexcept;
  /// What lies farther away is not measured, mm: 5, or 200 voxels if these are small.
  double reach() const noexcept { return reach_; }

 private:
  Structures() = default;
  std::vector<Structure> all_;
  double reach_ = 0;
};

/// The default reach of a keep-out field, or the nearest to it that this voxel allows.
KeepOutOptions keepOutReach(double voxel);

}  // namespace kerf
