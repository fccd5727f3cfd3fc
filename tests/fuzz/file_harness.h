// Harness of the readers that need a file: writes the bytes to a file of a given name, in memory where the system
// allows it.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "geometry/base/error.h"
#include "tests/fuzz/harness.h"

namespace kerf::fuzz {

/// A folder of this process with one file in it.
class ScratchFile {
 public:
  explicit ScratchFile(const char* name) {
    const std::filesystem::path memory = "/dev/shm";
    std::error_code ignored;
    const bool in_memory = std::filesystem::is_directory(memory, ignored) && ::access(memory.c_str(), W_OK) == 0;
    std::string pattern = ((in_memory ? memory : std::filesystem::temp_directory_path()) / "kerf-fuzz-XXXXXX").string();
    require(::mkdtemp(pattern.data()) != nullptr, "a scratch folder");
    folder_ = pattern;
    path_ = folder_ / name;
  }
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  void fill(const std::uint8_t* data, std::size_t size) const {
    const int fd = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    require(fd >= 0 && ::write(fd, data, size) == static_cast<ssize_t>(size) && ::close(fd) == 0, "a scratch file");
  }
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_, path_;
};

/// Required parts of every error about a text file.
inline void requireError(const Error& error) {
  require(!error.file.empty() && !error.found.empty(), "an error says where and what");
}

}  // namespace kerf::fuzz
