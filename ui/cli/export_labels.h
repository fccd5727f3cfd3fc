// kerf export RUN|CASE -o NAME.seg.nrrd.
#pragma once

#include <string>
#include <vector>

namespace kerf::cli {

struct LabelExport {
  std::string bundle;
  std::vector<std::string> outputs;  ///< checked: writable, free
  std::string grid;                  ///< "scan", "case" or empty: of the scan if it was a volume
  std::size_t beside = 0;
  bool json = false;
};

/// Writes the segmentations, and prints their volumes beside those of the ledger.   @return  exit code.
int exportLabels(const LabelExport& wanted);

}  // namespace kerf::cli
