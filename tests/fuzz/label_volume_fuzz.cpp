// Volumes in one file. The first byte selects the format and the options of the reader.
#include "tests/fuzz/volume_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using kerf::fuzz::ScratchFile;
  static const ScratchFile files[] = {ScratchFile("a.nrrd"), ScratchFile("a.nii"), ScratchFile("a.mha"),
                                      ScratchFile("a.nii.gz")};
  if (size == 0) return 0;
  const ScratchFile& file = files[data[0] % 4];
  file.fill(data + 1, size - 1);
  kerf::fuzz::readVolume(file.path(), data[0] / 4 % 3);
  return 0;
}
