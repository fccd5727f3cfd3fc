// Tests whether a mesh is open, by its own triangles before any drop; and drops sheets that make it look open.
#pragma once

#include <vector>

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// A mesh is as good as closed if its open edges together are shorter than this part of its diagonal.
inline constexpr double kHardlyOpen = 0.2;

/// Length of the edges that only one of the triangles uses, mm. A doubled triangle or a sheet inside a solid has none,
/// though both can leave a chain with a boundary.   @cost  that of sorting the edges.
double openLength(const Mesh& mesh, const std::vector<Triangle>& triangles);

/// Drops triangles without which the chain has less boundary: repeated ones, and sheets whose every border edge is
/// shared by three triangles or more. Drops the smaller of two equally suitable sheets, and no sheet with an open edge.
/// Entered in the report.   @cost  that of sorting the edges, a few times.
void dropSheets(Chain& chain, CloseReport& report);

}  // namespace kerf::internal
