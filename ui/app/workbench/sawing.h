// Sawing by plan: the planes of the open object, planned cuts through the 1 kHz thread, the guide for sawing by mouse.
//
// Errors name a remedy. A notice reports the end of a cut.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "geometry/tool/saw_blade.h"
#include "ui/app/document/part.h"
#include "ui/app/saw/saw_clearance.h"
#include "ui/app/saw/saw_plan.h"
#include "ui/app/saw/saw_section.h"
#include "ui/app/tool/stroke.h"
#include "ui/app/view/live_surface.h"
#include "ui/app/workbench/die_making.h"
#include "ui/app/workbench/saw_picking.h"

namespace kerf {

class Workbench;
enum class PlaneKeep : std::uint8_t;
struct CutPlanes;
struct FitOptions;
struct GuidedReport;

/// Progress of a planned cut.
struct SawingStatus {
  std::string plane;
  double share = 0;              ///< sawn part of the planned section, 0 to 1
  double planned_mm3 = 0;        ///< the planned section times the blade's kerf
  double removed_mm3 = 0;        ///< since it began
  double seconds = 0;            ///< simulated, since it began
  std::optional<double> left_s;  ///< estimated from the pace so far
  bool is_stopping = false;      ///< stopped early: the blade is on its way out
};

/// Window thread only.
class Sawing final : public Part {
 public:
  static constexpr double kLeastForce = 0.5, kMostForce = 8;  ///< N
  static constexpr double kUsualForce = 5;                    ///< N: usual for saws in bone are 2 to 8
  static constexpr double kFeed = 1;                          ///< mm/s in bone: 60 mm/min, the fastest advised

  explicit Sawing(Workbench& bench);
  ~Sawing() override;

  double force = kUsualForce;  ///< N, of a planned cut
  SawPicking picking;          ///< points picked by the user
  DieMaking die;
  bool has_handles = false;  ///< the chosen plane has handles in the view, unless a piece is chosen

  // ---- Planes. Each new plane is bounded to the bone and the blade, and chosen.

  SawPlan& plan() { return plan_; }
  const SawPlan& plan() const { return plan_; }
  /// The saw in hand; else the first of the rack; else a typical one.
  SawBlade blade() const;

  /// Hit of a ray on the surface as it is now. Error kEmpty: no hit.
  Expected<SurfaceHit> hit(const Ray& ray) const;
  /// Through the hits of three rays.
  Expected<void> addThrough(const std::array<Ray, 3>& rays);
  /// Through a line drawn in the view, along the view. Rays of one parallel projection.
  Expected<void> addAlongLine(const Ray& from, const Ray& to);
  /// Through the hit of a ray, along the view, upright in it.   @param right  of the view, unit.
  Expected<void> addFromView(const Ray& at, const Vec3d& right);
  /// Parallel to the surface at the hit of a ray, `below_mm` under it.
  Expected<void> addAlongFace(const Ray& at, double below_mm);
  /// Through a point, perpendicular to a normal.
  Expected<void> addAt(const Vec3d& point, const Vec3d& normal);

  /// Moves the chosen plane. Error kEmpty: none is chosen.
  Expected<void> move(double mm);
  Expected<void> turn(double about_approach_deg, double about_across_deg);
  Expected<void> turnApproach(double deg);
  Expected<void> resize(std::optional<double> width_mm, std::optional<double> depth_mm);
  /// Distance of the chosen plane to pulp and nerve canal with the blade in hand. None: no plane, or no structures.
  std::optional<SawClearance> clearance();
  /// Part of the section, as loaded, that the chosen plane passes with the blade in hand. None: no plane.
  std::optional<SawCoverage> coverage();
  /// Bounds the chosen plane to bone and blade again, in all sections that it meets.
  Expected<void> fit();
  /// @param file  or a session's folder.
  Expected<void> save(const std::filesystem::path& file) const;
  Expected<void> load(const std::filesystem::path& file);

  /// Error kUnsupported: a piece was moved.
  Expected<void> requireUnmoved() const;

  // ---- Sawing a plane

