// Losses of a scan by closing: missing vertices, and new through-holes.
#pragma once

#include <vector>

#include "geometry/mesh/mesh.h"
#include "preprocess/close/close.h"

namespace kerf::internal {

/// By x, then y, then z.
bool lessPlace(const Vec3d& p, const Vec3d& q);

/// Places of source vertices, float32, without a vertex of the solid; sorted by lessPlace(). weldPlace() defines a
/// place, so welded vertices are not lost.
std::vector<Vec3d> lostPlaces(const Mesh& imported, const Mesh& solid);

/// Groups of places, each place within `reach_mm` of another of its group; the largest group first.
/// @param places  sorted by x. Above 20 000 places the result is empty.   @cost  O(n^2) at worst, 0.2 s.
std::vector<LostPlace> heapsOf(const std::vector<Vec3d>& places, double reach_mm);

/// Handles of a surface without boundary: pieces less half the Euler characteristic. For an open surface: as if a disc
/// closed each of its boundaries.
int handlesOf(const Mesh& mesh);

/// Counts the losses, and reports those caused by a base.
/// @param handles_before  of the scan.   @param scale  below 1 on objects smaller than dental ones.
void reportLosses(const Mesh& imported, const Mesh& solid, int handles_before, double scale, CloseReport& report);

}  // namespace kerf::internal
