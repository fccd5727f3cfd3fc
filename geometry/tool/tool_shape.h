// Exact signed distances of tool parts, in the tool's own frame: tip at the origin, axis +z towards the shank, mm.
#pragma once

#include <memory>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

/// A solid with a distance function. Values, safe to read from any number of threads, allocation-free.
class ToolShape {
 public:
  virtual ~ToolShape() = default;
  /// Signed Euclidean distance to the surface, mm, negative inside. 1-Lipschitz: sweeps rely on it.
  virtual double distance(const Vec3d& p) const noexcept = 0;
  /// Box around the solid, tool frame.
  virtual Box3 bounds() const = 0;
  /// True only if the solid is convex: sweeps then use its convex distance. False only costs time.
  virtual bool isConvex() const = 0;

  /// Symmetry of the distance, so that its table needs only two dimensions.
  enum class Symmetry {
    kNone,
    kRevolved,  ///< on hypot(x, y) and z
    kPlate      ///< extruded along y: on the distance in the plane y = 0, and on |y|
  };
  virtual Symmetry symmetry() const { return Symmetry::kNone; }
  /// Half the extent of a plate along y, mm; the plate is symmetric about y = 0.
  virtual double halfThickness() const { return 0; }
  /// The solid is all of bounds(): its distance is a formula, which needs no table.
  virtual bool isBox() const { return false; }
};

/// Outline of a solid of revolution in the half-plane (radius >= 0, height), from the lowest point on the axis upwards.
/// Built piece by piece; heights never decrease. Every piece is a line or a circular arc, exactly.
class RevolvedProfile {
 public:
  using Point = Eigen::Vector2d;  ///< (radius, height), mm

  /// Starts on the axis at a height.
  explicit RevolvedProfile(double height = 0) : at_(0, height) {}
  RevolvedProfile& lineTo(double radius, double height);
  /// Arc about `center`, counter-clockwise (radius right, height up), at most half a turn, to `end` (same distance from
  /// the centre): bulges outwards.
  RevolvedProfile& arcTo(const Point& center, const Point& end);
  /// The same clockwise: hollows the solid out.
  RevolvedProfile& hollowArcTo(const Point& center, const Point& end);
  /// Closes to the axis with a flat top.
  RevolvedProfile& close() { return lineTo(0, at_[1]); }

  struct Piece {
    Point from, to, center;
    double arc_radius = 0;   ///< 0: a line
    bool is_hollow = false;  ///< an arc on the side of its circle that faces the axis
    /// Radius of the solid at a height within the piece; on a level piece the larger end.
    double radiusAt(double height) const;
  };
  const std::vector<Piece>& pieces() const { return pieces_; }
  Point end() const { return at_; }
  double lowest() const { return pieces_.empty() ? at_[1] : pieces_.front().from[1]; }
  double highest() const { return at_[1]; }
  double largestRadius() const;
  /// Radius of the solid at a height, 0 outside its range; at a step the larger one.
  double radiusAt(double height) const;
  /// The greatest height where the solid is at least as wide as `radius`; lowest() if nowhere.
  double highestAsWideAs(double radius) const;
  /// The outline never turns right, so that the solid of revolution is convex.
  bool isConvex() const;
  /// The part between two heights, with flat ends, closed. @pre lowest() <= low < high <= highest().
  RevolvedProfile clipped(double low, double high) const;
  /// Corners from the axis to the axis; chords of arcs stay within `tolerance` mm of them.
  std::vector<Point> polyline(double tolerance) const;
  /// Signed distance in the half-plane, mm, negative inside. @pre closed.
  double distance(const Point& p) const noexcept;

 private:
  RevolvedProfile& add(const Piece& piece);
  Point at_;
  std::vector<Piece> pieces_;
};

class RevolvedShape final : public ToolShape {
 public:
  /// @pre the profile is closed: it ends on the axis.
  explicit RevolvedShape(RevolvedProfile profile);
  double distance(const Vec3d& p) const noexcept override;
  Box3 bounds() const override;
  bool isConvex() const override { return is_convex_; }
  Symmetry symmetry() const override { return Symmetry::kRevolved; }
  const RevolvedProfile& profile() const { return profile_; }

 private:
  RevolvedProfile profile_;
  double radius_;
  bool is_convex_;
};

/// Box with optionally rounded edges: blades and their toothed edges.
class BoxShape final : public ToolShape {
 public:
  /// @param box  mm.   @param rounding  edge radius, 0 <= rounding <= half the thinnest side.
  explicit BoxShape(const Box3& box, double rounding = 0) : box_(box), rounding_(rounding) {}
  double distance(const Vec3d& p) const noexcept override;
  Box3 bounds() const override { return box_; }
  bool isConvex() const override { return true; }
  Symmetry symmetry() const override {
    return rounding_ == 0 && box_.min[1] == -box_.max[1] ? Symmetry::kPlate : Symmetry::kNone;
  }
  double halfThickness() const override { return box_.max[1]; }
  bool isBox() const override { return rounding_ == 0; }

 private:
  Box3 box_;
  double rounding_;
};

/// A flat solid, symmetric about x = 0: an outline in the half-plane (|x|, z), thick along y: blades that swing.
class ExtrudedShape final : public ToolShape {
 public:
  /// @pre the profile is closed: it ends on the axis.   @param thickness  mm, > 0.
  ExtrudedShape(RevolvedProfile profile, double thickness);
  double distance(const Vec3d& p) const noexcept override;
  Box3 bounds() const override;
  bool isConvex() const override { return is_convex_; }
  Symmetry symmetry() const override { return Symmetry::kPlate; }
  double halfThickness() const override { return half_; }

 private:
  RevolvedProfile profile_;
  double half_;
  bool is_convex_;
};

/// Union by the minimum: exact outside, a lower bound inside near where parts meet.
class UnionShape final : public ToolShape {
 public:
  explicit UnionShape(std::vector<std::shared_ptr<const ToolShape>> parts) : parts_(std::move(parts)) {}
  double distance(const Vec3d& p) const noexcept override;
  Box3 bounds() const override;
  bool isConvex() const override { return parts_.size() == 1 && parts_[0]->isConvex(); }
  /// kRevolved if all parts are.
  Symmetry symmetry() const override;

 private:
  std::vector<std::shared_ptr<const ToolShape>> parts_;
};

}  // namespace kerf
