// The area of a tool's cutting surface close to tissue, and its middle: heat enters through it.
//
// Read from distance fields, so that it does not depend on the contact response: under penalty a tool overlaps by 60
// um, under constraint by 5 um, and the patch in contact differs by a factor of five, although both tools stand in the
// same cavity.
//
// Samples of the surface are made once. A tick looks up every kTurn-th of them; kTurn ticks cover all.
#pragma once

#include <span>
#include <vector>

#include "sim/monitor/keep_out.h"
#include "sim/object/cut_object.h"

namespace kerf {

class ContactArea {
 public:
  /// Closer than this to the surface of tissue counts, mm: about half a voxel, and more than the gap of any response.
  static constexpr double kClose = 0.05;
  static constexpr int kTurn = 25;  ///< ticks

  /// @param samples  of the tool's cutting part. Those inside its body do not count.
  /// @param flank  unit, tool frame. Excludes the surface that faces along it (within 45 degrees), either way, and,
  /// unless the tool spins, the surface that faces away from its plunge. So a blade has the front of its teeth: kerf x
  /// engaged length. Zero: all of the surface counts.
  ContactArea(const ToolModel& tool, const ToolSamples& samples, const Vec3d& flank = Vec3d::Zero());

  /// The counted surface, mm^2, within a few per cent.
  double whole() const { return whole_; }

  struct Reading {
    double area = 0;               ///< mm^2, by this tick's samples; the mean of kTurn ticks is that of all
    Vec3d middle = Vec3d::Zero();  ///< of the close samples, tool frame, mm
    bool isClose() const { return area > 0; }
  };
  /// @param touched  bit n: look at object n.
  /// @rt safe.  @cost about 3 us for 1600 samples and one object.
  Reading read(std::span<const CutObject> objects, std::uint64_t touched, const Rigid3& T_world_tool) noexcept;
  /// The next turn: the only state between two ticks.
  std::size_t turn() const noexcept { return turn_; }
  void setTurn(std::size_t turn) noexcept { turn_ = turn; }

 private:
  struct Sample {
    Vec3f at;
    float area;
  };
  std::vector<Sample> samples_;
  double whole_ = 0;
  std::size_t turn_ = 0;
};

/// Trilinear value of an object's present field, mm; air where there is no brick. Object frame. @rt safe, about 20 ns.
float distanceIn(const CutObject& object, const Vec3d& p) noexcept;

}  // namespace kerf
