#include "geometry/tool_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/assets.h"
#include "geometry/toml_reader.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr const char* kCopyInRun = "tool.toml";  // a copy inside a run folder keeps its id

struct HeadNumbers {
  double diameter = 0, tip_diameter = 0, length = 0;
  std::vector<std::pair<double, double>> outline;  // height, diameter
};

// --- The visible list of head shapes: a new one is one function and one line in kHeadShapes. ---

RevolvedProfile roundHead(const HeadNumbers& n) {
  const double r = 0.5 * n.diameter;
  return RevolvedProfile().arcTo({0, r}, {0, 2 * r});
}

RevolvedProfile cylinderHead(const HeadNumbers& n) {
  const double r = 0.5 * n.diameter;
  return RevolvedProfile().lineTo(r, 0).lineTo(r, n.length).close();
}

RevolvedProfile cylinderRoundHead(const HeadNumbers& n) {
  const double r = 0.5 * n.diameter;
  return RevolvedProfile().arcTo({0, r}, {r, r}).lineTo(r, n.length).close();
}

// A sphere of radius r = tip / 2 about (0, r), and the cone through (R, L) that touches it. With the half angle a the
// cone's outward normal is (cos a, -sin a), so R cos a - (L - r) sin a = r: a = acos(r / A) - atan2(L - r, R),
// A = hypot(R, L - r). They touch at (r cos a, r - r sin a).
RevolvedProfile taperRoundHead(const HeadNumbers& n) {
  const double r = 0.5 * n.tip_diameter, R = 0.5 * n.diameter, up = n.length - r;
  const double a = std::acos(r / std::hypot(R, up)) - std::atan2(up, R);
  const RevolvedProfile::Point touch(r * std::cos(a), r - r * std::sin(a));
  return RevolvedProfile().arcTo({0, r}, touch).lineTo(R, n.length).close();
}

RevolvedProfile taperFlatHead(const HeadNumbers& n) {
  return RevolvedProfile().lineTo(0.5 * n.tip_diameter, 0).lineTo(0.5 * n.diameter, n.length).close();
}

RevolvedProfile coneHead(const HeadNumbers& n) { return RevolvedProfile().lineTo(0.5 * n.diameter, n.length).close(); }

RevolvedProfile outlineHead(const HeadNumbers& n) {
  RevolvedProfile profile;
  for (const auto& [height, diameter] : n.outline) profile.lineTo(0.5 * diameter, height);
  return profile.close();
}

struct HeadShape {
  const char* name;
  bool length, tip, outline;  // keys it takes beside head_diameter
  double shortest;            // head_length, in head diameters
  RevolvedProfile (*build)(const HeadNumbers&);
};
constexpr HeadShape kHeadShapes[] = {
    {"round", false, false, false, 0, roundHead},
    {"cylinder", true, false, false, 0, cylinderHead},
    {"cylinder_round", true, false, false, 0.5, cylinderRoundHead},
    {"taper_round", true, true, false, 0.5, taperRoundHead},
    {"taper_flat", true, true, false, 0, taperFlatHead},
    {"cone", true, false, false, 0, coneHead},
    {"profile", false, false, true, 0, outlineHead},
};

std::string headShapeNames() {
  std::string names;
  for (const HeadShape& s : kHeadShapes) names += (names.empty() ? "" : ", ") + std::string(s.name);
  return names;
}

std::vector<std::pair<double, double>> readOutline(TomlTable& top) {
  constexpr const char* kKey = "profile";
  constexpr std::size_t kMost = 256;
  const std::string expected = "[[height, diameter], ...] in mm, 2 to 256 points from height 0 upwards";
  top.allow(kKey);
  std::vector<std::pair<double, double>> out;
  const toml::node* node = top.node(kKey);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (!array || array->size() < 2 || array->size() > kMost) {
    top.reject(kKey, array ? fmt::format("{} points", array->size()) : node ? "another type" : "missing", expected);
    return out;
  }
  for (const toml::node& item : *array) {
    const toml::array* pair = item.as_array();
    const bool is_pair = pair && pair->size() == 2 && (*pair)[0].is_number() && (*pair)[1].is_number();
    const double height = is_pair ? *(*pair)[0].value<double>() : 0,
                 diameter = is_pair ? *(*pair)[1].value<double>() : 0;
    const std::string point = fmt::format("point {}", out.size() + 1);
    if (!is_pair)
      top.reject(kKey, point + " is no pair of numbers", expected);
    else if (!(height >= 0 && height <= 50 && diameter >= 0 && diameter <= 50))
      top.reject(kKey, fmt::format("{} is [{}, {}]", point, height, diameter), "heights and diameters from 0 to 50 mm");
    else if (out.empty() && height != 0)
      top.reject(kKey, fmt::format("begins at height {}", height), "the tip at height 0");
    else if (!out.empty() && height < out.back().first)
      top.reject(kKey, fmt::format("{} goes down to height {}", point, height), "heights that do not decrease");
    if (top.failed()) return out;
    out.emplace_back(height, diameter);
  }
  if (out.back().first <= 0) top.reject(kKey, "no height", expected);
  return out;
}

