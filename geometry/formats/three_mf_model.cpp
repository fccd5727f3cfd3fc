#include "geometry/formats/three_mf_model.h"

#include <algorithm>
#include <map>

#include "geometry/formats/xml_parser.h"

namespace kerf::internal {
namespace {

constexpr std::string_view kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
constexpr std::string_view kDraft = "http://schemas.microsoft.com/3dmanufacturing/2013/01";
constexpr std::string_view kMaterials = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";
constexpr std::string_view kProduction = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
constexpr std::string_view kProductionPath = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06 path";
// Names of subsets of triangles: no effect on the surface.
constexpr std::string_view kTriangleSets = "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07";
constexpr const char* kDamagedModel = "the file is damaged; export it again";
constexpr std::uint32_t kMostIndex = 0x7fffffff;  // the specification's ST_ResourceIndex

enum class Node {
  kDocument,
  kModel,
  kResources,
  kBaseMaterials,
  kColorGroup,
  kObject,
  kMesh,
  kVertices,
  kTriangles,
  kComponents,
  kBuild,
  kLeaf,    // an element with attributes only
  kSkipped  // and all that is in it
};

// "NAMESPACE name" taken apart.
struct Name {
  std::string_view name_space, local;
  explicit Name(std::string_view name) {
    const std::size_t blank = name.rfind(' ');
    local = blank == name.npos ? name : name.substr(blank + 1);
    name_space = blank == name.npos ? std::string_view{} : name.substr(0, blank);
  }
};

// A namespace for a message: without the common prefix of 3MF.
std::string shown(std::string_view name_space) {
  constexpr std::string_view kCommon = "http://schemas.microsoft.com/3dmanufacturing/";
  if (name_space.starts_with(kCommon)) name_space.remove_prefix(kCommon.size());
  return inQuotes(name_space);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (isBlank(text.front()) || isLineEnd(text.front()))) text.remove_prefix(1);
  while (!text.empty() && (isBlank(text.back()) || isLineEnd(text.back()))) text.remove_suffix(1);
  return text;
}

}  // namespace

std::size_t ThreeMfModel::find(std::uint32_t id) const {
  const auto at = std::find_if(objects.begin(), objects.end(), [id](const ThreeMfObject& o) { return o.id == id; });
  return static_cast<std::size_t>(at - objects.begin());
}

struct ThreeMfModelParser::State : XmlParser::Handler {
  State(const MeshSource& source, std::string_view part, bool root) : is_root(root), xml(source, part, *this) {}

  Expected<void> start(std::string_view name, const XmlAttributes& attributes) override {
    Node node = Node::kSkipped;
    if (open.back() != Node::kSkipped && open.back() != Node::kLeaf) {
      KERF_TRY(entered, enter(open.back(), Name(name), attributes));
      node = entered;
    }
    open.push_back(node);
    return {};
  }
  Expected<void> end() override {
    open.pop_back();
    return {};
  }
  void prefix(std::string_view short_name, std::string_view name_space) override {
    if (open.size() == 1) prefixes[std::string(short_name)] = name_space;
  }

  Expected<Node> enter(Node parent, const Name& name, const XmlAttributes& a) {
    const bool core = name.name_space == kCore, materials = name.name_space == kMaterials;
    const std::string_view local = name.local;
    switch (parent) {
      case Node::kDocument:
        if (core && local == "model") return model(a);
        if (local == "model" && name.name_space == kDraft)
          return fail(xml.here(Error::Code::kUnsupported, "a 3MF of 2013, older than the standard",
                               "3MF of 2015 or later", "export it again with a newer program, or as STL or PLY"));
        return fail(xml.here(Error::Code::kBadFormat,
                             "the XML element " + inQuotes(local) + " of " + shown(name.name_space),
                             "\"model\" of " + shown(kCore), kDamagedModel));
      case Node::kModel:
        if (core && local == "resources") return Node::kResources;
        if (core && local == "build") return is_root ? Node::kBuild : Node::kSkipped;
        break;
      case Node::kResources:
        if (core && local == "basematerials") return colors(a, Node::kBaseMaterials);
        if (materials && local == "colorgroup") return colors(a, Node::kColorGroup);
        if (core && local == "object") return object(a);
        if (a.find("id")) {  // textures, composites: objects that refer to them have no colour
          KERF_TRY(id, resourceId(a));
          other_resources.insert(id);
        }
        break;
      case Node::kBaseMaterials:
        if (core && local == "base") return color(a, "displaycolor");
        break;
      case Node::kColorGroup:
        if (materials && local == "color") return color(a, "color");
        break;
      case Node::kObject:
        if (core && local == "mesh") return Node::kMesh;
        if (core && local == "components") return Node::kComponents;
        break;
      case Node::kMesh:
        if (core && local == "vertices") return Node::kVertices;
        if (core && local == "triangles") return Node::kTriangles;
        break;
      case Node::kVertices:
        if (core && local == "vertex") return vertex(a);
        break;
      case Node::kTriangles:
        if (core && local == "triangle") return triangle(a);
        break;
      case Node::kComponents:
        if (core && local == "component") return component(a);
        break;
      case Node::kBuild:
        if (core && local == "item") return item(a);
        break;
      default:
        break;
    }

    if (!core && name.name_space != kTriangleSets && parent != Node::kModel && out.skipped.size() < 8)
      out.skipped.insert(std::string(local.substr(0, 40)));
    return Node::kSkipped;
  }

