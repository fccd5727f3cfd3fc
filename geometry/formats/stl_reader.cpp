// STL. Binary: 80 bytes of header, uint32 count, 50 bytes per triangle. ASCII: solid / facet / vertex, any case.
#include <algorithm>
#include <bit>
#include <cstring>

#include "geometry/formats/mesh_source.h"
#include "geometry/mesh/exact_weld.h"

namespace kerf::internal {
namespace {

constexpr std::size_t kHeader = 84, kRecord = 50;

std::uint32_t littleEndian32(const char* p) {
  const auto* u = reinterpret_cast<const unsigned char*>(p);
  return u[0] | std::uint32_t{u[1]} << 8 | std::uint32_t{u[2]} << 16 | std::uint32_t{u[3]} << 24;
}

bool hasBinarySize(const MeshSource& source) {
  return source.size >= kHeader && source.size == kHeader + kRecord * std::size_t{littleEndian32(&source.bytes[80])};
}

bool startsWithSolid(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size() && (isBlank(text[i]) || isLineEnd(text[i]))) ++i;
  return equalsIgnoringCase(text.substr(i, 5), "solid");
}

bool isPadding(char c) { return c == '\0' || c == '\x1a' || isBlank(c) || isLineEnd(c); }

bool isPrintable(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return isBlank(c) || isLineEnd(c) || (c >= 32 && c < 127); });
}

// The number of facets, by the header and by the bytes behind it.
Expected<std::size_t> countFacets(const MeshSource& source, MeshFile& file) {
  const char* hint = "the file is cut short or damaged; export or copy it again";
  const std::string_view text = source.text();
  if (isPrintable(text.substr(0, 512)))
    return fail(source.atLine(text.data(), Error::Code::kBadFormat,
                              "text that begins with " + inQuotes(text.substr(0, text.find_first_of("\r\n"))),
                              "\"solid\", the first word of an ASCII STL",
                              "check the type of the file; export the mesh again"));
  if (source.size < kHeader)
    return fail(source.atByte(source.size, Error::Code::kBadFormat,
                              "the end of the file after " + std::to_string(source.size) + " bytes",
                              "at least 84 bytes of a binary STL", hint));

  const std::size_t told = littleEndian32(&source.bytes[80]), room = (source.size - kHeader) / kRecord;
  const std::size_t end = kHeader + kRecord * told;
  if (told == 0 || told == 0xffffffffu)
    if (room > 0 && source.size == kHeader + kRecord * room) {
      file.notes.emplace_back("The header counts " + std::to_string(told) + " triangles; the " + std::to_string(room) +
                              " behind it were read.");
      return room;
    }
  if (end > source.size)
    return fail(source.atByte(
        80, Error::Code::kBadFormat,
        "a count of " + std::to_string(told) + " triangles in a file of " + std::to_string(source.size) + " bytes",
        "84 + 50 x count = " + std::to_string(end) + " bytes", hint));

  const std::string_view rest = text.substr(end);
  if (rest.empty()) return told;
  const std::string found =
      std::to_string(rest.size()) + " bytes after the last of " + std::to_string(told) + " triangles";
  if (!std::all_of(rest.begin(), rest.end(), isPadding))
    return fail(source.atByte(end, Error::Code::kBadFormat, found, "the end of the file",
                              "the count in the header is too small, or something was appended: export it again"));
  file.notes.emplace_back(found + " (zeros or blanks) were ignored.");
  return told;
}

// Facet colours out of the attribute words: Materialise Magics, which names a colour of the whole in the header, and
// VisCAM or SolidView.
class StlColors {
 public:
  explicit StlColors(std::string_view header) {
    const std::size_t at = header.find("COLOR=");
    if (at == header.npos || at + 10 > header.size()) return;
    is_magics_ = true;
    for (std::size_t k = 0; k < 4; ++k) whole_[k] = static_cast<std::uint8_t>(header[at + 6 + k]);
  }
  void add(std::uint16_t word) { words_.push_back(word); }
  void finish(MeshFile& file) const {
    const auto isOwn = [&](std::uint16_t word) { return ((word & 0x8000u) != 0) != is_magics_; };
    const auto set = words_.size() - static_cast<std::size_t>(std::count(words_.begin(), words_.end(), 0));
    if (!is_magics_ && std::none_of(words_.begin(), words_.end(), isOwn)) {
      if (set > 0)
        file.notes.emplace_back(std::to_string(set) + " triangles carry an attribute word that is no colour.");
      return;
    }
    file.mesh.face_colors.reserve(words_.size());
    for (const std::uint16_t word : words_) {
      const auto part = [&](int shift) { return static_cast<std::uint8_t>((((word >> shift) & 31) * 255 + 15) / 31); };
      const bool takes_whole = is_magics_ && set == 0;  // the words were never filled in
      if (!isOwn(word) || takes_whole)
        file.mesh.face_colors.push_back(is_magics_ ? whole_ : kNoColor);
      else
        file.mesh.face_colors.push_back(is_magics_ ? Rgba8{part(0), part(5), part(10), 255}
                                                   : Rgba8{part(10), part(5), part(0), 255});
    }
  }

