// Drilling by plan: a hole at a typed or clicked place, drilled to its depth through the 1 kHz thread.
//
// Places are in the model's frame: the axes of the views (Camera::upright: x right, y back, z up), from the left front
// lower corner of the box of the model as loaded, mm. Errors name a remedy. A notice reports the depth reached.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "ui/app/document/part.h"
#include "ui/app/tool/hole.h"
#include "ui/app/view/camera.h"

namespace kerf {

class Workbench;

enum class DrillAxis { kVertical, kOcclusal, kFace, kView };

/// Numbers of the planned hole.
struct HoleReadout {
  Vec3d place = Vec3d::Zero();  ///< of the entry, in the model's frame
  double diameter = 0;
  double full_to = 0;  ///< depth of the full width: the tool may have a point
  HoleWalls walls;
};

/// Progress of a hole.
struct DrillingStatus {
  double depth = 0, of_depth = 0;  ///< mm
  bool is_stopping = false;        ///< on its way out early
};

/// Window thread only.
class Drilling final : public Part {
 public:
  static constexpr double kFeed = 2;                            ///< mm/s
  static constexpr double kForce = 8;                           ///< N at most: the feed needs less in model stone
  static constexpr double kLeastDepth = 0.1, kMostDepth = 100;  ///< mm

  explicit Drilling(Workbench& bench);
  ~Drilling() override;

  /// Planning: clicks place the hole.
  bool isPlanning() const { return is_planning_; }
  /// Error kUnsupported: the tool in hand does not drill, or nothing is open.
  Expected<void> setPlanning(bool is_on);

  // ---- The hole

  DrillAxis axis() const { return axis_; }
  bool isThrough() const { return is_through_; }
  double depth() const { return depth_; }  ///< mm, if it is not through
  /// @param camera  the axis of view, and the model's frame.
  void setAxis(DrillAxis axis, const Camera& camera);
  void setDepth(std::optional<double> mm);  ///< none: through
  /// At the surface point over x, y on the viewer's side.   @param z  looks from that height only, not from outside.
  /// Errors: kBadValue beside the model; kUnsupported at a neighbour, or if the axis runs along the surface.
  Expected<void> placeAt(double x, double y, std::optional<double> z, const Camera& camera);
  /// At the hit of a ray. Errors: as placeAt().
  Expected<void> placeUnder(const Ray& ray, const Camera& camera);
  /// None: no place yet, the piece is gone, or through a model without another side.
  const std::optional<Hole>& hole() const { return hole_; }
  /// Outline for the picture.   @pre hole()
  double radius() const { return shape_.radius; }
  /// None: no hole.
  std::optional<HoleReadout> readout(const Camera& camera) const;
  /// The box of the model as loaded, along the axes of its frame.   @pre open
  Box3 boxIn(const Camera& camera) const;

  // ---- Drilling

  /// Drills the hole now, in real time. Errors: kEmpty without a place; kUnsupported if the tool is in use or does not
  /// drill; kGeometry if a wider part of the tool would meet the model.
  Expected<void> go();
  /// Stops early: the drill comes out. The drilled part stays, as one step.
  void stop();
  /// As stop(), and undoes the hole once the drill is out.
  void stopAndUndo();
  bool isDrilling() const { return drilling_ != nullptr; }
  std::optional<DrillingStatus> status() const;
  /// Depth reached by the last hole, mm; 0: none.
  double lastDepth() const { return last_depth_; }

  void update() override;
  void opened(Opening how) override;
  void closing() override;

 private:
  struct Running;
  struct Place {
    std::uint32_t object = 0;
    Vec3d point, normal;  // of the surface, outwards
    Vec3d to_viewer;      // unit
  };
  Expected<void> place(const Ray& ray, const Camera& camera);
  Expected<Vec3d> axisAt(const Place& at, const Eigen::Matrix3d& upright) const;
  Expected<void> plan(const Place& at);
  void planAgain();
  void finish();

  Workbench& bench_;
  bool is_planning_ = false, is_through_ = false;
  DrillAxis axis_ = DrillAxis::kVertical;
  double depth_ = 5;
  Eigen::Matrix3d upright_ = Eigen::Matrix3d::Identity();
  std::optional<Place> place_;
  std::optional<Hole> hole_;
  DrillShape shape_;
  HoleWalls walls_;
  struct Seen {
    std::size_t tool = 0, triangles = 0;
    std::optional<Vec3d> held;
    bool operator==(const Seen&) const = default;
  };
  Seen seen() const;
  Seen seen_;  // when the hole was planned
  std::unique_ptr<Running> drilling_;
  std::uint64_t holes_ = 0;
  double last_depth_ = 0;
};

}  // namespace kerf
