// Headers of NRRD, NIfTI and MetaImage files, read before ITK gets them: ITK treats a missing spacing as 1 mm, trusts
// sizes before it checks the amount of data, and accepts truncated packed values.
// After the format descriptions: teem.sourceforge.net/nrrd/format.html, nifti1.h of NIfTI-1.1, itk.org MetaIO.
#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "preprocess/volume/volume_file.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

constexpr double kDeflateGrowth = 1032;  // no deflate stream expands more
constexpr double kText = 8;              // a digit and a blank make up to 8 bytes, and half a byte is lost to rounding
constexpr std::size_t kMostHeader = 1 << 20;
constexpr int kMostAxes = 7;
// ITK 5.2's NRRD library quotes the text in its error, and overruns a buffer of 1024 bytes for longer text.
constexpr std::size_t kMostQuoted = 500;

tl::unexpected<Error> bad(const fs::path& path, std::string place, std::string found, std::string expected,
                          std::string hint = "save it again from the program it came from") {
  return fail({.code = Error::Code::kBadFormat,
               .file = path.string(),
               .place = std::move(place),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

tl::unexpected<Error> unsupported(const fs::path& path, std::string place, std::string found, std::string expected,
                                  std::string hint) {
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .place = std::move(place),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

tl::unexpected<Error> unreadable(const fs::path& path, std::string found) {
  return fail({.code = Error::Code::kUnreadable,
               .file = path.string(),
               .found = std::move(found),
               .expected = "a readable file"});
}

std::string trimmed(std::string s) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!s.empty() && blank(s.back())) s.pop_back();
  std::size_t first = 0;
  while (first < s.size() && blank(s[first])) ++first;
  return s.substr(first);
}

std::string lower(std::string s) {
  for (char& c : s)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return s;
}

// Numbers separated by blanks; other text becomes NaN, as `NaN` and `nan` do.
std::vector<double> numbers(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> out;
  for (std::string word; in >> word;) {
    char* end = nullptr;
    const double v = std::strtod(word.c_str(), &end);
    out.push_back(end && *end == '\0' ? v : std::nan(""));
  }
  return out;
}

// True if bytes in that order are not in this machine's.
bool isSwapped(bool is_big) { return is_big != (std::endian::native == std::endian::big); }

struct TextHeader {
  std::map<std::string, std::string> field;  // keys of NRRD in lower case
  std::uint64_t bytes = 0;                   // of the header, the separating line included
};

// ITK ignores a MetaImage key in other letters: it would use 1 mm as the spacing, and compressed bytes as labels.
Expected<void> requireSpelling(const fs::path& path, int line, const std::string& key) {
  for (const char* known : {"NDims", "DimSize", "ElementSpacing", "ElementSize", "ElementType", "ElementDataFile",
                            "ElementNumberOfChannels", "ElementByteOrderMSB", "BinaryDataByteOrderMSB", "BinaryData",
                            "CompressedData", "CompressedDataSize", "HeaderSize", "TransformMatrix", "Offset"})
    if (key != known && lower(key) == lower(known))
      return bad(path, fmt::format("line {}", line), "key '" + key + "'", fmt::format("'{}'", known));
  return {};
}

// MetaIO copies words into 255 bytes, and ends the program where they are more. Numbers it keeps as numbers.
Expected<void> requireShortWords(const fs::path& path, int line, const std::string& key, const std::string& value) {
  constexpr std::size_t kMostOfMetaIo = 254;
  const bool is_numbers = value.find_first_not_of("0123456789+-.eE \t") == std::string::npos;
  const std::size_t longest = is_numbers ? key.size() : std::max(key.size(), value.size());
  if (longest <= kMostOfMetaIo) return {};
  return bad(path, fmt::format("line {}", line), fmt::format("a word of {} bytes", longest),
             fmt::format("at most {}", kMostOfMetaIo));
}

// Lines `key SEPARATOR value` up to an empty line (NRRD) or through the line with the key `last` (MetaImage).
Expected<TextHeader> readTextHeader(const fs::path& path, char separator, const std::string& last) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return unreadable(path, "it cannot be opened");
  TextHeader h;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    h.bytes += line.size() + 1;
    if (h.bytes > kMostHeader || line.find('\0') != std::string::npos)
      return bad(path, fmt::format("line {}", number), "bytes that are no text", "a header in text");
    line = trimmed(line);
    if (line.empty() && last.empty()) break;
    if (line.empty() || line[0] == '#' || (number == 1 && separator == ':')) continue;

    const auto at = line.find(separator);
    if (at == std::string::npos)
      return bad(path, fmt::format("line {}", number), "no key and value", fmt::format("KEY{} VALUE", separator));
    if (separator == ':' && at + 1 < line.size() && line[at + 1] == '=') continue;  // key:=value, for programs
    if (separator == ':' && line.size() > kMostQuoted)
      return bad(path, fmt::format("line {}", number), fmt::format("{} bytes", line.size()),
                 fmt::format("a field of at most {} bytes", kMostQuoted));

    const std::string word = trimmed(line.substr(0, at));
    const std::string key = separator == ':' ? lower(word) : word;
    const std::string value = trimmed(line.substr(at + 1));
    if (separator == '=') {
      KERF_CHECK(requireSpelling(path, number, key));
      KERF_CHECK(requireShortWords(path, number, key, value));
    }
    if (!h.field.emplace(key, value).second)
      return bad(path, fmt::format("line {}", number), fmt::format("key '{}' a second time", key), "it once");
    if (key == last) return h;
  }
  if (!last.empty()) return bad(path, "", fmt::format("no key '{}'", last), "a complete header");
  return h;
}

