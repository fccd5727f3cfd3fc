#include "tests/fuzz/path_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const kerf::fuzz::ScratchFile file("path.csv");
  kerf::fuzz::readPathBytes(file, data, size);
  return 0;
}
