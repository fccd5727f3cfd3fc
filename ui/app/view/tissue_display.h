// Display of the tissues of the open object: section colours, shown, hidden and ghost tissues, and maps of depth and
// distance in place of tissue colours.
//
// While all tissues are shown, the surface is the mesher's. Once one is hidden or a ghost, the others get a separate
// surface (sim/live/tissue_mesher.h). Jobs make and update it, so a cut appears some tenths of a second later. Nothing
// here touches the session or its log.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/field/material.h"
#include "geometry/mesh/map_colour.h"
#include "sim/live/scan_colours.h"
#include "sim/live/tissue_mesher.h"
#include "sim/live/tissue_section.h"
#include "sim/monitor/structures.h"
#include "sim/run/session/live_run.h"
#include "ui/app/base/job.h"

namespace kerf {

class WatchedRun;

enum class TissueLook { kShow, kGhost, kHide };

struct SeenTissue {
  Material material = Material::kNone;
  std::string id, name;  ///< "nerve_canal", "nerve canal"
  Rgba8 colour{};        ///< sRGB
  double mm3 = 0;        ///< as loaded
  TissueLook look = TissueLook::kShow;
};

/// Meaning of the surface colours.
enum class SurfaceColours {
  kTissue,
  kDepth,     ///< below the surface as loaded
  kDistance,  ///< to pulp and nerve canal
  kContact,   ///< signed distance to the nearest neighbour, such as the other jaw; the tissue where none is near
  kScan       ///< scanned colours; the tissue where there are none and on cut surfaces
};

inline constexpr double kMapReach = 5;  ///< mm: from one end of a map to the other, by default

/// Range of the maps. With bands the colour changes every half millimetre.
struct MapScale {
  double reach_mm = kMapReach;
  bool has_bands = false;
  static constexpr double kLeast = 0.5, kMost = kMapReach, kBand = 0.5;  // mm
  /// Of the reach; with bands that of the beginning of the band.
  double shareOf(double mm) const;
  bool operator==(const MapScale&) const = default;
};

/// Limits of the contact map, mm: the darkest red; contact; the range, which MapScale chooses.
inline constexpr double kDeepOverlap = -0.5, kContactGap = 0.2, kLeastContactReach = 1, kMostContactReach = 2;
/// Colour of the contact map: red where the surfaces overlap, darker with depth; orange in contact; blue beyond, which
/// fades to the usual colour at the reach. The three differ in lightness.
/// @param mm  signed distance, negative: overlap.   @param usual  without the map.
Rgba8 contactColour(double mm, const MapScale& scale, const Rgba8& usual);

/// The range that a map uses.
MapScale scaleOf(SurfaceColours colours, MapScale scale);

/// Legend of a map.
struct MapLegend {
  std::string title, low, high;  ///< the quantity; its ends, with the unit
  SurfaceColours of = SurfaceColours::kDepth;
  MapScale scale{};
  struct Tick {
    double share = 0, mm = 0;
    std::string text;
  };
  std::vector<Tick> ticks{};  ///< between the ends; the scale is linear from one to the next
  /// @param share  0 at `low`, 1 at `high`.
  Rgba8 colourAt(double share) const;
};
/// None: colours without a number.
std::optional<MapLegend> legendOf(SurfaceColours colours, const MapScale& scale = {});

/// Surfaces of the tissues that are not hidden, in the frame of their object.
enum class TissuePart {
  kSolid,  ///< of the shown tissues
  kGhost   ///< of shown and ghost tissues, while others are hidden; else the object's own surface is the ghost
};

/// Data of a session that is cut or watched.
struct TissueSource {
  std::function<std::optional<SceneView>()> view;            ///< as LiveRun::viewScene()
  std::function<std::uint64_t()> edits;                      ///< as LiveRun::editsDone()
  std::function<std::size_t()> objects_now;                  ///< in the scene
  std::shared_ptr<const BakedObject> object;                 ///< in work, as loaded
  std::vector<std::shared_ptr<const BakedObject>> beside{};  ///< neighbours
  std::shared_ptr<const BrickField> original;                ///< of the case
  /// Distances to the neighbours, world frame. Empty: measured when needed, from `beside`.
  std::vector<std::shared_ptr<const KeepOut>> beside_fields{};
  std::shared_ptr<const Structures> structures;  ///< pulp and nerve canals as loaded
  std::shared_ptr<const ScanColours> scan;       ///< of the object; null: its scan has no colours
  bool has_scan_colours = false;                 ///< the object or a neighbour has them
};
TissueSource tissueSourceOf(LiveRun& run, std::shared_ptr<const Structures> structures);
TissueSource tissueSourceOf(const WatchedRun& run);

/// Display choices of the user.
struct TissueChoices {
  SurfaceColours colours = SurfaceColours::kTissue;
  std::vector<std::pair<std::string, TissueLook>> looks;  ///< by id, all that are not kShow
  MapScale scale{};
};

/// Window thread only.
class TissueDisplay {
 public:
  // ---- Calls by the workbench

  /// @param source  not called after closing().
  void opened(TissueSource source, const MaterialTable& materials);
  void closing();
  /// Once a frame. Errors: of a job, whose result is then dropped.
  Expected<void> update();
  /// A job runs or is due: the display does not show the choices yet.
  bool isBusy() const;

  // ---- Tissue looks

  /// Tissues of the object, in the order of the table of materials.
  std::span<const SeenTissue> all() const { return tissues_; }
  /// @param id  or its name.   Error kBadValue: the object has no such tissue.
  Expected<void> set(const std::string& id, TissueLook look);
  void showAll();
  bool areAllShown() const;
  /// True if there are surfaces of that part. Without solid ones show the object's own surface.
  bool hasPart(TissuePart part) const;
  /// True if the object's own surface is the ghost.
  bool isOwnSurfaceGhost() const;
  /// Colours and looks, to restore when the same object is opened again.
  TissueChoices choices() const;
  /// As set() and setColours(). Ignores tissues and colours that the object lacks.
  void choose(const TissueChoices& choices);

