// The unit of a mesh file: from the user, the file, or the size, always with a reason.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

struct UnitChoice {
  std::string unit;  ///< "mm", "cm", "m", "um" or "inch"
  double scale_to_mm = 1;
  std::string reason;        ///< one sentence, shown to the user and kept in the case
  bool is_doubtful = false;  ///< the size fits no unit, several, or not the named one; deserves a warning
};

/// "mm", "cm", "m", "um", "inch".
std::vector<std::string> unitNames();

/// Millimetres per unit; kBadValue with the list of units for an unknown name.
Expected<double> millimetresPer(std::string_view unit);

/// Order: `asked` by the user, `declared` in the file, then the size. A dental object, from a crown to a skull, is 3 to
/// 300 mm across, in inches 6 to 300. Coordinates outside this range that fit exactly one other unit get that unit.
/// Otherwise the unit is mm: no scaling on an ambiguous guess. A named unit always wins; if it gives no dental size,
/// the choice is doubtful, and the reason lists the units that fit.
/// @param box  of the mesh, in the file's unit.
Expected<UnitChoice> chooseUnit(const Box3& box, std::string_view asked, std::string_view declared);

/// For files of one object. Error kBadValue: the own unit of `file` differs from the unit it shares with `other`. A
/// size that fits no unit contradicts none.   @param declared  in `file`.
Expected<void> requireOneUnit(const std::filesystem::path& file, const Box3& box, std::string_view declared,
                              const UnitChoice& shared, const std::filesystem::path& other);

}  // namespace kerf
