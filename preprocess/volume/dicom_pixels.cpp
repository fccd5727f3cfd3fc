// After DICOM PS3.5, chapter 7 (elements), annex A (transfer syntaxes, fragments of compressed pixels); PS3.10, chapter
// 7 (the file).
#include "preprocess/volume/dicom_pixels.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kUndefined = 0xffffffff;
constexpr std::uint32_t kTransferSyntax = 0x00020010, kSamples = 0x00280002, kFrames = 0x00280008, kRows = 0x00280010,
                        kColumns = 0x00280011, kBitsAllocated = 0x00280100, kPixels = 0x7fe00010, kItem = 0xfffee000,
                        kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd;
constexpr int kDeepest = 32;              // sequences in sequences
constexpr std::size_t kLongestText = 64;  // of a read value

enum class Writing { kExplicitLittle, kExplicitBig, kImplicitLittle };

struct Element {
  std::uint32_t tag = 0;
  std::array<char, 2> vr{};  ///< zero where the writing has none
  std::uint32_t length = 0;  ///< bytes, or kUndefined
};

enum class Found {
  kAtPixels,  ///< the stream stands at the first byte of the value of `pixels`
  kEnd,       ///< the set ended
  kCut,       ///< the file ended within it
  kUnknown,   ///< not written in a way that this walk knows
};

// The elements of a file, one after the other.
class Walk {
 public:
  Walk(std::istream& in, std::uint64_t bytes) : in_(in), bytes_(bytes) {}

  double samples = 1, rows = 0, columns = 0, frames = 1, bits = 0;
  Element pixels{};
  std::uint32_t cut_in = 0;  ///< tag of the element that the file ends in
  bool is_compressed = false;

  Found toPixels() {
    std::array<char, 4> mark{};
    if (!seek(128) || !read(mark.data(), 4) || std::string_view(mark.data(), 4) != "DICM") return Found::kUnknown;
    std::string syntax;
    for (;;) {
      const std::uint64_t begin = at();
      Element e;
      if (!readElement(Writing::kExplicitLittle, e)) return Found::kUnknown;
      if (e.tag >> 16 != 2) {
        if (!seek(begin)) return Found::kUnknown;
        break;
      }
      if (e.length == kUndefined) return Found::kUnknown;
      if (e.tag == kTransferSyntax) {
        syntax = text(e.length);
      } else if (!skip(e.length)) {
        cut_in = e.tag;
        return Found::kCut;
      }
    }

    constexpr std::string_view kImplicit = "1.2.840.10008.1.2", kExplicit = "1.2.840.10008.1.2.1",
                               kBig = "1.2.840.10008.1.2.2", kDeflated = "1.2.840.10008.1.2.1.99";
    if (syntax.empty() || syntax == kDeflated) return Found::kUnknown;
    is_compressed = syntax != kImplicit && syntax != kExplicit && syntax != kBig;
    if (is_compressed && !syntax.starts_with("1.2.840.10008.1.2.")) return Found::kUnknown;  // a vendor's own
    return walkSet(syntax == kImplicit ? Writing::kImplicitLittle
                   : syntax == kBig    ? Writing::kExplicitBig
                                       : Writing::kExplicitLittle,
                   0);
  }

  /// True if the fragments end with a delimiter. @pre the stream stands at the first fragment.
  bool areFragmentsWhole() {
    for (;;) {
      Element e;
      if (!readDelimiter(Writing::kExplicitLittle, e)) return false;
      if (e.tag == kSequenceEnd) return true;
      if (e.tag != kItem || e.length == kUndefined || !skip(e.length)) return false;
    }
  }

  std::uint64_t at() { return static_cast<std::uint64_t>(in_.tellg()); }

 private:
  bool read(char* out, std::size_t n) { return static_cast<bool>(in_.read(out, static_cast<std::streamsize>(n))); }
  bool seek(std::uint64_t to) {
    if (to > bytes_) return false;
    in_.clear();
    return static_cast<bool>(in_.seekg(static_cast<std::streamoff>(to)));
  }
  bool skip(std::uint64_t n) { return seek(at() + n); }

