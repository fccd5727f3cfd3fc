#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/tool/head_shape.h"
#include "geometry/tool/tool_kinds.h"

namespace kerf {
namespace {

constexpr const char* kBurKeys[] = {"shape",         "profile",     "cuts",           "end_length",   "iso6360",
                                    "neck_diameter", "neck_length", "shank_diameter", "shank_length", "profile_file"};

// Words for shapes that catalogues use and Kerf spells otherwise.
struct Synonym {
  const char *word, *hint;
};
constexpr Synonym kShapeWords[] = {
    {"ball", "round"},
    {"sphere", "round"},
    {"fissure", "cylinder, or taper_flat for a tapered fissure"},
    {"straight", "cylinder"},
    {"flat", "cylinder"},
    {"taper", "taper_flat or taper_round"},
    {"tapered", "taper_flat or taper_round"},
    {"chamfer", "taper_round or torpedo"},
    {"shoulder", "taper_flat"},
    {"egg", "football"},
    {"end_cutting", "cylinder, with cuts = [\"end\"] and end_length = 0.4"},
    {"twist_drill", "drill, with cuts = [\"end\"]"},
    {"pilot_drill", "drill, with cuts = [\"end\"]"},
    {"disc", "kind = \"blade\" with motion = \"spin\""},
    {"disk", "kind = \"blade\" with motion = \"spin\""},
};

// Words for keys.
constexpr Synonym kKeyWords[] = {
    {"diameter", "head_diameter"},
    {"radius", "head_diameter, which is twice the radius"},
    {"head_radius", "head_diameter, which is twice the radius"},
    {"tip_radius", "tip_diameter, which is twice the radius"},
    {"neck_radius", "neck_diameter, which is twice the radius"},
    {"shank_radius", "shank_diameter, which is twice the radius"},
    {"length", "head_length, from the tip to the head's top"},
    {"working_length", "head_length"},
    {"end_radius", "edge_radius where a flat end meets the side, tip_diameter for a round tip"},
    {"angle", "point_angle of a drill; a taper follows from tip_diameter, head_diameter and head_length"},
    {"taper", "tip_diameter: head_diameter - 2 head_length tan(taper per side)"},
    {"taper_angle", "tip_diameter: head_diameter - 2 head_length tan(taper per side)"},
    {"unit", "leave it out: lengths are in mm"},
    {"units", "leave it out: lengths are in mm"},
    {"iso", "iso6360"},
    {"iso_code", "iso6360"},
    {"shank", "shank_diameter and shank_length, in mm"},
};

std::vector<ProfilePoint> readProfile(TomlTable& top) {
  constexpr const char* kKey = "profile";
  constexpr std::size_t kMost = 256;
  const std::string expected = "[[height, diameter], ...] in mm, 2 to 256 points from height 0 upwards";
  const std::string example = "profile = [[0, 0.4], [2, 1.2, 2.5], [4, 1.0]]";
  top.allow(kKey);
  std::vector<ProfilePoint> out;
  const toml::node* node = top.node(kKey);
  const toml::array* array = node ? node->as_array() : nullptr;

  if (!array || array->size() < 2 || array->size() > kMost) {
    top.reject(kKey,
               array  ? fmt::format("{} points", array->size())
               : node ? "another type"
                      : "missing",
               expected, example);
    return out;
  }

  for (const toml::node& item : *array) {
    const toml::array* numbers = item.as_array();
    const bool fits = numbers && (numbers->size() == 2 || numbers->size() == 3) &&
                      std::all_of(numbers->begin(), numbers->end(), [](const auto& n) { return n.is_number(); });
    const auto at = [&](std::size_t n) { return fits && n < numbers->size() ? *(*numbers)[n].value<double>() : 0.0; };
    const ProfilePoint p{at(0), at(1), at(2)};
    const std::string point = fmt::format("point {}", out.size() + 1);

    if (!fits)
      top.reject(kKey, point + " is neither [height, diameter] nor [height, diameter, arc radius]", expected, example);
    else if (!(p.height >= 0 && p.height <= 50 && p.diameter >= 0 && p.diameter <= 50))
      top.reject(kKey, fmt::format("{} is [{}, {}]", point, p.height, p.diameter),
                 "heights and diameters from 0 to 50 mm");
    else if (!(std::abs(p.arc_radius) <= 1000))
      top.reject(kKey, fmt::format("{} has an arc radius of {}", point, p.arc_radius),
                 "-1000 to 1000 mm, 0 for a line");
    else if (out.empty() && p.height != 0)
      top.reject(kKey, fmt::format("begins at height {}", p.height), "the tip at height 0");
    else if (!out.empty() && p.height < out.back().height)
      top.reject(kKey, fmt::format("{} goes down to height {}", point, p.height), "heights that do not decrease");
    if (top.failed()) return out;
    out.push_back(p);
  }

  if (out.back().height <= 0) top.reject(kKey, "no height", expected, example);
  return out;
}

// The drawing of a head in the folder of its file.
std::vector<OutlinePiece> readProfileFile(TomlTable& top, const std::filesystem::path& folder, Tool& tool) {
  constexpr const char* kKey = "profile_file";
  const auto name = top.get<std::string>(kKey, "the name of a drawing beside this one");
  top.allow("profile");
  if (top.has("profile")) top.reject(kKey, "\"" + name + "\"", "one of profile and profile_file");
  if (name.empty() || std::filesystem::path(name).filename() != name)
    top.reject(kKey, "\"" + name + "\"", "the name of a .dxf or .svg file in the folder of this one");
  if (top.failed()) return {};
  tool.companion = folder / name;
  auto outline = readOutline(tool.companion);
  if (outline) return *std::move(outline);
  const Error& error = outline.error();
  top.reject(kKey, fmt::format("{}: {}{}", name, error.place.empty() ? "" : error.place + ": ", error.found),
             error.expected, error.hint);
  return {};
}

// Cutting parts: both, or one of side and end.
void readCuts(TomlTable& top, Tool& tool) {
  constexpr const char* kExpected = "[\"side\", \"end\"], [\"side\"] or [\"end\"]";
  if (!top.has("cuts")) return top.allow("cuts");
  tool.cuts_side = tool.cuts_end = false;
  for (const std::string& part : top.strings("cuts")) {
    if (part == "side")
      tool.cuts_side = true;
    else if (part == "end")
      tool.cuts_end = true;
    else
      top.reject("cuts", "\"" + part + "\"", kExpected);
  }
  if (!tool.cuts_side && !tool.cuts_end) top.reject("cuts", "nothing that cuts", kExpected);
}

// The code itself and its last three digits: before anything that follows from a wrong head_diameter.
void readIso6360(TomlTable& top, Tool& tool, double head) {
  tool.iso6360 = top.getOr<std::string>("iso6360", "", "15 digits in quotes");
  if (tool.iso6360.empty() || top.failed()) return;
  const auto code = parseIso6360(tool.iso6360);
  if (!code) return top.reject("iso6360", code.error().found, code.error().expected, code.error().hint);
  tool.iso = *code;
  const double coded = code->diameterMm();
  if (std::abs(coded - head) > 0.05 + 1e-9) {
    const auto is = [&](double factor) { return std::abs(head * factor - coded) < 0.051; };
    const std::string digits = tool.iso6360.substr(12);
    std::string hint = fmt::format("the code or the number: {} is {:.1f} mm", digits, coded);
    if (is(10))
      hint =
          fmt::format("head_diameter = {:.1f}: the code counts tenths of a millimetre, {} means {:.1f} mm, not {:.2f}",
                      coded, digits, coded, coded / 10);
    else if (is(2))
      hint = fmt::format("head_diameter = {:.1f}: {} looks like a radius", coded, head);
    else if (std::abs(head * 0.1 - coded) < 0.051)
      hint = fmt::format("head_diameter = {:.1f}, in mm: {} looks like tenths of a millimetre", coded, head);
    top.reject("iso6360", fmt::format("code ends in {} = {:.1f} mm", digits, coded),
               fmt::format("the head_diameter, {} mm", head), hint);
  }
}

void checkShank(TomlTable& top, const Iso6360& code, double shank_diameter, double overall) {
  const auto shank = code.shankKnown();
  if (!shank || shank_diameter <= 0) return;
  if (std::abs(shank->diameter_mm - shank_diameter) > 0.05)
    top.reject("iso6360", fmt::format("shank {} is {}, {} mm thick", code.shank, shank->name, shank->diameter_mm),
               fmt::format("the shank_diameter, {} mm", shank_diameter),
               "1.6 mm is FG (313 to 316), 2.35 mm RA (204 to 206) or HP (104)");
  if (std::abs(shank->length_mm - overall) > 0.6)
    top.reject("iso6360", fmt::format("shank {} makes an instrument of {} mm", code.shank, shank->length_mm),
               fmt::format("head, neck and shank together, {:.4g} mm", overall),
               fmt::format("a shank_length that is {:.4g} mm {}", std::abs(shank->length_mm - overall),
                           shank->length_mm > overall ? "longer" : "shorter"));
}

const HeadShape* readShape(TomlTable& top) {
  const auto name = top.get<std::string>("shape", "a head shape");
  const HeadShape* shape = findHeadShape(name);
  if (shape) return shape;
  std::vector<std::string> names;
  std::string all, hint;
  for (const HeadShape& s : headShapes()) {
    names.emplace_back(s.name);
    all += (all.empty() ? "" : ", ") + names.back();
  }
  for (const Synonym& s : kShapeWords)
    if (name == s.word) hint = s.hint;
  if (hint.empty()) hint = nearestName(name, names);
  top.reject("shape", "\"" + name + "\"", "one of " + all, hint.empty() ? "shape = \"profile\", for any other" : hint);
  // Which keys belong depends on the shape: without one, none is called unknown.
  allowBurKeys(top);
  return nullptr;
}

// The numbers of the head: those its shape takes, and its diameter.
HeadNumbers readHead(TomlTable& top, const HeadShape& shape, const std::filesystem::path& folder, Tool& tool) {
  HeadNumbers n;
  for (const HeadKey& key : headKeys()) {
    const auto taken = std::find_if(shape.keys.begin(), shape.keys.end(),
                                    [&](const HeadShape::Key& k) { return std::string(k.name) == key.name; });
    const bool is_diameter = key.value == &HeadNumbers::head_diameter;
    if (taken == shape.keys.end() && !is_diameter) continue;

    if (is_diameter && top.has(key.name))
      if (const auto said = top.node(key.name)->value<double>(); said && *said > 0 && *said < key.low)
        top.reject(key.name, fmt::format("{}", *said), fmt::format("a number from {} to {} mm", key.low, key.high),
                   "mm, not cm or m: 016 on a packet is 1.6");
    const std::string unit = fmt::format("{}: {}", key.unit, key.meaning);
    if (is_diameter || !taken->unsaid || top.has(key.name))
      n.*key.value = top.number(key.name, key.low, key.high, unit.c_str());
    else
      top.allow(key.name);
  }
  if (shape.takes_profile && top.has("profile_file"))
    n.outline = readProfileFile(top, folder, tool);
  else if (shape.takes_profile)
    n.profile = readProfile(top);
  return n;
}

// Inert part above the head; diameter 0: none.
struct Stem {
  double neck = 0, neck_length = 0, shank = 0, shank_length = 0;  // mm
};

Stem readStem(TomlTable& top, double head_diameter) {
  Stem stem;
  stem.neck = top.numberOr("neck_diameter", 0, 0.05, 50);
  stem.neck_length = top.numberOr("neck_length", 0, 0.05, 100);
  stem.shank = top.numberOr("shank_diameter", 0, 0.05, 50);
  stem.shank_length = top.numberOr("shank_length", 0, 0.05, 200);
  for (const char* part : {"neck", "shank"})
    if (const std::string d = fmt::format("{}_diameter", part), l = fmt::format("{}_length", part);
        top.has(d) != top.has(l))
      top.reject(top.has(d) ? d : l, "stands alone", "both " + d + " and " + l + ", or neither");
  if (stem.neck > head_diameter)
    top.reject("neck_diameter", fmt::format("{}", stem.neck),
               fmt::format("at most the head_diameter, {} mm", head_diameter),
               "a neck that can follow the head into its cut");
  return stem;
}

// Upper limit of the end, if only one of side and end cuts; 0: omitted, as allowed for a drill.
double readEndLength(TomlTable& top, const Tool& tool, bool is_parted) {
  top.allow("end_length");
  if (is_parted && (top.has("end_length") || tool.shape != "drill")) return top.number("end_length", 0.05, 50);
  if (top.has("end_length"))
    top.reject("end_length", "where all of the head cuts", "cuts = [\"end\"] or [\"side\"] beside it");
  return 0;
}

// The head's outline; empty, with the error in `top`, if the numbers are invalid.
std::optional<RevolvedProfile> buildHead(TomlTable& top, const HeadShape& shape, const HeadNumbers& n) {
  const auto built = shape.build(n);
  if (!built) {
    const HeadMistake& wrong = built.error();
    const auto key =
        std::find_if(headKeys().begin(), headKeys().end(), [&](const HeadKey& k) { return wrong.key == k.name; });
    top.reject(wrong.key, key == headKeys().end() ? "a point that cannot be drawn" : fmt::format("{}", n.*key->value),
               wrong.expected, wrong.hint);
    return std::nullopt;
  }
  const double rounding = n.outline.empty() ? 1e-6 : 1e-3;  // mm: of a drawing
  if (const double widest = 2 * built->largestRadius(); std::abs(widest - n.head_diameter) > rounding) {
    top.reject("head_diameter", fmt::format("{}", n.head_diameter),
               fmt::format("the widest of the profile, {:.7g} mm", widest),
               std::abs(2 * n.head_diameter - widest) < rounding   ? "diameters throughout, never radii"
               : std::abs(n.head_diameter - 2 * widest) < rounding ? "twice the profile's second numbers: diameters, "
                                                                     "never radii"
                                                                   : "");
    return std::nullopt;
  }
  return *built;
}

// Neck and shank. The lowest part reaches down into the head until it is wholly covered: a ball narrows towards its
// top. A shank wider than all of the head begins above it.
RevolvedProfile outlineOf(const Stem& stem, const RevolvedProfile& head) {
  const double lowest = 0.5 * (stem.neck > 0 ? stem.neck : stem.shank);
  RevolvedProfile body(lowest > head.largestRadius() ? head.highest() : head.highestAsWideAs(lowest));
  if (stem.neck > 0)
    body.lineTo(0.5 * stem.neck, body.end()[1]).lineTo(0.5 * stem.neck, head.highest() + stem.neck_length);
  if (stem.shank > 0)
    body.lineTo(0.5 * stem.shank, body.end()[1])
        .lineTo(0.5 * stem.shank, head.highest() + stem.neck_length + stem.shank_length);
  return body.close();
}

// cut and body of the tool. @param end_length  where end and side part, if not both cut.
void buildShapes(Tool& tool, const RevolvedProfile& head, double end_length, const Stem& stem) {
  const bool is_parted = tool.cuts_side != tool.cuts_end;
  tool.head = std::make_shared<const RevolvedProfile>(head);
  const double low = tool.cuts_end ? 0 : end_length, high = tool.cuts_side ? head.highest() : end_length;
  tool.cutting = is_parted ? std::make_shared<const RevolvedProfile>(head.clipped(low, high)) : tool.head;
  tool.cut = std::make_shared<const RevolvedShape>(*tool.cutting);
  if (!tool.cuts_end) tool.plunge_direction = -Vec3d::UnitX();

  if (is_parted)
    tool.body_outlines.push_back(tool.cuts_end ? head.clipped(high, head.highest()) : head.clipped(0, low));
  if (stem.neck > 0 || stem.shank > 0) tool.body_outlines.push_back(outlineOf(stem, head));
  std::vector<std::shared_ptr<const ToolShape>> parts;
  for (const RevolvedProfile& outline : tool.body_outlines) parts.push_back(std::make_shared<RevolvedShape>(outline));
  if (parts.size() == 1)
    tool.body = parts[0];
  else if (!parts.empty())
    tool.body = std::make_shared<const UnionShape>(parts);
}

}  // namespace

void allowBurKeys(TomlTable& top) {
  for (const HeadKey& key : headKeys()) top.allow(key.name);
  for (const char* key : kBurKeys) top.allow(key);
}

void readBur(TomlTable& top, const std::filesystem::path& folder, Tool& tool) {
  for (const Synonym& s : kKeyWords) top.explain(s.word, s.hint);
  const HeadShape* shape = readShape(top);
  if (!shape) return;

  tool.shape = shape->name;
  const HeadNumbers n = readHead(top, *shape, folder, tool);
  readCuts(top, tool);
  readIso6360(top, tool, n.head_diameter);
  const Stem stem = readStem(top, n.head_diameter);
  const bool is_parted = tool.cuts_side != tool.cuts_end;
  double end_length = readEndLength(top, tool, is_parted);
  if (top.failed()) return;

  const std::optional<RevolvedProfile> head = buildHead(top, *shape, n);
  if (!head) return;
  tool.head_diameter_mm = n.head_diameter;
  tool.head_length_mm = head->highest();
  tool.neck_diameter_mm = stem.neck;
  tool.shank_diameter_mm = stem.shank;
  if (tool.iso) checkShank(top, *tool.iso, stem.shank, head->highest() + stem.neck_length + stem.shank_length);
  // A drill cuts with its point and the corner behind it: without that land the rim would be a knife's edge, which no
  // grid holds.
  if (is_parted && end_length == 0) end_length = head->pieces().front().to[1] + 0.25 * n.head_diameter;
  if (is_parted && !(end_length < head->highest()))
    top.reject("end_length", fmt::format("{}", end_length),
               fmt::format("less than the head's length, {:.4g} mm", head->highest()));
  if (top.failed()) return;

  buildShapes(tool, *head, end_length, stem);
}

}  // namespace kerf