Expected<std::uint64_t> fileSize(const fs::path& path) {
  std::error_code ec;
  const auto bytes = fs::file_size(path, ec);
  if (ec) return unreadable(path, ec.message());
  return bytes;
}

Expected<void> checkSizes(const fs::path& path, const std::string& key, const std::vector<double>& sizes,
                          const std::vector<double>& dimension) {
  if (dimension.size() != 1 || !(dimension[0] >= 1 && dimension[0] <= kMostAxes) ||
      dimension[0] != std::floor(dimension[0]))
    return bad(path, "key " + key, "no usable number of axes", fmt::format("1 to {}", kMostAxes));
  if (sizes.size() != static_cast<std::size_t>(dimension[0]))
    return bad(path, "key " + key, fmt::format("{} sizes", sizes.size()),
               fmt::format("{}, one per axis", dimension[0]));
  for (const double s : sizes)
    if (!(s >= 1 && s <= 1e6) || s != std::floor(s))
      return bad(path, "key " + key, fmt::format("a size of {}", s), "whole numbers, 1 to 1000000");
  return {};
}

// One quoted unit per axis: "mm", or "" and ??? for none. ITK takes any unit for mm.
Expected<void> checkUnits(const fs::path& path, const std::string& key, const std::string& units) {
  for (std::size_t at = 0; at < units.size();) {
    const std::size_t open = units[at] == '"' ? at + 1 : at;
    const std::size_t end = std::min(units.find_first_of(open > at ? "\"" : " \t\"", open), units.size());
    const std::string unit = trimmed(units.substr(open, end - open));
    if (const std::string u = lower(unit); !u.empty() && u != "mm" && u != "none" && u != "\?\?\?")
      return unsupported(path, "key " + key, "'" + unit + "'", "mm, or none", "save it in mm; Kerf scales no volume");
    at = open > at ? end + 1 : std::max(end, at + 1);
  }
  return {};
}

Expected<void> requireNrrdSignature(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::array<char, 8> magic{};
  in.read(magic.data(), magic.size());
  if (std::memcmp(magic.data(), "NRRD000", 7) != 0) return bad(path, "byte 0", "no NRRD signature", "NRRD000x");
  return {};
}

