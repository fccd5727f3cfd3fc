#include "geometry/formats/mesh_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "geometry/base/types.h"
#include "geometry/formats/mesh_formats.h"

namespace kerf::internal {

std::string MeshSource::extension() const {
  std::string e = std::filesystem::path(file).extension().string();
  for (char& c : e) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return e;
}

bool MeshSource::hasExtension(std::string_view list) const {
  const std::string own = extension();
  Words words(list);
  for (std::string_view e = words.next(); !e.empty(); e = words.next())
    if (e == own) return true;
  return false;
}

Error MeshSource::atByte(std::size_t offset, Error::Code code, std::string found, std::string expected,
                         std::string hint) const {
  return {code, file, "byte " + std::to_string(offset), std::move(found), std::move(expected), std::move(hint)};
}

Error MeshSource::atLine(const char* at, Error::Code code, std::string found, std::string expected,
                         std::string hint) const {
  std::size_t line = 1;
  for (const char* p = bytes.get(); p < at; ++p)
    if (*p == '\n' || (*p == '\r' && (p + 1 == bytes.get() + size || p[1] != '\n'))) ++line;
  return {code, file, "line " + std::to_string(line), std::move(found), std::move(expected), std::move(hint)};
}

Expected<MeshSource> loadMeshSource(const std::filesystem::path& path, std::size_t limit) {
  MeshSource source;
  source.file = path.string();
  const auto refuse = [&](Error::Code code, std::string found, std::string hint) {
    return fail({.code = code,
                 .file = source.file,
                 .place = "file",
                 .found = std::move(found),
                 .expected = "a mesh file (" + readableExtensions() + ")",
                 .hint = std::move(hint)});
  };

  // O_NONBLOCK: opening a pipe must not wait for its writer.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    const int reason = errno;
    if (reason == ENOENT || reason == ENOTDIR) return refuse(Error::Code::kNotFound, "no such file", "check the path");
    return refuse(Error::Code::kUnreadable, std::string("cannot be opened: ") + std::strerror(reason),
                  reason == EACCES ? "check the permissions of the file and its folders" : "");
  }

  struct Closer {
    int fd;
    ~Closer() { ::close(fd); }
  } closer{fd};

  struct stat status {};
  if (::fstat(fd, &status) != 0) return refuse(Error::Code::kUnreadable, std::strerror(errno), "");
  if (S_ISDIR(status.st_mode))
    return refuse(Error::Code::kUnreadable, "a folder",
                  "name a mesh file; of a case or a run first kerf export " + path.string() + " -o MESH.stl");
  if (!S_ISREG(status.st_mode))
    return refuse(Error::Code::kUnreadable, "not a regular file (a device or a pipe)", "save the data to a file first");
  if (status.st_size == 0)
    return fail(source.atByte(0, Error::Code::kEmpty, "an empty file (0 bytes)",
                              "a mesh file (" + readableExtensions() + ")",
                              "export or copy it again; the copy may have been interrupted"));

  source.size = static_cast<std::size_t>(status.st_size);
  if (source.size > limit)
    return refuse(Error::Code::kUnreadable, std::to_string(source.size) + " bytes, more than " + std::to_string(limit),
                  "reduce it first");
  source.bytes.reset(new (std::nothrow) char[source.size]);
  if (!source.bytes)
    return refuse(Error::Code::kUnreadable, std::to_string(source.size) + " bytes do not fit into memory",
                  "reduce the mesh first");