 private:
  bool is_magics_ = false;
  Rgba8 whole_ = kNoColor;
  std::vector<std::uint16_t> words_;
};

Expected<MeshFile> readBinary(const MeshSource& source, const Progress& progress) {
  MeshFile file;
  KERF_TRY(count, countFacets(source, file));
  if (count >= 0xffffffffu / 3)
    return fail(source.atByte(80, Error::Code::kUnsupported, std::to_string(count) + " triangles",
                              "fewer than 1.4 thousand million", "reduce the mesh first"));
  file.format = "binary STL";
  file.declared_unit = unitIn(source.text().substr(0, 80));
  file.unwelded_vertices = 3 * count;
  file.mesh.triangles.reserve(count);
  ExactWelder welder(count / 2 + 16);  // a closed surface has half as many vertices as triangles

  StlColors colors(source.text().substr(0, 80));
  for (std::size_t t = 0; t < count; ++t) {
    if (t % 65536 == 0 && !report(progress, static_cast<double>(t) / static_cast<double>(count), "reading STL"))
      return cancelled(source);

    const char* record = source.bytes.get() + kHeader + kRecord * t;
    Triangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3d p;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t offset = 12 + 12 * k + 4 * c;
        const std::uint32_t bits = littleEndian32(record + offset);
        if ((bits & 0x7f800000u) == 0x7f800000u)
          return fail(
              source.atByte(kHeader + kRecord * t + offset, Error::Code::kBadValue,
                            "a coordinate that is not finite (NaN or infinite) in triangle " + std::to_string(t),
                            "finite numbers", "repair the mesh in the program that wrote it"));
        p[static_cast<int>(c)] = std::bit_cast<float>(bits);
      }
      triangle[k] = welder.add(p);
    }

    colors.add(static_cast<std::uint16_t>(littleEndian32(record + 46) >> 16));
    file.mesh.triangles.push_back(triangle);
  }

  file.mesh.vertices = std::move(welder.vertices);
  colors.finish(file);
  if (startsWithSolid(source.text().substr(0, 80)))
    file.notes.emplace_back("The header begins with \"solid\" although the file is binary; read as binary.");
  return finished(source, std::move(file));
}

class AsciiReader {
 public:
  AsciiReader(const MeshSource& source, const Progress& progress)
      : source_(source),
        progress_(progress),
        p_(source.bytes.get()),
        end_(p_ + source.size),
        welder_(source.size / 512 + 16) {}  // a facet takes about 150 to 280 bytes, a vertex two facets

  Expected<MeshFile> read() {
    file_.format = "ASCII STL";
    std::size_t solids = 0;
    for (std::string_view word = next(); !word.empty(); word = next()) {
      if (!equalsIgnoringCase(word, "solid"))
        return fail(source_.atLine(word.data(), Error::Code::kBadFormat, inQuotes(word),
                                   solids == 0 ? "\"solid\"" : "\"solid\" or the end of the file", hint()));
      const std::string_view title = restOfLine();
      if (file_.declared_unit.empty()) file_.declared_unit = unitIn(title);
      KERF_CHECK(readSolid());
      ++solids;
    }

    file_.unwelded_vertices = 3 * file_.mesh.triangles.size();
    file_.mesh.vertices = std::move(welder_.vertices);
    if (lacks_end_) file_.notes.emplace_back("\"endsolid\" is missing: check that the file is complete.");
    if (odd_words_ > 0)
      file_.notes.emplace_back("Words that do not belong to STL were skipped, in " + std::to_string(odd_words_) +
                               (odd_words_ == 1 ? " place." : " places."));
    if (solids > 1) file_.notes.emplace_back(std::to_string(solids) + " solids were read into one mesh.");
    return finished(source_, std::move(file_));
  }

 private:
  static const char* hint() { return "the file is cut short or damaged; export or copy it again"; }

  std::string_view next() {
    while (p_ != end_ && (isBlank(*p_) || isLineEnd(*p_))) ++p_;
    const char* begin = p_;
    while (p_ != end_ && !isBlank(*p_) && !isLineEnd(*p_)) ++p_;
    return {begin, static_cast<std::size_t>(p_ - begin)};
  }
  std::string_view restOfLine() {
    const char* begin = p_;
    while (p_ != end_ && !isLineEnd(*p_)) ++p_;
    return {begin, static_cast<std::size_t>(p_ - begin)};
  }

