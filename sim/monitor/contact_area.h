// How much of a tool's cutting surface is close to tissue, and where: the area through which heat enters.
//
// Read from distance fields, so that it is the same whatever keeps the tool out of the tissue: under penalty a tool
// overlaps by 60 um, under constraint by 5 um, and the patch in contact differs by a factor of five. Their tools stand
// in the same cavity all the same.
//
// Samples of the surface are made once. A tick looks up every kTurn-th of them; in kTurn ticks each has had its turn.
#pragma once

#include <span>
#include <vector>

#include "sim/monitor/keep_out.h"
#include "sim/object/cut_object.h"

namespace kerf {

class ContactArea {
 public:
  /// Closer than this to the surface of tissue counts, mm: about half a voxel, and more than any response lets gape.
  static constexpr double kClose = 0.05;
  static constexpr int kTurn = 25;  ///< ticks

  /// @param samples  of the tool's cutting part. Those inside its body do not count.
  /// @param flank  unit, tool frame: where the surface faces along it (within 45 degrees), either way, it does not
  /// count, nor where it faces away from the way a tool plunges, unless that spins. So a blade has the front of its
  /// teeth: kerf x engaged length. Zero: all of the surface counts.
  ContactArea(const ToolModel& tool, const ToolSamples& samples, const Vec3d& flank = Vec3d::Zero());

  /// All of the surface that counts, mm^2, within a few per cent.
  double whole() const { return whole_; }

  struct Reading {
    double area = 0;               ///< mm^2, by this tick's samples; the mean of kTurn ticks is that of all
    Vec3d middle = Vec3d::Zero();  ///< of the samples that are close, tool frame, mm
    bool isClose() const { return area > 0; }
  };
  /// @param touched  bit n: look at object n.
  /// @rt safe.  @cost about 3 us for 1600 samples and one object.
  Reading read(std::span<const CutObject> objects, std::uint64_t touched, const Rigid3& T_world_tool) noexcept;
  /// Whose turn it is next: all that it remembers from one tick to the next.
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

/// Trilinear value of an object's present field, mm: of air where no brick is. Object frame. @rt safe, about 20 ns.
float distanceIn(const CutObject& object, const Vec3d& p) noexcept;

}  // namespace kerf
