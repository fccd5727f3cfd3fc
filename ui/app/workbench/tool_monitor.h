// Readings of the tool at work: depth of its tip, distances to protected structures and neighbours, drive, heat, plots.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "geometry/base/types.h"
#include "ui/app/document/part.h"
#include "ui/app/session/loop_rate.h"
#include "ui/app/session/neighbours.h"
#include "ui/app/session/trace.h"
#include "ui/app/tool/hindrance.h"
#include "ui/app/tool/stroke.h"

namespace kerf {

class Workbench;

/// The leading point of a tool, in the frame of the scan.
struct ToolFront {
  Vec3d point = Vec3d::Zero();   ///< mm
  Vec3d into = -Vec3d::UnitZ();  ///< unit: its direction of travel into the object
  double depth = 0;              ///< below the surface as loaded, along `into`, mm; negative in air
};

/// Distance from the tool to a protected structure.
struct NearStructure {
  std::string name;         ///< "pulp", "nerve canal"
  double distance_mm = 0;   ///< negative: the tool is inside it
  bool is_far = true;       ///< beyond the measured range: distance_mm is the reach
  bool is_stopped = false;  ///< the stroke stops short of it here
};

/// Window thread only.
class ToolMonitor final : public Part {
 public:
  explicit ToolMonitor(Workbench& bench) : bench_(bench) {}

  /// Distance of the tool to pulp and nerve canal: its pose in a stroke or led by a device, else its touch point. None:
  /// no structures.
  std::optional<NearStructure> nearStructure(const std::optional<ToolOverSurface>& over) const;
  /// The neighbour nearest to the tool, measured as nearStructure(). None: no neighbours.
  std::optional<NearNeighbour> nearNeighbour(const std::optional<ToolOverSurface>& over) const;
  /// Depth of the tool's leading point below the surface as loaded, mm, along its direction of travel; negative in air.
  /// For mouse, device and planned cut. None: nothing leads the tool, or there is no surface above or below.
  std::optional<double> tipDepth() const;
  /// Leading point of the same tool.
  std::optional<ToolFront> toolFront() const;
  /// Reason why the stroke removes nothing and a remedy, in English. Empty: no hindrance.
  const char* hindrance() const { return hindrance_.text(); }
  /// The same in the language of the window. It names a neighbour that the tool touches.
  std::string hindranceShown() const;
  /// Speed of the drive as a share of its free speed, 0 to 1.
  double driveShare() const;
  /// Load of the drive as a share of its stall load; 0: nothing stalls it.
  double driveLoadShare() const;
  /// Forces and cutting of the last 20 s.
  const Trace& trace() const { return trace_; }
  /// Ticks per second of the 1 kHz thread, mean of the last second. None in the first second.
  std::optional<double> loopHz() const { return loop_rate_.hz(); }
  /// The 1 kHz loop as of the last second: these numbers change once a second.
  struct Loop {
    std::optional<double> hz;
    std::optional<double> p99_ms;  ///< of the duration of a tick
    std::uint64_t overruns = 0, ticks = 0;
  };
  const Loop& loop() const { return loop_; }

  void opened(Opening how) override;
  void update() override;

 private:
  void addToTrace();
  void warnOfHeat();
  void readLoop();

  Workbench& bench_;
  LoopRate loop_rate_;
  Loop loop_;
  LoopRate::Clock::time_point loop_read_{};
  Trace trace_;
  Hindrance hindrance_;
  bool has_told_of_pulp_ = false, has_told_of_bone_ = false, has_told_of_dead_bone_ = false;  // heat warnings given
};

}  // namespace kerf
