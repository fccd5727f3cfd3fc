#include "geometry/base/text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace kerf {

Expected<std::string> readSmallFile(const std::filesystem::path& file, std::size_t most_bytes) {
  const auto refuse = [&](Error::Code code, std::string found) {
    return fail({.code = code,
                 .file = file.string(),
                 .found = std::move(found),
                 .expected = fmt::format("a file of at most {}", most_bytes < 1 << 20
                                                                     ? fmt::format("{} kB", most_bytes >> 10)
                                                                     : fmt::format("{} MB", most_bytes >> 20))});
  };
  const auto reason = [] { return std::string("cannot be read: ") + std::strerror(errno); };
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);  // a pipe would block
  if (fd < 0 && errno == ENOENT) return refuse(Error::Code::kNotFound, "no such file");
  if (fd < 0) return refuse(Error::Code::kUnreadable, reason());

  struct stat status {};
  std::string out;
  Expected<void> read;
  if (::fstat(fd, &status) != 0)
    read = refuse(Error::Code::kUnreadable, reason());
  else if (!S_ISREG(status.st_mode))
    read = refuse(Error::Code::kUnreadable, S_ISDIR(status.st_mode) ? "a folder" : "a pipe or a device");
  else
    out.resize(std::min(static_cast<std::size_t>(status.st_size), most_bytes) + 1);
  std::size_t size = 0;
  while (read && size <= most_bytes) {
    if (size == out.size())
      out.resize(std::min(2 * size, most_bytes) + 1);  // the file has grown, or has no size, as in /proc
    const ssize_t n = ::read(fd, out.data() + size, out.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) read = refuse(Error::Code::kUnreadable, reason());
    if (n <= 0) break;
    size += static_cast<std::size_t>(n);
  }
  ::close(fd);
  if (!read) return fail(read.error());
  if (size > most_bytes) return refuse(Error::Code::kBadFormat, "it is larger");
  out.resize(size);
  return out;
}

std::size_t utf8Length(std::string_view bytes, std::size_t at) {
  const auto byte = [&](std::size_t n) { return n < bytes.size() ? static_cast<unsigned char>(bytes[n]) : 0u; };
  const unsigned first = byte(at);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xc2 && first < 0xe0 ? 2
                             : first >> 4 == 0xe             ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  for (std::size_t k = 1; k < length; ++k)
    if (byte(at + k) >> 6 != 2) return 0;
  const unsigned second = byte(at + 1);
  const bool is_overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool is_beyond = (first == 0xed && second >= 0xa0) || (first == 0xf4 && second >= 0x90);
  return at >= bytes.size() || is_overlong || is_beyond ? 0 : length;
}

std::string printable(std::string_view text, bool keeps_lines) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8Length(text, at);
    const auto byte = static_cast<unsigned char>(text[at]);
    const bool is_kept = keeps_lines && (byte == '\n' || byte == '\t');
    const bool is_c1 = length == 2 && byte == 0xc2 && static_cast<unsigned char>(text[at + 1]) < 0xa0;
    const std::size_t count = std::max<std::size_t>(length, 1);
    if ((length == 0 || byte < 0x20 || byte == 0x7f || is_c1) && !is_kept)
      for (std::size_t k = 0; k < count; ++k) out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[at + k]));
    else
      out += text.substr(at, count);
    at += count;
  }
  return out;
}

}  // namespace kerf
