#include "preprocess/unit/unit.h"

#include <fmt/format.h>

#include <array>
#include <vector>

namespace kerf {
namespace {

constexpr double kSmallest = 3, kLargest = 300;  // mm across, a crown to a skull

struct Unit {
  std::string_view name;
  double mm;
  double smallest = kSmallest;  // mm across, without a given unit
  bool fits(double across) const { return across * mm >= smallest && across * mm <= kLargest; }
};
// In inches come blocks and skulls, no object below 6 mm: 0.12 to 0.236 across is a jaw in metres.
constexpr std::array<Unit, 5> kUnits{{{"mm", 1}, {"cm", 10}, {"m", 1000}, {"um", 0.001}, {"inch", 25.4, 6}}};

/// Units in which a size would be dental, with the size: "0.1047 mm across is no dental object; in m it would be
/// 104.7".
std::string elsewhere(double across, double mm) {
  std::string text = fmt::format("{:.4g} mm across is not a dental size", across * mm);
  std::string_view separator = "; it would be ";
  for (const Unit& u : kUnits)
    if (u.fits(across)) {
      text += fmt::format("{}{:.4g} mm in {}", separator, across * u.mm, u.name);
      separator = ", ";
    }
  return text;
}

/// A unit the user or the file names: taken, with a warning where it makes no dental object.
UnitChoice named(std::string_view unit, double mm, const char* by_whom, double across) {
  const bool fits = across * mm >= kSmallest && across * mm <= kLargest;
  return {std::string(unit), mm,
          fits ? std::string(by_whom) : fmt::format("{}, but {}", by_whom, elsewhere(across, mm)), !fits};
}

}  // namespace

std::vector<std::string> unitNames() {
  std::vector<std::string> names;
  for (const Unit& u : kUnits) names.emplace_back(u.name);
  return names;
}

Expected<double> millimetresPer(std::string_view unit) {
  for (const Unit& u : kUnits)
    if (u.name == unit) return u.mm;
  return fail({.code = Error::Code::kBadValue,
               .place = "--unit",
               .found = fmt::format("\"{}\"", unit),
               .expected = "mm, cm, m, um or inch"});
}

Expected<UnitChoice> chooseUnit(const Box3& box, std::string_view asked, std::string_view declared) {
  const double across = box.size().norm();

  // The user or the file names it.
  if (!asked.empty()) {
    KERF_TRY(mm, millimetresPer(asked));
    UnitChoice choice = named(asked, mm, "set with --unit", across);
    if (!declared.empty() && declared != asked) {
      choice.reason += fmt::format(", though the file says {}", declared);
      choice.is_doubtful = true;
    }
    return choice;
  }
  if (!declared.empty()) {
    KERF_TRY(mm, millimetresPer(declared));
    return named(declared, mm, "as the file says", across);
  }

  // By the size.
  const bool fits_mm = kUnits[0].fits(across);
  constexpr double kSmallObject = 15;  // a crown; or a jaw in cm, a block in inches
  if (fits_mm && across < kSmallObject)
    return UnitChoice{
        "mm", 1,
        fmt::format(
            "{:.4g} across fits a crown in mm; in cm it would be {:.4g} mm, in inches {:.4g} mm: if so, set --unit",
            across, 10 * across, 25.4 * across),
        true};
  if (fits_mm)
    return UnitChoice{"mm", 1, fmt::format("{:.4g} across fits a dental object in mm; the file names no unit", across),
                      false};

  std::vector<Unit> others;
  for (const Unit& u : kUnits)
    if (u.fits(across)) others.push_back(u);
  if (others.size() == 1)
    return UnitChoice{std::string(others[0].name), others[0].mm,
                      fmt::format("{:.4g} across is not a dental size in mm, but {:.4g} mm in {} is; --unit overrides",
                                  across, across * others[0].mm, others[0].name),
                      true};
  return UnitChoice{"mm", 1,
                    fmt::format("{:.4g} across fits {}: read as mm, unscaled; set --unit if that is wrong", across,
                                others.empty() ? "no unit" : "several units but not mm"),
                    true};
}

Expected<void> requireOneUnit(const std::filesystem::path& file, const Box3& box, std::string_view declared,
                              const UnitChoice& shared, const std::filesystem::path& other) {
  KERF_TRY(alone, chooseUnit(box, "", declared));
  const bool is_known = !declared.empty() || alone.unit != "mm" || kUnits[0].fits(box.size().norm());
  if (!is_known || alone.scale_to_mm == shared.scale_to_mm) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = file.string(),
               .place = "unit",
               .found = fmt::format("{} ({}), but {} for {} ({})", alone.unit, alone.reason, shared.unit,
                                    other.string(), shared.reason),
               .expected = "one unit for all files of an object",
               .hint = fmt::format("--unit {} if all are in it; else export them in one unit", shared.unit)});
}

}  // namespace kerf
