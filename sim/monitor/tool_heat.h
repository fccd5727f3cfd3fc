// How warm a tool makes what it cuts, tick by tick: what of the tool is close to tissue, the drive's power through it,
// and the temperature of pulp and nerve where the tool came near. The laws are those of sim/monitor/heat.h.
//
// A session changes its tools: the tissue stays as warm as it is, what heats it is another.
#pragma once

#include <cstdint>
#include <span>

#include "sim/monitor/contact_area.h"
#include "sim/monitor/heat.h"
#include "sim/monitor/keep_out.h"
#include "sim/step/step.h"

namespace kerf {

/// What of a tool heats tissue.
struct HeatingTool {
  /// @param samples  of its cutting part.   @cost  some ms.
  HeatingTool(const ToolModel& tool, const ToolSamples& samples, const HeatSource& heat_source = {});

  ContactArea close;
  HeatSource source;
  Vec3d middle;  ///< of its cutting part, tool frame, mm
};

/// A value; belongs to the thread that ticks it.
class ToolHeat {
 public:
  explicit ToolHeat(const HeatSettings& settings = {}) noexcept : heat_({}, settings) {}

  /// After step(): the tool in use cuts, or does not.
  /// @param tool  which it is.   @param objects  those of the session now; the first is the one that is watched.
  /// @rt safe.   @cost  about 6 us.
  void tick(HeatingTool& tool, const DeviceSample& sample, const StepOutput& output,
            std::span<const CutObject> objects) noexcept;
  /// The temperature of a structure of the first object is followed from now on, where the tool is nearest to it.
  /// @param nearest  of the tool to it, object frame.   @rt safe.
  void watch(Material structure, const KeepOut& field, const KeepOut::Reading& nearest) noexcept;

  double temperature() const noexcept { return kBodyCelsius + heat_.surfaceRise(); }  ///< under the tool, C
  double area() const noexcept { return area_; }  ///< of the cutting surface close to tissue, mm^2, in the last tick
  const Heat& heat() const noexcept { return heat_; }

 private:
  Heat heat_;
  const HeatingTool* tool_ = nullptr;  // of the last tick
  double area_ = 0, touched_s_ = 0;
  Vec3d middle_ = Vec3d::Zero();  // of the area, tool frame, mm: the mean, as last known
  Rigid3 T_object_before_;        // pose of the tool in the first object at the last tick
  bool has_before_ = false;
};

}  // namespace kerf
