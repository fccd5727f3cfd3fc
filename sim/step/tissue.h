// A material's properties for the step, by the number stored in a voxel.
#pragma once

#include <array>

#include "geometry/field/material.h"

namespace kerf {

/// Coherent units for the laws.
struct Tissue {
  float stiffness = 0;       ///< contact stiffness k_n, N/mm^3: pressure per overlap
  float friction = 0;        ///< mu of the cutting drag, no unit
  float inverse_energy = 0;  ///< 1 / u_s, mm^2/N (u_s in N mm per mm^3; 1 J/mm^3 = 1000 N/mm^2)
  bool is_in_table = false;  ///< false: the number has no material and is treated as the fallback
};

/// One row per number 0 to 255. Numbers without a material of their own, including kNone, take the fallback's row: a
/// node at the surface may carry no label.
using TissueTable = std::array<Tissue, 256>;

/// @param fallback  material of unlabelled nodes. Error: a material without contact stiffness or cutting energy.
Expected<TissueTable> tissueTable(const MaterialTable& materials, Material fallback = Material::kGeneric);

}  // namespace kerf
