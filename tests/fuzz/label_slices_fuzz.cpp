// Folders of slices: DICOM and pictures. The first byte selects the format and the options of the reader. The library
// crashes on some files. The reader first tries them in a separate process, which this harness tests.
#include "tests/fuzz/volume_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using kerf::fuzz::ScratchFile;
  static const ScratchFile files[] = {ScratchFile("a.dcm"), ScratchFile("a.png"), ScratchFile("a.tif"),
                                      ScratchFile("a.bmp")};
  if (size == 0) return 0;
  const ScratchFile& file = files[data[0] % 4];
  file.fill(data + 1, size - 1);
  kerf::fuzz::readVolume(file.folder(), data[0] / 4 % 3);
  return 0;
}
