// Design dimensions of the demo anatomy, with their sources. The tests measure the meshes.
#pragma once

namespace kerf {

/// Two ends of a range, both included.
struct DemoRange {
  double least, most;
};

/// Lower first molar, mm. Wheeler: averages of "Dental Anatomy, Physiology and Occlusion"; several textbooks share a
/// textbook range.
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
  DemoRange canal_diameter{0.3, 1.0};      ///< Kerf's choice: wide enough to be visible at the apex, narrower than an
                                           ///< orifice
};

/// Mandible with teeth 1 to 7, mm unless noted.
struct DemoMandibleDimensions {
  DemoRange bicondylar{110, 125};              ///< over the outer poles of the condyles; textbook range
  DemoRange bigonial{90, 105};                 ///< textbook range
  DemoRange body_length{75, 85};               ///< chin to gonion in the side view; textbook range
  DemoRange symphysis_height{28, 32};          ///< textbook range
  DemoRange height_at_mental_foramen{28, 32};  ///< textbook range
  double ramus_height = 44.8;                  ///< notch to lower border; Head Face Med 2020, 228
  double ramus_width = 31.3;                   ///< Head Face Med 2020, 228
  double gonial_angle_deg = 124.8;             ///< degrees; Head Face Med 2020, 228
  double foramen_from_back = 0.53;             ///< mandibular foramen, share of the width; Head Face Med 2020, 228
  double foramen_from_below = 0.65;            ///< share of the height; Head Face Med 2020, 228
  double border_at_symphysis = 11.2;           ///< thickness of the lower border; PMC10366919
  double border_at_gonion = 5.4;               ///< PMC10366919
  DemoRange cortex{2.0, 3.0};                  ///< of the body, thickest at the base; textbook range
  double ramus_cortex = 1.6;                   ///< Kerf's choice: leaves room for marrow in 6 mm of bone
  double canal_diameter = 3.0;                 ///< of 2.0 to 3.4; textbook range
  DemoRange canal_below_foramen{3.4, 4.4};     ///< lowest point of the canal under the mental foramen; Lin 2020
  double canal_to_border = 8.0;                ///< at the second molar; El Hadidi 2024, SD 3.4
  double canal_to_root = 1.76;                 ///< at the second molar; El Hadidi 2024, SD 1.86
  double canal_to_buccal = 5.16;               ///< at the second molar; El Hadidi 2024, SD 1.26
  double canal_wall = 0.5;                     ///< compact bone around the canal; Kerf's choice
  double ligament = 0.2;                       ///< PDL; textbook value
  double socket_wall = 0.5;                    ///< compact bone around the ligament; Kerf's choice
  double junction_to_crest = 1.75;             ///< of 1.5 to 2 below the cemento-enamel junction; textbook range
};

}  // namespace kerf