  // --- attributes ---

  tl::unexpected<Error> bad(std::string_view attribute, std::string found, std::string expected) const {
    return fail(xml.here(Error::Code::kBadValue, "attribute " + std::string(attribute) + " " + std::move(found),
                         std::move(expected), kDamagedModel));
  }
  Expected<std::string_view> need(const XmlAttributes& a, std::string_view name) const {
    if (const auto value = a.find(name)) return trimmed(*value);
    return bad(name, "missing", "one");
  }
  Expected<std::uint32_t> index(std::string_view name, std::string_view text, std::uint32_t least, std::size_t end,
                                const char* of) const {
    std::int64_t value = 0;
    if (const char* wrong = parseInteger(trimmed(text), value)) return bad(name, inQuotes(text) + ", " + wrong, of);
    if (value < least || value >= static_cast<std::int64_t>(end))
      return bad(name, inQuotes(text),
                 std::string(of) + ", " + std::to_string(least) + " to " + std::to_string(end) + " - 1");
    return static_cast<std::uint32_t>(value);
  }
  Expected<double> number(const XmlAttributes& a, std::string_view name) {
    KERF_TRY(text, need(a, name));
    double value = 0;
    if (const char* wrong = parseCoordinate(text, value, out.had_double_coordinates))
      return bad(name, inQuotes(text) + ", " + wrong, "a finite coordinate");
    return value;
  }
  Expected<std::uint32_t> resourceId(const XmlAttributes& a) {
    KERF_TRY(text, need(a, "id"));
    KERF_TRY(id, index("id", text, 1, std::size_t{kMostIndex} + 1, "a number"));
    if (!ids.insert(id).second) return bad("id", inQuotes(text) + ", taken by another resource", "a number of its own");
    return id;
  }

  // --- elements ---

  Expected<Node> model(const XmlAttributes& a) {
    if (const auto unit = a.find("unit")) {
      constexpr std::string_view kUnits[] = {"micron", "millimeter", "centimeter", "inch", "foot", "meter"};
      if (std::find(std::begin(kUnits), std::end(kUnits), *unit) == std::end(kUnits))
        return bad("unit", inQuotes(*unit), "micron, millimeter, centimeter, inch, foot or meter");
      out.unit = *unit;
    }

    Words required(trimmed(a.find("requiredextensions").value_or("")));
    for (std::string_view word = required.next(); !word.empty(); word = required.next()) {
      const auto known = prefixes.find(std::string(word));
      const std::string_view name_space = known == prefixes.end() ? std::string_view{} : known->second;
      if (name_space == kCore || name_space == kMaterials || name_space == kProduction || name_space == kTriangleSets)
        continue;
      return fail(xml.here(Error::Code::kUnsupported,
                           "the 3MF extension " + shown(name_space.empty() ? word : name_space) +
                               ", required to read the file correctly",
                           "core 3MF, with materials and production extension", "export without it, or as STL or PLY"));
    }
    return Node::kModel;
  }

  Expected<Node> colors(const XmlAttributes& a, Node node) {
    KERF_TRY(id, resourceId(a));
    color_group = &color_groups[id];
    return node;
  }

