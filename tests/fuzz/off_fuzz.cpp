#include "tests/fuzz/mesh_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kerf::fuzz::readMeshBytes(".off", data, size);
  return 0;
}
