#include "geometry/case/case_bundle.h"
#include "tests/fuzz/file_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  static const fuzz::ScratchFile file(kCaseManifest);
  file.fill(data, size);
  const Expected<CaseManifest> manifest = readCaseManifest(file.folder());
  if (!manifest)
    fuzz::requireError(manifest.error());
  else
    fuzz::require(manifest->voxel_mm >= 0.001 && manifest->voxel_mm <= 100, "a voxel size in range");
  return 0;
}