  Expected<Node> color(const XmlAttributes& a, const char* attribute) {
    KERF_TRY(text, need(a, attribute));
    Rgba8 value{0, 0, 0, 255};
    bool good = (text.size() == 7 || text.size() == 9) && text[0] == '#';
    for (std::size_t k = 0; good && k < (text.size() - 1) / 2; ++k) {
      const char* first = text.data() + 1 + 2 * k;
      good = std::from_chars(first, first + 2, value[k], 16).ptr == first + 2;
    }
    if (!good) return bad(attribute, inQuotes(text), "#RRGGBB or #RRGGBBAA");
    color_group->push_back(value);
    return Node::kLeaf;
  }

  Expected<Node> object(const XmlAttributes& a) {
    KERF_TRY(id, resourceId(a));
    ThreeMfObject fresh;
    fresh.id = id;
    fresh.name = objectName(a.find("name").value_or(""));
    const std::string_view type = a.find("type").value_or("model");
    fresh.is_support = type == "support" || type == "solidsupport";

    out.objects.push_back(std::move(fresh));
    object_index[id] = out.objects.size() - 1;
    object_color.reset();
    object_group = nullptr;

    if (const auto pid = a.find("pid")) {
      KERF_CHECK(group("pid", *pid, object_group));
      if (const auto pindex = a.find("pindex"); pindex && object_group) {
        KERF_TRY(at, index("pindex", *pindex, 0, object_group->size(), "a colour of its group"));
        object_color = (*object_group)[at];
      }
    }
    return Node::kObject;
  }

  // Null for a resource that is known but has no colours.
  Expected<void> group(std::string_view attribute, std::string_view text, const std::vector<Rgba8>*& found) {
    KERF_TRY(id, index(attribute, text, 1, std::size_t{kMostIndex} + 1, "a number"));
    const auto known = color_groups.find(id);
    found = known == color_groups.end() ? nullptr : &known->second;
    if (!found && !other_resources.contains(id))
      return bad(attribute, inQuotes(text), "materials or colours defined before");
    return {};
  }

  Expected<Node> vertex(const XmlAttributes& a) {
    std::vector<Vec3d>& vertices = out.objects.back().vertices;
    KERF_TRY(x, number(a, "x"));
    KERF_TRY(y, number(a, "y"));
    KERF_TRY(z, number(a, "z"));
    if (vertices.size() >= kMostIndex)
      return fail(xml.here(Error::Code::kUnsupported, "more than 2 147 483 647 vertices", "fewer", "reduce the mesh"));
    vertices.emplace_back(x, y, z);
    return Node::kLeaf;
  }

  Expected<Node> triangle(const XmlAttributes& a) {
    ThreeMfObject& o = out.objects.back();
    Triangle t;
    constexpr const char* kCorners[] = {"v1", "v2", "v3"};
    for (std::size_t k = 0; k < 3; ++k) {
      KERF_TRY(text, need(a, kCorners[k]));
      KERF_TRY(v, index(kCorners[k], text, 0, o.vertices.size(), "a vertex of the object"));
      t[k] = v;
    }

    std::optional<std::array<Rgba8, 3>> colored;
    const std::vector<Rgba8>* from = object_group;
    if (const auto pid = a.find("pid")) KERF_CHECK(group("pid", *pid, from));
    if (const auto first = a.find("p1"); first && from) {
      KERF_TRY(p1, index("p1", *first, 0, from->size(), "a colour of its group"));
      colored.emplace();
      colored->fill((*from)[p1]);
      constexpr const char* kOthers[] = {"p2", "p3"};
      for (std::size_t k = 0; k < 2; ++k)
        if (const auto text = a.find(kOthers[k])) {
          KERF_TRY(p, index(kOthers[k], *text, 0, from->size(), "a colour of its group"));
          (*colored)[k + 1] = (*from)[p];
        }
    } else if (!first && object_color) {
      colored.emplace();
      colored->fill(*object_color);
    }

    if (colored && o.corner_colors.empty()) o.corner_colors.resize(o.triangles.size(), kUncolored);
    if (colored || !o.corner_colors.empty()) o.corner_colors.push_back(colored.value_or(kUncolored));
    o.triangles.push_back(t);
    return Node::kLeaf;
  }

