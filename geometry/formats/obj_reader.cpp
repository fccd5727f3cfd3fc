// Wavefront OBJ: v (with the common colour extension v x y z r g b) and f; vt, usemtl and mtllib for colours;
// o and g for names; the reader skips and notes the rest.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "geometry/formats/mesh_texture.h"

namespace kerf::internal {
namespace {

constexpr std::size_t kLargestMaterials = std::size_t{16} << 20;  // bytes
constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::string_view kSkipped[] = {
    "vn",  "vt",     "vp",     "g",     "o",          "s",         "mg",    "usemtl",   "mtllib",   "l",
    "p",   "usemap", "maplib", "lod",   "shadow_obj", "trace_obj", "bevel", "c_interp", "d_interp", "cstype",
    "deg", "curv",   "curv2",  "surf",  "parm",       "trim",      "hole",  "scrv",     "sp",       "end",
    "con", "bmat",   "step",   "ctech", "stech",      "call",      "csh"};

struct Material {
  std::optional<Rgba8> color;  // Kd
  std::string picture;         // map_Kd
};

// Options of map_Kd, with their values, and the name behind them.
std::string pictureName(Words words) {
  for (std::string_view name = words.rest();; name = words.rest()) {
    if (!name.starts_with('-')) return std::string(name);
    words.next();
    double ignored = 0;
    for (Words ahead = words;; words = ahead)
      if (const std::string_view word = ahead.next();
          word != "on" && word != "off" && parseNumber(word, ignored) != nullptr)
        break;
  }
}

void readMaterials(std::string_view text, std::map<std::string, Material>& materials) {
  Material* material = nullptr;
  Lines lines(text);
  for (std::string_view line; lines.next(line);) {
    while (!line.empty() && isBlank(line.back())) line.remove_suffix(1);
    Words words(line);
    const std::string_view keyword = words.next();
    if (keyword == "newmtl") {
      material = &materials[std::string(words.rest())];
    } else if (material && equalsIgnoringCase(keyword, "map_kd")) {
      material->picture = pictureName(words);
    } else if (material && equalsIgnoringCase(keyword, "kd")) {
      std::array<double, 3> value{};
      bool good = true;
      for (double& c : value) good = good && parseNumber(words.next(), c) == nullptr;
      if (!good) continue;
      material->color = kNoColor;
      for (std::size_t k = 0; k < 3; ++k)
        (*material->color)[k] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(value[k], 0.0, 1.0)));
    }
  }
}

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
    if (!colors_.empty()) {
      while (colors_.size() < vertices().size()) colors_.add(kUnset);
      file_.mesh.vertex_colors = colors_.finish(true, file_);
    }
    paint();
    noteSkipped();
    triangulate(polygons_, file_);
    nameObjects();
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
    if (keyword == "vt") {
      std::array<float, 2> uv{};
      for (float& c : uv)
        if (parseNumber(words.next(), c)) c = std::numeric_limits<float>::quiet_NaN();
      uv_.push_back(uv);
    } else if (keyword == "mtllib") {
      libraries_.emplace_back(trimmedEnd(words.rest()));
    } else if (keyword == "usemtl") {
      material_ =
          material_names_.try_emplace(std::string(trimmedEnd(words.rest())), material_names_.size()).first->second;
    } else if (keyword == "o") {
      objects_.begin(words.rest(), triangles_);
    } else if (keyword == "g") {
      const std::string_view name = trimmedEnd(words.rest());
      groups_.begin(name == "default" ? std::string_view{} : name, triangles_);
    }
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
      const char* const wrong =
          n < 3 ? parseCoordinate(word, value[n], file_.had_double_coordinates) : parseNumber(word, value[n]);
      if (wrong && n >= 3 && (equalsIgnoringCase(word, "nan") || equalsIgnoringCase(word, "-nan")))
        value[n] = std::numeric_limits<double>::quiet_NaN();
      else if (wrong)
        return bad(inQuotes(word) + ", " + wrong, "a finite number", numberHint(word));
    }

    if (n < 3 || n == 5) return bad(std::to_string(n) + " numbers after \"v\"", "x y z or x y z r g b");
    if (vertices().size() >= 0xfffffff0u)
      return bad("more than 4 294 967 280 vertices", "fewer", "reduce the mesh first");

    vertices().emplace_back(value[0], value[1], value[2]);
    if (n >= 6) {
      while (colors_.size() + 1 < vertices().size()) colors_.add(kUnset);
      colors_.add({value[n - 3], value[n - 2], value[n - 1], 1});
    }
    return {};
  }

  Expected<void> readFace(Words& words) {
    corners_.clear();
    corner_uv_.resize(libraries_.empty() ? 0 : polygons_.corners.size(), kNone);
    for (std::string_view word = words.next(); !word.empty() && word[0] != '#'; word = words.next()) {
      std::int64_t index = 0, texture = 0;
      // v, v/vt, v//vn, v/vt/vn: texture and normal must be integers; the normal is not used.
      for (std::size_t part = 0, begin = 0;; ++part) {
        const std::size_t slash = word.find('/', begin);
        const std::string_view number = word.substr(begin, slash == word.npos ? word.npos : slash - begin);
        std::int64_t ignored = 0;
        if (part == 0 || !number.empty())
          if (const char* wrong = parseInteger(number, part == 0 ? index : part == 1 ? texture : ignored))
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
      if (texture < 0) texture += static_cast<std::int64_t>(uv_.size()) + 1;
      if (!libraries_.empty())
        corner_uv_.push_back(texture > 0 && texture < kNone ? static_cast<std::uint32_t>(texture - 1) : kNone);
      if (corners_.size() > kMaxPolygonCorners)
        return bad("a face of more than " + std::to_string(kMaxPolygonCorners) + " corners", "fewer",
                   "triangulate the mesh before exporting it");
    }

    if (corners_.size() < 3) return bad("a face of " + std::to_string(corners_.size()) + " corners", "three or more");
    face_material_.resize(polygons_.sizes.size(), kNone);
    face_material_.push_back(static_cast<std::uint32_t>(material_));
    polygons_.add(corners_.data(), corners_.size());
    triangles_ += corners_.size() - 2;
    return {};
  }

  static std::string_view trimmedEnd(std::string_view text) {
    while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
    return text;
  }

  std::map<std::string, Material> readLibraries() {
    std::map<std::string, Material> materials;
    for (const std::string& name : libraries_) {
      Expected<MeshSource> library = loadBeside(source_, name, kLargestMaterials);
      if (library) {
        MeshSource text;
        const bool is_decoded = !decodeText(*library, text).empty();
        readMaterials(is_decoded ? text.text() : library->text(), materials);
      } else {
        file_.notes.emplace_back("Materials (mtllib " + inQuotes(name) + ") were not read: " + library.error().found +
                                 ".");
      }
    }
    return materials;
  }

  // Colours from materials and their textures, where the vertices have none of their own.
  void paint() {
    if (libraries_.empty() || polygons_.sizes.empty()) return;
    if (file_.mesh.hasVertexColors()) {
      file_.notes.emplace_back("Materials (mtllib) were not read: the vertices have colours of their own.");
      return;
    }
    std::map<std::string, Material> materials = readLibraries();
    std::vector<Material> used(material_names_.size());
    std::string undefined;
    for (const auto& [name, index] : material_names_) {
      if (!materials.contains(name)) undefined += (undefined.empty() ? "" : ", ") + inQuotes(name);
      used[index] = std::move(materials[name]);
    }
    if (!undefined.empty()) file_.notes.emplace_back("Materials that no library defines: " + undefined + ".");

    TexturePainter painter(source_);
    std::vector<const TexturePainter::Picture*> pictures;
    for (const Material& m : used) pictures.push_back(m.picture.empty() ? nullptr : painter.picture(m.picture));
    const bool has_picture = std::any_of(pictures.begin(), pictures.end(), [](const auto* p) { return p != nullptr; });
    const bool has_uv = std::any_of(corner_uv_.begin(), corner_uv_.end(), [&](auto uv) { return uv < uv_.size(); });
    if (has_picture && !has_uv) file_.notes.emplace_back("The texture was not used: no face has texture coordinates.");
    if (!has_picture || !has_uv) {
      paintFaces(used);
      return painter.finish(file_);
    }

    std::size_t bare = 0;
    for (std::size_t f = 0, c = 0; f < face_material_.size(); ++f) {
      const std::uint32_t m = face_material_[f];
      for (const std::size_t end = c + polygons_.sizes[f]; c < end; ++c) {
        if (m == kNone) continue;
        const std::uint32_t v = polygons_.corners[c], uv = c < corner_uv_.size() ? corner_uv_[c] : kNone;
        if (pictures[m] && uv < uv_.size())
          painter.paint(v, *pictures[m], uv_[uv][0], uv_[uv][1]);
        else if (!pictures[m] && used[m].color)
          painter.paint(v, *used[m].color);
        else
          ++bare;
      }
    }
    painter.finish(file_);
    if (bare > 0) file_.notes.emplace_back(std::to_string(bare) + " corners of faces have neither texture nor colour.");
  }

  // A grey that all faces share is the default of a program, no colour of a scan.
  void paintFaces(const std::vector<Material>& used) {
    std::vector<Rgba8> colors;
    for (const std::uint32_t m : face_material_)
      colors.push_back(m == kNone ? kNoColor : used[m].color.value_or(kNoColor));
    const Rgba8& first = colors[0];
    const bool one = std::all_of(colors.begin(), colors.end(), [&](const Rgba8& c) { return c == first; });
    if (one && first[0] == first[1] && first[1] == first[2]) return;
    polygons_.colors = std::move(colors);
  }

  void nameObjects() {
    file_.objects = objects_.finish(triangles_);
    std::vector<NamedPart> groups = groups_.finish(triangles_);
    // Names of groups are more useful than a single name for all.
    if (file_.objects.empty() || (file_.objects.size() == 1 && groups_.nameCount() > 1))
      if (!objects_.hasTooMany() && !groups.empty()) file_.objects = std::move(groups);
    if (file_.objects.empty() && (objects_.hasTooMany() || groups_.hasTooMany()))
      file_.notes.push_back(noteOfTooManyNames());
  }

  void noteSkipped() {
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

  static constexpr std::array<double, 4> kUnset{0, 0, 0, -1};
  NumericColors colors_;                      // colours of the vertices so far
  std::vector<std::string> libraries_;        // mtllib
  std::vector<std::array<float, 2>> uv_;      // vt
  std::vector<std::uint32_t> corner_uv_;      // with libraries: index into uv_ or kNone, per corner so far
  std::vector<std::uint32_t> face_material_;  // per face
  std::map<std::string, std::size_t> material_names_;
  std::size_t material_ = kNone;  // the current one

  PartList objects_, groups_;
  std::size_t triangles_ = 0;  // of the faces so far
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
