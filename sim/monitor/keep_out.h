// Distance of the tool to structures it must not touch: pulp, nerve canal, a neighbouring tooth.
//
// At load, a signed distance field to a structure (the nodes labelled with certain materials) is made from a baked
// object. At each tick the distance is its minimum over points on the tool's cutting part. When the tool touches the
// cut surface, that is also the thickness of tissue left between cut and structure.
//
// Distances are exact Euclidean ones between nodes (lower envelopes of parabolas, one axis after the other:
// Felzenszwalb & Huttenlocher, Theory Comput 2012;8:415), less half a voxel, because a labelled node stands for its
// voxel. Labels are yes or no, so the surface of a structure is known to half a voxel (measured: 0.50 for a canal
// of 1.5 mm, 0.53 for a ball of 1 mm radius at 0.1 mm). Sampling the tool adds up to ToolSamples::spacing(), its
// sagitta where the tool is round.
//
// Only nodes within `most_distance` are stored, in bricks found by a directory; the nerve canals of a mandible at
// 0.1 mm take about 140 MB. Where even that exceeds `most_bytes`, every second, fourth or eighth node is kept:
// distances there are as exact as before, between them they are interpolated.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "geometry/base/progress.h"
#include "sim/object/baked_object.h"
#include "sim/step/tool_model.h"

namespace kerf {

/// Points on the surface of a tool's cutting part, with a hierarchy that lets most of them be skipped.
class ToolSamples {
 public:
  ToolSamples() = default;
  /// @param count  of points, at least 1.   @cost tens of milliseconds: once per tool.
  explicit ToolSamples(const ToolField& cut, int count = 400);

  bool isEmpty() const { return points_.empty(); }
  /// Tool frame, mm, on the surface within 5 um.
  std::span<const Vec3f> points() const { return points_; }
  /// mm^2 of the surface around each of them; together all of it, within a few per cent.
  std::span<const float> areas() const { return areas_; }
  /// No point of the surface is farther from the nearest sample than this, mm.
  double spacing() const { return spacing_; }

  struct Group {
    Vec3f center;
    float radius;  ///< mm
    int begin, end;
  };
  std::span<const Group> groups() const { return groups_; }

 private:
  void group(const std::vector<Vec3f>& chosen, const std::vector<float>& areas, std::size_t most_groups);

  std::vector<Vec3f> points_;
  std::vector<float> areas_;
  std::vector<Group> groups_;
  double spacing_ = 0;
};

struct KeepOutOptions {
  double most_distance = 5;              ///< mm: larger distances count as this. Memory grows with it
  double most_depth = 1;                 ///< mm: larger depths in the structure count as this; at most most_distance
  std::size_t most_bytes = 200'000'000;  ///< of the field; see above
};

/// Never changes once made; any thread may read.
class KeepOut {
 public:
  static constexpr double kMostVoxels = 200;  ///< upper limit of most_distance, in voxels

  /// The nodes of `object` that lie inside it (phi0 <= 0) and are of one of `materials`.
  /// Error kNotFound: there are none; kBadValue: options out of range, or a field that exceeds most_bytes at every
  /// eighth node; kCancelled. Works on all cores. @cost seconds for a mandible.
  static Expected<std::shared_ptr<const KeepOut>> make(const BakedObject& object, std::span<const Material> materials,
                                                       const KeepOutOptions& options = {},
                                                       const Progress& progress = {});

  /// All of `object` as loaded, of any material: a neighbouring tooth. In the band of its baked field (3 voxels
  /// outside, 4 inside) distances are that field's own, good to a twentieth of a voxel at flat places; farther out they
  /// are those between nodes.
  /// @cost  on 2 cores 0.7 s for a molar at 0.1 mm (44 MB), 7 s at 0.05 mm, 14 s for a mandible at 0.1 mm.
  static Expected<std::shared_ptr<const KeepOut>> ofSolid(const BakedObject& object, const KeepOutOptions& options = {},
                                                          const Progress& progress = {});

  /// Signed distance of a point of the object's frame, mm: negative inside, between -most_depth and most_distance.
  /// @rt safe. @cost about 20 ns.
  float distance(const Vec3f& p) const noexcept;

  struct Reading {
    double distance = 0;          ///< mm, negative: in the structure; most_distance: that far or farther
    Vec3d point = Vec3d::Zero();  ///< nearest point of the tool, object frame, mm
    bool is_far = true;           ///< no part of the structure within most_distance
  };
  /// Distance of the tool. @pre samples are not empty.  @rt safe.  @cost below 20 microseconds for 400 samples.
  Reading read(const ToolSamples& samples, const Rigid3& T_object_tool) const noexcept;

  double spacing() const { return spacing_; }  ///< of the stored nodes, mm: the object's voxel or a multiple
  std::size_t bytes() const { return values_.size() * sizeof(float) + directory_.size() * sizeof(std::int32_t); }

 private:
  class Builder;
  KeepOut() = default;
  static Expected<std::shared_ptr<const KeepOut>> build(const BakedObject& object, std::span<const Material> materials,
                                                        const KeepOutOptions& options, const Progress& progress);
  double spacing_ = 0;
  float inverse_ = 0, far_ = 0, deep_ = 0;
  Vec3i low_ = Vec3i::Zero(), size_ = Vec3i::Zero();  // of the directory, in bricks
  std::vector<std::int32_t> directory_;               // brick, kNothing or kDeep; z fastest
  std::vector<float> values_;                         // 9^3 a brick: its last nodes are its neighbours' first
};

}  // namespace kerf
