// From any imported mesh to a solid: closed, 2-manifold, outward, not crossing itself, in float32 coordinates.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/close/occlusal_plane.h"
#include "preprocess/unit/source_triangle.h"

namespace kerf {

enum class CloseMode {
  kAuto,    ///< holes are filled, a missing underside gets a base; wraps only if the exact way fails, and reports it
  kBase,    ///< the longest boundary of the mesh is taken for the rim of a missing underside, however short it is
  kRepair,  ///< holes only: a mesh whose underside is missing is refused
  kWrap,    ///< shrink-wraps the mesh, closed first where that works: the last resort, no source vertex survives
};

/// What closing can do. See CloseOptions::only.
enum class CloseStep {
  kWeld,    ///< join vertices at the same place
  kDrop,    ///< drop triangles without area, duplicates, open crumbs
  kStitch,  ///< join boundaries that run along each other
  kOrient,  ///< turn triangles and pieces
  kFill,    ///< fill holes
  kBase,    ///< put a base under a missing underside
  kUnite,   ///< resolve crossings and keep what bounds winding number >= 1
  kWrap,    ///< shrink-wrap the result
};
inline constexpr std::array<const char*, 8> kCloseStepNames{"weld", "drop", "stitch", "orient",
                                                            "fill", "base", "union",  "wrap"};

enum class BaseStyle {
  kHorseshoe,  ///< the walls follow the rim all the way down
  kFull,       ///< the arch stands on a plate under the convex outline of its rim: the tongue's place is floored
};

/// A plane the user gives: the base is parallel to it.
struct GivenPlane {
  Vec3d normal = Vec3d::UnitZ();  ///< either way round, any length but zero
  std::optional<Vec3d> point{};   ///< mm, on it; without one it is put onto the highest vertex
};

inline constexpr double kWidestStitch = 1;  ///< mm
inline constexpr double kWidestTrim = 20;   ///< mm
/// mm, the diagonal of the box around the triangles: a skull has 300. What is larger has a wrong unit, and is refused
/// before closing begins.
inline constexpr double kLargestObject = 2000;

struct CloseOptions {
  CloseMode mode = CloseMode::kAuto;
  /// If not empty: exactly these steps, whatever `mode` says. A mesh that needs another one is refused with its name.
  std::set<CloseStep> only{};
  /// Boundaries no farther apart are stitched; 0: none. The default is what exporters with few digits leave open. kAuto
  /// goes up to 0.2 mm, and reports it, before it wraps.
  double stitch_mm = 1e-3;
  /// A longer boundary is no hole: it is the rim of a base, or refused. Default: by rim_to_diagonal.
  std::optional<double> fill_up_to_mm{};
  BaseStyle base_style = BaseStyle::kHorseshoe;
  /// A base is asked for explicitly: a mesh that gets none is noted, as with every other base option.
  bool base_is_asked = false;
  /// The base lies this far below the lowest vertex, > 0; thin bases break in the printer. All but a tenth of it (0.25
  /// mm at most) is the plate of kFull.
  double base_margin_mm = 2.0;
  /// The walls of kHorseshoe lead from the rim to an outline without waves shorter than this; narrow gaps of the rim
  /// are bridged first. 8 is crisper on casts that were cut, 16 calmer on ragged rims. 0: straight walls under every
  /// corner of the rim. Where the smooth walls can not be resolved another lip is tried, then straight walls, with a
  /// warning.
  double base_smoothing_mm = 12;
  double base_lip_mm = 0.3;  ///< how far the scan is led on along its tangent plane before the walls turn down; 0: not
  /// From the base up to the occlusal plane (found, given, or the highest vertex), in place of the margin. Too little
  /// for the scan is refused. Laboratories leave 3 to 6 mm below the gingiva.
  std::optional<double> base_height_mm{};
  /// Where the base goes, out of the mesh; the nearest coordinate axis is used, so that the base is exactly flat in
  /// float32. Without it: the axis nearest to the direction in which the mesh is open. With an occlusal plane the base
  /// is parallel to that, and this only says which side is down. Refused if it leads away from the opening: by more
  /// than 75 degrees, or 105 from one that only rim and orientation together show.
  std::optional<Vec3d> base_direction{};
  /// Tongues and flakes of a rim narrower than this are taken before it gets a base; 0: nothing is. See trimRims().
  double trim_rim_mm = 0;
  bool find_occlusal_plane = false;  ///< makes the base parallel to findOcclusalPlane(); see baseFrame() on flatness
  std::optional<GivenPlane> occlusal_plane{};  ///< or to this one
  double rim_to_diagonal = 1.2;  ///< a boundary longer than this many box diagonals is a rim, a shorter one a hole
  /// Open pieces with less than this share of the triangles and less than a tenth of it of the area are dropped: scan
  /// debris has few triangles and is small, a patch of bone meshed coarsely is not. 0 keeps them all.
  double crumb_fraction = 0.01;
  /// Pieces that cutting created are dropped if they are smaller than this share of the volume. 0 keeps them all, but
  /// for crumbs; see cleanup_length_mm.
  double debris_fraction = 1e-4;
  double drop_specks_mm3 = 0;  ///< closed pieces of the solid smaller than this are dropped; never the largest
  /// New edges shorter than this are collapsed; see cleanUpForFloat32(). A hundredth of a voxel: closed pieces that
  /// closing made are dropped below (10 times this)^3, a thousandth of a voxel.
  double cleanup_length_mm = 1e-3;
  double wrap_alpha_mm = 1.0;    ///< hollows narrower than this are bridged; below 0.3 a wrap takes minutes
  double wrap_offset_mm = 0.05;  ///< the wrap stands off the mesh by this much
  /// A solid that is not what was scanned (more than twice or less than a quarter of its volume, more than three fifths
  /// of the vertices lost, a wrap of what encloses nothing) is made all the same, with a warning, not refused.
  bool accept_doubtful = false;
};

/// An edge of surface that was invented over a gap, from scan vertex to scan vertex, longer than any mouth of a gap.
struct WideSpan {
  Vec3d middle = Vec3d::Zero();  ///< mm, in the scan's frame
  double mm = 0;
};

/// A gap of the rim that was bridged.
struct BridgedPlace {
  Vec3d middle = Vec3d::Zero();  ///< mm, of the surface that was added, in the scan's frame
  double area_mm2 = 0;
  double span_mm = 0;  ///< longest edge of that surface that is none of the rim
};

/// Bridges may invent this part of the scan's own area, and span so many mm; more is warned of. Scans get 1 % and 6.5
/// mm at most; a strip of gum whose sockets are roofed over 43 % and 10 mm.
inline constexpr double kMostBridged = 0.05, kWidestSpan = 8;

/// Lost vertices that lie together: each within 2 mm of another.
struct LostPlace {
  Vec3d middle = Vec3d::Zero();  ///< mm, their mean
  std::size_t vertices = 0;
};

/// So many lost vertices in one place are said with the place.
inline constexpr std::size_t kManyLostTogether = 25;

struct CloseReport {
  std::vector<std::string> changes;  ///< what was done, as sentences with counts; empty if nothing had to be
  /// Those of the changes that went beyond what was asked for: seams stitched wider than stitch_mm, lengths scaled down
  /// with a small object.
  std::vector<std::string> warnings{};
  std::size_t vertices_rounded = 0;  ///< source vertices that were not float32 numbers
  std::size_t vertices_welded = 0;   ///< source vertices joined with another at the same place
  std::size_t vertices_moved = 0;    ///< source vertices moved to separate parts that touched
  std::size_t vertices_added = 0;
  std::size_t triangles_kept = 0;     ///< in the solid with the same three source vertices
  std::size_t triangles_dropped = 0;  ///< source triangles of which nothing is left
  std::size_t triangles_split = 0;    ///< source triangles of which parts are left
  std::size_t triangles_added = 0;    ///< in the solid and not from any source triangle
  std::size_t triangles_flipped = 0;  ///< turned to face outwards
  std::size_t crumbs_dropped = 0;     ///< small open pieces
  std::size_t debris_dropped = 0;     ///< small closed splinters and pockets left by cutting, and crumbs
  std::size_t holes_filled = 0;
  std::size_t seam_vertices = 0;  ///< boundary vertices joined, or put on a boundary edge, by stitching
  std::size_t rims_extruded = 0;
  std::vector<Vec3d> rim_points{};         ///< mm: boundary vertices of a scan that got a base
  std::size_t gaps_bridged = 0;            ///< of these rims
  double rim_bridged_mm = 0;               ///< length of the rims along these gaps
  double widest_gap_mm = 0;                ///< of their mouths: a gap may be wider behind its mouth
  double bridged_mm2 = 0;                  ///< surface that was invented over them, on the scan's side
  double bridged_share = 0;                ///< of the scan's own area; see kMostBridged
  double widest_span_mm = 0;               ///< longest edge of that surface, from scan vertex to scan vertex
  std::vector<BridgedPlace> bridged_at{};  ///< one per gap, the largest area first
  std::vector<WideSpan> wide_spans{};      ///< above 4 mm, the widest first, none within 6 mm of a wider one
  std::string base_fallback{};         ///< how the base was built where the smooth walls failed: "a lip of 0.4 mm", ...
  std::size_t rim_places_trimmed = 0;  ///< as CloseOptions::trim_rim_mm asked; with what was taken there:
  std::size_t vertices_trimmed = 0;
  std::size_t triangles_trimmed = 0;
  double trimmed_mm2 = 0;
  /// Source vertices whose place has no vertex of the solid, but for trimmed ones. A welded vertex is at the place of
  /// the one it was welded to.
  std::size_t vertices_lost = 0;
  std::size_t vertices_lost_far = 0;  ///< those of them farther than 1 mm from the scan's boundary
  std::vector<LostPlace> lost_at{};   ///< where they lie together, most of them first; empty if any were trimmed
  int handles_added = 0;              ///< of the solid beyond the scan's own; counted where a rim got a base
  std::vector<Vec3d> handles_at{};    ///< mm: where to look for them, the finest of the solid first
  std::size_t pinholes_mended = 0;    ///< holes that the base made, and threads of material around one
  std::size_t specks_dropped = 0;     ///< as CloseOptions::drop_specks_mm3 asked
  double specks_dropped_mm3 = 0;
  std::size_t vertices_in_specks = 0;           ///< that went with them; not in vertices_lost
  std::size_t crossings_resolved = 0;           ///< pairs of triangles that crossed or touched
  double largest_move_mm = 0;                   ///< of a source vertex
  std::optional<Vec3d> base_direction;          ///< unit, out of the model; set if a base was built
  double base_level_mm = 0;                     ///< the base is {x : base_direction . x = base_level_mm}
  std::optional<OcclusalPlane> occlusal_plane;  ///< set if options ask to find it
  bool exact = true;                            ///< false after a wrap: the surface is an approximation
  double volume_closed_mm3 = 0;  ///< enclosed by the closed triangles that were wrapped; 0: none, or they stayed open
  double wrap_offset_mm = 0;     ///< of a wrap, as CloseOptions::wrap_offset_mm asked, scaled on small objects
};

struct Solid {
  Mesh mesh;  ///< mm; surviving source vertices first, in their order; see below on colours
  std::vector<std::uint32_t> source_triangle;  ///< per triangle: index in the imported mesh, or kAdded
  CloseReport report;
};

/// Closes a mesh, changing as little as possible and reporting every change. In short (preprocess/README.md tells why):
/// round, weld, stitch, orient; fill holes, extrude rims to a flat base, until the triangles form a closed chain; if
/// that is an embedded 2-manifold it is the answer, and no source vertex moved. Otherwise all crossings are resolved by
/// an exact arrangement, and the surface that bounds {winding number >= 1} is kept: interpenetrating parts unite,
/// double layers and inner shells vanish, cavities stay. New vertices are rounded to float32 under cleanUpForFloat32().
/// The result is verified (closed, 2-manifold at edges and vertices, crossingPairs() empty, positive volume) or
/// refused.
/// Colours: a source vertex or triangle keeps its own; a new vertex on a source triangle takes the colour there;
/// everything else is light model stone (214, 205, 189). Where vertices carry the colours a wall runs from the rim's
/// into stone within its uppermost 0.2 mm, in a row of triangles of its own; smooth walls do so in their lip, 0.3 mm.
/// @param imported_mm  anything a file can hold, in mm, at least one triangle.
/// @return the solid. Errors: kEmpty (no triangle with area), kGeometry (kRepair on a mesh without underside; nothing
/// left; the exact way and the wrap failed; a solid that is not what was scanned, see CloseOptions::accept_doubtful),
/// kBadValue (options; an object larger than kLargestObject), kCancelled.
/// @cost about 130 ms for 60k triangles without crossings; with about 800 crossing pairs (a ragged rim) about 1 s. No
/// step takes longer for a larger unit: what goes along a rim in mm takes 8000 steps at most, a wrap 1 M facets.
/// @thread any; uses all TBB threads; deterministic.
Expected<Solid> closeMesh(const Mesh& imported_mm, const CloseOptions& options = {}, const Progress& progress = {});

/// The plane that closeMesh() would find for a scan without underside under CloseOptions::find_occlusal_plane.
/// Errors: as findOcclusalPlane(); kGeometry for a closed mesh; kBadValue for one larger than kLargestObject.
Expected<OcclusalPlane> findOcclusalPlaneOfScan(const Mesh& imported_mm, const CloseOptions& options = {});

/// "weld,orient,fill"; empty for an empty set.
std::string namesOf(const std::set<CloseStep>& steps);

/// All options in one line of text: equal options give equal text.
std::string canonicalText(const CloseOptions& options);

/// The same for several meshes that make one object; they are united. `source_triangle` counts through them in order.
Expected<Solid> closeMeshes(std::span<const Mesh> imported_mm, const CloseOptions& options = {},
                            const Progress& progress = {});

}  // namespace kerf
