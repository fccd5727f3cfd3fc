// A force-feedback device that leads the tool in place of the mouse.
#pragma once

#include <memory>
#include <string>

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "ui/app/document/part.h"

namespace kerf {

class ArmLead;
class Workbench;

/// Window thread only.
class ForceDevice final : public Part {
 public:
  /// Opens the device that the options name; an error is a notice.
  explicit ForceDevice(Workbench& bench);
  ~ForceDevice() override;

  /// All queries also work on a device that is not open.
  ArmLead& arm() { return *arm_; }
  const ArmLead& arm() const { return *arm_; }
  /// Opens the device. The open document continues in a session with a coupling that suits it.
  Expected<void> open(const std::string& name);
  /// Continues the open document in a session with a coupling for the device as it is now.
  Expected<void> fit();
  /// Maps the hand's present position to this tip position and moves the tool there.
  Expected<void> place(const Vec3d& tip);
  /// The device leads the tool, not the mouse.
  bool isLed() const;
  /// Says once that the device leads the tool.
  void warnThatItLeads();

  void opened(Opening how) override;
  void closing() override;
  void update() override;

 private:
  void sendPlace(const Rigid3& T_world_tool);

  Workbench& bench_;
  std::unique_ptr<ArmLead> arm_;
  bool has_told_that_it_leads_ = false;
};

}  // namespace kerf