// Largest number of value bytes per stored byte.
Expected<double> mostPerByteOfNrrd(const fs::path& path, const std::string& encoding) {
  if (encoding == "gzip" || encoding == "gz") return kDeflateGrowth;
  if (encoding == "bzip2" || encoding == "bz2")
    return unsupported(path, "key encoding", "'" + encoding + "', which no reader here unpacks",
                       "raw, gzip, ascii or hex", "save it with encoding: gzip");
  if (encoding == "ascii" || encoding == "text" || encoding == "txt") return kText;
  if (encoding == "raw" || encoding == "hex") return 1;
  return bad(path, "key encoding", "'" + encoding + "'", "raw, gzip, ascii or hex");
}

// Where the values of a NRRD file begin that are raw or compressed by gzip. Lines are skipped before they are unpacked,
// bytes afterwards; a negative number of bytes counts from the end.
Expected<PackedValues> packedValuesOfNrrd(const fs::path& path, const TextHeader& h, Packing packing) {
  const auto skip = [&](const char* key, const char* other) {
    const auto at = h.field.count(key) ? h.field.find(key) : h.field.find(other);
    if (at == h.field.end()) return 0.0;
    const std::vector<double> v = numbers(at->second);
    return v.size() == 1 ? v[0] : std::nan("");
  };
  const auto isCount = [](double v) { return v >= 0 && v <= 1e12 && v == std::floor(v); };
  const double lines_ahead = skip("line skip", "lineskip"), bytes_ahead = skip("byte skip", "byteskip");
  PackedValues out{.packing = packing,
                   .file = path,
                   .from = h.bytes,
                   .ahead = isCount(bytes_ahead) ? static_cast<std::uint64_t>(bytes_ahead) : 0};

  std::ifstream in(path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(out.from));
  std::string line;
  for (double lines = isCount(lines_ahead) ? lines_ahead : 0; lines > 0; --lines) {
    if (!std::getline(in, line)) return bad(path, "key line skip", "fewer lines", "as many lines as are to be skipped");
    out.from += line.size() + 1;
  }

  const auto endian = h.field.find("endian");
  const std::string order = endian == h.field.end() ? "" : lower(endian->second);
  out.is_plain = isCount(lines_ahead) && isCount(bytes_ahead) && (order.empty() || order == "little" || order == "big");
  out.is_swapped = isSwapped(order == "big");
  return out;
}

// Lengths of vectors: "none" on axes that are not in space; "(x,y,z)" on the others.
std::vector<double> lengthsOf(const std::string& directions) {
  std::vector<double> lengths;
  std::istringstream in(directions);
  for (std::string vector; in >> vector;) {
    if (lower(vector) == "none") continue;
    while (vector.find(')') == std::string::npos) {
      std::string more;
      if (!(in >> more)) break;
      vector += more;
    }
    for (char& c : vector)
      if (c == '(' || c == ')' || c == ',') c = ' ';
    double square = 0;
    for (const double v : numbers(vector)) square += v * v;
    lengths.push_back(std::sqrt(square));
  }
  return lengths;
}

