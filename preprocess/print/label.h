// Engraves a text into a solid, or embosses it.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/print/glyph_outlines.h"

namespace kerf {

struct LabelOptions {
  std::string text;  ///< UTF-8; '\n' ends a line
  double height_mm =
      4;  ///< of a capital letter, 0.5 to 100; strokes of Inter Bold: 0.62 mm at 4 mm for digits, 0.49 for an a
  double depth_mm = 0.6;  ///< below the surface, or above; 0.05 to 10. A printer hardly shows less than 0.3
  bool embossed = false;  ///< raised; else engraved
  /// The middle of the text's rectangle, within 1.5 mm of the surface.
  Vec3d point = Vec3d::Zero();
  Vec3d normal = Vec3d::UnitZ();  ///< out of the solid; any length
  Vec3d up = Vec3d::UnitY();      ///< of the letters; only its part across the normal counts
  /// Radius of a cylinder around an axis along `up` that the text follows, as on the wall of a base. > 0: the wall
  /// bulges outwards; < 0: it is hollow. 0: a flat text.
  double bend_radius_mm = 0;
  TextAlign align = TextAlign::kCentre;
  double least_wall_mm = 1;      ///< engraved: refuses to leave less between the letters and the far side of the wall
  std::filesystem::path font{};  ///< empty: Inter Bold
  PostOpOptions post_op{};
};

struct LabelReport {
  double width_mm = 0, height_mm = 0;            ///< of the rectangle around all lines
  double area_mm2 = 0;                           ///< of the letters
  double least_stroke_mm = 0;                    ///< the narrowest stroke
  double unevenness_mm = 0;                      ///< of the surface over the rectangle, from the plane or the cylinder
  double least_depth_mm = 0, most_depth_mm = 0;  ///< below or above the surface
  std::optional<double> wall_mm{};               ///< engraved: left behind the letters, if less than 5 mm
  double volume_mm3 = 0;                         ///< removed or added
  int attempts = 1;
  std::vector<std::string> warnings{};  ///< plain sentences: a stroke below 0.5 mm, a depth below 0.3 mm
};

struct Labelled {
  PostOpMesh part;
  LabelReport report;
};

/// The solid with the text cut into it, or put on. Read from outside, upright for `up`. The letters' floor (embossed:
/// their top) is parallel to the plane or cylinder of the label; where the surface is less even than a tenth of the
/// depth, to the surface smoothed over 1.4 mm. So the depth is 60 to 100 % of depth_mm everywhere. Outlines: see
/// internal::glyphOutlines() and internal::united(). The exact boolean and the guarantees of postOperativeMesh(): uncut
/// vertices stay bit for bit.
/// @pre solid: as in postOperativeMesh().
/// Errors: kBadValue: numbers out of range, or `up` along the normal; those of the text and the font; kGeometry, each
/// with numbers: the text reaches beyond the face, the surface is too steep or rough, the wall behind is too thin,
/// another surface is close in front, or no printable mesh in 8 attempts with shifts of 0.13 um; kCancelled.
/// @cost  for 16 letters 0.1 s of CPU on 25k triangles, 1.3 s on 400k.   @thread any; deterministic.
Expected<Labelled> withLabel(const Mesh& solid, const LabelOptions& label, const Progress& progress = {});

enum class LabelFace { kUnderside, kSide };

struct LabelPlace {
  LabelOptions label;           ///< as wanted, with point, normal, up, bend and height set
  double wanted_height_mm = 0;  ///< more than label.height_mm: only that fits
  double unevenness_mm = 0;     ///< as of LabelReport
  std::string note{};           ///< a plain sentence if the text is smaller than wanted
};

/// Finds a place for a text.
/// kUnderside: in the flat face at the end of the solid along `down`, with 1 mm of it around the text; holes and the
/// gap of a horseshoe are no part of it. Turned by steps of 7.5 degrees away from label.up if only so it fits. kSide:
/// upright on a vertical wall, 1 mm above the end along `down`, where the wall is nearest to a plane or a cylinder; at
/// equal evenness on the outside of a curve. Chooses the largest height up to label.height_mm that withLabel() takes,
/// at least 1.5 mm.
/// @param down  out of the base; any length.   @param label  text, height, depth, wall, font, and up for the underside.
/// Errors: kBadValue; those of the text and the font; kGeometry: no place, with the best one found; kCancelled.
/// @cost  0.1 s for 300k triangles.   @thread any; deterministic.
Expected<LabelPlace> placeLabel(const Mesh& solid, const Vec3d& down, LabelFace face, const LabelOptions& label,
                                const Progress& progress = {});

/// Replaces {name} by its value; {{ and }} stand for braces. Errors: kBadValue: an unknown name, with the known ones,
/// or a brace without its partner.
Expected<std::string> withPlaceholders(std::string_view text, const std::map<std::string, std::string>& values);

}  // namespace kerf