  for (std::size_t done = 0; done < source.size;) {
    const ssize_t n = ::read(fd, source.bytes.get() + done, source.size - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return refuse(Error::Code::kUnreadable, std::string("cannot be read: ") + std::strerror(errno), "");
    if (n == 0)
      return fail(source.atByte(done, Error::Code::kUnreadable, "the file got shorter while it was read",
                                std::to_string(source.size) + " bytes", "wait until it is written completely"));
    done += static_cast<std::size_t>(n);
  }
  return source;
}

namespace {

void appendUtf8(std::uint32_t code, std::string& text) {
  const auto tail = [&](int shift) { text += static_cast<char>(0x80 | ((code >> shift) & 0x3f)); };
  if (code < 0x80) {
    text += static_cast<char>(code);
  } else if (code < 0x800) {
    text += static_cast<char>(0xc0 | code >> 6);
    tail(0);
  } else if (code < 0x10000) {
    text += static_cast<char>(0xe0 | code >> 12);
    tail(6);
    tail(0);
  } else {
    text += static_cast<char>(0xf0 | code >> 18);
    tail(12);
    tail(6);
    tail(0);
  }
}

// 0 or 1: which byte of a unit is the high one, by the byte order mark or by the zeros of plain letters. -1: no UTF-16.
int highByteOfUtf16(std::string_view text) {
  if (text.starts_with("\xff\xfe")) return 1;
  if (text.starts_with("\xfe\xff")) return 0;
  constexpr std::size_t kLetters = 8;
  if (text.size() < 2 * kLetters) return -1;
  for (const std::size_t high : {std::size_t{1}, std::size_t{0}}) {
    bool all = true;
    for (std::size_t i = 0; i < kLetters; ++i) {
      const char letter = text[2 * i + 1 - high];
      all = all && text[2 * i + high] == 0 && (isBlank(letter) || isLineEnd(letter) || (letter > 32 && letter < 127));
    }
    if (all) return static_cast<int>(high);
  }
  return -1;
}

}  // namespace

std::string_view decodeText(const MeshSource& source, MeshSource& out) {
  const std::string_view text = source.text();
  std::string decoded;
  std::string_view note;
  if (text.starts_with("\xef\xbb\xbf")) {
    decoded = text.substr(3);
    note = "The file begins with a byte order mark, which was skipped.";
  } else if (const int high_byte = highByteOfUtf16(text); high_byte >= 0) {
    const auto high = static_cast<std::size_t>(high_byte);
    const auto unit = [&](std::size_t i) -> std::uint32_t {
      const auto byte = [&](std::size_t at) { return std::uint32_t{static_cast<unsigned char>(text[at])}; };
      return byte(2 * i + high) << 8 | byte(2 * i + 1 - high);
    };
    decoded.reserve(text.size() / 2);
    for (std::size_t i = 0, end = text.size() / 2; i < end; ++i) {
      std::uint32_t code = unit(i);
      if (i == 0 && code == 0xfeff) continue;
      const bool is_pair = code >= 0xd800 && code < 0xdc00 && i + 1 < end && (unit(i + 1) & 0xfc00) == 0xdc00;
      if (is_pair) code = 0x10000 + ((code & 0x3ff) << 10 | (unit(++i) & 0x3ff));
      appendUtf8(code, decoded);
    }
    note = "The text is in UTF-16 and was read as such.";
  }
  if (note.empty() || decoded.empty()) return {};

  out.file = source.file;
  out.size = decoded.size();
  out.bytes.reset(new char[out.size]);
  std::copy(decoded.begin(), decoded.end(), out.bytes.get());
  return note;
}

std::string inQuotes(std::string_view word) {
  if (word.empty()) return "nothing";
  std::string text = "\"";
  for (const char c : word.substr(0, 40)) {
    const auto u = static_cast<unsigned char>(c);
    if (u >= 0x20 && u < 0x7f) {
      text += c;
    } else {
      constexpr const char* kHex = "0123456789abcdef";
      text += {'\\', 'x', kHex[u >> 4], kHex[u & 15]};
    }
  }
  return text + (word.size() > 40 ? "...\"" : "\"");
}

bool equalsIgnoringCase(std::string_view a, std::string_view lower_case) {
  return a.size() == lower_case.size() && std::equal(a.begin(), a.end(), lower_case.begin(), [](char x, char y) {
           return static_cast<char>(std::tolower(static_cast<unsigned char>(x))) == y;
         });
}

namespace {

template <class T>
const char* parseReal(std::string_view word, T& value) {
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error == std::errc::invalid_argument || end != word.data() + word.size()) return "not a number";
  if (error == std::errc::result_out_of_range) {
    if (word.find("e-") == word.npos && word.find("E-") == word.npos) return "too large a number";
    value = 0;  // below the smallest number: means zero in a scan
    return nullptr;
  }
  return std::isfinite(value) ? nullptr : "not a finite number";
}

}  // namespace

const char* parseNumber(std::string_view word, double& value) { return parseReal(word, value); }
const char* parseNumber(std::string_view word, float& value) { return parseReal(word, value); }

const char* parseInteger(std::string_view word, std::int64_t& value) {
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error == std::errc::invalid_argument || end != word.data() + word.size()) return "not an integer";
  return error == std::errc{} ? nullptr : "too large an integer";
}

std::string numberHint(std::string_view word) {
  if (word.find(',') != word.npos) return "write decimal points, not commas: export with an English locale";
  return "export the mesh again";
}

