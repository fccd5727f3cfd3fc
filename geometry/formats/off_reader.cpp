// Object File Format (Geomview), ASCII: OFF, COFF, NOFF, CNOFF and the ST variants.
#include <algorithm>
#include <cmath>

#include "geometry/formats/mesh_source.h"

namespace kerf::internal {
namespace {

struct Kind {
  bool texture = false, color = false, normal = false, four = false, any_dimension = false;
};

// "STCN4nOFF", every letter optional.
bool parseKind(std::string_view word, Kind& kind) {
  if (word.substr(0, 2) == "ST") {
    kind.texture = true;
    word.remove_prefix(2);
  }
  if (word.substr(0, 1) == "C") {
    kind.color = true;
    word.remove_prefix(1);
  }
  if (word.substr(0, 1) == "N") {
    kind.normal = true;
    word.remove_prefix(1);
  }
  if (word.substr(0, 1) == "4") {
    kind.four = true;
    word.remove_prefix(1);
  }
  if (word.substr(0, 1) == "n") {
    kind.any_dimension = true;
    word.remove_prefix(1);
  }
  return word == "OFF";
}

class OffReader {
 public:
  OffReader(const MeshSource& source, const Progress& progress)
      : source_(source), progress_(progress), lines_(source.text()) {}

  Expected<MeshFile> read() {
    KERF_CHECK(readHeader());
    KERF_CHECK(readVertices());
    KERF_CHECK(readFaces());

    std::string_view extra;
    if (nextLine(extra)) return bad(extra, inQuotes(extra) + " after the last face", "the end of the file");
    if (colors_skipped_) file_.notes.emplace_back("Colours given as an index into a colour table were not read.");
    if (odd_colors_ > 0)
      file_.notes.emplace_back(std::to_string(odd_colors_) +
                               " colours are not finite (NaN or infinite): grey instead.");
    if (extra_values_) file_.notes.emplace_back("Additional values per vertex (normals or texture) were not read.");

    triangulate(polygons_, file_);
    return finished(source_, std::move(file_));
  }

 private:
  static constexpr const char* kDamaged = "the file is cut short or damaged; export or copy it again";

  tl::unexpected<Error> bad(std::string_view at, std::string found, std::string expected,
                            std::string hint = kDamaged) const {
    return fail(
        source_.atLine(at.data(), Error::Code::kBadFormat, std::move(found), std::move(expected), std::move(hint)));
  }

  // The next line with something on it besides a comment.
  bool nextLine(std::string_view& line) {
    while (lines_.next(line)) {
      if (const std::size_t comment = line.find('#'); comment != line.npos) {
        if (file_.declared_unit.empty()) file_.declared_unit = unitIn(line.substr(comment));
        line = line.substr(0, comment);
      }
      if (!Words(line).next().empty()) return true;
    }
    line = {source_.bytes.get() + source_.size, 0};
    return false;
  }

  Expected<void> readHeader() {
    std::string_view line;
    if (!nextLine(line)) return bad(line, "the end of the file", "\"OFF\"");
    Words words(line);
    const std::string_view keyword = words.next();
    if (!parseKind(keyword, kind_)) return bad(line, inQuotes(keyword), "\"OFF\", \"COFF\" or \"NOFF\"");

    if (kind_.four || kind_.any_dimension)
      return fail(source_.atLine(line.data(), Error::Code::kUnsupported,
                                 inQuotes(keyword) + ": vertices not of three coordinates", "OFF, COFF or NOFF",
                                 "export as three-dimensional OFF"));

    std::string_view word = words.next();
    if (word == "BINARY")
      return fail(source_.atLine(line.data(), Error::Code::kUnsupported, "binary OFF", "ASCII OFF",
                                 "save as ASCII OFF, or as PLY or STL"));
    if (word.empty()) {
      if (!nextLine(line)) return bad(line, "the end of the file", "the numbers of vertices, faces and edges");
      words = Words(line);
      word = words.next();
    }

    std::array<std::int64_t, 3> count{};
    for (std::size_t k = 0; k < 3; ++k, word = words.next()) {
      if (word.empty() && k == 2) break;  // the number of edges is often missing and never used
      if (const char* wrong = parseInteger(word, count[k]))
        return bad(line, inQuotes(word) + ", " + wrong, "a count of vertices, faces or edges");
      if (count[k] < 0) return bad(line, "a count of " + std::to_string(count[k]), "a count that is not negative");
    }

    // A vertex takes at least "0 0 0\n", a face "1 0\n".
    const std::size_t left = static_cast<std::size_t>(source_.bytes.get() + source_.size - lines_.position()) + 1;
    vertex_count_ = static_cast<std::size_t>(count[0]);
    face_count_ = static_cast<std::size_t>(count[1]);
    if (vertex_count_ > left / 6 || face_count_ > left / 4 || vertex_count_ >= 0xfffffff0u)
      return bad(line, std::to_string(vertex_count_) + " vertices and " + std::to_string(face_count_) + " faces",
                 "what the " + std::to_string(left - 1) + " bytes after it have room for");
    return {};
  }

  // Integers 0..255, or numbers 0..1 when one of the words has a point or an exponent.
  Expected<bool> parseColor(std::string_view line, const std::string_view* word, std::size_t n, Rgba8& color) {
    color = kNoColor;
    if (n < 3 || n > 4) return false;
    bool real = false;
    for (std::size_t k = 0; k < n; ++k) real |= word[k].find_first_of(".eE") != std::string_view::npos;

    for (std::size_t k = 0; k < n; ++k) {
      double value = 0;
      const char* const wrong = parseNumber(word[k], value);
      if (wrong && (equalsIgnoringCase(word[k], "nan") || equalsIgnoringCase(word[k], "-nan"))) {
        color = kNoColor;
        ++odd_colors_;
        return true;
      }
      if (wrong) return bad(line, inQuotes(word[k]) + ", " + wrong, "a colour", numberHint(word[k]));
      if (real) value *= 255;
      if (value < 0 || value > 255.5) return bad(line, "colour " + inQuotes(word[k]), "0 to 255, or 0.0 to 1.0");
      color[k] = static_cast<std::uint8_t>(std::min(255l, std::lround(value)));
    }
    return true;
  }

