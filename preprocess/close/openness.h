// Whether a mesh is open, judged by its own triangles before any are dropped; and sheets that make it look so.
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
/// shared by three triangles or more. Of two sheets that would do equally the smaller one goes. Nothing that has an
/// open edge is dropped. Entered in the report.   @cost  that of sorting the edges, a few times.
void dropSheets(Chain& chain, CloseReport& report);

}  // namespace kerf::internal