  Expected<ThreeMfPlacement> placement(const XmlAttributes& a) {
    ThreeMfPlacement p;
    KERF_TRY(text, need(a, "objectid"));
    KERF_TRY(id, index("objectid", text, 1, std::size_t{kMostIndex} + 1, "a number"));
    p.id = id;
    if (const auto path = a.find(kProductionPath)) {
      if (!is_root) return bad("path", inQuotes(*path), "none outside the first part");
      p.path = *path;
    } else {
      const auto known = object_index.find(id);
      if (known == object_index.end()) return bad("objectid", inQuotes(text), "an object defined before");
      p.object = known->second;
    }

    const auto transform = a.find("transform");
    if (!transform) return p;

    // Row vectors: p' = p * M, the translation in the last row.
    std::array<double, 12> m{};
    std::size_t n = 0;
    Words words(trimmed(*transform));
    for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++n) {
      if (n == m.size()) return bad("transform", "of more than 12 numbers", "12 numbers");
      if (const char* wrong = parseNumber(word, m[n]))
        return bad("transform", inQuotes(word) + ", " + wrong, "12 numbers");
    }
    if (n != m.size()) return bad("transform", "of " + std::to_string(n) + " numbers", "12 numbers");

    p.linear << m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8];
    p.translation = {m[9], m[10], m[11]};

    const double determinant = p.linear.determinant();
    if (!std::isfinite(determinant) || determinant == 0)
      return bad("transform", "that flattens the object", "12 numbers");
    p.is_identity = p.linear == Eigen::Matrix3d::Identity() && p.translation == Vec3d::Zero();
    return p;
  }

  Expected<Node> component(const XmlAttributes& a) {
    KERF_TRY(p, placement(a));
    // An object can name itself: it is in the list already.
    if (p.path.empty() && p.object + 1 == out.objects.size())
      return bad("objectid", std::to_string(p.id) + ", the object itself", "an object defined before");
    out.objects.back().components.push_back(std::move(p));
    return Node::kLeaf;
  }
  Expected<Node> item(const XmlAttributes& a) {
    KERF_TRY(p, placement(a));
    out.items.push_back(std::move(p));
    return Node::kLeaf;
  }

  static constexpr std::array<Rgba8, 3> kUncolored{kNoColor, kNoColor, kNoColor};

  bool is_root;
  ThreeMfModel out;
  std::vector<Node> open{Node::kDocument};
  std::map<std::string, std::string> prefixes;  // declared by the model element
  std::set<std::uint32_t> ids, other_resources;
  std::map<std::uint32_t, std::size_t> object_index;
  std::map<std::uint32_t, std::vector<Rgba8>> color_groups;
  std::vector<Rgba8>* color_group = nullptr;         // the one being read
  const std::vector<Rgba8>* object_group = nullptr;  // of the object being read
  std::optional<Rgba8> object_color;
  XmlParser xml;
};

ThreeMfModelParser::ThreeMfModelParser(const MeshSource& source, std::string_view part, bool is_root)
    : state_(std::make_unique<State>(source, part, is_root)) {}
ThreeMfModelParser::~ThreeMfModelParser() = default;

Expected<void> ThreeMfModelParser::feed(std::string_view piece) { return state_->xml.feed(piece); }

Expected<ThreeMfModel> ThreeMfModelParser::finish() {
  KERF_CHECK(state_->xml.feed({}, true));
  return std::move(state_->out);
}

// --- _rels/.rels ---

struct ThreeMfRelationsParser::State : XmlParser::Handler {
  explicit State(const MeshSource& source) : xml(source, "_rels/.rels", *this) {}

  Expected<void> start(std::string_view name, const XmlAttributes& a) override {
    constexpr std::string_view kModel = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
    if (Name(name).local == "Relationship" && a.find("Type").value_or("") == kModel && target.empty())
      target = a.find("Target").value_or("");
    return {};
  }
  Expected<void> end() override { return {}; }

  std::string target;
  XmlParser xml;
};

ThreeMfRelationsParser::ThreeMfRelationsParser(const MeshSource& source) : state_(std::make_unique<State>(source)) {}
ThreeMfRelationsParser::~ThreeMfRelationsParser() = default;

Expected<void> ThreeMfRelationsParser::feed(std::string_view piece) { return state_->xml.feed(piece); }

Expected<std::string> ThreeMfRelationsParser::finish() {
  KERF_CHECK(state_->xml.feed({}, true));
  if (state_->target.empty())
    return fail(state_->xml.here(Error::Code::kBadFormat, "no relationship to a 3D model", "the model of a 3MF file",
                                 "the file is damaged, or no 3MF file; export it again"));
  return std::move(state_->target);
}

}  // namespace kerf::internal
