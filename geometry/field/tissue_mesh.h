// Display of tissues: an object coloured by material, and cut open by a plane.
#pragma once

#include <functional>

#include "geometry/field/material_field.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Gives every triangle the colour of the material at its middle.
void colorByMaterial(Mesh& mesh, const MaterialField& materials, const MaterialTable& table);

/// The part of an object below a plane, closed by a picture of its inside: one square per voxel, coloured by material,
/// trimmed to the outline by linear interpolation. For display only: the lid is not joined to the rest.
/// @param surface  closed, mm, with face colours.   @param distance  to the object, mm, negative inside.
/// @param voxel  side of the squares, mm.
Mesh section(const Mesh& surface, const std::function<double(const Vec3d&)>& distance, double voxel,
             const MaterialField& materials, const MaterialTable& table, const Plane& plane);

}  // namespace kerf
