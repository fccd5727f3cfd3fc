// What the demo anatomy measures: the numbers it is built to, with their sources. The tests measure the meshes.
#pragma once

namespace kerf {

/// Two ends of a range, both included.
struct DemoRange {
  double least, most;
};

/// Lower first molar, mm. Wheeler: averages of "Dental Anatomy, Physiology and Occlusion"; a textbook range is one that
/// several textbooks share.
struct DemoMolarDimensions {
  double crown_height = 7.5;               ///< Wheeler
  double crown_mesiodistal = 11.0;         ///< Wheeler
  double cervix_mesiodistal = 9.0;         ///< Wheeler
  double crown_buccolingual = 10.5;        ///< Wheeler
  double root_length = 14.0;               ///< Wheeler
  double cusp_to_pulp_ceiling = 6.36;      ///< buccal cusp; Deutsch & Musikant 2004, SD 0.93
  double pulp_chamber_height = 1.57;       ///< Deutsch & Musikant 2004, SD 0.68
  double pulp_floor_to_furcation = 2.96;   ///< Deutsch & Musikant 2004, SD 0.78
  DemoRange enamel_at_cusps{2.0, 2.6};     ///< textbook range
  DemoRange enamel_at_sides{1.3, 1.6};     ///< half way up; textbook range
  DemoRange enamel_at_fissures{0.5, 1.0};  ///< floor; textbook range
  DemoRange canal_diameter{0.3, 1.0};      ///< ours: wide enough to be seen at the apex, narrower than an orifice
};

}  // namespace kerf
