#include "geometry/base/hash.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace kerf {
namespace {

constexpr std::size_t kBlock = 64;

std::string hex(const std::array<std::uint8_t, 32>& digest) {
  std::string text;
  for (const std::uint8_t byte : digest) text += {"0123456789abcdef"[byte >> 4], "0123456789abcdef"[byte & 15]};
  return text;
}

}  // namespace

void Sha256::update(std::span<const std::byte> bytes) {
  const internal::Sha256Blocks take = internal::sha256BlocksHere();
  const std::size_t used = length_ % kBlock;
  length_ += bytes.size();

  // What is left of the piece before, and enough to make it a block.
  if (used > 0) {
    const std::size_t n = std::min(kBlock - used, bytes.size());
    std::copy_n(bytes.data(), n, buffer_.data() + used);
    bytes = bytes.subspan(n);
    if (used + n < kBlock) return;
    take(state_, buffer_.data(), 1);
  }

  // Whole blocks, and what is left of this piece.
  const std::size_t blocks = bytes.size() / kBlock;
  take(state_, bytes.data(), blocks);
  bytes = bytes.subspan(kBlock * blocks);
  std::copy(bytes.begin(), bytes.end(), buffer_.begin());
}

std::array<std::uint8_t, 32> Sha256::digest() {
  const std::uint64_t bits = 8 * length_;
  std::vector<std::byte> tail(1, std::byte{0x80});
  while ((length_ + tail.size()) % 64 != 56) tail.push_back(std::byte{0});
  for (int shift = 56; shift >= 0; shift -= 8) tail.push_back(static_cast<std::byte>(bits >> shift));
  update(tail);
  std::array<std::uint8_t, 32> out;
  for (std::size_t i = 0; i < 32; ++i) out[i] = static_cast<std::uint8_t>(state_[i / 4] >> (24 - 8 * (i % 4)));
  return out;
}

std::string sha256(std::span<const std::byte> bytes) {
  Sha256 hash;
  hash.update(bytes);
  return hex(hash.digest());
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
                 .hint = "get the folder it lies in again: Kerf writes nothing of that kind"});
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
  return hex(hash.digest());
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
