// The package: any bytes as a zip archive. Its checksums keep most mutations from the XML, which three_mf_model covers.
#include "tests/fuzz/mesh_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kerf::fuzz::readMeshBytes(".3mf", data, size);
  return 0;
}
