// Sentences about a finished cut: what the author of the path hardly intended, and what limits the result.
#pragma once

#include <string>
#include <vector>

#include "geometry/tool/tool.h"
#include "sim/run/cut/haptic_cut.h"
#include "sim/run/files/run_manifest.h"

namespace kerf {

struct CutRemark {
  bool is_warning = true;  ///< else a note
  std::string text;        ///< without its full stop
};

/// Of the run that a cut continues: pieces not found, filling counted otherwise.
std::vector<std::string> warningsOf(const RunManifest& cut);

/// Of a cut by geometry only, in the order of their weight for the reader. Neighbours are not among them.
/// @param cut  returned by cutCase(), not read from a file: half of it is not stored.   @param tool  as used.
std::vector<CutRemark> remarksOf(const RunManifest& cut, const Tool& tool);

/// The same of a cut against resistance.   @param options  as given to cutCaseByHand().
std::vector<CutRemark> remarksOf(const HapticCut& cut, const HapticCutOptions& options, const Tool& tool);

}  // namespace kerf
