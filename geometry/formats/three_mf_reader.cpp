// 3MF: the package, and its objects assembled as its build states.
#include <algorithm>
#include <map>

#include "geometry/formats/three_mf_model.h"
#include "geometry/formats/zip_archive.h"

namespace kerf::internal {
namespace {

constexpr const char* kDamaged = "the file is cut short or damaged; export or copy it again";
constexpr std::size_t kMostParts = 1024, kMostNesting = 64;
// Components multiply: 20 lines can ask for 10^18 triangles. A plate full of copies stays far below.
constexpr std::uint64_t kFreeTriangles = 1'000'000, kMostCopies = 100, kMostTotal = 0xfffffff0u;

struct Part {
  ThreeMfModel model;
  struct Size {
    std::uint64_t vertices = 0, triangles = 0;
    std::size_t nesting = 0;  // components below components
  };
  std::vector<Size> sizes;  // per object, with its components
};

struct Affine {
  bool is_identity = true;
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Vec3d translation = Vec3d::Zero();

  Affine after(const ThreeMfPlacement& p) const {
    if (p.is_identity) return *this;
    if (is_identity) return {false, p.linear, p.translation};
    return {false, linear * p.linear, linear * p.translation + translation};
  }
};

class ThreeMfReader {
 public:
  ThreeMfReader(const MeshSource& source, ZipArchive archive, const Progress& progress)
      : source_(source), progress_(progress), archive_(std::move(archive)) {}

  Expected<MeshFile> read() {
    ThreeMfRelationsParser relations(source_);
    KERF_CHECK(readEntry("_rels/.rels", [&](std::string_view piece) { return relations.feed(piece); }));
    KERF_TRY(first, relations.finish());
    KERF_TRY(root, readPart(first, true));

    // Parts that the build and components of the first one name; those cannot name others.
    for (const ThreeMfObject& object : root->model.objects)
      for (const ThreeMfPlacement& component : object.components) KERF_CHECK(needPart(component.path));
    for (const ThreeMfPlacement& item : root->model.items) KERF_CHECK(needPart(item.path));

    for (auto& [path, part] : parts_) KERF_CHECK(measure(*part));
    KERF_CHECK(measure(*root));
    setUnit(root->model.unit);
    KERF_CHECK(build(*root));

    finishColors();
    file_.objects = names_.finish(file_.mesh.triangles.size());
    if (names_.hasTooMany()) file_.notes.push_back(noteOfTooManyNames());
    file_.had_double_coordinates |= root->model.had_double_coordinates;
    for (const auto& [path, part] : parts_) file_.had_double_coordinates |= part->model.had_double_coordinates;
    return finished(source_, std::move(file_));
  }

 private:
  tl::unexpected<Error> bad(Error::Code code, std::string place, std::string found, std::string expected,
                            std::string hint = kDamaged) const {
    return fail({code, source_.file, std::move(place), std::move(found), std::move(expected), std::move(hint)});
  }

  Expected<void> readEntry(std::string_view name, const std::function<Expected<void>(std::string_view)>& take) {
    const auto entry = archive_.find(name);
    if (!entry) return bad(Error::Code::kBadFormat, "zip archive", "no part " + inQuotes(name), "a whole 3MF package");
    return archive_.read(*entry, take, progress_);
  }

  Expected<std::unique_ptr<Part>> readPart(const std::string& path, bool is_root) {
    ThreeMfModelParser parser(source_, path, is_root);
    KERF_CHECK(readEntry(path, [&](std::string_view piece) { return parser.feed(piece); }));
    KERF_TRY(model, parser.finish());
    for (const ThreeMfObject& object : model.objects) stored_triangles_ += object.triangles.size();
    for (const std::string& name : model.skipped) skipped_.insert(name);
    auto part = std::make_unique<Part>();
    part->model = std::move(model);
    return part;
  }

  Expected<void> needPart(const std::string& path) {
    if (path.empty() || parts_.contains(path)) return {};
    if (parts_.size() == kMostParts)
      return bad(Error::Code::kUnsupported, inQuotes(path), "more than " + std::to_string(kMostParts) + " model parts",
                 "fewer", "export the object by itself");
    KERF_TRY(part, readPart(path, false));
    parts_.emplace(path, std::move(part));
    return {};
  }

  struct Target {
    const Part* part;
    std::size_t object;
  };
  Expected<Target> resolve(const Part& home, const ThreeMfPlacement& p) const {
    if (p.path.empty()) return Target{&home, p.object};
    const Part& other = *parts_.at(p.path);
    const std::size_t object = other.model.find(p.id);
    if (object == other.model.objects.size())
      return bad(Error::Code::kBadValue, inQuotes(p.path), "no object " + std::to_string(p.id),
                 "the referenced object");
    return Target{&other, object};
  }

