// Runs in kerf-slice-trial, without the rest of Kerf.
#include "preprocess/volume/slice_trial.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <new>
#include <system_error>

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

// Sets a soft limit, capped by the hard limit of the process.
void setSoftLimit(decltype(RLIMIT_AS) what, rlim_t wanted) {
  rlimit limit{};
  if (getrlimit(what, &limit) != 0) return;
  limit.rlim_cur = std::min(wanted, limit.rlim_max);
  setrlimit(what, &limit);
}

// Allows two seconds of processor time from now, and more for a large file; exceeding them ends this process. The
// wall-clock limit is ten times that: the machine may be busy, but a wait for a pipe that never closes must end.
void limitTime(const fs::path& file) {
  constexpr double kLeastSeconds = 2, kBytesPerSecond = 2e6, kMostSeconds = 3600;
  std::error_code failed;
  const auto bytes = fs::file_size(file, failed);
  const double more =
      std::min(kLeastSeconds + (failed ? 0 : static_cast<double>(bytes)) / kBytesPerSecond, kMostSeconds);
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto until = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + 1 + static_cast<rlim_t>(more);
  setSoftLimit(RLIMIT_CPU, until);
  alarm(10 * static_cast<unsigned>(more));
}

// Peak memory of this process, bytes.
double mostMemory() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return 1024.0 * static_cast<double>(used.ru_maxrss);
}

// Allows the memory of a sound file, on top of the current use; a larger request ends the process. GDCM allocates by a
// length in the file before it checks the size of the file.
// @param values  bytes of the pixels, unpacked; 0 while only the header is read.
void limitMemory(const fs::path& file, double values) {
  constexpr double kAmple = 512e6, kPerByte = 20, kCopies = 4;
  std::error_code failed;
  const auto size = fs::file_size(file, failed);
  double pages = 0;
  if (!(std::ifstream("/proc/self/statm") >> pages)) return;
  const double most = pages * static_cast<double>(sysconf(_SC_PAGESIZE)) + kAmple + kCopies * values +
                      (failed ? 0 : kPerByte * static_cast<double>(size));
  setSoftLimit(RLIMIT_AS, static_cast<rlim_t>(most));
}

}  // namespace

bool readEverySlice(const ItkReader& reader, const std::vector<fs::path>& files, VolumeFormat format,
                    std::uint64_t max_bytes) {
  std::set_new_handler([] { _exit(1); });
  std::error_code ignored;
  for (const fs::path& f : files) {
    limitTime(f);
    limitMemory(f, 0);
    // A length that is not true makes the library take that much memory. It must not happen in the host.
    const auto size = fs::file_size(f, ignored);
    const double ample = 1e8 + 20 * (ignored ? 0 : static_cast<double>(size)), before = mostMemory();
    const bool is_slice = format != VolumeFormat::kDicom || reader.is_dicom(f);
    if (mostMemory() > before + ample) return false;
    if (!is_slice) continue;

    const auto h = reader.read_header(f, format);
    if (mostMemory() > before + ample) return false;
    if (!h) continue;

    double bytes = static_cast<double>(bytesOf(h->type)) * h->components;
    for (const auto s : h->size) bytes *= static_cast<double>(s);
    if (!(bytes <= static_cast<double>(max_bytes))) continue;
    limitMemory(f, bytes);
    std::vector<std::byte> values(static_cast<std::size_t>(bytes));
    (void)reader.read_values(f, format, values.data(), values.size());
  }
  return true;
}

}  // namespace kerf::internal
