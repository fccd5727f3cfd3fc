// Planned saw cuts: named planes, bounded to a blade, kept in a file.
//
// Frame: the case's (world), mm, right-handed. A plane is a rectangle: `point` is the middle of the side where the
// teeth enter, `approach` their direction, `width` the extent along the teeth, `depth` that along the approach.
//
//        point
//    ┌─────●─────┐  ──▶ across = normal x approach
//    │     │     │
//    │     ▼     │  depth
//    └───────────┘
//        width
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

struct SawPlane {
  std::string name;
  Vec3d point = Vec3d::Zero();
  Vec3d normal = Vec3d::UnitX();     ///< unit
  Vec3d approach = -Vec3d::UnitZ();  ///< unit, in the plane
  double width = 20, depth = 10;     ///< mm

  Vec3d across() const { return normal.cross(approach); }
  /// Corners of the rectangle: entering left, entering right, far right, far left.
  std::array<Vec3d, 4> corners() const;
  /// In the plane, mm: x along across, y along approach, from `point`. z: height above the plane.
  Vec3d toPlane(const Vec3d& p) const;
  Vec3d fromPlane(double u, double v) const { return point + u * across() + v * approach; }
};

// ---- Planes from user picks. The rectangle is not bounded yet: fitToBone() (saw_section.h) does that.

/// Through three points. The teeth go against `outward` (of the surface there) as far as the plane allows.
/// Error kGeometry: the points lie on a line, or nearer than 0.5 mm to each other.
Expected<SawPlane> planeThrough(const std::array<Vec3d, 3>& points, const Vec3d& outward);
/// Through two points, parallel to `view` (unit, into the picture): a line drawn in a view. The teeth go along the
/// view. Error kGeometry: nearer than 0.5 mm as seen.
Expected<SawPlane> planeAlongView(const Vec3d& from, const Vec3d& to, const Vec3d& view);
/// Through a point, perpendicular to `normal` (any length). Without an approach, or with one along the normal, the
/// teeth go downwards (-z) as far as the plane allows.   Error kBadValue: no direction.
Expected<SawPlane> planeSquareTo(const Vec3d& point, const Vec3d& normal, const std::optional<Vec3d>& approach = {});

// ---- Steps

void movePlane(SawPlane& plane, double mm);  ///< along its normal
/// First about the approach through `point`, then about the line along the teeth, rad. Right-handed. Depth and width
/// stay.
void turnPlane(SawPlane& plane, double about_approach, double about_across);
/// Turns the approach within the plane about the middle of the rectangle, rad, right-handed about the normal.
void turnApproach(SawPlane& plane, double angle);
/// Moved and turned in the world, about any centre.
SawPlane movedPlane(SawPlane plane, const Rigid3& by);

/// Where the planes of a file come from.
struct PlanOrigin {
  /// Of a file of 3D Slicer: "LPS", "RAS", "LPS and RAS", or "LPS (not named)", the default of its schema. Empty: of
  /// Kerf.
  std::string frame;
  std::size_t others = 0;  ///< markups that are no planes, left out
  /// Some planes were written in RAS, and have x and y negated.
  bool isTurned() const { return frame.ends_with("RAS"); }
};

/// Named planes, one of them chosen. Names are unique and not empty.
class SawPlan {
 public:
  static constexpr double kLeastSide = 0.5, kMostSide = 120;  ///< mm, of a rectangle

  const std::vector<SawPlane>& planes() const { return planes_; }
  const SawPlane* chosen() const { return chosen_ < planes_.size() ? &planes_[chosen_] : nullptr; }
  std::size_t chosenIndex() const { return chosen_; }  ///< planes().size(): none
  /// Increases with every change: results derived from the planes are outdated.
  std::uint64_t version() const { return version_; }

  /// Adds a plane and chooses it. Without a name it gets "plane 1", or the next free number.
  void add(SawPlane plane);
  /// Replaces the chosen plane; its name stays. @pre one is chosen.
  void replaceChosen(SawPlane plane);
  void choose(std::size_t n);
  Expected<void> choose(const std::string& name);
  /// Error kBadValue: another plane has this name, or it is empty or longer than 60 characters.
  Expected<void> renameChosen(const std::string& name);
  void removeChosen();  ///< chooses the previous one
  void clear();

  /// Writes a TOML file atomically. Errors: kWriteFailed.
  Expected<void> save(const std::filesystem::path& file) const;
  /// Replaces all planes by those of a file of save(), or of 3D Slicer (slicer_planes.h). Errors name the key and keep
  /// the planes: kBadFormat, kBadValue; kUnsupported for a version of another Kerf; kNotFound.
  Expected<PlanOrigin> load(const std::filesystem::path& file);

 private:
  std::string freeName() const;
  bool hasName(const std::string& name) const;

  std::vector<SawPlane> planes_;
  std::size_t chosen_ = 0;
  std::uint64_t version_ = 0;
};

}  // namespace kerf