  /// Saws the chosen plane now, in real time: places the tool in hand above the bone and leads it along its passes.
  /// Errors: kEmpty without a plane or without bone in it; kUnsupported if the tool is no saw, a piece was moved, or
  /// another cut or undo is under way; kGeometry if the blade has no room above the bone.
  Expected<void> cut(double force_n);
  /// Stops the cut early: draws the blade or the drill out. The sawn part stays, as one stroke.
  void stop();
  /// As stop(), and undoes the cut once the blade is out.
  void stopAndUndo();
  /// A planned cut or a hole (drilling.h) is under way.
  bool isCutting() const;
  /// As isCutting(), and says so in a notice.
  bool isBusy();
  std::optional<SawingStatus> status() const;
  /// Sawn part of the planned section in the last planned cut, 0 to 1; 0: no cut.
  double lastShare() const { return last_share_; }
  /// Takes the reports of the cut.
  void update() override;

  /// For GuidedCut::id.
  std::uint64_t nextOrder() { return ++cuts_; }

  // ---- Cutting at once

  /// Parallel to the occlusal plane of the scan, so much above it. @cost 0.5 s. Error kGeometry: no occlusal plane.
  Expected<void> addOcclusal(double above_mm);
  /// Cuts the chosen piece, or the only one that the plane meets, by the chosen plane without its bounds. One undo
  /// step; exported as `kerf trim` would. A notice reports the end, or that the plane misses.
  /// @param kerf_mm  width lost along the plane.   Errors: kEmpty without a plane or a piece in it; kUnsupported for a
  /// neighbour, while the tool is in use, and if several pieces meet the plane and none is chosen.
  Expected<void> cutAtOnce(PlaneKeep keep, double kerf_mm);
  /// The same by several planes and a hole, world frame.
  /// @param name  of the cut, for notices.   @param piece  its id; none: as above.
  Expected<void> cutAtOnce(PlaneKeep keep, const CutPlanes& planes, const std::string& name,
                           std::optional<std::uint32_t> piece = {});
  /// The planes did their cut at once: the view hides them until one changes, is chosen, or the cut is undone.
  bool isPlanSpent() const;
  /// Chooses a plane of the plan, and shows the plan again.
  void choosePlane(std::size_t n);

  /// Names of the neighbours that the chosen plane meets: a cut at once leaves them whole. Empty: none.
  std::string neighboursInPlane() const;

  // ---- The guide

  bool guide = false;  ///< keeps the blade in the chosen plane, by mouse
  /// The guide is on, a plane is chosen, a saw is in hand, and no piece has moved.
  bool isGuiding() const;
  /// Pose of a guided blade: on the surface as it is now, below the hit of the ray, its front in the plane. None: no
  /// hit, or too far beside the plane.
  std::optional<ToolOverSurface> over(const Ray& ray) const;
  /// From the tip of a guided tool to its front, perpendicular to the approach, world, mm.
  Vec3d tipToFront() const;

  void opened(Opening how) override;  ///< those of the session that goes on, else none
  void closing() override;            ///< writes the plan to the session's folder

 private:
  struct Cutting;
  Expected<void> addFitted(SawPlane plane, FitOptions options);
  Expected<SawPlane> chosen() const;
  Expected<void> requireOpen() const;
  bool isMoved() const;
  Expected<Rigid3> startAbove(const SawPlane& plane, const SawBlade& blade, double u, double v, bool is_turned) const;
  std::string sawsOfTheRack() const;
  void markSawn(const GuidedReport& report);
  double plannedMm3() const;
  double removedMm3() const;
  void finish(const GuidedReport& report);
  void saveSoon();

  struct AtOnce {
    std::string plane;
    std::uint64_t sent = 0, refused_before = 0;
    std::size_t steps_before = 0;
    std::string beside;  // neighbours in the plane
  };
  struct Spent {
    std::uint64_t version = 0;  ///< of the plan
    std::size_t steps_before = 0;
  };
  void reportAtOnce();

  Workbench& bench_;
  SawPlan plan_;
  std::optional<AtOnce> at_once_;  ///< sent, not answered yet
  std::optional<Spent> spent_;
  std::unique_ptr<Cutting> cutting_;
  std::uint64_t cuts_ = 0;
  double last_share_ = 0;
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};
  std::uint64_t saved_ = 0, seen_ = 0;  // versions of the plan
  struct Measured {
    std::uint64_t version = 0;  // of the plan
    double kerf = 0;
    const Structures* of = nullptr;
    SawClearance clearance;
  };
  Measured measured_;
  struct Covered {
    std::uint64_t version = ~std::uint64_t{0};  // of the plan
    double most_depth = 0;
    SawCoverage coverage;
  };
  Covered covered_;
  std::chrono::steady_clock::time_point changed_{};
};

}  // namespace kerf
