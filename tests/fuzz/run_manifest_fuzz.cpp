#include "sim/run/files/run_manifest.h"
#include "tests/fuzz/file_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  static const fuzz::ScratchFile file(kRunManifest);
  file.fill(data, size);
  const Expected<RunManifest> manifest = readRunManifest(file.folder());
  if (!manifest) {
    fuzz::requireError(manifest.error());
    return 0;
  }
  fuzz::require(manifest->voxel_mm >= 0.001 && manifest->voxel_mm <= 100, "a voxel size in range");
  fuzz::require(manifest->path_file.find('/') == std::string::npos, "the path file is one of the run's own");
  return 0;
}
