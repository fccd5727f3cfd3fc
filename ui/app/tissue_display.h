// What a person sees of the tissues of what is open: their colours in a section, which of them are shown, hidden or
// ghosts, and maps of depth and distance in the place of their colours.
//
// While all are shown the surface is that of the mesher, as ever. As soon as one is hidden or a ghost, the others get
// a surface of their own (sim/live/tissue_mesher.h), made in a job and followed in jobs: a cut is seen in it some
// tenths of a second later. Nothing here touches the session or its log.
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
#include "sim/live/scan_colours.h"
#include "sim/live/tissue_mesher.h"
#include "sim/live/tissue_section.h"
#include "sim/monitor/structures.h"
#include "sim/run/live_run.h"
#include "ui/app/job.h"

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

/// What the colour of the surface says.
enum class SurfaceColours {
  kTissue,
  kDepth,     ///< below the surface as loaded
  kDistance,  ///< to pulp and nerve canal
  kScan       ///< what the scanner saw; where there is no such, and where it was cut, the tissue
};

/// Of a map: light yellow to dark blue, evenly darker, told apart by the colour-blind.
/// @param share  0 light to 1 dark; clamped.
Rgba8 mapColour(double share);
inline constexpr double kMapReach = 5;  ///< mm: from one end of a map to the other

/// What the colours of a map say, in words.
struct MapLegend {
  std::string title, low, high;  ///< what is measured; at its ends, with the unit
  bool is_dark_first = false;
  /// @param share  0 at `low`, 1 at `high`.
  Rgba8 colourAt(double share) const { return mapColour(is_dark_first ? 1 - share : share); }
};
/// Nothing: colours that say no number.
std::optional<MapLegend> legendOf(SurfaceColours colours);

/// Surfaces of the tissues that are not hidden, in the frame of their object.
enum class TissuePart {
  kSolid,  ///< of those shown
  kGhost   ///< of those shown and the ghosts, while others are hidden; else the object's own surface is the ghost
};

/// What it is told of: a session that is cut, or one that is watched.
struct TissueSource {
  std::function<std::optional<SceneView>()> view;            ///< as LiveRun::viewScene()
  std::function<std::uint64_t()> edits;                      ///< as LiveRun::editsDone()
  std::function<std::size_t()> objects_now;                  ///< in the scene
  std::shared_ptr<const BakedObject> object;                 ///< that is worked on, as loaded
  std::vector<std::shared_ptr<const BakedObject>> beside{};  ///< what stands beside it
  std::shared_ptr<const BrickField> original;                ///< of the case
  std::shared_ptr<const Structures> structures;              ///< pulp and nerve canals as loaded
  std::shared_ptr<const ScanColours> scan;                   ///< of the object; null: its scan has no colours
  bool has_scan_colours = false;                             ///< it has them, or what stands beside has
};
TissueSource tissueSourceOf(LiveRun& run, std::shared_ptr<const Structures> structures);
TissueSource tissueSourceOf(const WatchedRun& run);

/// What a person has chosen to see.
struct TissueChoices {
  SurfaceColours colours = SurfaceColours::kTissue;
  std::vector<std::pair<std::string, TissueLook>> looks;  ///< by id, those that are not shown
};

/// One thread, the window's.
class TissueDisplay {
 public:
  // ---- What the workbench calls

  /// @param source  is not called after closing().
  void opened(TissueSource source, const MaterialTable& materials);
  void closing();
  /// Once a frame. Errors: of a job; what could not be made is then given up.
  Expected<void> update();
  /// A job is under way, or is due: what is seen is not yet what was asked for.
  bool isBusy() const;

  // ---- Which tissues are seen

  /// Those that the object has, in the order of the table of materials.
  std::span<const SeenTissue> all() const { return tissues_; }
  /// @param id  or its name.   Error kBadValue: the object has no such tissue.
  Expected<void> set(const std::string& id, TissueLook look);
  void showAll();
  bool areAllShown() const;
  /// Whether there are surfaces of that part to show. Without solid ones the object's own surface is to be shown.
  bool hasPart(TissuePart part) const;
  /// Whether the object's own surface is the ghost.
  bool isOwnSurfaceGhost() const;
  /// Colours and looks, to be chosen again when the same object is opened anew.
  TissueChoices choices() const;
  /// As set() and setColours(); what the object does not have is passed over.
  void choose(const TissueChoices& choices);

