#include "tests/fuzz/mesh_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kerf::fuzz::readMeshBytes("input.obj", kerf::internal::isObj, kerf::internal::readObj, data, size);
  return 0;
}
