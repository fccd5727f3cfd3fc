#include "geometry/base/hash.h"

#include <nettle/sha2.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <vector>

namespace kerf {
namespace {

class Sha256 {
 public:
  Sha256() { sha256_init(&context_); }
  void update(std::span<const std::byte> bytes) {
    sha256_update(&context_, bytes.size(), reinterpret_cast<const std::uint8_t*>(bytes.data()));
  }
  // Starts anew.
  std::string digest() {
    std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest;
    sha256_digest(&context_, digest.size(), digest.data());
    std::string text;
    for (const std::uint8_t byte : digest) text += {"0123456789abcdef"[byte >> 4], "0123456789abcdef"[byte & 15]};
    return text;
  }

 private:
  sha256_ctx context_;
};

}  // namespace

std::string sha256(std::span<const std::byte> bytes) {
  Sha256 hash;
  hash.update(bytes);
  return hash.digest();
}

Expected<std::string> sha256OfFile(const std::filesystem::path& path) {
  std::error_code ignored;
  if (const auto status = std::filesystem::status(path, ignored);
      std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return fail({.code = Error::Code::kUnreadable,
                 .file = path.string(),
                 .place = "file",
                 .found = std::filesystem::is_directory(status) ? "a folder" : "a pipe or a device",
                 .expected = "a regular file",
                 .hint = "get its folder from the source again: Kerf writes no such file"});
  std::ifstream in(path, std::ios::binary);
  const auto refuse = [&](Error::Code code) {
    return fail({.code = code,
                 .file = path.string(),
                 .place = "file",
                 .found = std::string("cannot be read: ") + std::strerror(errno),
                 .expected = "a file",
                 .hint = "check the path"});
  };
  if (!in) return refuse(Error::Code::kNotFound);
  Sha256 hash;
  std::vector<char> buffer(1 << 18);
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), in.gcount() > 0)
    hash.update(std::as_bytes(std::span(buffer.data(), static_cast<std::size_t>(in.gcount()))));
  if (in.bad()) return refuse(Error::Code::kUnreadable);
  return hash.digest();
}

Expected<void> requireSha256(const std::filesystem::path& path, const std::string& expected, const std::string& hint) {
  KERF_TRY(found, sha256OfFile(path));
  if (found == expected) return {};
  return fail({.code = Error::Code::kUnreadable,
               .file = path.string(),
               .place = "content",
               .found = "damaged or edited: SHA-256 " + found.substr(0, 12) + "...",
               .expected = expected.substr(0, 12) + "...",
               .hint = hint});
}

}  // namespace kerf
