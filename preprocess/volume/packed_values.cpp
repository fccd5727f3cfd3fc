#include "preprocess/volume/packed_values.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunk = 1 << 18;          // bytes read, and bytes unpacked, at a time
constexpr int kGzipOnly = 31, kGzipOrZlib = 47;  // how inflateInit2() calls them, with the largest window

tl::unexpected<Error> badPacking(const fs::path& path, std::string found, std::string expected, std::string hint) {
  return fail({.code = Error::Code::kBadFormat,
               .file = path.string(),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

// The packed bytes of a file, a chunk at a time.
class PackedBytes {
 public:
  explicit PackedBytes(const PackedValues& packed) : in_(packed.file, std::ios::binary), left_(packed.bytes) {
    in_.seekg(static_cast<std::streamoff>(packed.from));
    chunk_.resize(static_cast<std::size_t>(std::clamp<std::uint64_t>(packed.bytes, 1, kChunk)));
  }

  bool isReadable() const { return in_.is_open() && !in_.bad(); }
  unsigned char* at() { return chunk_.data() + first_; }
  std::size_t size() const { return end_ - first_; }
  void drop(std::size_t bytes) { first_ += bytes; }

  // Keeps the remaining bytes, and fills the rest of the chunk.
  void refill() {
    std::memmove(chunk_.data(), at(), size());
    end_ = size();
    first_ = 0;
    const std::uint64_t wanted = std::min<std::uint64_t>(chunk_.size() - end_, left_);
    in_.read(reinterpret_cast<char*>(chunk_.data()) + end_, static_cast<std::streamsize>(wanted));
    const auto got = static_cast<std::size_t>(in_.gcount());
    end_ += got;
    left_ -= got;
  }

 private:
  std::ifstream in_;
  std::uint64_t left_;
  std::vector<unsigned char> chunk_;
  std::size_t first_ = 0, end_ = 0;
};

struct Inflater {
  z_stream z{};
  bool is_ready = false;

  explicit Inflater(int streams) { is_ready = inflateInit2(&z, streams) == Z_OK; }
  ~Inflater() {
    if (is_ready) inflateEnd(&z);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
};

// Receives the unpacked bytes, in parts of any size.
using ByteSink = std::function<Expected<void>(std::span<const std::byte>)>;

// Unpacks to the end, with the checksum; returns the number of unpacked bytes.
Expected<std::uint64_t> inflate(const PackedValues& packed, const ByteSink& sink, const Progress& progress) {
  const bool is_gzip = packed.packing == Packing::kGzip;
  Inflater inflater(is_gzip ? kGzipOnly : kGzipOrZlib);
  PackedBytes in(packed);
  std::vector<unsigned char> out(kChunk);
  std::uint64_t bytes = 0;
  if (!inflater.is_ready)
    return fail({.code = Error::Code::kUnsupported,
                 .file = packed.file.string(),
                 .found = "no memory to unpack its values",
                 .expected = "50 kB of it"});

  for (;;) {
    if (in.size() == 0) {
      if (!report(progress, 0.2, "unpacking voxels")) return cancelled(packed.file.string());
      in.refill();
      if (in.size() == 0)
        return badPacking(packed.file, fmt::format("compressed values that break off after {} bytes", bytes),
                          "compressed values with their end and its checksum", "copy the file again: it is cut short");
    }

    z_stream& z = inflater.z;
    z.next_in = in.at();
    z.avail_in = static_cast<unsigned>(in.size());
    z.next_out = out.data();
    z.avail_out = static_cast<unsigned>(out.size());
    const int said = ::inflate(&z, Z_NO_FLUSH);
    in.drop(in.size() - z.avail_in);
    const std::size_t fresh = out.size() - z.avail_out;
    bytes += fresh;
    if (sink) KERF_CHECK(sink(std::as_bytes(std::span(out).first(fresh))));

    if (said == Z_STREAM_END) {
      if (in.size() < 2) in.refill();
      const bool is_followed = is_gzip && in.size() >= 2 && in.at()[0] == 0x1f && in.at()[1] == 0x8b;
      if (!is_followed) return bytes;
      inflateReset(&z);
    } else if (said != Z_OK && said != Z_BUF_ERROR) {
      return badPacking(packed.file,
                        fmt::format("compressed values that are damaged after {} bytes ({})", bytes,
                                    z.msg ? z.msg : "no reason given"),
                        "compressed values that agree with their checksum",
                        "copy the file again, or save it again from the program it came from");
    }
  }
}

// Raw bytes to the end; how many there are.
Expected<std::uint64_t> copy(const PackedValues& packed, const ByteSink& sink, const Progress& progress) {
  PackedBytes in(packed);
  std::uint64_t bytes = 0;
  for (in.refill(); in.size() > 0; in.refill()) {
    if (!report(progress, 0.2, "reading voxels")) return cancelled(packed.file.string());
    KERF_CHECK(sink(std::as_bytes(std::span(in.at(), in.size()))));
    bytes += in.size();
    in.drop(in.size());
  }
  return bytes;
}

// Puts parts of any size together to slices.
class SliceCutter {
 public:
  SliceCutter(const PackedValues& packed, std::size_t slices, std::size_t bytes, std::size_t value_bytes,
              const SliceSink& sink)
      : sink_(sink), ahead_(packed.ahead), slices_(slices), value_bytes_(value_bytes), slice_(bytes) {
    is_swapped_ = packed.is_swapped && value_bytes > 1;
  }

  Expected<void> take(std::span<const std::byte> part) {
    const auto dropped = static_cast<std::size_t>(std::min<std::uint64_t>(ahead_, part.size()));
    ahead_ -= dropped;
    part = part.subspan(dropped);
    while (!part.empty() && done_ < slices_) {
      const std::size_t n = std::min(part.size(), slice_.size() - held_);
      std::memcpy(slice_.data() + held_, part.data(), n);
      held_ += n;
      part = part.subspan(n);
      if (held_ < slice_.size()) break;
      if (is_swapped_) swap();
      KERF_CHECK(sink_(done_++, slice_));
      held_ = 0;
    }
    return {};
  }

 private:
  void swap() {
    for (std::size_t at = 0; at < slice_.size(); at += value_bytes_)
      std::reverse(slice_.begin() + static_cast<std::ptrdiff_t>(at),
                   slice_.begin() + static_cast<std::ptrdiff_t>(at + value_bytes_));
  }

  const SliceSink& sink_;
  std::uint64_t ahead_;
  std::size_t slices_, value_bytes_;
  std::vector<std::byte> slice_;
  std::size_t held_ = 0, done_ = 0;
  bool is_swapped_ = false;
};

// Number of words.
Expected<std::uint64_t> wordsOf(const PackedValues& packed, const Progress& progress) {
  PackedBytes in(packed);
  std::uint64_t words = 0;
  bool is_blank = true;
  for (in.refill(); in.size() > 0; in.refill()) {
    if (!report(progress, 0.2, "checking the packed values")) return cancelled(packed.file.string());
    for (std::size_t i = 0; i < in.size(); ++i) {
      const unsigned char c = in.at()[i];
      const bool was_blank = is_blank;
      is_blank = c == ' ' || (c >= '\t' && c <= '\r');
      words += was_blank && !is_blank;
    }
    in.drop(in.size());
  }
  return words;
}

Expected<void> requireReadable(const PackedValues& packed) {
  if (PackedBytes(packed).isReadable()) return {};
  return fail({.code = Error::Code::kUnreadable,
               .file = packed.file.string(),
               .found = "it cannot be opened",
               .expected = "a readable file"});
}

// @param bytes  that came out.   @param needed  those of the values.
Expected<void> requireEnough(const PackedValues& packed, std::uint64_t bytes, std::uint64_t needed) {
  if (bytes >= packed.ahead + needed) return {};
  const bool is_raw = packed.packing == Packing::kNone;
  return badPacking(
      packed.file,
      fmt::format("{} bytes of values{}", bytes - std::min(bytes, packed.ahead), is_raw ? "" : ", unpacked"),
      fmt::format("{}, as its header claims", needed),
      is_raw ? "copy the file again: it is cut short"
             : "save it again from the program it came from: its header and its values do not belong together");
}

}  // namespace

Expected<void> readSlices(const PackedValues& packed, std::size_t slices, std::size_t values_per_slice,
                          std::size_t value_bytes, const SliceSink& sink, const Progress& progress) {
  KERF_CHECK(requireReadable(packed));
  SliceCutter cutter(packed, slices, values_per_slice * value_bytes, value_bytes, sink);
  const ByteSink take = [&](std::span<const std::byte> part) { return cutter.take(part); };
  KERF_TRY(bytes, packed.packing == Packing::kNone ? copy(packed, take, progress) : inflate(packed, take, progress));
  return requireEnough(packed, bytes, std::uint64_t{slices} * values_per_slice * value_bytes);
}

Expected<void> requireWholeValues(const PackedValues& packed, std::uint64_t values, std::uint64_t value_bytes,
                                  const Progress& progress) {
  if (packed.packing == Packing::kNone) return {};
  KERF_CHECK(requireReadable(packed));
  if (packed.packing == Packing::kText) {
    KERF_TRY(words, wordsOf(packed, progress));
    if (words >= values) return {};
    return badPacking(packed.file, fmt::format("{} values", words), fmt::format("{}, as its header claims", values),
                      "copy the file again: it is cut short");
  }
  KERF_TRY(bytes, inflate(packed, {}, progress));
  return requireEnough(packed, bytes, values * value_bytes);
}

}  // namespace kerf::internal