  struct Change {
    std::uint32_t object = 0;
    TissuePart part = TissuePart::kSolid;
    bool is_new = false;  ///< drop all earlier chunks of that part of that object
    std::vector<MeshChunkPtr> chunks;
  };
  /// Since the last call.
  std::vector<Change> takeChanges();

  // ---- As loaded

  /// Shows the object in work as in its case: without cuts, whole, where its scan stands. The first call starts a job
  /// that meshes it: 1 s for a jaw of 300 000 triangles on a core. Its surface stays until the document closes.
  void showAsLoaded(bool is_shown);
  bool isAsLoadedShown() const { return is_as_loaded_shown_; }
  /// Its whole surface, in the frame of loading. Null: not made yet.
  const std::vector<MeshChunkPtr>* asLoaded() const { return as_loaded_.get(); }

  // ---- Colours

  /// Tissues in a plane of the object's own frame, as loaded. Empty: nothing is open.
  /// @param beside  0: the object in work; n: the n-th neighbour.
  /// @cost  as tissueSection(): once for each plane, not each frame.
  TissueSection sectionAt(const Plane& plane, std::size_t beside = 0) const;
  /// Initially the scan's, if it has any and the object has one tissue.
  SurfaceColours colours() const { return colours_; }
  /// The colours show a number: depth or distance.
  bool isMap() const { return colours_ != SurfaceColours::kTissue && colours_ != SurfaceColours::kScan; }
  bool hasScanColours() const { return source_ && source_->has_scan_colours; }
  bool hasNeighbours() const { return source_ && !source_->beside.empty(); }
  /// A job measures depth first: 9 s for a molar at 0.05 mm; and in replays the distance to neighbours: 14 s for a
  /// mandible at 0.1 mm. Error kUnsupported: a distance map without pulp and nerve canal, a contact map without
  /// neighbours, colours of a scan without any.
  Expected<void> setColours(SurfaceColours colours);
  const MapScale& mapScale() const { return scale_; }
  /// @pre reach_mm from kLeast to kMost.
  void setMapScale(const MapScale& scale);
  /// Increases when the colours of all chunks change.
  std::uint64_t coloursVersion() const { return colours_version_; }
  /// One per vertex: of the map, of the scan, or the chunk's own.   @cost  30 ns a vertex.
  /// @param T_world_object  for the contact map: moved pieces show their contacts where they are.
  std::vector<Rgba8> coloursOf(const MeshChunk& chunk, const Rigid3& T_world_object = {}) const;
  /// Distance to the surface of the nearest neighbour as loaded, where its scan stands, mm, negative: inside. Exact to
  /// a twentieth of a voxel within three voxels, to half a voxel beyond; 3 mm or more count as 3. None: not measured,
  /// or no neighbours.
  std::optional<double> toNeighbours(const Vec3d& world) const;
  /// The same for a neighbour: maps cover only the object in work.
  const std::vector<Rgba8>& coloursBeside(const MeshChunk& chunk) const;

 private:
  /// Tissues of the parts.
  struct Wanted {
    TissueSet solid, ghost;     ///< ghost: none if that part is not needed
    bool is_own_ghost = false;  ///< nothing is hidden: the object's own surface is the ghost
    bool operator==(const Wanted&) const = default;
  };
  /// A running job owns it.
  struct Meshers {
    Wanted of;
    std::map<std::pair<std::uint32_t, TissuePart>, std::unique_ptr<TissueMesher>> all;
  };
  using Changes = std::vector<Change>;
  using Depths = std::shared_ptr<const KeepOut>;
  using Fields = std::vector<Depths>;

  static Expected<Changes> meshed(const SceneView& view, Meshers& meshers, const BakedObject& loaded,
                                  const RemesherOptions& options, const Progress& progress);
  Wanted wanted() const;
  RemesherOptions colouring() const;
  void startMeshing();
  Expected<void> takeMeshed();
  double nearness(const Vec3d& p) const;
  Expected<void> takeDepths();
  Expected<void> takeContacts();

  std::optional<TissueSource> source_;  // none: nothing is open
  std::optional<TissueLabels> labels_;
  std::vector<TissueLabels> labels_beside_;
  std::optional<TissuePalette> palette_;
  std::vector<SeenTissue> tissues_;

  std::shared_ptr<Meshers> meshers_;
  std::unique_ptr<Job<Changes>> meshing_;
  std::optional<Wanted> parts_of_;  // tissues of the surfaces handed out
  std::uint64_t meshed_edits_ = 0;  // LiveRun::editsDone() at the start of the last job
  std::size_t meshed_objects_ = 0;  // in the scene at that start
  bool is_dropped_ = false;         // all tissues were shown during a job
  std::chrono::steady_clock::time_point next_{};
  Changes changes_;

  SurfaceColours colours_ = SurfaceColours::kTissue;
  SurfaceColours wanted_colours_ = SurfaceColours::kTissue;  // differs while depths are measured
  std::uint64_t colours_version_ = 0;
  MapScale scale_;
  Depths depths_;
  std::unique_ptr<Job<Depths>> measuring_;
  std::unique_ptr<Job<Fields>> measuring_contacts_;

  bool is_as_loaded_shown_ = false;
  std::unique_ptr<std::vector<MeshChunkPtr>> as_loaded_;
  std::unique_ptr<Job<std::vector<MeshChunkPtr>>> loading_;
  std::vector<std::unique_ptr<AnyJob>> ending_;  // cancelled; end by themselves
};

}  // namespace kerf
