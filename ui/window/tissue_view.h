// Making tissues visible: an object coloured by material, and cut open by a plane.
#pragma once

#include "geometry/brick_field.h"
#include "geometry/material_field.h"
#include "geometry/mesh.h"

namespace kerf {

/// Gives every triangle the colour of the material at its middle.
void colorByMaterial(Mesh& mesh, const MaterialField& materials, const MaterialTable& table);

/// What of an object lies below a plane, closed by a picture of its inside: one square per voxel, coloured by material,
/// trimmed to the outline by linear interpolation. For the eye only: the lid is not joined to the rest.
/// @param solid  closed, mm.   @param phi  its distance field.
Mesh section(const Mesh& solid, const BrickField& phi, const MaterialField& materials, const MaterialTable& table,
             const Plane& plane);

}  // namespace kerf