  // A number of `n` bytes.
  bool number(Writing writing, std::size_t n, std::uint32_t& out) {
    std::array<char, 4> raw{};
    if (!read(raw.data(), n)) return false;
    out = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto byte = static_cast<unsigned char>(raw[writing == Writing::kExplicitBig ? n - 1 - i : i]);
      out |= static_cast<std::uint32_t>(byte) << (8 * i);
    }
    return true;
  }

  bool readTag(Writing writing, std::uint32_t& tag) {
    std::uint32_t group = 0, element = 0;
    if (!number(writing, 2, group) || !number(writing, 2, element)) return false;
    tag = group << 16 | element;
    return true;
  }

  // Tag and length: an item, or its end. They have no VR in any encoding.
  bool readDelimiter(Writing writing, Element& e) { return readTag(writing, e.tag) && number(writing, 4, e.length); }

  bool readElement(Writing writing, Element& e) {
    if (!readTag(writing, e.tag)) return false;
    if (writing == Writing::kImplicitLittle || e.tag >> 16 == 0xfffe) return number(writing, 4, e.length);
    if (!read(e.vr.data(), 2)) return false;
    const std::string_view vr(e.vr.data(), 2);
    const bool is_long = std::string_view("OB OD OF OL OV OW SQ SV UC UN UR UT UV").find(vr) != std::string_view::npos;
    std::uint32_t unused = 0;
    if (is_long && !number(writing, 2, unused)) return false;
    return number(writing, is_long ? 4 : 2, e.length);
  }

  std::string text(std::uint32_t length) {
    std::string out(std::min<std::size_t>(length, kLongestText), '\0');
    if (!read(out.data(), out.size()) || !skip(length - out.size())) return {};
    while (!out.empty() && (out.back() == '\0' || out.back() == ' ')) out.pop_back();
    return out;
  }

  // Keeps the values that describe the pixels, and skips the rest.
  Found takeValue(Writing writing, const Element& e) {
    double* const wanted = e.tag == kSamples         ? &samples
                           : e.tag == kRows          ? &rows
                           : e.tag == kColumns       ? &columns
                           : e.tag == kBitsAllocated ? &bits
                                                     : nullptr;
    if (wanted && e.length == 2) {
      std::uint32_t value = 0;
      if (!number(writing, 2, value)) return Found::kCut;
      *wanted = value;
      return Found::kEnd;
    }
    if (e.tag == kFrames && e.length <= kLongestText) {
      frames = std::strtod(text(e.length).c_str(), nullptr);
      return Found::kEnd;
    }
    return skip(e.length) ? Found::kEnd : Found::kCut;
  }

  // The items of a sequence without a length. An unknown one (UN) is written without VR (PS3.5, 6.2.2).
  Found walkSequence(Writing writing, int depth) {
    for (;;) {
      Element item;
      if (!readDelimiter(writing, item)) return Found::kCut;
      if (item.tag == kSequenceEnd) return Found::kEnd;
      if (item.tag != kItem) return Found::kUnknown;
      if (item.length != kUndefined) {
        if (!skip(item.length)) return Found::kCut;
      } else if (const Found found = walkSet(writing, depth + 1); found != Found::kEnd) {
        return found;
      }
    }
  }

  Found walkSet(Writing writing, int depth) {
    if (depth > kDeepest) return Found::kUnknown;
    while (at() < bytes_) {
      Element e;
      if (!readElement(writing, e)) return Found::kCut;
      cut_in = e.tag;
      if (e.tag == kItemEnd && depth > 0) return Found::kEnd;
      if (e.tag >> 16 == 0xfffe) return Found::kUnknown;
      if (e.tag == kPixels && depth == 0) {
        pixels = e;
        return Found::kAtPixels;
      }
      const bool is_unknown = std::string_view(e.vr.data(), 2) == "UN";
      const Found found = e.length == kUndefined ? walkSequence(is_unknown ? Writing::kImplicitLittle : writing, depth)
                          : depth == 0           ? takeValue(writing, e)
                          : skip(e.length)       ? Found::kEnd
                                                 : Found::kCut;
      if (found != Found::kEnd) return found;
    }
    return depth == 0 ? Found::kEnd : Found::kCut;
  }

  std::istream& in_;
  std::uint64_t bytes_;
};

tl::unexpected<Error> cutShort(const fs::path& path, std::string found, std::string expected) {
  return fail({.code = Error::Code::kBadFormat,
               .file = path.string(),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = "copy the file again, or export the series again: it is cut short"});
}

}  // namespace

Expected<void> requireWholePixels(const fs::path& path) {
  std::error_code ec;
  const std::uint64_t bytes = fs::file_size(path, ec);
  std::ifstream in(path, std::ios::binary);
  if (ec || !in)
    return fail({.code = Error::Code::kUnreadable,
                 .file = path.string(),
                 .found = "it cannot be opened",
                 .expected = "a readable file"});

  Walk walk(in, bytes);
  const Found found = walk.toPixels();
  const std::string in_element = fmt::format("element ({:04x},{:04x})", walk.cut_in >> 16, walk.cut_in & 0xffff);
  if (found == Found::kCut) return cutShort(path, "a file that ends in its " + in_element, "its pixels");
  if (found == Found::kEnd) return {};
  // Colours may have fewer stored values than pixels. They are no labels: a later step rejects them.
  const double needed = walk.samples > 1 ? 0 : walk.rows * walk.columns * walk.frames * walk.bits / 8;
  if (found == Found::kUnknown) {
    if (walk.is_compressed || static_cast<double>(bytes) >= needed) return {};
    return cutShort(path, fmt::format("{} bytes", bytes), fmt::format("{:.0f} bytes of pixels alone", needed));
  }

  const std::uint64_t held = bytes - walk.at();
  if (walk.pixels.length == kUndefined) {
    if (walk.areFragmentsWhole()) return {};
    return cutShort(path, fmt::format("compressed pixels that break off after {} bytes", held),
                    "fragments with their end");
  }
  if (walk.pixels.length > held)
    return cutShort(path, fmt::format("{} bytes of pixels", held), fmt::format("{}, as it claims", walk.pixels.length));
  if (!walk.is_compressed && static_cast<double>(walk.pixels.length) < needed)
    return cutShort(path, fmt::format("{} bytes of pixels", walk.pixels.length),
                    fmt::format("{:.0f}: {:.0f} x {:.0f} in {:.0f} frames, {:.0f} bits for each of {:.0f} values",
                                needed, walk.columns, walk.rows, walk.frames, walk.bits, walk.samples));
  return {};
}

}  // namespace kerf::internal
