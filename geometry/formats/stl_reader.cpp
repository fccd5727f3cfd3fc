// STL. Binary: 80 bytes of header, uint32 count, 50 bytes per triangle. ASCII: solid / facet / vertex, any case.
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

Expected<MeshFile> readBinary(const MeshSource& source, const Progress& progress) {
  const char* hint = "the file is cut short or damaged; export or copy it again";
  if (source.size < kHeader)
    return fail(source.atByte(source.size, Error::Code::kBadFormat,
                              "the end of the file after " + std::to_string(source.size) + " bytes",
                              "at least 84 bytes of a binary STL", hint));

  const std::size_t count = littleEndian32(&source.bytes[80]);
  if (!hasBinarySize(source))
    return fail(source.atByte(
        80, Error::Code::kBadFormat,
        "a count of " + std::to_string(count) + " triangles in a file of " + std::to_string(source.size) + " bytes",
        "84 + 50 x count = " + std::to_string(kHeader + kRecord * count) + " bytes", hint));

  if (count >= 0xffffffffu / 3)
    return fail(source.atByte(80, Error::Code::kUnsupported, std::to_string(count) + " triangles",
                              "fewer than 1.4 thousand million", "reduce the mesh first"));
  MeshFile file;
  file.format = "binary STL";
  file.declared_unit = unitIn(source.text().substr(0, 80));
  file.unwelded_vertices = 3 * count;
  file.mesh.triangles.reserve(count);
  ExactWelder welder(count / 2 + 16);  // a closed surface has half as many vertices as triangles

  std::size_t coloured = 0;
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

    if (record[48] != 0 || record[49] != 0) ++coloured;
    file.mesh.triangles.push_back(triangle);
  }

  file.mesh.vertices = std::move(welder.vertices);
  if (coloured > 0)
    file.notes.emplace_back(std::to_string(coloured) +
                            " triangles carry an attribute word (some programs store a colour there); it was ignored.");
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
  Expected<void> keyword(std::string_view expected) {
    const std::string_view word = next();
    if (equalsIgnoringCase(word, expected)) return {};
    return unexpected(word, inQuotes(expected));
  }

  Expected<void> readSolid() {
    for (;;) {
      const std::string_view word = next();
      if (equalsIgnoringCase(word, "endsolid")) {
        restOfLine();
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
  MeshFile file_;
};

// ASCII unless there are zero bytes: a damaged binary STL whose header begins with "solid" must be called binary.
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
