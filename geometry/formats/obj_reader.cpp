// Wavefront OBJ: v (with the common colour extension v x y z r g b) and f; everything else is skipped and noted.
#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/formats/mesh_source.h"

namespace kerf::internal {
namespace {

constexpr Rgba8 kNoObjColor{200, 200, 200, 255};
constexpr std::string_view kSkipped[] = {
    "vn",  "vt",     "vp",     "g",     "o",          "s",         "mg",    "usemtl",   "mtllib",   "l",
    "p",   "usemap", "maplib", "lod",   "shadow_obj", "trace_obj", "bevel", "c_interp", "d_interp", "cstype",
    "deg", "curv",   "curv2",  "surf",  "parm",       "trim",      "hole",  "scrv",     "sp",       "end",
    "con", "bmat",   "step",   "ctech", "stech",      "call",      "csh"};

class ObjReader {
 public:
  ObjReader(const MeshSource& source, const Progress& progress) : source_(source), progress_(progress) {}

  Expected<MeshFile> read() {
    Lines lines(source_.text());
    std::string_view line;
    std::string joined;  // a statement continued over several lines
    for (std::size_t number = 0; lines.next(line); ++number) {
      if (number % 65536 == 0) {
        const double done = static_cast<double>(line.data() - source_.bytes.get()) / static_cast<double>(source_.size);
        if (!report(progress_, done, "reading OBJ")) return cancelled(source_);
      }

      at_ = line.data();
      if (!line.empty() && line.back() == '\\' && line[line.find_first_not_of(" \t")] != '#') {
        joined.clear();
        do {
          joined.append(line.substr(0, line.size() - 1)).append(" ");
        } while (lines.next(line) && !line.empty() && line.back() == '\\');
        line = joined.append(!line.empty() && line.back() != '\\' ? line : std::string_view{});
      }

      KERF_CHECK(readStatement(line));
    }

    if (highest_corner_ > vertices().size())
      return fail(source_.atLine(highest_corner_at_, Error::Code::kBadValue,
                                 "vertex index " + std::to_string(highest_corner_),
                                 "1 to " + std::to_string(vertices().size()), kDamaged));
    noteSkipped();
    triangulate(polygons_, file_);
    return finished(source_, std::move(file_));
  }

 private:
  static constexpr const char* kDamaged = "the file is cut short or damaged; export or copy it again";
  std::vector<Vec3d>& vertices() { return file_.mesh.vertices; }

  tl::unexpected<Error> bad(std::string found, std::string expected, std::string hint = kDamaged) const {
    return fail(source_.atLine(at_, Error::Code::kBadValue, std::move(found), std::move(expected), std::move(hint)));
  }

  Expected<void> readStatement(std::string_view line) {
    Words words(line);
    const std::string_view keyword = words.next();
    if (keyword.empty()) return {};
    if (keyword[0] == '#') {
      if (file_.declared_unit.empty()) file_.declared_unit = unitIn(line);
      return {};
    }
    if (keyword == "v") return readVertex(words);
    if (keyword == "f" || keyword == "fo") return readFace(words);
    const bool known = std::find(std::begin(kSkipped), std::end(kSkipped), keyword) != std::end(kSkipped);
    const bool is_word = std::all_of(keyword.begin(), keyword.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    });
    if (!known && (!is_word || vertices().empty()))
      return fail(
          source_.atLine(at_, Error::Code::kBadFormat, inQuotes(keyword), "an OBJ statement (v, f, ...)", kDamaged));
    ++skipped_[std::string(keyword)];
    return {};
  }

  Expected<void> readVertex(Words& words) {
    std::array<double, 7> value{};
    std::size_t n = 0;
    for (std::string_view word = words.next(); !word.empty() && word[0] != '#'; word = words.next(), ++n) {
      if (n == value.size()) return bad("more than seven numbers after \"v\"", "x y z [r g b]");
      if (const char* wrong =
              n < 3 ? parseCoordinate(word, value[n], file_.had_double_coordinates) : parseNumber(word, value[n]))
        return bad(inQuotes(word) + ", " + wrong, "a finite number", numberHint(word));
    }

    if (n < 3 || n == 5) return bad(std::to_string(n) + " numbers after \"v\"", "x y z or x y z r g b");
    if (vertices().size() >= 0xfffffff0u)
      return bad("more than 4 294 967 280 vertices", "fewer", "reduce the mesh first");

    vertices().emplace_back(value[0], value[1], value[2]);
    if (n >= 6) {
      std::vector<Rgba8>& colors = file_.mesh.vertex_colors;
      colors.resize(vertices().size() - 1, kNoObjColor);
      Rgba8 color = kNoObjColor;
      for (std::size_t k = 0; k < 3; ++k) {
        const double c = value[n - 3 + k];  // 0..1 by custom; some programs write 0..255
        color[k] = static_cast<std::uint8_t>(std::lround(std::clamp(c <= 1.0 ? 255 * c : c, 0.0, 255.0)));
      }
      colors.push_back(color);
    } else if (file_.mesh.hasVertexColors()) {
      file_.mesh.vertex_colors.push_back(kNoObjColor);
    }
    return {};
  }