Expected<StatedHeader> checkNrrd(const fs::path& path) {
  KERF_TRY(bytes, fileSize(path));
  if (path.native().size() > kMostQuoted)
    return unsupported(path, "", fmt::format("a path of {} bytes", path.native().size()),
                       fmt::format("at most {} bytes", kMostQuoted), "move the file to a folder with a shorter path");
  KERF_TRY(h, readTextHeader(path, ':', ""));
  KERF_CHECK(requireNrrdSignature(path));

  const auto get = [&](const std::string& key) { return h.field.count(key) ? h.field[key] : std::string(); };
  if (h.field.count("data file") || h.field.count("datafile"))
    return unsupported(path, "key data file", "values in another file", "header and values in one .nrrd",
                       "save it as a single .nrrd");
  KERF_CHECK(checkSizes(path, "sizes", numbers(get("sizes")), numbers(get("dimension"))));
  KERF_CHECK(checkUnits(path, "space units", get("space units")));
  KERF_CHECK(checkUnits(path, "units", get("units")));

  StatedHeader out;
  out.stored_bytes = bytes > h.bytes ? bytes - h.bytes : 0;
  KERF_TRY(most_per_byte, mostPerByteOfNrrd(path, lower(get("encoding"))));
  out.most_per_byte = most_per_byte;
  const bool is_raw = lower(get("encoding")) == "raw";
  if (most_per_byte == kDeflateGrowth || is_raw) {
    KERF_TRY(packed, packedValuesOfNrrd(path, h, is_raw ? Packing::kNone : Packing::kGzip));
    out.packed = packed;
  }
  if (h.field.count("space directions"))
    out.spacing = lengthsOf(h.field["space directions"]);
  else if (h.field.count("spacings"))
    out.spacing = numbers(h.field["spacings"]);
  return out;
}

// Encoding of the values in a MetaImage file. ITK uses the first letter of True and False.
Expected<PackedValues> packedValuesOfMetaImage(const fs::path& path, const TextHeader& h, const StatedHeader& stated) {
  const auto startsWith = [&](const std::string& key, const char* letters) {
    const auto at = h.field.find(key);
    return at != h.field.end() && !at->second.empty() &&
           std::string_view(letters).find(at->second[0]) != std::string_view::npos;
  };
  PackedValues out{.file = stated.data_file.empty() ? path : stated.data_file,
                   .from = stated.data_file.empty() ? h.bytes : 0};
  if (startsWith("CompressedData", "Tt1")) {
    out.packing = Packing::kZlib;
    const auto at = h.field.find("CompressedDataSize");
    const std::vector<double> size = at == h.field.end() ? std::vector<double>{} : numbers(at->second);
    if (size.size() != 1 || !(size[0] >= 1 && size[0] <= 1e15) || size[0] != std::floor(size[0]))
      return bad(path, "key CompressedDataSize", at == h.field.end() ? "it is not there" : "'" + at->second + "'",
                 "how many bytes the compressed values take, a whole number");
    out.bytes = static_cast<std::uint64_t>(size[0]);
    if (out.bytes > stated.stored_bytes)
      return bad(out.file, "", fmt::format("{} bytes of compressed values", stated.stored_bytes),
                 fmt::format("{}, as its header claims", out.bytes), "copy the file again: it is cut short");
  } else if (h.field.count("BinaryData") && !startsWith("BinaryData", "Tt1")) {
    out.packing = Packing::kText;
  }

  const auto skipped = h.field.find("HeaderSize");
  if (out.packing != Packing::kNone && skipped != h.field.end() && numbers(skipped->second) != std::vector<double>{0})
    return unsupported(path, "key HeaderSize", "'" + skipped->second + "'", "no bytes to skip before packed values",
                       "save it as a single .mha");
  out.is_plain = out.packing != Packing::kText && skipped == h.field.end();
  out.is_swapped = isSwapped(startsWith("BinaryDataByteOrderMSB", "Tt1") || startsWith("ElementByteOrderMSB", "Tt1"));
  return out;
}

