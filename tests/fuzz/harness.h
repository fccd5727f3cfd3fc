// What the fuzz harnesses share. A harness is one source with one LLVMFuzzerTestOneInput: it hands the bytes to one
// reader and requires of the answer what the reader's header promises. libFuzzer runs it with bytes of its own making,
// replay.cpp with the files kept in tests/data/fuzz.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace kerf::fuzz {

/// A broken promise ends the program, which is what libFuzzer and CTest look for.
inline void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", promise);
  std::abort();
}

}  // namespace kerf::fuzz