void checkIso6360(TomlTable& top, const std::string& code, double head_diameter) {
  if (code.empty()) return;
  if (code.size() != 15 || !std::all_of(code.begin(), code.end(), [](char c) { return c >= '0' && c <= '9'; })) {
    top.reject("iso6360", "\"" + code + "\"", "15 digits: material, shank, shape, execution, head diameter in 1/10 mm");
    return;
  }
  const double coded = std::stoi(code.substr(12)) / 10.0;
  if (std::abs(coded - head_diameter) > 0.05 + 1e-9)
    top.reject("iso6360", fmt::format("code ends in {} = {:.1f} mm", code.substr(12), coded),
               fmt::format("the head_diameter, {} mm", head_diameter));
}

void readBur(TomlTable& top, Tool& tool) {
  const auto name = top.get<std::string>("shape", "a head shape");
  const auto* shape =
      std::find_if(std::begin(kHeadShapes), std::end(kHeadShapes), [&](const HeadShape& s) { return name == s.name; });
  if (shape == std::end(kHeadShapes)) {
    top.reject("shape", "\"" + name + "\"", "one of " + headShapeNames());
    return;
  }
  HeadNumbers n;
  n.diameter = top.number("head_diameter", 0.1, 50);
  if (shape->tip) n.tip_diameter = top.number("tip_diameter", 0.01, 50);
  if (shape->length) n.length = top.number("head_length", 0.05, 50);
  if (shape->outline) n.outline = readOutline(top);
  tool.iso6360 = top.getOr<std::string>("iso6360", "", "15 digits in quotes");
  checkIso6360(top, tool.iso6360, n.diameter);
  const double neck = top.numberOr("neck_diameter", 0, 0.05, 50),
               neck_length = top.numberOr("neck_length", 0, 0.05, 100);
  const double shank = top.numberOr("shank_diameter", 0, 0.05, 50);
  const double shank_length = top.numberOr("shank_length", 0, 0.05, 200);
  if (shape->tip && n.tip_diameter > n.diameter)
    top.reject("tip_diameter", fmt::format("{}", n.tip_diameter),
               fmt::format("at most the head_diameter, {} mm", n.diameter),
               "shape = \"profile\" for a head that narrows");
  if (shape->length && n.length < shape->shortest * n.diameter)
    top.reject("head_length", fmt::format("{}", n.length),
               fmt::format("at least {} mm, half the head_diameter", shape->shortest * n.diameter));
  for (const char* part : {"neck", "shank"})
    if (const std::string d = fmt::format("{}_diameter", part), l = fmt::format("{}_length", part);
        top.has(d) != top.has(l))
      top.reject(top.has(d) ? d : l, "stands alone", "both " + d + " and " + l + ", or neither");
  if (neck > n.diameter)
    top.reject("neck_diameter", fmt::format("{}", neck), fmt::format("at most the head_diameter, {} mm", n.diameter),
               "a neck wider than the head could not follow it into its cut");
  if (top.failed()) return;

  const RevolvedProfile head = shape->build(n);
  if (std::abs(2 * head.largestRadius() - n.diameter) > 1e-6) {
    top.reject("head_diameter", fmt::format("{}", n.diameter),
               fmt::format("the widest of the profile, {} mm", 2 * head.largestRadius()));
    return;
  }
  tool.head_diameter_mm = n.diameter;
  tool.head_length_mm = head.highest();
  tool.head = std::make_shared<const RevolvedProfile>(head);
  tool.cut = std::make_shared<const RevolvedShape>(head);
  if (neck <= 0 && shank <= 0) return;
  // The lowest part reaches down into the head until it is wholly covered: a ball narrows towards its top.
  const double lowest_radius = 0.5 * (neck > 0 ? neck : shank);
  const double reach =
      shape->build == roundHead
          ? std::sqrt(std::max(0.0, 0.25 * n.diameter * n.diameter - lowest_radius * lowest_radius)) + 0.5 * n.diameter
          : head.highest();
  RevolvedProfile body(std::min(reach, head.highest()));
  if (neck > 0) body.lineTo(0.5 * neck, body.end()[1]).lineTo(0.5 * neck, head.highest() + neck_length);
  if (shank > 0)
    body.lineTo(0.5 * shank, body.end()[1]).lineTo(0.5 * shank, head.highest() + neck_length + shank_length);
  tool.body = std::make_shared<const RevolvedShape>(body.close());
}