  // Sizes of all objects with their components, known before anything is built: it might not fit into memory.
  Expected<void> measure(Part& part) {
    part.sizes.resize(part.model.objects.size());
    for (std::size_t o = 0; o < part.sizes.size(); ++o) {
      const ThreeMfObject& object = part.model.objects[o];
      Part::Size size{object.vertices.size(), object.triangles.size(), 0};
      for (const ThreeMfPlacement& component : object.components) {
        KERF_TRY(target, resolve(part, component));
        const Part::Size& of = target.part->sizes[target.object];
        size.vertices = std::min(size.vertices + of.vertices, kMostTotal);
        size.triangles = std::min(size.triangles + of.triangles, kMostTotal);
        size.nesting = std::max(size.nesting, of.nesting + 1);
      }

      if (size.nesting > kMostNesting)
        return bad(Error::Code::kUnsupported, "object " + std::to_string(object.id),
                   "components nested deeper than " + std::to_string(kMostNesting), "fewer",
                   "export the object by itself");
      part.sizes[o] = size;
    }
    return {};
  }

  void setUnit(const std::string& unit) {
    if (unit == "foot") {  // exact: a foot is 12 inches
      file_.declared_unit = "inch";
      scale_ = 12;
      file_.notes.emplace_back("The file is in feet; its coordinates were multiplied by 12 and are in inches.");
      return;
    }
    constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
        {"micron", "um"}, {"millimeter", "mm"}, {"centimeter", "cm"}, {"inch", "inch"}, {"meter", "m"}};
    for (const auto& [theirs, ours] : kUnits)
      if (unit == theirs) file_.declared_unit = ours;
  }

  Expected<void> build(Part& root) {
    std::uint64_t vertices = 0, triangles = 0;
    std::size_t supports = 0, empty = 0;
    std::vector<std::pair<Target, const ThreeMfPlacement*>> items;
    for (const ThreeMfPlacement& item : root.model.items) {
      KERF_TRY(target, resolve(root, item));

      const Part::Size& size = target.part->sizes[target.object];
      if (target.part->model.objects[target.object].is_support)
        ++supports;
      else if (size.triangles == 0)
        ++empty;
      else {
        items.emplace_back(target, &item);
        vertices += size.vertices;
        triangles += size.triangles;
      }

      if (std::max(vertices, triangles) >= std::min(kMostTotal, kFreeTriangles + kMostCopies * stored_triangles_))
        return bad(Error::Code::kUnsupported, "build",
                   "copies of copies: " + std::to_string(vertices) + " vertices or more of the " +
                       std::to_string(stored_triangles_) + " triangles stored",
                   "a build of at most 100 times what the file stores", "export the object by itself");
    }

    if (root.model.items.empty() && stored_triangles_ > 0)
      return bad(Error::Code::kEmpty, "build",
                 "nothing to build, although the file holds " + std::to_string(root.model.objects.size()) + " objects",
                 "at least one item in the build",
                 "put the object on the plate in the program that wrote the file, and save again");

    file_.mesh.vertices.reserve(vertices);
    file_.mesh.triangles.reserve(triangles);
    for (const auto& [target, item] : items) KERF_CHECK(add(*target.part, target.object, Affine{}.after(*item), ""));
    if (file_.mesh.triangles.empty()) return {};

    if (placed_ > 1)
      file_.notes.emplace_back(std::to_string(items.size()) + " build items, " + std::to_string(placed_) +
                               " objects and copies in all, were united into one mesh.");
    if (moved_ > 0) file_.notes.emplace_back("Objects were moved to where the build places them.");
    if (supports > 0) file_.notes.emplace_back(std::to_string(supports) + " supports were left out.");
    if (empty > 0) file_.notes.emplace_back(std::to_string(empty) + " build items without triangles were left out.");

    std::string list;
    for (const std::string& name : skipped_) list += (list.empty() ? "" : ", ") + inQuotes(name);
    if (!list.empty()) file_.notes.emplace_back("Not read: " + list + ".");
    return {};
  }

  // Depth is at most kMostNesting; skips objects without triangles.
  // @param whole  name of the object with this component.
  Expected<void> add(const Part& part, std::size_t index, const Affine& affine, const std::string& whole) {
    const ThreeMfObject& object = part.model.objects[index];
    const std::string& name = object.name.empty() ? whole : object.name;
    if (!object.triangles.empty()) KERF_CHECK(addMesh(object, affine, name));
    for (const ThreeMfPlacement& component : object.components) {
      KERF_TRY(target, resolve(part, component));
      if (target.part->sizes[target.object].triangles > 0)
        KERF_CHECK(add(*target.part, target.object, affine.after(component), name));
    }
    return {};
  }

