#include "ui/app/tissue_display.h"

namespace kerf {

void TissueDisplay::opened(const LiveRun& run, const MaterialTable& materials) {
  opened_ = {TissueLabels::of(run.object()), TissuePalette(materials)};
}

void TissueDisplay::closing() { opened_.reset(); }

TissueSection TissueDisplay::sectionAt(const Plane& plane) const {
  return opened_ ? tissueSection(plane, opened_->labels, opened_->palette) : TissueSection{};
}

}  // namespace kerf
