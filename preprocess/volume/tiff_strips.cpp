// After the TIFF 6.0 specification (Adobe, 1992), sections 2 and 8; its technical note 2 for deflate; BigTIFF by
// libtiff.gitlab.io/libtiff/specification/bigtiff.html.
#include "preprocess/volume/tiff_strips.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/packed_values.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

enum Tag : std::uint16_t {
  kWidth = 256,
  kLength = 257,
  kBitsPerSample = 258,
  kCompression = 259,
  kFillOrder = 266,
  kStripOffsets = 273,
  kSamplesPerPixel = 277,
  kRowsPerStrip = 278,
  kStripByteCounts = 279,
  kTileOffsets = 324,
};
constexpr std::array kWanted{kWidth,        kLength,          kBitsPerSample, kCompression,     kFillOrder,
                             kStripOffsets, kSamplesPerPixel, kRowsPerStrip,  kStripByteCounts, kTileOffsets};
constexpr std::uint64_t kRaw = 1, kDeflate = 8, kOldDeflate = 32946;  // values of kCompression
constexpr std::uint64_t kReversed = 2;                                // of kFillOrder
constexpr std::size_t kMostPages = 64;  // of a file: a slice has one, and perhaps small pictures of itself

tl::unexpected<Error> badTiff(const fs::path& path, std::string place, std::string found, std::string expected,
                              std::string hint = "copy the file again: it is cut short or damaged") {
  return fail({.code = Error::Code::kBadFormat,
               .file = path.string(),
               .place = std::move(place),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

tl::unexpected<Error> unsupportedTiff(const fs::path& path, std::string found, std::string expected) {
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = "save it again in strips, compressed by deflate or not at all, or as PNG"});
}

// The wanted numbers of one directory, by their tags.
class Page {
 public:
  std::map<std::uint16_t, std::vector<std::uint64_t>> numbers;

  std::uint64_t first(Tag tag, std::uint64_t otherwise) const {
    const auto at = numbers.find(tag);
    return at == numbers.end() || at->second.empty() ? otherwise : at->second.front();
  }
  std::vector<std::uint64_t> all(Tag tag) const {
    const auto at = numbers.find(tag);
    return at == numbers.end() ? std::vector<std::uint64_t>{} : at->second;
  }
};

// The directories of a file, one after the other.
class TiffWalk {
 public:
  TiffWalk(const fs::path& path, std::istream& in, std::uint64_t bytes) : path_(path), in_(in), bytes_(bytes) {}

  // The place of the first directory; 0 if none.
  Expected<std::uint64_t> begin() {
    std::array<char, 2> order{};
    in_.read(order.data(), order.size());
    const std::string_view mark(order.data(), order.size());
    is_big_endian_ = mark == "MM";
    std::uint64_t version = 0, offset_bytes = 8, unused = 0, first = 0;
    const bool is_tiff = (mark == "MM" || mark == "II") && number(2, version) && (version == 42 || version == 43);
    if (!is_tiff) return badTiff(path_, "byte 0", "no TIFF signature", "a TIFF picture", "leave it out of the folder");
    is_big_ = version == 43;
    if (is_big_ && !(number(2, offset_bytes) && offset_bytes == 8 && number(2, unused))) return endsInDirectory(0);
    if (!number(is_big_ ? 8 : 4, first)) return endsInDirectory(0);
    return first;
  }

  // Reads the directory at `at`, which becomes the place of the next one; 0: it was the last.
  Expected<Page> readPage(std::uint64_t& at) {
    const std::uint64_t place = at;
    std::uint64_t entries = 0;
    if (!seek(place) || !number(is_big_ ? 8 : 2, entries)) return endsInDirectory(place);
    const std::uint64_t entry_bytes = is_big_ ? 20 : 12, from = place + (is_big_ ? 8 : 2);
    if (entries > (bytes_ - from) / entry_bytes) return endsInDirectory(place);

    Page page;
    for (std::uint64_t n = 0; n < entries; ++n) KERF_CHECK(takeEntry(from + n * entry_bytes, page));
    if (!seek(from + entries * entry_bytes) || !number(is_big_ ? 8 : 4, at)) return endsInDirectory(place);
    return page;
  }

 private:
  bool seek(std::uint64_t to) {
    if (to > bytes_) return false;
    in_.clear();
    return static_cast<bool>(in_.seekg(static_cast<std::streamoff>(to)));
  }

  // A number of `n` bytes.
  bool number(std::size_t n, std::uint64_t& out) {
    std::array<char, 8> raw{};
    if (!in_.read(raw.data(), static_cast<std::streamsize>(n))) return false;
    out = 0;
    for (std::size_t i = 0; i < n; ++i)
      out |= std::uint64_t{static_cast<unsigned char>(raw[is_big_endian_ ? n - 1 - i : i])} << (8 * i);
    return true;
  }

  tl::unexpected<Error> endsInDirectory(std::uint64_t place) const {
    return badTiff(path_, fmt::format("byte {}", place),
                   fmt::format("a file of {} bytes that ends in its directory", bytes_), "a directory of its strips");
  }

  // How many bytes a number of this type takes; 0: it is none, or none without a sign.
  static std::uint64_t bytesOfType(std::uint64_t type) {
    switch (type) {
      case 1:  // BYTE
        return 1;
      case 3:  // SHORT
        return 2;
      case 4:   // LONG
      case 13:  // IFD
        return 4;
      case 16:  // LONG8
      case 18:  // IFD8
        return 8;
      default:
        return 0;
    }
  }

  // Keeps the numbers of a wanted entry. The entry itself holds a few, else they lie elsewhere in the file.
  Expected<void> takeEntry(std::uint64_t at, Page& page) {
    std::uint64_t tag = 0, type = 0, count = 0;
    const std::size_t word = is_big_ ? 8 : 4;
    if (!seek(at) || !number(2, tag) || !number(2, type) || !number(word, count)) return endsInDirectory(at);
    const bool is_wanted = std::find(kWanted.begin(), kWanted.end(), tag) != kWanted.end();
    if (!is_wanted || page.numbers.contains(static_cast<std::uint16_t>(tag))) return {};  // libtiff: the first counts

    const std::uint64_t each = bytesOfType(type);
    const std::string place = fmt::format("tag {}", tag);
    if (each == 0) return badTiff(path_, place, fmt::format("values of type {}", type), "whole numbers");
    std::uint64_t from = at + 4 + word;
    if (count > word / each && !number(word, from)) return endsInDirectory(at);
    if (from > bytes_ || count > (bytes_ - from) / each)
      return badTiff(path_, place,
                     fmt::format("{} numbers from byte {} on, in a file of {} bytes", count, from, bytes_),
                     "numbers that are in the file");

    std::vector<std::uint64_t>& numbers = page.numbers[static_cast<std::uint16_t>(tag)];
    numbers.resize(count);
    if (!seek(from)) return endsInDirectory(at);
    for (std::uint64_t& value : numbers)
      if (!number(each, value)) return endsInDirectory(at);
    return {};
  }

  const fs::path& path_;
  std::istream& in_;
  std::uint64_t bytes_;
  bool is_big_endian_ = false, is_big_ = false;
};

// Required unpacked sizes of the strips. Empty for colours and for impossible sizes: a later step rejects those.
struct Strips {
  std::uint64_t rows = 0, rows_each = 1, row_bytes = 0;

  explicit Strips(const Page& page) {
    constexpr std::uint64_t kMostPixels = 1u << 30, kMostBits = 64;
    const std::uint64_t width = page.first(kWidth, 0), length = page.first(kLength, 0);
    const std::uint64_t bits = page.first(kBitsPerSample, 1);
    if (page.first(kSamplesPerPixel, 1) != 1 || width > kMostPixels || length > kMostPixels || bits > kMostBits) return;
    rows = length;
    rows_each = std::clamp<std::uint64_t>(page.first(kRowsPerStrip, length), 1, std::max<std::uint64_t>(1, length));
    row_bytes = (width * bits + 7) / 8;
  }

  std::uint64_t count() const { return (rows + rows_each - 1) / rows_each; }
  std::uint64_t bytesOf(std::uint64_t strip) const {
    const std::uint64_t above = std::min(rows, strip * rows_each);
    return std::min(rows_each, rows - above) * row_bytes;
  }
};

Expected<void> requireWholePage(const fs::path& path, std::uint64_t file_bytes, const Page& page,
                                const Progress& progress) {
  if (page.numbers.contains(kTileOffsets)) return unsupportedTiff(path, "a picture in tiles", "one in strips");
  const std::uint64_t compression = page.first(kCompression, kRaw);
  const bool is_deflate = compression == kDeflate || compression == kOldDeflate;
  if (is_deflate && page.first(kFillOrder, 1) == kReversed)
    return unsupportedTiff(path, "compressed bytes with their bits in reverse (FillOrder 2)", "FillOrder 1");

  const Strips strips(page);
  const std::vector<std::uint64_t> offsets = page.all(kStripOffsets), counts = page.all(kStripByteCounts);
  if (offsets.size() < strips.count())
    return badTiff(path, fmt::format("tag {}", static_cast<int>(kStripOffsets)),
                   fmt::format("{} strips", offsets.size()),
                   fmt::format("{}: {} rows, {} in a strip", strips.count(), strips.rows, strips.rows_each));

  for (std::size_t n = 0; n < strips.count(); ++n) {
    const std::string place = fmt::format("strip {} of {}", n + 1, strips.count());
    const std::uint64_t held = file_bytes - std::min(file_bytes, offsets[n]);
    // Some programs omit the counts, or write 0. For raw strips the counts are not needed.
    const std::uint64_t stated = n < counts.size() && counts[n] > 0 ? counts[n] : held;
    const std::uint64_t needed = compression == kRaw ? strips.bytesOf(n) : stated;
    if (needed > held || offsets[n] > file_bytes)
      return badTiff(path, place, fmt::format("{} bytes up to the end of the file", held), fmt::format("{}", needed),
                     "copy the file again: it is cut short");
    if (!is_deflate) continue;

    const PackedValues packed{.packing = Packing::kZlib, .file = path, .from = offsets[n], .bytes = stated};
    if (const auto whole = requireWholeValues(packed, strips.bytesOf(n), 1, progress); !whole) {
      Error error = whole.error();
      error.place = place;
      return fail(std::move(error));
    }
  }
  return {};
}

}  // namespace

Expected<void> requireWholeStrips(const fs::path& path, const Progress& progress) {
  std::error_code failed;
  const std::uint64_t bytes = fs::file_size(path, failed);
  std::ifstream in(path, std::ios::binary);
  if (failed || !in)
    return fail({.code = Error::Code::kUnreadable,
                 .file = path.string(),
                 .found = "it cannot be opened",
                 .expected = "a readable file"});

  TiffWalk walk(path, in, bytes);
  KERF_TRY(at, walk.begin());
  std::set<std::uint64_t> places;
  while (at != 0 && places.size() < kMostPages && places.insert(at).second) {
    KERF_TRY(page, walk.readPage(at));
    KERF_CHECK(requireWholePage(path, bytes, page, progress));
  }
  return {};
}

}  // namespace kerf::internal