  Expected<void> unexpected(std::string_view word, std::string expected) const {
    if (word.empty())
      return fail(source_.atLine(end_, Error::Code::kBadFormat, "the end of the file", std::move(expected), hint()));
    return fail(source_.atLine(word.data(), Error::Code::kBadFormat, inQuotes(word), std::move(expected), hint()));
  }
  // The next keyword. Skips words on the line of the last one, but not numbers: they may be a corner.
  std::string_view nextKeyword(bool skips_numbers = false) {
    const char* last = p_;
    std::string_view word = next();
    const auto isInLine = [&] { return !word.empty() && std::none_of(last, word.data(), isLineEnd); };
    constexpr std::string_view kKeywords[] = {"solid",  "facet",   "normal",   "outer",   "loop",
                                              "vertex", "endloop", "endfacet", "endsolid"};
    const auto isKeyword = [&] {
      return std::any_of(std::begin(kKeywords), std::end(kKeywords),
                         [&](std::string_view known) { return equalsIgnoringCase(word, known); });
    };
    constexpr std::string_view kNumber = "+-.0123456789";
    if (!isInLine() || isKeyword() || (!skips_numbers && kNumber.find(word[0]) != kNumber.npos)) return word;
    ++odd_words_;
    while (isInLine() && !isKeyword()) {
      last = p_;
      word = next();
    }
    return word;
  }
  Expected<void> keyword(std::string_view expected) {
    const std::string_view word = nextKeyword();
    if (equalsIgnoringCase(word, expected)) return {};
    return unexpected(word, inQuotes(expected));
  }

  Expected<void> readSolid() {
    for (;;) {
      const std::string_view word = nextKeyword(true);
      if (equalsIgnoringCase(word, "endsolid")) {
        restOfLine();
        return {};
      }
      // A solid ends where the next one begins, or with the file.
      if ((word.empty() && !file_.mesh.triangles.empty()) || equalsIgnoringCase(word, "solid")) {
        lacks_end_ = true;
        p_ -= word.size();
        return {};
      }
      if (!equalsIgnoringCase(word, "facet")) return unexpected(word, "\"facet\" or \"endsolid\"");
      KERF_CHECK(keyword("normal"));

      // The normal follows from the corners; programs write nan for a degenerate facet. Only its words are counted.
      for (int k = 0; k < 3; ++k)
        if (const std::string_view number = next(); number.empty() || equalsIgnoringCase(number, "outer"))
          return unexpected(number, "three numbers after \"facet normal\"");

      KERF_CHECK(keyword("outer"));
      KERF_CHECK(keyword("loop"));
      Triangle triangle;
      for (std::uint32_t& index : triangle) {
        KERF_CHECK(keyword("vertex"));
        Vec3d p;
        for (int k = 0; k < 3; ++k) {
          const std::string_view number = next();
          if (number.empty()) return unexpected(number, "three coordinates after \"vertex\"");
          if (const char* wrong = parseCoordinate(number, p[k], file_.had_double_coordinates))
            return fail(source_.atLine(number.data(), Error::Code::kBadValue, inQuotes(number) + ", " + wrong,
                                       "a finite coordinate", numberHint(number)));
        }
        if (welder_.vertices.size() >= 0xfffffff0u)
          return fail(source_.atLine(p_, Error::Code::kUnsupported, "more than four thousand million vertices", "",
                                     "reduce the mesh first"));
        index = welder_.add(p);
      }

      KERF_CHECK(keyword("endloop"));
      KERF_CHECK(keyword("endfacet"));
      file_.mesh.triangles.push_back(triangle);
      if (file_.mesh.triangles.size() % 65536 == 0) {
        const double done = static_cast<double>(p_ - source_.bytes.get()) / static_cast<double>(source_.size);
        if (!report(progress_, done, "reading STL")) return cancelled(source_);
      }
    }
  }

  const MeshSource& source_;
  const Progress& progress_;
  const char *p_, *end_;
  ExactWelder welder_;
  bool lacks_end_ = false;
  std::size_t odd_words_ = 0;
  MeshFile file_;
};

// ASCII unless there are zero bytes: a damaged binary STL whose header begins with "solid" must count as binary.
bool isAscii(const MeshSource& source) {
  return startsWithSolid(source.text().substr(0, 4096)) &&
         source.text().substr(0, 4096).find('\0') == std::string_view::npos;
}

}  // namespace

bool isStl(const MeshSource& source) { return hasBinarySize(source) || startsWithSolid(source.text().substr(0, 4096)); }

Expected<MeshFile> readStl(const MeshSource& source, const Progress& progress) {
  if (hasBinarySize(source) || !isAscii(source)) return readBinary(source, progress);
  return AsciiReader(source, progress).read();
}

}  // namespace kerf::internal