void readBlade(TomlTable& top, Tool& tool) {
  tool.thickness_mm = top.number("thickness", 0.05, 5);
  tool.set_per_side_mm = top.numberOr("set_per_side", 0.02, 0, 1);
  tool.blade_width_mm = top.number("width", 0.2, 50);
  tool.blade_length_mm = top.number("length", 1, 100);
  tool.stroke_mm = top.number("stroke", 0, 20);
  tool.tooth_pitch_mm = top.number("tooth_pitch", 0.1, 10);
  tool.edge_depth_mm = top.numberOr("edge_depth", 0.5, 0.05, 10);
  const auto motion = top.get<std::string>("motion", "\"reciprocating\"");
  if (motion != "reciprocating") top.reject("motion", "\"" + motion + "\"", "\"reciprocating\"");
  if (tool.edge_depth_mm > tool.blade_width_mm)
    top.reject("edge_depth", fmt::format("{}", tool.edge_depth_mm),
               fmt::format("at most the width, {} mm", tool.blade_width_mm));
  if (top.failed()) return;
  const double low = -0.5 * tool.stroke_mm, high = tool.blade_length_mm + 0.5 * tool.stroke_mm;
  const double half = 0.5 * tool.thickness_mm, half_kerf = half + tool.set_per_side_mm;
  tool.cut =
      std::make_shared<const BoxShape>(Box3{Vec3d(0, -half_kerf, low), Vec3d(tool.edge_depth_mm, half_kerf, high)});
  tool.body = std::make_shared<const BoxShape>(Box3{Vec3d(0, -half, low), Vec3d(tool.blade_width_mm, half, high)});
  tool.plunge_direction = -Vec3d::UnitX();
}

}  // namespace

Expected<Tool> readTool(const fs::path& file) {
  KERF_TRY(root, parseToml(file));
  TomlTable top(root, file, "");
  Tool tool;
  const auto format = top.get<std::string>("format", "\"kerf-tool\"");
  if (format != "kerf-tool") top.reject("format", "\"" + format + "\"", "\"kerf-tool\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (version != 1) top.reject("version", fmt::format("{}", version), "1");
  tool.id = top.get<std::string>("id", "the file's name without .toml");
  if (tool.id.empty() || tool.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") != std::string::npos)
    top.reject("id", "\"" + tool.id + "\"", "lower-case letters, digits and hyphens");
  if (file.filename() != kCopyInRun && file.stem() != tool.id)
    top.reject("id", "\"" + tool.id + "\"", "the file's name, \"" + file.stem().string() + "\"");
  tool.name = top.get<std::string>("name", "a name for people");
  tool.description = top.getOr<std::string>("description", "", "a text");
  const auto kind = top.get<std::string>("kind", "\"bur\" or \"blade\"");
  if (kind == "bur") {
    tool.kind = ToolKind::kBur;
    readBur(top, tool);
    if (top.failed())  // which keys belong depends on the shape: without one, none is called unknown
      if (const auto shape = root["shape"].value<std::string>();
          !shape ||
          std::none_of(std::begin(kHeadShapes), std::end(kHeadShapes), [&](auto& s) { return *shape == s.name; }))
        for (const char* key : {"head_diameter", "tip_diameter", "head_length", "profile", "iso6360", "neck_diameter",
                                "neck_length", "shank_diameter", "shank_length"})
          top.allow(key);
  } else if (kind == "blade") {
    tool.kind = ToolKind::kBlade;
    readBlade(top, tool);
  } else {
    top.reject("kind", "\"" + kind + "\"", "\"bur\" or \"blade\"");
    for (const char* key : {"shape", "head_diameter", "tip_diameter", "head_length", "profile", "iso6360",
                            "neck_diameter", "neck_length", "shank_diameter", "shank_length", "thickness",
                            "set_per_side", "width", "length", "stroke", "tooth_pitch", "edge_depth", "motion"})
      top.allow(key);
  }
  KERF_CHECK(top.finish());
  return tool;
}

std::vector<ToolListing> listTools(const std::vector<fs::path>& folders) {
  std::vector<fs::path> files;
  for (const fs::path& folder : folders) {
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
      if (entry->path().extension() == ".toml") files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return std::pair(a.stem(), a) < std::pair(b.stem(), b); });
  std::vector<ToolListing> out;
  for (const fs::path& file : files) {
    ToolListing& listing = out.emplace_back();
    listing.file = file;
    if (auto tool = readTool(file))
      listing.tool = std::move(*tool);
    else
      listing.error = tool.error();
  }
  return out;
}

std::vector<fs::path> defaultToolFolders() { return findAssets("tools"); }

Expected<fs::path> findToolFile(const std::string& id_or_path, const std::vector<fs::path>& folders) {
  const fs::path path(id_or_path);
  std::error_code ignored;
  if (path.has_parent_path() || path.extension() == ".toml") {
    if (fs::is_regular_file(path, ignored)) return path;
    return fail({Error::Code::kNotFound, id_or_path, "", "no such file", "a tool's TOML file", "kerf tool list"});
  }
  std::string known;
  for (const fs::path& folder : folders)
    if (fs::path file = folder / (id_or_path + ".toml"); fs::is_regular_file(file, ignored)) return file;
  for (const ToolListing& listing : listTools(folders))
    known += (known.empty() ? "" : ", ") + listing.file.stem().string();
  return fail({Error::Code::kNotFound, "", "tool " + id_or_path, "no such tool",
               known.empty() ? "a tools folder" : "one of " + known,
               known.empty() ? "set KERF_ASSETS to the folder that holds tools/" : "the path of a TOML file"});
}

}  // namespace kerf
