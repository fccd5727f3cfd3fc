// Heat of a tool in tissue, tick by tick: its area close to tissue, the drive's power through it, and the temperature
// of pulp and nerve where the tool came near. The laws are those of sim/monitor/heat.h.
//
// When a session changes its tool, the tissue keeps its temperature and the heat source changes.
#pragma once

#include <cstdint>
#include <span>

#include "sim/monitor/contact_area.h"
#include "sim/monitor/heat.h"
#include "sim/monitor/keep_out.h"
#include "sim/step/step.h"

namespace kerf {

/// Heat data of a tool.
struct HeatingTool {
  /// @param samples  of its cutting part.   @cost  some ms.
  HeatingTool(const ToolModel& tool, const ToolSamples& samples, const HeatSource& heat_source = {});

  ContactArea close;
  HeatSource source;
  Vec3d middle;  ///< of its cutting part, tool frame, mm
};

/// A value; for the thread that ticks it.
class ToolHeat {
 public:
  explicit ToolHeat(const HeatSettings& settings = {}) noexcept : heat_({}, settings) {}

  /// After step(): the tool in use cuts, or does not.
  /// @param tool  the tool in use.   @param objects  current objects of the session; the first is the watched one.
  /// @rt safe.   @cost  about 6 us.
  void tick(HeatingTool& tool, const DeviceSample& sample, const StepOutput& output,
            std::span<const CutObject> objects) noexcept;
  /// Watches the temperature of a structure of the first object from now on, where the tool is nearest to it.
  /// @param nearest  of the tool to it, object frame.   @rt safe.
  void watch(Material structure, const KeepOut& field, const KeepOut::Reading& nearest) noexcept;

  double temperature() const noexcept { return kBodyCelsius + heat_.surfaceRise(); }  ///< under the tool, C
  double area() const noexcept { return area_; }  ///< of the cutting surface close to tissue, mm^2, in the last tick
  const Heat& heat() const noexcept { return heat_; }

 private:
  Heat heat_;
  const HeatingTool* tool_ = nullptr;  // of the last tick
  double area_ = 0, touched_s_ = 0;
  Vec3d middle_ = Vec3d::Zero();  // of the area, tool frame, mm: last known mean
  Rigid3 T_object_before_;        // pose of the tool in the first object at the last tick
  bool has_before_ = false;
};

}  // namespace kerf
