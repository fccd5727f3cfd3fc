#include "ui/app/saw/slicer_planes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "geometry/base/text.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMostSlicerBytes = 16 << 20, kMostSlicerPlanes = 200, kLongestSlicerName = 60;
constexpr double kFarthestSlicerMm = 1e4;  // of a coordinate
constexpr double kSameAxis = 0.9999;       // cosine between the normal and the third axis: 0.8 degrees

// One plane of the file. Keeps the first error, as TomlTable does.
class SlicerMarkup {
 public:
  SlicerMarkup(const json& object, const fs::path& file, std::size_t n) : object_(object), file_(file), n_(n) {}

  bool has(const char* key) const { return object_.contains(key) && !object_[key].is_null(); }

  Error error(Error::Code code, const std::string& key, std::string found, std::string expected) const {
    return {.code = code,
            .file = file_.string(),
            .place = fmt::format("markups[{}]{}", n_, key.empty() ? "" : "." + key),
            .found = std::move(found),
            .expected = std::move(expected),
            .hint = "save the plane again in 3D Slicer, as .mrk.json"};
  }

  // Empty if the key is missing.
  Expected<std::string> text(const char* key) const {
    if (!has(key)) return std::string();
    if (object_[key].is_string()) return object_[key].get<std::string>();
    return fail(error(Error::Code::kBadFormat, key, object_[key].type_name(), "a text"));
  }

  template <std::size_t N>
  Expected<std::array<double, N>> numbers(const json& list, const std::string& key) const {
    std::array<double, N> out{};
    const bool is_list = list.is_array() && list.size() == N &&
                         std::all_of(list.begin(), list.end(), [](const json& value) { return value.is_number(); });
    if (!is_list) {
      const std::string found = list.is_array() ? fmt::format("a list of {} items", list.size()) : list.type_name();
      return fail(error(Error::Code::kBadFormat, key, found, fmt::format("{} numbers", N)));
    }
    for (std::size_t n = 0; n < N; ++n) {
      out[n] = list[n].template get<double>();
      if (!(std::abs(out[n]) < kFarthestSlicerMm))
        return fail(error(Error::Code::kBadValue, key, fmt::format("{}", out[n]), "less than 10 m"));
    }
    return out;
  }

  Expected<Vec3d> vector(const json& list, const std::string& key) const {
    KERF_TRY(v, numbers<3>(list, key));
    return Vec3d(v[0], v[1], v[2]);
  }

  const json& operator[](const char* key) const { return object_[key]; }

 private:
  const json& object_;
  const fs::path& file_;
  std::size_t n_;
};

struct SlicerFrame {
  std::string name;  // "LPS", "RAS", "LPS (not named)"
  double mm = 1;     // length of a unit
  bool is_turned = false;

  Vec3d way(const Vec3d& v) const { return is_turned ? Vec3d(0 - v[0], 0 - v[1], v[2]) : v; }
  Vec3d place(const Vec3d& v) const { return mm * way(v); }
};

Expected<SlicerFrame> slicerFrameOf(const SlicerMarkup& markup) {
  SlicerFrame out;
  KERF_TRY(system, markup.text("coordinateSystem"));
  if (!system.empty() && system != "LPS" && system != "RAS")
    return fail(markup.error(Error::Code::kUnsupported, "coordinateSystem", "\"" + system + "\"", "LPS or RAS"));
  out.name = system.empty() ? "LPS (not named)" : system;
  out.is_turned = system == "RAS";

  // A text, or a code of three texts: "mm", "UCUM", "millimeter".
  const bool is_code = markup.has("coordinateUnits") && markup["coordinateUnits"].is_array() &&
                       !markup["coordinateUnits"].empty() && markup["coordinateUnits"][0].is_string();
  std::string unit;
  if (is_code)
    unit = markup["coordinateUnits"][0].get<std::string>();
  else {
    KERF_TRY(text, markup.text("coordinateUnits"));
    unit = text.empty() ? "mm" : text;
  }
  if (unit != "mm" && unit != "um")
    return fail(markup.error(Error::Code::kUnsupported, "coordinateUnits", "\"" + unit + "\"", "mm or um"));
  if (unit == "um") out.mm = 1e-3;
  return out;
}

// Of older files, which have no centre and no normal.
Expected<SawPlane> planeOfPoints(const SlicerMarkup& markup, const SlicerFrame& frame) {
  std::vector<Vec3d> points;
  if (markup.has("controlPoints") && markup["controlPoints"].is_array())
    for (const json& point : markup["controlPoints"]) {
      if (!point.is_object() || !point.contains("position") || point["position"].is_null()) continue;
      const std::string key = fmt::format("controlPoints[{}].position", points.size());
      KERF_TRY(position, markup.vector(point["position"], key));
      points.push_back(frame.place(position));
    }
  if (points.size() != 3)
    return fail(markup.error(Error::Code::kBadFormat, "",
                             fmt::format("no center with normal, and {} placed points", points.size()),
                             "center and normal, or three points"));
  auto plane = planeThrough({points[0], points[1], points[2]}, Vec3d::UnitZ());
  if (!plane)
    return fail(markup.error(plane.error().code, "controlPoints", plane.error().found, plane.error().expected));
  return plane;
}

