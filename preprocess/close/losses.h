// What a scan loses when it is closed: vertices that are gone, and holes right through that it did not have.
#pragma once

#include <vector>

#include "geometry/mesh/mesh.h"
#include "preprocess/close/close.h"

namespace kerf::internal {

/// By x, then y, then z.
bool lessPlace(const Vec3d& p, const Vec3d& q);

/// Places of source vertices, float32, that have no vertex of the solid; sorted by lessPlace(). A place is one as
/// weldPlace() has it: what was welded is there.
std::vector<Vec3d> lostPlaces(const Mesh& imported, const Mesh& solid);

/// Places that lie together, each within `reach_mm` of another of its heap; the largest heap first.
/// @param places  sorted by x. More than 20 000 are not sorted into heaps: none then.   @cost  O(n^2) at worst, 0.2 s.
std::vector<LostPlace> heapsOf(const std::vector<Vec3d>& places, double reach_mm);

/// Handles of a surface without boundary: pieces less half the Euler characteristic. Of an open one: as if each of its
/// boundaries were closed by a disc.
int handlesOf(const Mesh& mesh);

/// Counts what is lost, and says what a base cost.
/// @param handles_before  of the scan.   @param scale  below 1 on objects smaller than dental ones.
void reportLosses(const Mesh& imported, const Mesh& solid, int handles_before, double scale, CloseReport& report);

}  // namespace kerf::internal