  Expected<void> addMesh(const ThreeMfObject& object, const Affine& affine, const std::string& name) {
    Mesh& mesh = file_.mesh;
    names_.begin(name, mesh.triangles.size());
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    if (!report(progress_, static_cast<double>(mesh.triangles.size()) / static_cast<double>(mesh.triangles.capacity()),
                "building the 3MF"))
      return cancelled(source_);

    for (const Vec3d& stored : object.vertices) {
      Vec3d p = affine.is_identity ? stored : Vec3d(affine.linear * stored + affine.translation);
      p *= scale_;
      if (!p.allFinite())
        return bad(Error::Code::kBadValue, "object " + std::to_string(object.id),
                   "a transform that sends a vertex beyond all numbers", "finite coordinates");
      if (!affine.is_identity || scale_ != 1)
        file_.had_double_coordinates = file_.had_double_coordinates || roundedToFloat(p) != p;
      mesh.vertices.push_back(p);
    }

    const bool mirrored = affine.linear.determinant() < 0;  // the inside would be outside
    if (!object.corner_colors.empty()) {
      corner_colors_.resize(mesh.triangles.size(), kUncolored);
      corner_colors_.insert(corner_colors_.end(), object.corner_colors.begin(), object.corner_colors.end());
      if (mirrored)
        for (std::size_t t = mesh.triangles.size(); t < corner_colors_.size(); ++t)
          std::swap(corner_colors_[t][1], corner_colors_[t][2]);
    }

    for (const Triangle& t : object.triangles)
      mesh.triangles.push_back(mirrored ? Triangle{first + t[0], first + t[2], first + t[1]}
                                        : Triangle{first + t[0], first + t[1], first + t[2]});

    ++placed_;
    moved_ += affine.is_identity ? 0 : 1;
    return {};
  }

  // 3MF colours the corners of triangles. One colour per triangle is a face colour; shaded ones are vertex colours.
  void finishColors() {
    Mesh& mesh = file_.mesh;
    if (corner_colors_.empty()) return;
    corner_colors_.resize(mesh.triangles.size(), kUncolored);
    const auto isFlat = [](const std::array<Rgba8, 3>& c) { return c[0] == c[1] && c[1] == c[2]; };
    if (std::all_of(corner_colors_.begin(), corner_colors_.end(), isFlat)) {
      mesh.face_colors.reserve(mesh.triangles.size());
      for (const auto& corners : corner_colors_) mesh.face_colors.push_back(corners[0]);
      return;
    }

    std::vector<char> known(mesh.vertices.size(), 0), differs(mesh.vertices.size(), 0);
    mesh.vertex_colors.assign(mesh.vertices.size(), kNoColor);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh.triangles[t][k];
        if (!known[v]) {
          known[v] = 1;
          mesh.vertex_colors[v] = corner_colors_[t][k];
        }
        differs[v] |= mesh.vertex_colors[v] != corner_colors_[t][k] ? 1 : 0;
      }

    if (const auto n = std::count(differs.begin(), differs.end(), 1); n > 0)
      file_.notes.emplace_back(std::to_string(n) +
                               " vertices have another colour in every triangle; the first one was taken.");
  }

  static constexpr std::array<Rgba8, 3> kUncolored{kNoColor, kNoColor, kNoColor};

  const MeshSource& source_;
  const Progress& progress_;
  ZipArchive archive_;
  std::map<std::string, std::unique_ptr<Part>> parts_;  // all but the first
  std::uint64_t stored_triangles_ = 0;
  std::set<std::string> skipped_;
  double scale_ = 1;
  std::size_t placed_ = 0, moved_ = 0;
  PartList names_;
  std::vector<std::array<Rgba8, 3>> corner_colors_;  // empty or one per triangle so far
  MeshFile file_;
};

}  // namespace

// A zip archive holds the names of its parts uncompressed. Other formats pack XML the same way, but without a model
// part.
bool isThreeMf(const MeshSource& source) {
  const std::string_view text = source.text();
  return text.starts_with("PK\x03\x04") && text.find("_rels/.rels") != text.npos && text.find(".model") != text.npos;
}

Expected<MeshFile> readThreeMf(const MeshSource& source, const Progress& progress) {
  KERF_TRY(archive, ZipArchive::open(source));
  return ThreeMfReader(source, std::move(archive), progress).read();
}

}  // namespace kerf::internal
