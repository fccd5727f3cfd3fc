// Shared by the mesh readers: the bytes of a file, lines and words, numbers, errors with a place, polygons.
#pragma once

#include <charconv>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/formats/mesh_io.h"

namespace kerf::internal {

/// A whole file in memory, under the name the user gave it.
struct MeshSource {
  std::string file;
  std::unique_ptr<char[]> bytes;
  std::size_t size = 0;

  std::string_view text() const { return {bytes.get(), size}; }
  bool hasExtension(std::string_view list) const;  ///< any of ".stl .ply", any case
  std::string extension() const;                   ///< lower case, with the dot
  Error atByte(std::size_t offset, Error::Code code, std::string found, std::string expected = {},
               std::string hint = {}) const;
  /// `at` points into text(); counts the lines only now.
  Error atLine(const char* at, Error::Code code, std::string found, std::string expected = {},
               std::string hint = {}) const;
};

/// @param limit  bytes; a longer file is an error without a read.
Expected<MeshSource> loadMeshSource(const std::filesystem::path& path, std::size_t limit = SIZE_MAX);
/// Text in UTF-16 as UTF-8, without a byte order mark. Returns a note on the change; empty without one, with `out`
/// unchanged.
std::string_view decodeText(const MeshSource& source, MeshSource& out);

/// A word for a message: quoted, at most 40 characters, unprintable bytes as \xNN.
std::string inQuotes(std::string_view word);
bool equalsIgnoringCase(std::string_view a, std::string_view lower_case);
inline bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
inline bool isLineEnd(char c) { return c == '\n' || c == '\r'; }

/// Words of one line.
class Words {
 public:
  explicit Words(std::string_view line) : p_(line.data()), end_(line.data() + line.size()) {}
  /// The next word, empty at the end of the line.
  std::string_view next() {
    while (p_ != end_ && isBlank(*p_)) ++p_;
    const char* begin = p_;
    while (p_ != end_ && !isBlank(*p_)) ++p_;
    return {begin, static_cast<std::size_t>(p_ - begin)};
  }
  std::string_view rest() {
    while (p_ != end_ && isBlank(*p_)) ++p_;
    return {p_, static_cast<std::size_t>(end_ - p_)};
  }

 private:
  const char *p_, *end_;
};

/// Lines of a text; ends with \n, \r\n or \r.
class Lines {
 public:
  explicit Lines(std::string_view text) : p_(text.data()), end_(text.data() + text.size()) {}
  bool next(std::string_view& line) {
    if (p_ == end_) return false;
    const char* begin = p_;
    while (p_ != end_ && !isLineEnd(*p_)) ++p_;
    line = {begin, static_cast<std::size_t>(p_ - begin)};
    if (p_ != end_) p_ += (*p_ == '\r' && p_ + 1 != end_ && p_[1] == '\n') ? 2 : 1;
    return true;
  }
  const char* position() const { return p_; }

 private:
  const char *p_, *end_;
};

/// Reads one whole word as a finite number, independent of the locale. Returns nullptr, or the error.
const char* parseNumber(std::string_view word, double& value);
const char* parseNumber(std::string_view word, float& value);
/// The same for an integer; wrong also when it does not fit.
const char* parseInteger(std::string_view word, std::int64_t& value);
/// Hint for a word rejected by parseNumber ("1,5": decimal comma).
std::string numberHint(std::string_view word);
/// A coordinate. Sets `is_double` if the text exceeds a float32: neither the shortest text that reads back as one, nor
/// rounded to fewer digits.
const char* parseCoordinate(std::string_view word, double& value, bool& is_double);
/// "mm", "cm", "m", "um", "inch" if the text declares one ("units: mm", "UNIT=inch"), else empty.
std::string unitIn(std::string_view text);

/// Colour of an item without a colour, or with a colour that is no number.
inline constexpr Rgba8 kNoColor{200, 200, 200, 255};
/// Colours written as numbers. The largest of a file decides the scale: 1 (if real), 255 or 65535.
class NumericColors {
 public:
  /// A negative alpha: no colour.
  void add(const std::array<double, 4>& rgba) { values_.push_back(rgba); }
  bool empty() const { return values_.empty(); }
  std::size_t size() const { return values_.size(); }
  /// Empties this. A colour that is not finite becomes kNoColor, with a note.
  std::vector<Rgba8> finish(bool is_real, MeshFile& file);

 private:
  std::vector<std::array<double, 4>> values_;
};

/// Faces in the order of the file, corners not yet checked against the vertices (which may come later).
struct Polygons {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> sizes;  ///< corners per face
  std::vector<Rgba8> colors;         ///< empty or one per face

  void add(const std::uint32_t* begin, std::size_t n) {
    corners.insert(corners.end(), begin, begin + n);
    sizes.push_back(static_cast<std::uint32_t>(n));
  }
};
inline constexpr std::size_t kMaxPolygonCorners = 1024;
/// Turns polygons into the triangles (and face colours) of `file.mesh` and counts them. All corners must be in range.
/// Omits faces of one or two corners, with a note.
void triangulate(const Polygons& polygons, MeshFile& file);

/// Last check of every reader: a mesh without faces is an error (with a note for a point cloud).
Expected<MeshFile> finished(const MeshSource& source, MeshFile file);
/// The error of a cancelled reader.
tl::unexpected<Error> cancelled(const MeshSource& source);

}  // namespace kerf::internal
