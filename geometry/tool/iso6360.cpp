#include "geometry/tool/iso6360.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

struct Meaning {
  const char *code, *meaning;
};
// Public catalogues and decoders agree on these codes. The table omits disputed codes (sintered diamond).
constexpr Meaning kMaterials[] = {{"310", "steel"}, {"500", "tungsten carbide"}, {"806", "diamond"}};
constexpr Meaning kShapes[] = {{"001", "round"},
                               {"010", "inverted cone"},
                               {"031", "acorn"},
                               {"068", "round wheel"},
                               {"107", "cylinder, flat"},
                               {"110", "cylinder, flat"},
                               {"111", "cylinder, flat"},
                               {"140", "cylinder, round"},
                               {"141", "cylinder, round"},
                               {"142", "cylinder, round"},
                               {"150", "end-cutting"},
                               {"165", "needle"},
                               {"166", "needle"},
                               {"170", "taper, flat"},
                               {"171", "taper, flat"},
                               {"172", "taper, flat"},
                               {"198", "taper, round"},
                               {"199", "taper, round"},
                               {"225", "inverted cone"},
                               {"233", "pear"},
                               {"234", "pear"},
                               {"237", "pear"},
                               {"249", "flame"},
                               {"250", "flame"},
                               {"257", "bud"},
                               {"277", "football"},
                               {"288", "torpedo"},
                               {"289", "torpedo"},
                               {"290", "torpedo"},
                               {"298", "torpedo, tapered"},
                               {"299", "torpedo, tapered"}};
constexpr Meaning kGrits[] = {{"494", "ultra-fine grit, 8-15 um"}, {"504", "extra-fine grit, 25-30 um"},
                              {"514", "fine grit, 46-50 um"},      {"524", "medium grit, 107 um"},
                              {"534", "coarse grit, 135-151 um"},  {"544", "super-coarse grit, 180 um"}};
struct ShankCode {
  const char* code;
  Iso6360::Shank shank;
};
// ISO 1797: FG is type 3, 1.6 mm; RA and HP are types 1 and 2, 2.35 mm.
constexpr ShankCode kShanks[] = {{"104", {"HP", 2.35, 44.5}}, {"204", {"RA", 2.35, 22}}, {"205", {"RA", 2.35, 26}},
                                 {"206", {"RA", 2.35, 34}},   {"313", {"FG", 1.6, 16}},  {"314", {"FG", 1.6, 19}},
                                 {"315", {"FG", 1.6, 21}},    {"316", {"FG", 1.6, 25}}};

template <std::size_t N>
std::string lookUp(const Meaning (&table)[N], const std::string& code) {
  for (const Meaning& m : table)
    if (code == m.code) return m.meaning;
  return "";
}

}  // namespace

std::optional<Iso6360::Shank> Iso6360::shankKnown() const {
  for (const ShankCode& s : kShanks)
    if (shank == s.code) return s.shank;
  return std::nullopt;
}
std::string Iso6360::materialName() const { return lookUp(kMaterials, material); }
std::string Iso6360::shapeName() const { return lookUp(kShapes, shape); }
std::string Iso6360::executionName() const { return material == "806" ? lookUp(kGrits, execution) : ""; }

std::string Iso6360::meaning() const {
  std::string text;
  const auto say = [&](const char* group, const std::string& code, const std::string& meaning) {
    text += meaning.empty() ? fmt::format("{} {}; ", group, code) : meaning + "; ";
  };

  say("material", material, materialName());
  const auto known = shankKnown();
  say("shank", shank,
      known ? fmt::format("{} shank {} mm, {} mm long in all", known->name, known->diameter_mm, known->length_mm) : "");
  say("shape", shape, shapeName());
  say("execution", execution, executionName());
  return text + fmt::format("head {:.1f} mm", diameterMm());
}

Expected<Iso6360> parseIso6360(const std::string& code) {
  const bool is_digits = std::all_of(code.begin(), code.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (code.size() != 15 || !is_digits) {
    std::string digits;
    for (const char c : code)
      if (c >= '0' && c <= '9') digits += c;
    return fail(
        {.code = Error::Code::kBadValue,
         .found = is_digits ? fmt::format("\"{}\" has {} digits", code, code.size()) : "\"" + code + "\"",
         .expected = "15 digits: material 806, shank 314, shape 198, execution 524, head diameter 016 in 1/10 mm",
         .hint = digits.size() == 15 ? "\"" + digits + "\", digits only"
                                     : "\"806314198524016\", or leave the key out if a digit is not known"});
  }

  return Iso6360{code.substr(0, 3), code.substr(3, 3), code.substr(6, 3), code.substr(9, 3),
                 std::stoi(code.substr(12))};
}

}  // namespace kerf
