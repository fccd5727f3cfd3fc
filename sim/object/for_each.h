// A loop by all cores, or by the calling thread alone.
#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>

namespace kerf::internal {

/// Calls work(n) for n below count, in any order. @param is_parallel  false: in order, and without TBB, because
/// ThreadSanitizer cannot see into its Debian build.
template <class Work>
void forEach(std::size_t count, bool is_parallel, const Work& work) {
  if (is_parallel)
    tbb::parallel_for(std::size_t{0}, count, work);
  else
    for (std::size_t n = 0; n < count; ++n) work(n);
}

}  // namespace kerf::internal
