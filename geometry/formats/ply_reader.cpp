// PLY: ASCII, binary little and big endian. After Greg Turk's format description, 1994.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "geometry/formats/mesh_texture.h"

namespace kerf::internal {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

std::optional<Type> typeNamed(std::string_view word) {
  constexpr std::pair<std::string_view, Type> kTypes[] = {
      {"char", Type::kInt8},   {"int8", Type::kInt8},     {"uchar", Type::kUint8},   {"uint8", Type::kUint8},
      {"short", Type::kInt16}, {"int16", Type::kInt16},   {"ushort", Type::kUint16}, {"uint16", Type::kUint16},
      {"int", Type::kInt32},   {"int32", Type::kInt32},   {"uint", Type::kUint32},   {"uint32", Type::kUint32},
      {"float", Type::kFloat}, {"float32", Type::kFloat}, {"double", Type::kDouble}, {"float64", Type::kDouble}};
  for (const auto& [spelled, type] : kTypes)
    if (word == spelled) return type;
  return std::nullopt;
}

std::size_t sizeOf(Type type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

// Meaning of a property.
enum class Role { kSkip, kX, kY, kZ, kRed, kGreen, kBlue, kAlpha, kU, kV, kPicture, kCorners, kStrip, kTexcoord };

bool isColor(Role role) { return role >= Role::kRed && role <= Role::kAlpha; }
bool isTexture(Role role) { return (role >= Role::kU && role <= Role::kPicture) || role == Role::kTexcoord; }
bool isIndices(Role role) { return role == Role::kCorners || role == Role::kStrip; }
bool isReal(Type type) { return type == Type::kFloat || type == Type::kDouble; }

struct Property {
  std::string name;
  Type type = Type::kFloat;
  std::optional<Type> count_type;  // set for a list
  Role role = Role::kSkip;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
  const char* declared_at = nullptr;
  bool colored = false;      // red, green and blue
  bool plain_colors = true;  // each a byte
  bool real_colors = false;

  bool has(Role role) const {
    return std::any_of(properties.begin(), properties.end(), [&](const Property& p) { return p.role == role; });
  }
};

enum class Encoding { kAscii, kLittle, kBig };

// One item of data, in any encoding.
struct Item {
  Vec3d position = Vec3d::Zero();
  std::array<double, 4> color{0, 0, 0, 255};
  std::array<double, 2> uv{};
  double picture = 0;
  std::vector<std::uint32_t> corners;  // of a strip: UINT32_MAX between two
  std::vector<double> texcoord;        // u and v of each corner
};

constexpr std::uint32_t kNextStrip = 0xffffffffu;

class PlyReader {
 public:
  PlyReader(const MeshSource& source, const Progress& progress) : source_(source), progress_(progress) {}

  Expected<MeshFile> read() {
    KERF_CHECK(readHeader());
    KERF_CHECK(checkHeader());
    noteSkipped();
    for (const Element& element : elements_) {
      current_ = &element;
      KERF_CHECK(encoding_ == Encoding::kAscii ? readAscii(element) : readBinary(element));
    }

    KERF_CHECK(checkEnd());
    for (std::size_t k = 0; k < strip_triangles_.size(); k += 3) polygons_.add(&strip_triangles_[k], 3);
    for (std::size_t f = 0, c = 0; f < polygons_.sizes.size(); c += polygons_.sizes[f++])
      for (std::size_t k = 0; k < polygons_.sizes[f]; ++k)
        if (polygons_.corners[c + k] >= file_.mesh.vertices.size())
          return fail({.code = Error::Code::kBadValue,
                       .file = source_.file,
                       .place = "face " + std::to_string(f),
                       .found = "vertex index " + std::to_string(polygons_.corners[c + k]),
                       .expected = "0 to " + std::to_string(file_.mesh.vertices.size()) + " - 1",
                       .hint = kDamaged});

    if (strips_ > 0) {
      file_.notes.emplace_back(std::to_string(strips_) + " triangle strips were split into triangles.");
      if (!polygons_.colors.empty()) polygons_.colors.resize(polygons_.sizes.size(), kNoColor);
    }
    paint();
    triangulate(polygons_, file_);
    return finished(source_, std::move(file_));
  }

 private:
  static constexpr const char* kDamaged = "the file is cut short or damaged; export or copy it again";

  Expected<void> badHeader(std::string_view at, std::string found, std::string expected) const {
    return fail(source_.atLine(at.data(), Error::Code::kBadFormat, std::move(found), std::move(expected), kDamaged));
  }

  Expected<void> readHeader() {
    // No header is long; a file without end_header must not be searched to its end for one.
    Lines lines(source_.text().substr(0, 1 << 20));
    std::string_view line;
    bool has_format = false;
    for (std::size_t number = 1; lines.next(line); ++number) {
      Words words(line);
      const std::string_view keyword = words.next();
      if (number == 1) {
        if (keyword != "ply") return badHeader(line, inQuotes(line), "\"ply\"");
      } else if (keyword == "end_header") {
        if (!has_format) return badHeader(line, "no \"format\" line before end_header", "format ascii 1.0 or the like");
        data_ = static_cast<std::size_t>(lines.position() - source_.bytes.get());
        return {};
      } else if (keyword == "format") {
        const std::string_view encoding = words.next();
        has_format = true;
        if (encoding == "ascii") {
          encoding_ = Encoding::kAscii;
          file_.format = "ASCII PLY";
        } else if (encoding == "binary_little_endian") {
          encoding_ = Encoding::kLittle;
          file_.format = "binary PLY (little endian)";
        } else if (encoding == "binary_big_endian") {
          encoding_ = Encoding::kBig;
          file_.format = "binary PLY (big endian)";
        } else {
          return badHeader(line, "format " + inQuotes(encoding), "ascii, binary_little_endian or binary_big_endian");
        }
      } else if (keyword == "comment" || keyword == "obj_info") {
        Words comment = words;
        if (equalsIgnoringCase(comment.next(), "texturefile")) pictures_.emplace_back(comment.rest());
        if (file_.declared_unit.empty()) file_.declared_unit = unitIn(words.rest());
      } else if (keyword == "element") {
        KERF_CHECK(readElement(line, words));
      } else if (keyword == "property") {
        KERF_CHECK(readProperty(line, words));
      } else if (!line.empty()) {
        return badHeader(line, inQuotes(keyword), "a line of a PLY header (element, property, comment, end_header)");
      }
    }
    return badHeader({lines.position(), 0}, "a header without \"end_header\"", "\"end_header\"");
  }

  Expected<void> readElement(std::string_view line, Words& words) {
    Element element;
    element.name = words.next();
    element.declared_at = line.data();
    const std::string_view count = words.next();
    std::int64_t n = 0;
    if (const char* wrong = parseInteger(count, n)) return badHeader(line, inQuotes(count) + ", " + wrong, "a count");
    if (n < 0) return badHeader(line, "a count of " + std::to_string(n), "a count that is not negative");
    element.count = static_cast<std::size_t>(n);
    elements_.push_back(std::move(element));
    return {};
  }

  Expected<void> readProperty(std::string_view line, Words& words) {
    if (elements_.empty()) return badHeader(line, "a property before any element", "\"element\" first");
    Property property;
    std::string_view type = words.next();
    if (type == "list") {
      const std::string_view count = words.next();
      property.count_type = typeNamed(count);
      if (!property.count_type || *property.count_type == Type::kFloat || *property.count_type == Type::kDouble)
        return badHeader(line, "list count of type " + inQuotes(count), "an integer type such as uchar");
      type = words.next();
    }

    const std::optional<Type> known = typeNamed(type);
    if (!known)
      return badHeader(line, "type " + inQuotes(type), "char, uchar, short, ushort, int, uint, float or double");
    property.type = *known;
    property.name = words.next();
    if (property.name.empty()) return badHeader(line, "a property without a name", "property TYPE NAME");

    Element& element = elements_.back();
    constexpr std::size_t kMostProperties = 256;  // each is compared with all others, and visited for every item
    if (element.properties.size() == kMostProperties)
      return badHeader(line, "more than 256 properties of " + inQuotes(element.name), "fewer");
    for (const Property& other : element.properties)
      if (other.name == property.name) return badHeader(line, "property " + inQuotes(property.name) + " twice", "once");

    property.role = roleOf(element, property);
    element.properties.push_back(std::move(property));
    return {};
  }

  static Role roleOf(const Element& element, const Property& property) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    const std::string& name = property.name;
    if (property.count_type) {
      const bool corners = name == "vertex_indices" || name == "vertex_index";
      if (corners && !isReal(property.type))
        return is_face ? Role::kCorners : element.name == "tristrips" ? Role::kStrip : Role::kSkip;
      return is_face && name == "texcoord" && isReal(property.type) ? Role::kTexcoord : Role::kSkip;
    }
    if (is_vertex) {
      if (name == "x") return Role::kX;
      if (name == "y") return Role::kY;
      if (name == "z") return Role::kZ;
      if (name == "s" || name == "u" || name == "texture_u") return Role::kU;
      if (name == "t" || name == "v" || name == "texture_v") return Role::kV;
    }
    if (is_face && name == "texnumber") return Role::kPicture;
    if (is_vertex || is_face) {
      if (name == "red" || name == "diffuse_red") return Role::kRed;
      if (name == "green" || name == "diffuse_green") return Role::kGreen;
      if (name == "blue" || name == "diffuse_blue") return Role::kBlue;
      if (name == "alpha") return Role::kAlpha;
    }
    return Role::kSkip;
  }

  // Checks the counts against the file's bytes, before any allocation.
  Expected<void> checkHeader() {
    std::size_t vertices = 0, faces = 0;
    std::size_t left = source_.size - data_;
    for (Element& element : elements_) {
      const std::string_view at{element.declared_at, 0};
      std::size_t smallest = 0;
      for (const Property& p : element.properties)
        smallest += encoding_ == Encoding::kAscii ? 2 : p.count_type ? sizeOf(*p.count_type) : sizeOf(p.type);
      if (element.properties.empty()) element.count = 0;  // nothing is stored for it
      // The last value of an ASCII file may lack its separator, hence the 1.
      if (smallest > 0 && element.count > (left + 1) / smallest)
        return badHeader(at, std::to_string(element.count) + " items of " + inQuotes(element.name),
                         "at most " + std::to_string((left + 1) / smallest) + ", which is what the file has room for");

      left -= std::min(left, smallest * element.count);
      if (element.name == "vertex") {
        ++vertices;
        if (!(element.has(Role::kX) && element.has(Role::kY) && element.has(Role::kZ)))
          return badHeader(at, "a vertex element without x, y or z", "properties x, y and z");
        if (element.count >= 0xfffffff0u)
          return badHeader(at, std::to_string(element.count) + " vertices", "fewer than 4 294 967 280");
        for (const Property& p : element.properties)
          if (p.role == Role::kX || p.role == Role::kY || p.role == Role::kZ)
            file_.had_double_coordinates |= p.type == Type::kDouble;
      } else if (element.name == "face") {
        ++faces;
        if (element.count > 0 && !element.has(Role::kCorners))
          return badHeader(at, "a face element without vertex_indices", "property list uchar int vertex_indices");
      } else if (element.name == "tristrips" && element.count > 0 && !element.has(Role::kStrip)) {
        return badHeader(at, "triangle strips without vertex_indices", "property list int int vertex_indices");
      }
    }

    if (vertices == 1 && faces <= 1) return {};
    const char* at = elements_.empty() ? source_.bytes.get() : elements_.front().declared_at;
    return badHeader({at, 0},
                     std::to_string(vertices) + " vertex elements and " + std::to_string(faces) + " face elements",
                     "one of each");
  }

  void noteSkipped() {
    std::string list;
    for (Element& element : elements_) {
      const bool known = element.name == "vertex" || element.name == "face";
      if (!known && !element.has(Role::kStrip)) list += (list.empty() ? "" : ", ") + element.name;
      element.colored = element.has(Role::kRed) && element.has(Role::kGreen) && element.has(Role::kBlue);
      for (Property& p : element.properties) {
        if (isColor(p.role)) {
          element.plain_colors = element.plain_colors && p.type == Type::kUint8;
          element.real_colors = element.real_colors || isReal(p.type);
          if (!element.colored) p.role = Role::kSkip;
        }
        if (isTexture(p.role) && pictures_.empty()) p.role = Role::kSkip;
        if (known && p.role == Role::kSkip) list += (list.empty() ? "" : ", ") + element.name + "." + p.name;
      }
    }
    if (!list.empty()) file_.notes.emplace_back("Not read: " + list + ".");
  }

  template <class Real>
  static void store(Role role, Real value, Item& item) {
    switch (role) {
      case Role::kX:
        item.position[0] = value;
        break;
      case Role::kY:
        item.position[1] = value;
        break;
      case Role::kZ:
        item.position[2] = value;
        break;
      case Role::kRed:
      case Role::kGreen:
      case Role::kBlue:
      case Role::kAlpha:
        item.color[static_cast<std::size_t>(role) - static_cast<std::size_t>(Role::kRed)] = value;
        break;
      case Role::kU:
        item.uv[0] = value;
        break;
      case Role::kV:
        item.uv[1] = value;
        break;
      case Role::kPicture:
        item.picture = value;
        break;
      default:
        break;
    }
  }

  void reserve(const Element& element) {
    if (element.name == "vertex") {
      file_.mesh.vertices.reserve(element.count);
      if (element.colored) file_.mesh.vertex_colors.reserve(element.count);
    } else if (element.name == "face") {
      polygons_.sizes.reserve(element.count);
      polygons_.corners.reserve(std::min(3 * element.count, (source_.size - data_) / 2));
      if (element.colored) polygons_.colors.reserve(element.count);
    }
  }

  void keep(const Element& element, const Item& item) {
    const bool is_vertex = element.name == "vertex";
    if (element.has(Role::kStrip)) return keepStrip(item.corners);
    if (!is_vertex && element.name != "face") return;

    if (is_vertex) {
      file_.mesh.vertices.push_back(item.position);
      if (element.has(Role::kU) && element.has(Role::kV)) vertex_uv_.push_back(item.uv);
    } else {
      polygons_.add(item.corners.data(), item.corners.size());
      if (!pictures_.empty()) {
        face_picture_.push_back(item.picture);
        if (element.has(Role::kTexcoord)) {
          face_uv_.insert(face_uv_.end(), item.texcoord.begin(), item.texcoord.end());
          face_uv_.resize(2 * polygons_.corners.size(), std::numeric_limits<double>::quiet_NaN());
        }
      }
    }
    if (!element.colored) return;
    if (element.plain_colors) {
      Rgba8 color;
      for (std::size_t k = 0; k < 4; ++k) color[k] = static_cast<std::uint8_t>(item.color[k]);
      (is_vertex ? file_.mesh.vertex_colors : polygons_.colors).push_back(color);
      return;
    }
    NumericColors& colors = is_vertex ? vertex_numbers_ : face_numbers_;
    colors.add(item.color);
    if (colors.size() == element.count)
      (is_vertex ? file_.mesh.vertex_colors : polygons_.colors) = colors.finish(element.real_colors, file_);
  }

  // Every second triangle of a strip is turned. Repeated corners only stitch parts together.
  void keepStrip(const std::vector<std::uint32_t>& corners) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (i == begin && corners[i] != kNextStrip) ++strips_;
      if (corners[i] == kNextStrip) begin = i + 1;
      if (i < begin + 2 || corners[i] == kNextStrip) continue;
      const bool turned = (i - begin) % 2 == 1;
      const std::uint32_t triangle[3] = {corners[i - 2 + turned], corners[i - 1 - turned], corners[i]};
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
        strip_triangles_.insert(strip_triangles_.end(), triangle, triangle + 3);
    }
  }

  // Colours from textures, where the vertices have none of their own.
  void paint() {
    if (pictures_.empty() || (vertex_uv_.empty() && face_uv_.empty())) return;
    if (file_.mesh.hasVertexColors()) {
      file_.notes.emplace_back("The texture was not read: the vertices have colours of their own.");
      return;
    }
    TexturePainter painter(source_);
    for (std::size_t f = 0, c = 0; f < face_picture_.size(); ++f) {
      const double number = face_picture_[f];
      const bool has_picture = number >= 0 && number < static_cast<double>(pictures_.size());
      const auto* picture = has_picture ? painter.picture(pictures_[static_cast<std::size_t>(number)]) : nullptr;
      for (const std::size_t end = c + polygons_.sizes[f]; c < end; ++c) {
        const std::uint32_t v = polygons_.corners[c];
        if (!picture) continue;
        if (face_uv_.empty())
          painter.paint(v, *picture, vertex_uv_[v][0], vertex_uv_[v][1]);
        else
          painter.paint(v, *picture, face_uv_[2 * c], face_uv_[2 * c + 1]);
      }
    }
    painter.finish(file_);
  }

  bool goOn(std::size_t i) const {
    return i % 65536 != 0 ||
           report(progress_, static_cast<double>(i) / static_cast<double>(current_->count + 1), "reading PLY");
  }

  std::string itemName(std::size_t i) const { return current_->name + " " + std::to_string(i); }

  // `where` makes an error that says where.
  template <class Where>
  static Expected<void> corner(Role role, std::int64_t index, Item& item, const Where& where) {
    if (role == Role::kStrip && index == -1) {
      item.corners.push_back(kNextStrip);
      return {};
    }
    if (index < 0 || index >= kNextStrip) return badIndex(index, where());
    item.corners.push_back(static_cast<std::uint32_t>(index));
    return {};
  }

  static Expected<void> badIndex(std::int64_t index, const Error& where) {
    return fail({.code = Error::Code::kBadValue,
                 .file = where.file,
                 .place = where.place,
                 .found = "vertex index " + std::to_string(index),
                 .expected = "0 to the number of vertices - 1",
                 .hint = kDamaged});
  }

  Expected<void> checkCorners(std::int64_t n, const Error& where) const {
    if (n >= 0 && n <= static_cast<std::int64_t>(kMaxPolygonCorners)) return {};
    return fail({.code = Error::Code::kBadValue,
                 .file = where.file,
                 .place = where.place,
                 .found = "a face of " + std::to_string(n) + " corners",
                 .expected = "0 to " + std::to_string(kMaxPolygonCorners),
                 .hint = "triangulate the mesh before exporting it"});
  }

  Expected<void> readAscii(const Element& element) {
    if (element.count == 0) return {};
    reserve(element);
    Lines lines(source_.text().substr(data_));
    std::string_view line;
    Item item;
    for (std::size_t i = 0; i < element.count; ++i) {
      if (!goOn(i)) return cancelled(source_);

      std::string_view word;
      do {
        if (!lines.next(line))
          return fail(source_.atLine(source_.bytes.get() + source_.size, Error::Code::kBadFormat,
                                     "the end of the file at " + itemName(i),
                                     std::to_string(element.count) + " items of " + inQuotes(element.name), kDamaged));
        word = Words(line).next();
      } while (word.empty());
      Words words(line);
      item.corners.clear();
      item.texcoord.clear();
      for (const Property& p : element.properties) KERF_CHECK(readAsciiProperty(p, words, line, item));

      if (const std::string_view extra = words.next(); !extra.empty())
        return fail(source_.atLine(line.data(), Error::Code::kBadFormat,
                                   inQuotes(extra) + " after the last value of " + itemName(i), "the end of the line",
                                   kDamaged));
      keep(element, item);
    }
    data_ = static_cast<std::size_t>(lines.position() - source_.bytes.get());
    return {};
  }

  Expected<void> readAsciiProperty(const Property& p, Words& words, std::string_view line, Item& item) const {
    const auto wrongWord = [&](std::string_view word, const char* wrong) {
      if (word.empty())
        return fail(source_.atLine(line.data(), Error::Code::kBadFormat, "the end of the line",
                                   "a value for " + inQuotes(p.name), kDamaged));
      return fail(source_.atLine(line.data(), Error::Code::kBadValue, inQuotes(word) + ", " + wrong,
                                 "a value for " + inQuotes(p.name), numberHint(word)));
    };

    if (!p.count_type) return readAsciiScalar(p, words.next(), wrongWord, item);
    const std::string_view count = words.next();
    std::int64_t n = 0;
    if (const char* wrong = parseInteger(count, n)) return wrongWord(count, wrong);
    if (p.role == Role::kCorners) {
      if (n < 0 || n > static_cast<std::int64_t>(kMaxPolygonCorners))
        return checkCorners(n, source_.atLine(line.data(), Error::Code::kBadValue, ""));
    } else if (n < 0) {
      return wrongWord(count, "a negative count");
    }

    for (std::int64_t k = 0; k < n; ++k) {
      const std::string_view word = words.next();
      std::int64_t index = 0;
      if (word.empty()) return wrongWord(word, "");
      if (p.role == Role::kTexcoord) {
        double value = 0;
        item.texcoord.push_back(parseNumber(word, value) ? std::numeric_limits<double>::quiet_NaN() : value);
      }
      if (!isIndices(p.role)) continue;
      if (const char* wrong = parseInteger(word, index)) return wrongWord(word, wrong);
      KERF_CHECK(corner(p.role, index, item, [&] { return source_.atLine(line.data(), Error::Code::kBadValue, ""); }));
    }
    return {};
  }

  template <class Wrong>
  static Expected<void> readAsciiScalar(const Property& p, std::string_view word, const Wrong& wrongWord, Item& item) {
    if (word.empty()) return wrongWord(word, "");
    const char* wrong = nullptr;
    if (p.role == Role::kSkip) return {};
    if (p.type == Type::kFloat) {
      float value = 0;
      if (!(wrong = parseNumber(word, value))) store(p.role, value, item);
    } else if (p.type == Type::kDouble) {
      double value = 0;
      if (!(wrong = parseNumber(word, value))) store(p.role, value, item);
    } else {
      std::int64_t value = 0;
      wrong = parseInteger(word, value);
      if (!wrong && p.type == Type::kUint8 && (value < 0 || value > 255)) wrong = "outside 0 to 255";
      if (!wrong) store(p.role, static_cast<double>(value), item);
    }
    if (wrong && mayBeOdd(p)) {
      store(p.role, std::numeric_limits<double>::quiet_NaN(), item);
      return {};
    }
    if (wrong) return wrongWord(word, wrong);
    return {};
  }

  // No position: a number that is not finite does no harm there.
  static bool mayBeOdd(const Property& p) { return isReal(p.type) && (isColor(p.role) || isTexture(p.role)); }

  std::uint64_t bits(std::size_t at, std::size_t n) const {
    const auto* u = reinterpret_cast<const unsigned char*>(source_.bytes.get() + at);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n; ++i)
      value |= std::uint64_t{u[encoding_ == Encoding::kBig ? n - 1 - i : i]} << (8 * i);
    return value;
  }
  std::int64_t integer(std::size_t at, Type type) const {
    const std::uint64_t b = bits(at, sizeOf(type));
    switch (type) {
      case Type::kInt8:
        return static_cast<std::int8_t>(b);
      case Type::kInt16:
        return static_cast<std::int16_t>(b);
      case Type::kInt32:
        return static_cast<std::int32_t>(b);
      default:
        return static_cast<std::int64_t>(b);
    }
  }
  double real(std::size_t at, Type type) const {
    if (type == Type::kFloat) return std::bit_cast<float>(static_cast<std::uint32_t>(bits(at, 4)));
    if (type == Type::kDouble) return std::bit_cast<double>(bits(at, 8));
    return static_cast<double>(integer(at, type));
  }

  Expected<void> readBinary(const Element& element) {
    if (element.count == 0) return {};
    reserve(element);
    Item item;
    for (std::size_t i = 0; i < element.count; ++i) {
      if (!goOn(i)) return cancelled(source_);

      const auto tooShort = [&] {
        return fail(source_.atByte(source_.size, Error::Code::kBadFormat, "the end of the file at " + itemName(i),
                                   std::to_string(element.count) + " items of " + inQuotes(element.name), kDamaged));
      };
      item.corners.clear();
      item.texcoord.clear();
      for (const Property& p : element.properties) {
        const std::size_t size = sizeOf(p.type);
        if (!p.count_type) {
          if (source_.size - data_ < size) return tooShort();
          if (p.role != Role::kSkip) {
            const double value = real(data_, p.type);
            if (!std::isfinite(value) && !mayBeOdd(p))
              return fail(source_.atByte(data_, Error::Code::kBadValue,
                                         inQuotes(p.name) + " of " + itemName(i) + " is not finite (NaN or infinite)",
                                         "a finite number", "repair the mesh in the program that wrote it"));
            store(p.role, value, item);
          }
          data_ += size;
          continue;
        }

        if (source_.size - data_ < sizeOf(*p.count_type)) return tooShort();
        const std::int64_t n = integer(data_, *p.count_type);
        if (p.role == Role::kCorners) {
          if (n < 0 || n > static_cast<std::int64_t>(kMaxPolygonCorners))
            return checkCorners(n, source_.atByte(data_, Error::Code::kBadValue, ""));
        } else if (n < 0) {
          return fail(source_.atByte(data_, Error::Code::kBadValue, "a list of " + std::to_string(n) + " values",
                                     "a count that is not negative", kDamaged));
        }

        data_ += sizeOf(*p.count_type);
        if (static_cast<std::uint64_t>(n) > (source_.size - data_) / size) return tooShort();
        for (std::size_t k = 0; isIndices(p.role) && k < static_cast<std::size_t>(n); ++k) {
          const std::size_t at = data_ + k * size;
          KERF_CHECK(corner(p.role, integer(at, p.type), item,
                            [&] { return source_.atByte(at, Error::Code::kBadValue, ""); }));
        }
        for (std::size_t k = 0; p.role == Role::kTexcoord && k < static_cast<std::size_t>(n); ++k)
          item.texcoord.push_back(real(data_ + k * size, p.type));
        data_ += static_cast<std::size_t>(n) * size;
      }
      keep(element, item);
    }
    return {};
  }

  // Some writers end a binary file with a line end; more than that means that the counts are wrong.
  Expected<void> checkEnd() const {
    std::size_t at = data_;
    const bool text = encoding_ == Encoding::kAscii;
    while (at < source_.size && (isBlank(source_.bytes[at]) || isLineEnd(source_.bytes[at])) &&
           (text || at < data_ + 2))
      ++at;
    if (at == source_.size) return {};
    const std::string found = std::to_string(source_.size - at) + " bytes after the last element";

    if (text)
      return fail(
          source_.atLine(source_.bytes.get() + at, Error::Code::kBadFormat, found, "the end of the file", kDamaged));
    return fail(source_.atByte(at, Error::Code::kBadFormat, found, "the end of the file", kDamaged));
  }

  const MeshSource& source_;
  const Progress& progress_;
  Encoding encoding_ = Encoding::kAscii;
  std::vector<Element> elements_;
  const Element* current_ = nullptr;
  std::size_t data_ = 0;  // offset of the data not read yet
  Polygons polygons_;
  std::size_t strips_ = 0;
  std::vector<std::uint32_t> strip_triangles_;
  NumericColors vertex_numbers_, face_numbers_;
  std::vector<std::string> pictures_;             // comments "TextureFile"
  std::vector<std::array<double, 2>> vertex_uv_;  // empty or one per vertex
  std::vector<double> face_uv_;                   // empty or u and v of each corner of polygons_
  std::vector<double> face_picture_;              // with pictures_: which one
  MeshFile file_;
};

}  // namespace

bool isPly(const MeshSource& source) {
  const std::string_view text = source.text();
  return text.size() >= 4 && text.substr(0, 3) == "ply" && (isLineEnd(text[3]) || isBlank(text[3]));
}

Expected<MeshFile> readPly(const MeshSource& source, const Progress& progress) {
  return PlyReader(source, progress).read();
}

}  // namespace kerf::internal
