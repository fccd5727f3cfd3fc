// Folders of slices: DICOM and pictures. The first byte says which, and with what the reader is helped. The library
// that reads them crashes on some files: the reader tries them in a process of its own first, which is what is tested.
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