  struct Change {
    std::uint32_t object = 0;
    TissuePart part = TissuePart::kSolid;
    bool is_new = false;  ///< forget what was known of that part of that object
    std::vector<MeshChunkPtr> chunks;
  };
  /// Since the last call.
  std::vector<Change> takeChanges();

  // ---- Colours

  /// What objects are made of in a plane of their own frame, as loaded. Empty: nothing is open.
  /// @param beside  0: of what is worked on; n: of the n-th neighbour.
  /// @cost  as tissueSection(): once for each plane, not each frame.
  TissueSection sectionAt(const Plane& plane, std::size_t beside = 0) const;
  /// From the beginning those of the scan, if it has any and is of one tissue.
  SurfaceColours colours() const { return colours_; }
  /// They say a number: depth, or distance.
  bool isMap() const { return colours_ == SurfaceColours::kDepth || colours_ == SurfaceColours::kDistance; }
  bool hasScanColours() const { return source_ && source_->has_scan_colours; }
  /// Depth is measured in a job first: 9 s for a molar at 0.05 mm. Error kUnsupported: a map of distances without pulp
  /// and nerve canal, colours of a scan that has none.
  Expected<void> setColours(SurfaceColours colours);
  /// Rises when the colours of all chunks are others.
  std::uint64_t coloursVersion() const { return colours_version_; }
  /// One per vertex: of the map, of the scan, or the chunk's own.   @cost  30 ns a vertex.
  std::vector<Rgba8> coloursOf(const MeshChunk& chunk) const;
  /// The same of what stands beside: maps are of what is worked on alone.
  const std::vector<Rgba8>& coloursBeside(const MeshChunk& chunk) const;

 private:
  /// What the parts are made of.
  struct Wanted {
    TissueSet solid, ghost;     ///< ghost: none: that part is not needed
    bool is_own_ghost = false;  ///< nothing is hidden: the object's own surface is the ghost
    bool operator==(const Wanted&) const = default;
  };
  /// Belongs to the job while there is one.
  struct Meshers {
    Wanted of;
    std::map<std::pair<std::uint32_t, TissuePart>, std::unique_ptr<TissueMesher>> all;
  };
  using Changes = std::vector<Change>;
  using Depths = std::shared_ptr<const KeepOut>;

  static Expected<Changes> meshed(const SceneView& view, Meshers& meshers, const BakedObject& loaded,
                                  const RemesherOptions& options, const Progress& progress);
  Wanted wanted() const;
  void startMeshing();
  Expected<void> takeMeshed();
  double nearness(const Vec3d& p) const;
  Expected<void> takeDepths();

  std::optional<TissueSource> source_;  // none: nothing is open
  std::optional<TissueLabels> labels_;
  std::vector<TissueLabels> labels_beside_;
  std::optional<TissuePalette> palette_;
  std::vector<SeenTissue> tissues_;

  std::shared_ptr<Meshers> meshers_;
  std::unique_ptr<Job<Changes>> meshing_;
  std::optional<Wanted> parts_of_;  // what the surfaces that were handed out are of
  std::uint64_t meshed_edits_ = 0;  // LiveRun::editsDone() when the last job began
  std::size_t meshed_objects_ = 0;  // in the scene then
  bool is_dropped_ = false;         // all were shown while a job was under way
  std::chrono::steady_clock::time_point next_{};
  Changes changes_;

  SurfaceColours colours_ = SurfaceColours::kTissue;
  SurfaceColours wanted_colours_ = SurfaceColours::kTissue;  // another one while depths are measured
  std::uint64_t colours_version_ = 0;
  Depths depths_;
  std::unique_ptr<Job<Depths>> measuring_;
  std::vector<std::unique_ptr<AnyJob>> ending_;  // cancelled; nobody waits for them
};

}  // namespace kerf