// Centre and normal; with axes and size also the rectangle.
Expected<SawPlane> planeOfCentre(const SlicerMarkup& markup, const SlicerFrame& frame) {
  KERF_TRY(read_center, markup.vector(markup["center"], "center"));
  KERF_TRY(read_normal, markup.vector(markup["normal"], "normal"));
  const Vec3d center = frame.place(read_center), normal = frame.way(read_normal);
  auto plane = planeSquareTo(center, normal);
  if (!plane) return fail(markup.error(Error::Code::kBadValue, "normal", "a vector of length 0", "a direction"));
  if (!markup.has("orientation")) return plane;

  KERF_TRY(axes, markup.numbers<9>(markup["orientation"], "orientation"));  // by rows; a column is an axis
  const auto axis = [&](std::size_t n) { return frame.way({axes[n], axes[n + 3], axes[n + 6]}); };
  const double length = axis(2).norm();
  if (!(axis(2).dot(plane->normal) > kSameAxis * length) || !(length > 0.5))
    return fail(markup.error(Error::Code::kBadValue, "orientation", "a third axis that is not the normal",
                             "axes that fit the normal"));
  std::array<double, 3> size{plane->width, plane->depth, 0};
  if (markup.has("size")) {
    KERF_TRY(read_size, markup.numbers<3>(markup["size"], "size"));
    size = read_size;
  }
  const std::size_t down = std::abs(axis(0)[2]) > std::abs(axis(1)[2]) ? 0 : 1;
  const Vec3d way = axis(down)[2] > 0 ? Vec3d(-axis(down)) : axis(down);
  KERF_TRY(turned, planeSquareTo(center, normal, way));
  const auto side = [&](double units) {
    return std::clamp(std::abs(frame.mm * units), SawPlan::kLeastSide, SawPlan::kMostSide);
  };
  turned.depth = side(size[down]);
  turned.width = side(size[1 - down]);
  turned.point = center - 0.5 * turned.depth * turned.approach;
  return turned;
}

std::string slicerNameOf(const std::string& written, const fs::path& file) {
  std::string name = written.empty() ? file.stem().stem().string() : written;  // NAME.mrk.json
  const bool is_odd = std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; });
  return is_odd || name.size() > kLongestSlicerName ? std::string() : name;
}

}  // namespace

bool isSlicerFile(const fs::path& file) { return file.extension() == ".json"; }

Expected<SlicerPlanes> readSlicerPlanes(const fs::path& file) {
  KERF_TRY(text, readSmallFile(file, kMostSlicerBytes));
  const auto wrong = [&](std::string found, std::string expected) {
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = "a plane saved by 3D Slicer (.mrk.json), or a plan of saw.save"});
  };
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded()) return wrong("no valid JSON", "markups of 3D Slicer");
  if (!root.is_object() || !root.contains("markups") || !root["markups"].is_array())
    return wrong("no list \"markups\"", "markups of 3D Slicer");

  SlicerPlanes out;
  std::set<std::string> frames, others;
  const json& markups = root["markups"];
  for (std::size_t n = 0; n < markups.size(); ++n) {
    if (!markups[n].is_object()) return wrong(fmt::format("markups[{}] is no object", n), "markups of 3D Slicer");
    const SlicerMarkup markup(markups[n], file, n);
    KERF_TRY(type, markup.text("type"));
    if (type != "Plane") {
      others.insert(type);
      ++out.origin.others;
      continue;
    }
    if (out.planes.size() == kMostSlicerPlanes)
      return wrong(fmt::format("more than {} planes", kMostSlicerPlanes), fmt::format("at most {}", kMostSlicerPlanes));
    KERF_TRY(frame, slicerFrameOf(markup));
    const bool has_both = markup.has("center") && markup.has("normal");
    KERF_TRY(plane, has_both ? planeOfCentre(markup, frame) : planeOfPoints(markup, frame));
    KERF_TRY(name, markup.text("name"));
    plane.name = slicerNameOf(name, file);
    out.planes.push_back(std::move(plane));
    frames.insert(frame.name);
  }
  if (out.planes.empty())
    return wrong(others.empty() ? "no markups" : fmt::format("only markups of type {}", fmt::join(others, ", ")),
                 "a markup of type Plane");
  out.origin.frame = fmt::format("{}", fmt::join(frames, " and "));
  return out;
}

}  // namespace kerf