Expected<StatedHeader> checkMetaImage(const fs::path& path) {
  KERF_TRY(bytes, fileSize(path));
  KERF_TRY(h, readTextHeader(path, '=', "ElementDataFile"));
  const auto get = [&](const std::string& key) { return h.field.count(key) ? h.field[key] : std::string(); };
  KERF_CHECK(checkSizes(path, "DimSize", numbers(get("DimSize")), numbers(get("NDims"))));

  StatedHeader out;
  const std::string data = get("ElementDataFile");
  if (lower(data) == "local") {
    out.stored_bytes = bytes > h.bytes ? bytes - h.bytes : 0;
  } else {
    // One file beside the header. A list or a pattern of files, or a path that leads elsewhere, is not followed.
    if (data.find('/') != std::string::npos || data.find('%') != std::string::npos ||
        data.find(' ') != std::string::npos || lower(data) == "list" || data.empty())
      return unsupported(path, "key ElementDataFile", "'" + data + "'", "LOCAL, or the name of one file beside it",
                         "save it as a single .mha");
    if (!fs::is_regular_file(path.parent_path() / data))
      return fail({.code = Error::Code::kNotFound,
                   .file = path.string(),
                   .place = "key ElementDataFile",
                   .found = "'" + data + "' is not there",
                   .expected = "the file with the values beside the header",
                   .hint = "copy it too, or save a single .mha"});
    KERF_TRY(data_bytes, fileSize(path.parent_path() / data));
    out.stored_bytes = data_bytes;
    out.data_file = path.parent_path() / data;
  }

  KERF_TRY(packed, packedValuesOfMetaImage(path, h, out));
  out.packed = packed;
  if (packed.packing == Packing::kZlib) out.most_per_byte = kDeflateGrowth;
  if (packed.packing == Packing::kText) out.most_per_byte = kText;
  if (const std::vector<double> skipped = numbers(get("HeaderSize")); skipped.size() == 1 && skipped[0] > 0) {
    // Counted from the start of the file that holds the values.
    const double held = static_cast<double>(out.data_file.empty() ? bytes : out.stored_bytes) - skipped[0];
    out.stored_bytes = held > 0 ? static_cast<std::uint64_t>(held) : 0;
  }
  if (h.field.count("ElementSpacing"))
    out.spacing = numbers(h.field["ElementSpacing"]);
  else if (h.field.count("ElementSize"))
    out.spacing = numbers(h.field["ElementSize"]);
  return out;
}

// A NIfTI-1 header with the numbers in it, whichever byte order they are in.
struct NiftiHeader {
  std::array<unsigned char, 348> bytes{};
  bool is_compressed = false;
  bool is_swapped = false;

  double shortAt(std::size_t at) const {
    std::int16_t v = 0;
    std::memcpy(&v, word(at, 2).data(), 2);
    return static_cast<double>(v);
  }
  double floatAt(std::size_t at) const {
    float v = 0;
    std::memcpy(&v, word(at, 4).data(), 4);
    return static_cast<double>(v);
  }

 private:
  std::array<unsigned char, 4> word(std::size_t at, std::size_t count) const {  // in this machine's byte order
    std::array<unsigned char, 4> b{};
    for (std::size_t i = 0; i < count; ++i) b[i] = bytes[at + (is_swapped ? count - 1 - i : i)];
    return b;
  }
};

Expected<NiftiHeader> readNiftiHeader(const fs::path& path) {
  NiftiHeader header;
  gzFile in = gzopen(path.c_str(), "rb");
  if (!in) return unreadable(path, "it cannot be opened");
  const int got = gzread(in, header.bytes.data(), static_cast<unsigned>(header.bytes.size()));
  header.is_compressed = gzdirect(in) == 0;
  gzclose(in);
  if (got < 0)
    return bad(path, "byte 0", "compressed bytes that are damaged", "compressed bytes that agree with their checksum",
               "copy the file again, or save it again from the program it came from");
  if (got != 348) return bad(path, "byte 0", "the file ends in its header", "348 bytes of NIfTI-1 header");

  const bool one_file = std::memcmp(&header.bytes[344], "n+1", 4) == 0;
  std::int32_t size = 0;
  std::memcpy(&size, header.bytes.data(), 4);
  header.is_swapped = size == 0x5C010000;
  if (!one_file || (size != 348 && !header.is_swapped))
    return bad(path, "byte 0", "no NIfTI-1 signature", "a single-file NIfTI-1 (n+1)",
               "save it as .nii or .nii.gz, version 1");
  return header;
}

