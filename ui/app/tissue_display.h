// What a person sees of the tissues of what is open: their colours in a section.
#pragma once

#include <optional>

#include "geometry/field/material.h"
#include "sim/live/tissue_section.h"
#include "sim/run/live_run.h"

namespace kerf {

/// One thread, the window's.
class TissueDisplay {
 public:
  /// @param run  must not end before closing().
  void opened(const LiveRun& run, const MaterialTable& materials);
  void closing();

  /// What objects are made of in a plane of their own frame, as loaded. Empty: nothing is open.
  /// @cost  as tissueSection(): once for each plane, not each frame.
  TissueSection sectionAt(const Plane& plane) const;

 private:
  struct Opened {
    TissueLabels labels;
    TissuePalette palette;
  };
  std::optional<Opened> opened_;
};

}  // namespace kerf
