// The bytes of a .vdb file, one number after the other, without OpenVDB.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace kerf::internal {

static_assert(std::endian::native == std::endian::little, "the file is read as it lies in memory");

constexpr std::int64_t kVdbMagic = 0x56444220;
constexpr std::uint32_t kOldestVdb = 222, kNewestVdb = 224;
constexpr std::int32_t kMostVdbEntries = 10'000, kMostVdbText = 1 << 16;  // far above the length of a name

/// Reads a regular file through one block of 256 kB. After the first missing number it reads zeros.
class VdbReader {
 public:
  /// Neither waits for nor reads a pipe or a device: isGood() is false then.
  explicit VdbReader(const std::filesystem::path& path)
      : fd_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)), block_(std::size_t{1} << 18) {
    struct stat status {};
    good_ = fd_ >= 0 && ::fstat(fd_, &status) == 0 && S_ISREG(status.st_mode);
    if (good_) size_ = status.st_size;
  }
  ~VdbReader() {
    if (fd_ >= 0) ::close(fd_);
  }
  VdbReader(const VdbReader&) = delete;
  VdbReader& operator=(const VdbReader&) = delete;

  bool isGood() const { return good_; }
  void fail() { good_ = false; }
  std::int64_t at() const { return at_; }
  std::int64_t left() const { return size_ - at_; }

  void goTo(std::int64_t at) {
    if (at < 0 || at > size_) return fail();  // a truncated file
    at_ = at;
  }
  void skip(std::int64_t bytes) {
    if (bytes < 0 || bytes > left()) return fail();
    at_ += bytes;
  }

  void read(char* out, std::size_t count) {
    if (!good_ || std::cmp_greater(count, left())) {
      std::memset(out, 0, count);
      return fail();
    }
    while (count > 0) {
      if (at_ < begin_ || at_ >= end_) fill();
      if (!good_) return;
      const std::size_t n = std::min(count, static_cast<std::size_t>(end_ - at_));
      std::memcpy(out, block_.data() + (at_ - begin_), n);
      out += n;
      count -= n;
      at_ += static_cast<std::int64_t>(n);
    }
  }

  template <class Number>
  Number number() {
    std::array<char, sizeof(Number)> bytes{};
    read(bytes.data(), bytes.size());
    return good_ ? std::bit_cast<Number>(bytes) : Number{};
  }

  std::string text() {
    const auto size = number<std::int32_t>();
    if (size >= 0 && size <= kMostVdbText) return bytes(size);
    fail();
    return {};
  }

  std::string bytes(std::int32_t size) {
    if (size < 0 || size > left()) fail();
    if (!good_) return {};
    std::string out(static_cast<std::size_t>(size), '\0');
    read(out.data(), out.size());
    return good_ ? out : std::string();
  }

  /// Calls visit(name, type, size) for each entry, at its first byte; continues behind it wherever visit() stops.
  template <class Visit>
  void metadata(const Visit& visit) {
    const auto entries = number<std::int32_t>();
    if (entries < 0 || entries > kMostVdbEntries) return fail();
    for (std::int32_t n = 0; n < entries && good_; ++n) {
      const std::string name = text(), type = text();
      const auto size = number<std::int32_t>();
      if (size < 0 || size > left()) return fail();
      const std::int64_t begin = at_;
      visit(name, type, size);
      goTo(begin + size);
    }
  }

 private:
  void fill() {
    const ssize_t n = ::pread(fd_, block_.data(), block_.size(), at_);
    if (n <= 0) return fail();
    begin_ = at_;
    end_ = at_ + n;
  }

  int fd_;
  bool good_ = false;
  std::int64_t size_ = 0, at_ = 0, begin_ = 0, end_ = 0;  // file size; the next byte; the block
  std::vector<char> block_;
};

}  // namespace kerf::internal