  Expected<void> readFace(Words& words) {
    corners_.clear();
    for (std::string_view word = words.next(); !word.empty() && word[0] != '#'; word = words.next()) {
      std::int64_t index = 0;
      // v, v/vt, v//vn, v/vt/vn: texture and normal must be integers but are not used.
      for (std::size_t part = 0, begin = 0;; ++part) {
        const std::size_t slash = word.find('/', begin);
        const std::string_view number = word.substr(begin, slash == word.npos ? word.npos : slash - begin);
        std::int64_t ignored = 0;
        if (part == 0 || !number.empty())
          if (const char* wrong = parseInteger(number, part == 0 ? index : ignored))
            return bad(inQuotes(word) + ", " + wrong, "a corner v, v/vt, v//vn or v/vt/vn");
        if (slash == word.npos) break;
        if (part == 2) return bad(inQuotes(word), "a corner v, v/vt, v//vn or v/vt/vn");
        begin = slash + 1;
      }

      const auto count = static_cast<std::int64_t>(vertices().size());
      if (index < 0) index = index < -count ? 0 : count + 1 + index;  // -1 is the newest vertex
      if (index <= 0 || index > 0xfffffff0ll)
        return bad("corner " + inQuotes(word), "a vertex number from 1 to " + std::to_string(count));
      if (index > count && static_cast<std::uint64_t>(index) > highest_corner_) {
        highest_corner_ = static_cast<std::uint64_t>(index);
        highest_corner_at_ = at_;
      }

      corners_.push_back(static_cast<std::uint32_t>(index - 1));
      if (corners_.size() > kMaxPolygonCorners)
        return bad("a face of more than " + std::to_string(kMaxPolygonCorners) + " corners", "fewer",
                   "triangulate the mesh before exporting it");
    }

    if (corners_.size() < 3) return bad("a face of " + std::to_string(corners_.size()) + " corners", "three or more");
    polygons_.add(corners_.data(), corners_.size());
    return {};
  }

  void noteSkipped() {
    if (skipped_.contains("mtllib"))
      file_.notes.emplace_back("Materials and textures (mtllib) were not read; colours come from the vertices only.");
    std::string odd;
    for (const auto& [keyword, count] : skipped_) {
      const bool known = std::find(std::begin(kSkipped), std::end(kSkipped), keyword) != std::end(kSkipped);
      if (!known || keyword == "l" || keyword == "p" || keyword == "surf" || keyword == "curv")
        odd += (odd.empty() ? "" : ", ") + keyword + " (" + std::to_string(count) + ")";
    }
    if (!odd.empty()) file_.notes.emplace_back("Statements skipped: " + odd + ".");
    if (!isLineEnd(source_.bytes[source_.size - 1]))
      file_.notes.emplace_back("The last line has no line end: check that the file is complete.");
  }

  const MeshSource& source_;
  const Progress& progress_;
  const char* at_ = nullptr;  // first line of the current statement
  MeshFile file_;
  Polygons polygons_;
  std::vector<std::uint32_t> corners_;
  std::uint64_t highest_corner_ = 0;  // a face may name vertices that come later; checked at the end
  const char* highest_corner_at_ = nullptr;
  std::map<std::string, std::size_t> skipped_;
};

}  // namespace

bool isObj(const MeshSource& source) {
  Lines lines(source.text().substr(0, 1 << 16));
  std::string_view line;
  while (lines.next(line)) {
    const std::string_view keyword = Words(line).next();
    if (keyword.empty() || keyword[0] == '#') continue;
    if (keyword == "v" || keyword == "f") return true;
    if (std::find(std::begin(kSkipped), std::end(kSkipped), keyword) == std::end(kSkipped)) return false;
  }
  return false;
}

Expected<MeshFile> readObj(const MeshSource& source, const Progress& progress) {
  return ObjReader(source, progress).read();
}

}  // namespace kerf::internal