const char* parseCoordinate(std::string_view word, double& value, bool& is_double) {
  if (const char* wrong = parseNumber(word, value)) return wrong;
  const double nearest = roundedToFloat(value);
  if (nearest == value) return nullptr;

  // Uncertainty of the digits: half a unit of the last one.
  int decimals = 0, exponent = 0;
  const std::size_t e = std::min(word.find_first_of("eE"), word.size());
  if (const std::size_t point = word.substr(0, e).find('.'); point != word.npos)
    decimals = static_cast<int>(e - point) - 1;
  if (e < word.size()) {
    std::string_view digits = word.substr(e + 1);
    if (digits.starts_with('+')) digits.remove_prefix(1);
    std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
  }

  constexpr double kSlack = 1 + 1e-6;  // `value` is rounded itself
  if (std::abs(value - nearest) > kSlack * 0.5 * std::pow(10.0, exponent - decimals)) is_double = true;
  return nullptr;
}

std::string unitIn(std::string_view text) {
  constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
      {"mm", "mm"},      {"millimeter", "mm"}, {"millimeters", "mm"}, {"millimetre", "mm"}, {"millimetres", "mm"},
      {"cm", "cm"},      {"centimeter", "cm"}, {"centimeters", "cm"}, {"m", "m"},           {"meter", "m"},
      {"meters", "m"},   {"metre", "m"},       {"metres", "m"},       {"um", "um"},         {"micron", "um"},
      {"microns", "um"}, {"in", "inch"},       {"inch", "inch"},      {"inches", "inch"}};

  bool after_unit = false;
  for (std::size_t i = 0; i < text.size();) {
    if (!std::isalpha(static_cast<unsigned char>(text[i]))) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && std::isalpha(static_cast<unsigned char>(text[end]))) ++end;
    const std::string_view word = text.substr(i, end - i);
    if (after_unit)
      for (const auto& [spelled, unit] : kUnits)
        if (equalsIgnoringCase(word, spelled)) return std::string(unit);
    after_unit = equalsIgnoringCase(word, "unit") || equalsIgnoringCase(word, "units") ||
                 (after_unit && (equalsIgnoringCase(word, "is") || equalsIgnoringCase(word, "are")));
    i = end;
  }
  return {};
}

std::vector<Rgba8> NumericColors::finish(bool is_real, MeshFile& file) {
  // For real numbers, a tenth of the values above black decides the scale, so that no single value makes all others
  // black.
  struct Range {
    std::size_t bright = 0, above_one = 0, above_byte = 0;
    void add(double c) {
      bright += std::isfinite(c) && c > 0 ? 1 : 0;
      above_one += std::isfinite(c) && c >= 2 ? 1 : 0;  // somewhat above 1 through rounding
      above_byte += std::isfinite(c) && c >= 256 ? 1 : 0;
    }
    double scale(bool real) const {
      const std::size_t few = real ? bright / 10 : 0;
      return above_byte > few ? 255.0 / 65535 : above_one > few || !real ? 1.0 : 255.0;
    }
  };
  Range light, alpha;
  for (const auto& [r, g, b, a] : values_) {
    for (const double c : {r, g, b}) light.add(c);
    alpha.add(a);
  }
  const double of_light = light.scale(is_real);
  const std::array<double, 4> scale{of_light, of_light, of_light, alpha.scale(is_real)};

  std::size_t odd = 0;
  std::vector<Rgba8> out(values_.size(), kNoColor);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (values_[i][3] < 0) continue;
    if (!std::all_of(values_[i].begin(), values_[i].end(), [](double c) { return std::isfinite(c); })) {
      ++odd;
      continue;
    }
    for (std::size_t k = 0; k < 4; ++k)
      out[i][k] = static_cast<std::uint8_t>(std::lround(std::clamp(scale[k] * values_[i][k], 0.0, 255.0)));
  }
  values_.clear();
  if (odd > 0)
    file.notes.emplace_back(std::to_string(odd) + " colours are not finite (NaN or infinite): grey instead.");
  return out;
}

Expected<MeshFile> finished(const MeshSource& source, MeshFile file) {
  if (!file.mesh.triangles.empty()) return file;
  if (!file.mesh.vertices.empty())
    return fail(
        {.code = Error::Code::kEmpty,
         .file = source.file,
         .place = "faces",
         .found = "a point cloud: " + std::to_string(file.mesh.vertices.size()) + " points and no faces",
         .expected = "a surface made of triangles",
         .hint = "export the mesh, not the points, from the scanner software, or reconstruct the surface first"});
  return fail({.code = Error::Code::kEmpty,
               .file = source.file,
               .place = "faces",
               .found = "no faces and no vertices",
               .expected = "a surface made of triangles",
               .hint = "export the mesh again"});
}

tl::unexpected<Error> cancelled(const MeshSource& source) {
  return fail({.code = Error::Code::kCancelled, .file = source.file, .place = "reading", .found = "cancelled"});
}

}  // namespace kerf::internal
