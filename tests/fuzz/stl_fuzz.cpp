#include "tests/fuzz/mesh_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kerf::fuzz::readMeshBytes(".stl", data, size);
  return 0;
}

// One mutation in a hundred keeps the count of a binary STL consistent with its size. Every second input gets a valid
// count.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) __attribute__((weak));
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  constexpr std::size_t kHeader = 84, kTriangle = 50;
  size = LLVMFuzzerMutate(data, size, most);
  if (seed % 2 == 0 || size < kHeader) return size;
  const std::size_t count = (size - kHeader) / kTriangle;
  for (std::size_t i = 0; i < 4; ++i) data[80 + i] = static_cast<std::uint8_t>(count >> (8 * i));
  return kHeader + kTriangle * count;
}
