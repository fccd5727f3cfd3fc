// Makes a solid of any imported mesh: closed, 2-manifold, outward, not crossing itself, in float32 coordinates.
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
#include "preprocess/close/scan_trim.h"
#include "preprocess/unit/source_triangle.h"

namespace kerf {

enum class CloseMode {
  kAuto,    ///< holes are filled, a missing underside gets a base; wraps only if the exact way fails, and reports it
  kBase,    ///< treats the longest boundary as the rim of a missing underside, at any length
  kRepair,  ///< fills holes only; rejects a mesh without underside
  kWrap,    ///< shrink-wraps the mesh, closed first where that works: the last resort, no source vertex survives
};

/// Steps of closing. See CloseOptions::only.
enum class CloseStep {
  kWeld,    ///< join vertices at the same place
  kDrop,    ///< drop triangles without area, duplicates, open crumbs
  kStitch,  ///< join boundaries that run along each other
  kOrient,  ///< turn triangles and pieces
  kFill,    ///< fill holes
  kBase,    ///< put a base under a missing underside
  kUnite,   ///< resolve crossings and keep the boundary of winding number >= 1
  kWrap,    ///< shrink-wrap the result
};
inline constexpr std::array<const char*, 8> kCloseStepNames{"weld", "drop", "stitch", "orient",
                                                            "fill", "base", "union",  "wrap"};

enum class BaseStyle {
  kHorseshoe,  ///< the walls follow the rim all the way down
  kFull,       ///< the arch stands on a plate under the convex outline of its rim, with a floor at the tongue
};

/// Plane given by the user, parallel to the base.
struct GivenPlane {
  Vec3d normal = Vec3d::UnitZ();  ///< either way round, any length but zero
  std::optional<Vec3d> point{};   ///< mm, on the plane; empty: the highest vertex
};

inline constexpr double kWidestStitch = 1;  ///< mm
inline constexpr double kWidestTrim = 20;   ///< mm
/// mm, the diagonal of the box around the triangles: a skull has 300. A larger mesh has a wrong unit: closeMesh()
/// rejects it before it begins.
inline constexpr double kLargestObject = 2000;

struct CloseOptions {
  CloseMode mode = CloseMode::kAuto;
  /// Parts of the scan to remove before all steps. See trimScan().
  std::vector<ScanTrim> trims{};
  /// If not empty: exactly these steps, in any `mode`. The error for a mesh that needs another step names that step.
  std::set<CloseStep> only{};
  /// Stitches boundaries up to this distance apart; 0: none. The default covers seams from exporters with few digits.
  /// kAuto goes up to 0.2 mm before it wraps, and reports it.
  double stitch_mm = 1e-3;
  /// Longest boundary of a hole; a longer one is the rim of a base, or an error. Default: by rim_to_diagonal.
  std::optional<double> fill_up_to_mm{};
  BaseStyle base_style = BaseStyle::kHorseshoe;
  /// The user requests a base: the report notes a mesh without one, as with every other base option.
  bool base_is_asked = false;
  /// Distance of the base below the lowest vertex, > 0; thin bases break in the printer. The plate of kFull takes all
  /// but a tenth of it (0.25 mm at most).
  double base_margin_mm = 2.0;
  /// The walls of kHorseshoe lead from the rim to an outline without waves shorter than this; narrow gaps of the rim
  /// are bridged first. 8 is crisper on casts that were cut, 16 calmer on ragged rims. 0: straight walls under every
  /// corner of the rim. If the smooth walls can not be resolved, closing tries another lip, then straight walls, with a
  /// warning.
  double base_smoothing_mm = 12;
  double base_lip_mm = 0.3;  ///< extension of the scan along its tangent plane above the walls; 0: none
  /// From the base up to the occlusal plane (found, given, or the highest vertex), in place of the margin. An error if
  /// too little for the scan. Laboratories leave 3 to 6 mm below the gingiva.
  std::optional<double> base_height_mm{};
  /// Direction from the mesh to the base. Closing uses the nearest coordinate axis, so that the base is exactly flat in
  /// float32. Default: the axis nearest to the opening of the mesh. With an occlusal plane the base is parallel to that
  /// plane, and this direction only selects the side. An error if it is more than 75 degrees from the opening, or 105
  /// from one that only rim and orientation together show.
  std::optional<Vec3d> base_direction{};
  /// Removes tongues and flakes of a rim narrower than this before it gets a base; 0: none. See trimRims().
  double trim_rim_mm = 0;
  bool find_occlusal_plane = false;  ///< makes the base parallel to findOcclusalPlane(); see baseFrame() on flatness
  std::optional<GivenPlane> occlusal_plane{};  ///< makes the base parallel to this plane
  double rim_to_diagonal = 1.2;  ///< a boundary longer than this many box diagonals is a rim, a shorter one a hole
  /// Drops open pieces with less than this share of the triangles and less than a tenth of this share of the area. Scan
  /// debris has few triangles and a small area; a coarse patch of bone has a large area. 0 keeps them all.
  double crumb_fraction = 0.01;
  /// Drops pieces created by cutting that are smaller than this share of the volume. 0 keeps all except crumbs; see
  /// cleanup_length_mm.
  double debris_fraction = 1e-4;
  double drop_specks_mm3 = 0;  ///< drops closed pieces of the solid smaller than this; never the largest
  /// Collapses new edges shorter than this; see cleanUpForFloat32(). The default is a hundredth of a voxel. Closing
  /// also drops its own closed pieces below (10 times this)^3, a thousandth of a voxel.
  double cleanup_length_mm = 1e-3;
  double wrap_alpha_mm = 1.0;    ///< a wrap bridges hollows narrower than this; below 0.3 it takes minutes
  double wrap_offset_mm = 0.05;  ///< distance of the wrap from the mesh
  /// Warns about a solid that differs from the scan, instead of an error: more than twice or less than a quarter of its
  /// volume, more than three fifths of the vertices lost, a wrap of a mesh that encloses nothing.
  bool accept_doubtful = false;
};

/// Edge of the surface over a gap, from scan vertex to scan vertex, longer than any mouth of a gap.
struct WideSpan {
  Vec3d middle = Vec3d::Zero();  ///< mm, in the scan's frame
  double mm = 0;
};

/// Bridged gap of the rim.
struct BridgedPlace {
  Vec3d middle = Vec3d::Zero();  ///< mm, of the added surface, in the scan's frame
  double area_mm2 = 0;
  double span_mm = 0;  ///< longest edge of the added surface, rim edges excluded
};

/// Limits of a warning: area of the bridges as a share of the scan's own area, and their span in mm. Scans get 1 % and
/// 6.5 mm at most; a strip of gum with roofed-over sockets gets 43 % and 10 mm.
inline constexpr double kMostBridged = 0.05, kWidestSpan = 8;

/// Group of lost vertices, each within 2 mm of another.
struct LostPlace {
  Vec3d middle = Vec3d::Zero();  ///< mm, their mean
  std::size_t vertices = 0;
};

/// From this many lost vertices in one place, the report names the place.
inline constexpr std::size_t kManyLostTogether = 25;

struct CloseReport {
  std::vector<std::string> changes;  ///< sentences with counts; empty if the mesh needed no change
  /// Changes beyond the options: seams stitched wider than stitch_mm, lengths scaled down with a small object.
  std::vector<std::string> warnings{};
  std::size_t vertices_cut_away = 0;  ///< by CloseOptions::trims, as the next two; all other counts are of the rest
  std::size_t triangles_cut_away = 0;
  double cut_away_mm2 = 0;
  std::size_t vertices_rounded = 0;  ///< source vertices with coordinates other than float32 numbers
  std::size_t vertices_welded = 0;   ///< source vertices joined with another at the same place
  std::size_t vertices_moved = 0;    ///< source vertices moved to separate parts that touched
  std::size_t vertices_added = 0;
  std::size_t triangles_kept = 0;     ///< in the solid with the same three source vertices
  std::size_t triangles_dropped = 0;  ///< source triangles without any part in the solid
  std::size_t triangles_split = 0;    ///< source triangles with some parts in the solid
  std::size_t triangles_added = 0;    ///< in the solid and not from any source triangle
  std::size_t triangles_flipped = 0;  ///< turned to face outwards
  std::size_t crumbs_dropped = 0;     ///< small open pieces
  std::size_t debris_dropped = 0;     ///< small closed splinters and pockets left by cutting, and crumbs
  std::size_t holes_filled = 0;
  std::size_t seam_vertices = 0;  ///< boundary vertices joined, or put on a boundary edge, by stitching
  std::size_t rims_extruded = 0;
  std::vector<Vec3d> rim_points{};         ///< mm: boundary vertices of a scan that got a base
  std::size_t gaps_bridged = 0;            ///< in these rims
  double rim_bridged_mm = 0;               ///< length of the rims along these gaps
  double widest_gap_mm = 0;                ///< widest mouth of a gap; a gap may be wider behind its mouth
  double bridged_mm2 = 0;                  ///< area of the bridges, on the scan's side
  double bridged_share = 0;                ///< bridged area over the scan's own area; see kMostBridged
  double widest_span_mm = 0;               ///< longest edge of the bridges, from scan vertex to scan vertex
  std::vector<BridgedPlace> bridged_at{};  ///< one per gap, the largest area first
  std::vector<WideSpan> wide_spans{};      ///< above 4 mm, the widest first, none within 6 mm of a wider one
  std::string base_fallback{};             ///< base built instead of smooth walls that failed: "a lip of 0.4 mm", ...
  std::size_t rim_places_trimmed = 0;      ///< by CloseOptions::trim_rim_mm; the next counts are their removed parts
  std::size_t vertices_trimmed = 0;
  std::size_t triangles_trimmed = 0;
  double trimmed_mm2 = 0;
  /// Source vertices without a vertex of the solid at their place, trimmed ones excluded. A welded vertex counts at the
  /// place of its partner.
  std::size_t vertices_lost = 0;
  std::size_t vertices_lost_far = 0;  ///< lost vertices farther than 1 mm from the scan's boundary
  std::vector<LostPlace> lost_at{};   ///< groups of lost vertices, largest first; empty if any vertices were trimmed
  int handles_added = 0;              ///< handles of the solid minus those of the scan; counted if a rim got a base
  std::vector<Vec3d> handles_at{};    ///< mm: their places, the finest of the solid first
  std::size_t pinholes_mended = 0;    ///< holes caused by the base, and threads of material around one
  std::size_t specks_dropped = 0;     ///< by CloseOptions::drop_specks_mm3
  double specks_dropped_mm3 = 0;
  std::size_t vertices_in_specks = 0;           ///< vertices of the dropped specks; not in vertices_lost
  std::size_t crossings_resolved = 0;           ///< pairs of crossing or touching triangles
  double largest_move_mm = 0;                   ///< largest move of a source vertex
  std::optional<Vec3d> base_direction;          ///< unit, out of the model; set if a base was built
  double base_level_mm = 0;                     ///< the base is {x : base_direction . x = base_level_mm}
  std::optional<OcclusalPlane> occlusal_plane;  ///< set if the options request it
  bool exact = true;                            ///< false after a wrap: the surface is an approximation
  double volume_closed_mm3 = 0;  ///< volume inside the wrapped triangles; 0: no wrap, or the triangles stayed open
  double wrap_offset_mm = 0;     ///< CloseOptions::wrap_offset_mm, scaled on small objects
};

struct Solid {
  Mesh mesh;  ///< mm; surviving source vertices first, in their order; see below on colours
  std::vector<std::uint32_t> source_triangle;  ///< per triangle: index in the imported mesh, or kAdded
  CloseReport report;
};

/// Closes a mesh, changing as little as possible and reporting every change. Steps (reasons in preprocess/README.md):
/// trim, round, weld, stitch, orient, fill holes, extrude rims to a flat base, until the triangles form a closed chain.
/// If the chain is an embedded 2-manifold, it is the result, and no source vertex moves. Otherwise an exact arrangement
/// resolves all crossings, and the boundary of {winding number >= 1} remains: interpenetrating parts unite, double
/// layers and inner shells vanish, cavities stay. cleanUpForFloat32() rounds new vertices to float32. A last check
/// returns an error unless the result is closed, 2-manifold at edges and vertices, without crossingPairs(), and of
/// positive volume.
/// Colours: a source vertex or triangle keeps its own; a new vertex on a source triangle takes the colour there;
/// everything else is light model stone (214, 205, 189). With vertex colours, a wall fades from the rim's colour to
/// stone within its uppermost 0.2 mm, in a separate row of triangles; smooth walls fade within their lip, 0.3 mm.
/// @param imported_mm  anything a file can hold, in mm, at least one triangle.
/// @return the solid. Errors: kEmpty (no triangle with area), kGeometry (kRepair on a mesh without underside; nothing
/// left; the exact way and the wrap failed; a solid that differs from the scan, see CloseOptions::accept_doubtful),
/// kBadValue (options; an object larger than kLargestObject), kCancelled.
/// @cost about 130 ms for 60k triangles without crossings; with about 800 crossing pairs (a ragged rim) about 1 s. No
/// step takes longer for a larger unit: walks along a rim in mm take 8000 steps at most, a wrap 1 M facets.
/// @thread any; uses all TBB threads; deterministic.
Expected<Solid> closeMesh(const Mesh& imported_mm, const CloseOptions& options = {}, const Progress& progress = {});

/// The plane that closeMesh() would find for a scan without underside under CloseOptions::find_occlusal_plane.
/// Errors: as findOcclusalPlane(); kGeometry for a closed mesh; kBadValue for one larger than kLargestObject.
/// @pre  no trims.
Expected<OcclusalPlane> findOcclusalPlaneOfScan(const Mesh& imported_mm, const CloseOptions& options = {});

/// "weld,orient,fill"; empty for an empty set.
std::string namesOf(const std::set<CloseStep>& steps);

/// All options in one line of text: equal options give equal text.
std::string canonicalText(const CloseOptions& options);

/// Closes several meshes and unites them into one object. `source_triangle` counts through them in order.
Expected<Solid> closeMeshes(std::span<const Mesh> imported_mm, const CloseOptions& options = {},
                            const Progress& progress = {});

}  // namespace kerf
