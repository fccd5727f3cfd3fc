// Structures of an object to keep, its pulp and nerve canals: their place as loaded, and a tool's distance to them.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/monitor/keep_out.h"

namespace kerf {

/// Samples of a tool. A taper of 8 mm then has one every 0.18 mm. Between two samples the tool is nearer to a flat
/// surface by 0.02 mm. Reading takes 6 us.
inline constexpr int kToolSamples = 1600;

/// Never changes once made; any thread may read.
class Structures {
 public:
  struct Structure {
    Material material = Material::kNone;
    std::string id;                        ///< "pulp", "nerve_canal"
    std::shared_ptr<const KeepOut> field;  ///< object frame
  };

  /// The object's structures; none is no error.   Errors: those of KeepOut::make(), but kNotFound; kCancelled.
  /// @cost  seconds for a mandible's canals; at most 200 MB for each structure.
  static Expected<std::shared_ptr<const Structures>> of(const BakedObject& object, const Progress& progress = {});

  bool isEmpty() const { return all_.empty(); }
  std::span<const Structure> all() const { return all_; }

  struct Nearest {
    std::size_t structure = 0;  ///< of all()
    KeepOut::Reading reading;
  };
  /// The structure nearest to a tool.   @pre samples are not empty, nor is this.   @rt safe.   @cost  below 20 us a
  /// structure.
  Nearest nearest(const ToolSamples& samples, const Rigid3& T_object_tool) const noexcept;
  /// Least distance of a point of the object's frame, mm: reach() if that far or farther.   @rt safe.
  double distance(const Vec3d& p) const noexcept;
  /// Largest measured distance, mm: 5, or 200 voxels if these are small.
  double reach() const noexcept { return reach_; }

 private:
  Structures() = default;
  std::vector<Structure> all_;
  double reach_ = 0;
};

/// The default reach of a keep-out field, or the nearest value that this voxel allows.
KeepOutOptions keepOutReach(double voxel);

}  // namespace kerf
