// The surface of selected tissues of an object, for hiding the others. It follows the cut.
//
//   {phi < 0}  and  {the wanted tissues}  =  {max(phi, s) < 0}
//
// s comes from labels, which are yes or no: their share among the nodes around, smoothed by the binomial 1 4 6 4 1
// along each axis, scaled to be a distance where it changes sign. A border between tissues is smooth, and good to about
// half a voxel; parts thinner than two voxels may vanish. At the object's own surface the field is phi, and the surface
// equals Remesher's, vertex by vertex.
#pragma once

#include <bitset>
#include <span>
#include <vector>

#include "sim/live/remesher.h"
#include "sim/object/baked_object.h"

namespace kerf {

/// By material number.
using TissueSet = std::bitset<256>;

/// The field of some tissues of one object.
class TissueField {
 public:
  /// @param object  kept by reference: labels and surface as loaded.
  TissueField(const BakedObject& object, const TissueSet& wanted) : object_(object), wanted_(wanted) {}

  /// max(phi, s) of one brick.   @cost  15 us; 1 us if all nodes around are of one kind.
  BrickValues brick(const Vec3i& at, const BrickValues& phi) const;
  /// The same for a whole field: the object's own, or that of a piece of it. All cores.
  BrickField of(const BrickField& field) const;

 private:
  enum class Around { kWanted, kOther, kBoth };
  Around around(const Vec3i& brick) const;

  const BakedObject& object_;
  TissueSet wanted_;
};

/// Remeshes them where the object has changed. One thread at a time.
class TissueMesher {
 public:
  /// @param object  kept by reference.   @param begin  its field, or that of a piece, before the cut.
  /// @cost  as Remesher, and 15 us for each brick near the surface or a border: 0.5 s for a molar at 0.05 mm.
  TissueMesher(const BakedObject& object, const TissueSet& wanted, const BrickField& begin,
               const RemesherOptions& options = {});

  /// @param changed  all bricks that differ from `begin`, and their values; may include others.
  /// @return  chunks changed since the last call; at the first call all.   @cost  30 us for a changed brick.
  std::vector<MeshChunkPtr> update(const BrickField& changed);

 private:
  TissueField tissues_;
  BrickField begin_;  // of the wanted tissues
  Remesher remesher_;
  BrickField known_;  // `changed` of the last update()
  std::uint64_t told_ = 0;
};

}  // namespace kerf