// ITK inverts this matrix unchecked, and its linear algebra aborts the program on values that are not finite.
Expected<void> checkNiftiGeometry(const fs::path& path, const NiftiHeader& header, const std::vector<double>& spacing) {
  const auto refuse = [&](const char* key, double value) {
    return bad(path, fmt::format("key {}", key), fmt::format("the number {}", value),
               "spacing and orientation in mm, none above 1e6, no axis of length zero",
               "save it again with its voxel size, or as .nrrd");
  };
  for (std::size_t at = 76; at < 108; at += 4)
    if (!(std::abs(header.floatAt(at)) <= 1e6)) return refuse("pixdim", header.floatAt(at));
  for (std::size_t at = 256; at < 328; at += 4)
    if (!(std::abs(header.floatAt(at)) <= 1e6)) return refuse(at < 280 ? "qform" : "sform", header.floatAt(at));
  for (const double v : spacing)
    if (!(v > 1e-6)) return refuse("pixdim", v);
  if (header.shortAt(254) > 0)
    for (std::size_t a = 0; a < 3; ++a) {
      const double x = header.floatAt(280 + 4 * a), y = header.floatAt(296 + 4 * a), z = header.floatAt(312 + 4 * a);
      if (!(std::hypot(x, y, z) > 1e-6)) return refuse("sform", 0);
    }
  return {};
}

// Type of the stored values; empty if they are no single numbers.
std::optional<ValueType> niftiType(const NiftiHeader& header) {
  switch (static_cast<int>(header.shortAt(70))) {
    case 2:
      return ValueType::kU8;
    case 4:
      return ValueType::kI16;
    case 8:
      return ValueType::kI32;
    case 16:
      return ValueType::kF32;
    case 64:
      return ValueType::kF64;
    case 256:
      return ValueType::kI8;
    case 512:
      return ValueType::kU16;
    case 768:
      return ValueType::kU32;
    case 1024:
      return ValueType::kI64;
    case 1280:
      return ValueType::kU64;
    default:
      return std::nullopt;
  }
}

// True if the values are slope times stored values, plus an offset.
bool isScaled(const NiftiHeader& header) {
  const double slope = header.floatAt(112), more = header.floatAt(116);
  return slope != 0 && !(slope == 1 && more == 0);
}

Expected<StatedHeader> checkNifti(const fs::path& path) {
  KERF_TRY(bytes, fileSize(path));
  KERF_TRY(header, readNiftiHeader(path));
  const double axes = header.shortAt(40);
  std::vector<double> sizes;
  for (std::size_t a = 1; a <= 7 && static_cast<double>(a) <= axes; ++a) sizes.push_back(header.shortAt(40 + 2 * a));
  KERF_CHECK(checkSizes(path, "dim", sizes, {axes}));
  const double offset = header.floatAt(108);
  if (!(offset >= 348 && offset <= 1e9))
    return bad(path, "key vox_offset", fmt::format("values at byte {}", offset), "at byte 352 or later");

  StatedHeader out;
  for (std::size_t a = 1; a <= 3 && a <= sizes.size(); ++a) out.spacing.push_back(header.floatAt(76 + 4 * a));
  KERF_CHECK(checkNiftiGeometry(path, header, out.spacing));
  const auto start = static_cast<std::uint64_t>(offset);
  out.type = niftiType(header);
  if (header.is_compressed) {
    out.most_per_byte = kDeflateGrowth;
    out.stored_bytes = bytes;
    out.packed = {.packing = Packing::kGzip, .file = path, .ahead = start};
  } else {
    out.stored_bytes = bytes > start ? bytes - start : 0;
    out.packed = {.file = path, .from = start};
  }
  out.packed.is_plain = out.type && !isScaled(header);
  out.packed.is_swapped = header.is_swapped;
  return out;
}

}  // namespace

Expected<StatedHeader> checkVolumeHeader(const fs::path& path, VolumeFormat format) {
  if (format == VolumeFormat::kNrrd) return checkNrrd(path);
  if (format == VolumeFormat::kMetaImage) return checkMetaImage(path);
  return checkNifti(path);
}

}  // namespace kerf::internal
