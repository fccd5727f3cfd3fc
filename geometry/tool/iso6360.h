// The fifteen digits on a bur's packet: 806 314 198524 016.
#pragma once

#include <optional>
#include <string>

#include "geometry/base/error.h"

namespace kerf {

/// A number system for rotary instruments (ISO 6360): material, shank with overall length, shape, execution, head
/// diameter. An unknown group stays, without a meaning.
struct Iso6360 {
  std::string material;   ///< three digits: 806 diamond, 500 tungsten carbide
  std::string shank;      ///< three digits: 314 friction grip, 1.6 mm, 19 mm long
  std::string shape;      ///< three digits: 198 taper with a round end
  std::string execution;  ///< three digits: 524 medium grit
  int tenths = 0;         ///< three digits: the largest diameter of the head in 1/10 mm: 016 is 1.6 mm

  struct Shank {
    const char* name;
    double diameter_mm, length_mm;  ///< diameter of the shank; length of the whole instrument
  };
  double diameterMm() const { return tenths / 10.0; }
  std::optional<Shank> shankKnown() const;
  /// "diamond", "" when unknown; likewise the others.
  std::string materialName() const;
  std::string shapeName() const;
  std::string executionName() const;  ///< diamonds: grit with its grain in um
  /// "diamond; FG 1.6 mm, 19 mm long; taper, round end; medium grit, 107 um; head 1.6 mm"
  std::string meaning() const;
};

/// kBadValue with `found`, `expected` and `hint`; the caller adds file and place.
Expected<Iso6360> parseIso6360(const std::string& code);

}  // namespace kerf