  Expected<void> readVertices() {
    Mesh& mesh = file_.mesh;
    mesh.vertices.reserve(vertex_count_);
    std::array<std::string_view, 16> word;
    for (std::size_t i = 0; i < vertex_count_; ++i) {
      if (i % 65536 == 0 &&
          !report(progress_, 0.5 * static_cast<double>(i) / static_cast<double>(vertex_count_), "reading OFF"))
        return cancelled(source_);
      std::string_view line;
      if (!nextLine(line))
        return bad(line, "the end of the file at vertex " + std::to_string(i),
                   std::to_string(vertex_count_) + " vertices");
      std::size_t n = 0;
      Words words(line);
      for (std::string_view w = words.next(); !w.empty(); w = words.next()) {
        if (n == word.size()) return bad(line, "more than 16 values for vertex " + std::to_string(i), "x y z");
        word[n++] = w;
      }
      std::size_t used = kind_.normal ? 6 : 3;
      if (n < used)
        return bad(line, std::to_string(n) + " values for vertex " + std::to_string(i),
                   "at least " + std::to_string(used));
      Vec3d p;
      for (int k = 0; k < 3; ++k) {
        const std::string_view w = word[static_cast<std::size_t>(k)];
        if (const char* wrong = parseCoordinate(w, p[k], file_.had_double_coordinates))
          return bad(line, inQuotes(w) + ", " + wrong, "a finite coordinate", numberHint(w));
      }
      mesh.vertices.push_back(p);
      // OpenMesh and its kin write COFF for face colours alone.
      if (i == 0 && n == used) kind_.color = false;
      if (kind_.color) {
        // Then follow a colour of three or four numbers, and two of texture if the header says ST.
        const std::size_t of_color = std::min<std::size_t>(n - used - (kind_.texture && n - used >= 2 ? 2 : 0), 4);
        Rgba8 color;
        KERF_TRY(good, parseColor(line, &word[used], of_color, color));
        if (!good)
          return bad(line, "no colour for vertex " + std::to_string(i), "three or four numbers after the position");
        mesh.vertex_colors.push_back(color);
        used += of_color;
      }
      extra_values_ |= kind_.normal || n > used;
    }
    return {};
  }

  Expected<void> readFaces() {
    polygons_.sizes.reserve(face_count_);
    polygons_.corners.reserve(3 * face_count_);
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < face_count_; ++i) {
      if (i % 65536 == 0 &&
          !report(progress_, 0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(face_count_), "reading OFF"))
        return cancelled(source_);
      std::string_view line;
      if (!nextLine(line))
        return bad(line, "the end of the file at face " + std::to_string(i), std::to_string(face_count_) + " faces");
      Words words(line);
      const std::string_view first = words.next();
      std::int64_t n = 0;
      if (const char* wrong = parseInteger(first, n))
        return bad(line, inQuotes(first) + ", " + wrong, "the number of corners of a face");
      if (n < 0 || n > static_cast<std::int64_t>(kMaxPolygonCorners))
        return bad(line, "a face of " + std::to_string(n) + " corners", "0 to " + std::to_string(kMaxPolygonCorners),
                   "triangulate the mesh before exporting it");
      corners.clear();
      for (std::int64_t k = 0; k < n; ++k) {
        const std::string_view word = words.next();
        std::int64_t index = 0;
        if (const char* wrong = parseInteger(word, index))
          return bad(line, inQuotes(word) + ", " + wrong, "a vertex index");
        if (index < 0 || index >= static_cast<std::int64_t>(vertex_count_))
          return bad(line, "vertex index " + std::to_string(index), "0 to " + std::to_string(vertex_count_) + " - 1");
        corners.push_back(static_cast<std::uint32_t>(index));
      }
      polygons_.add(corners.data(), corners.size());
      std::array<std::string_view, 5> word;
      std::size_t rest = 0;
      for (std::string_view w = words.next(); !w.empty() && rest < word.size(); w = words.next()) word[rest++] = w;
      if (rest == 0 && polygons_.colors.empty()) continue;
      Rgba8 color;
      KERF_TRY(good, parseColor(line, word.data(), rest, color));
      colors_skipped_ |= rest > 0 && !good;
      if (good && polygons_.colors.empty()) polygons_.colors.assign(i, kNoColor);
      if (good || !polygons_.colors.empty()) polygons_.colors.push_back(color);
    }
    return {};
  }

  const MeshSource& source_;
  const Progress& progress_;
  Lines lines_;
  Kind kind_;
  std::size_t vertex_count_ = 0, face_count_ = 0;
  bool colors_skipped_ = false, extra_values_ = false;
  std::size_t odd_colors_ = 0;
  Polygons polygons_;
  MeshFile file_;
};

}  // namespace

bool isOff(const MeshSource& source) {
  Lines lines(source.text().substr(0, 1 << 16));
  std::string_view line;
  while (lines.next(line)) {
    const std::string_view keyword = Words(line).next();
    if (keyword.empty() || keyword[0] == '#') continue;
    Kind kind;
    return parseKind(keyword, kind);
  }
  return false;
}

Expected<MeshFile> readOff(const MeshSource& source, const Progress& progress) {
  return OffReader(source, progress).read();
}

}  // namespace kerf::internal
