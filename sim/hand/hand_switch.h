// Two hands, one of which leads the tool: a person's mouse, and a force-feedback arm that may come and go.
#pragma once

#include <atomic>

#include "sim/hand/device_source.h"

namespace kerf {

/// The window chooses the leading hand; the haptic thread switches before its next read(). The old hand gets zero force
/// and disarm(), the new one finds the tool where it is. @rt safe.
class HandSwitch final : public DeviceSource {
 public:
  /// @param first  leads at first, must outlive this.
  explicit HandSwitch(DeviceSource& first)
      : first_(first), now_(&first), wanted_(&first), coming_(&first), in_use_(&first) {}

  /// Null: the first one. Any other hand must outlive its use: isInUse(). One thread.
  void lead(DeviceSource* other) noexcept { wanted_.store(other ? other : &first_); }
  bool isInUse(const DeviceSource* other) const noexcept {
    return in_use_.load(std::memory_order_acquire) == other || wanted_.load() == other || coming_.load() == other;
  }

  void arm() noexcept override {
    is_armed_ = true;
    now_->arm();
  }
  DeviceSample read() noexcept override {
    if (DeviceSource* const wanted = wanted_.load(); wanted != now_) {
      // Claims first, then checks again: isInUse() must not miss this hand after another was chosen.
      coming_.store(wanted);
      if (wanted_.load() == wanted)
        change(wanted);
      else
        coming_.store(now_);
    }
    last_ = now_->read();
    return last_;
  }
  void write(const DeviceForce& force) noexcept override { now_->write(force); }
  void placed(const Rigid3& T_world_tool) noexcept override {
    last_.T_world_device = T_world_tool;
    now_->placed(T_world_tool);
  }
  void disarm() noexcept override {
    is_armed_ = false;
    now_->disarm();
  }
  bool isAtRest() const noexcept override { return wanted_.load() == now_ && now_->isAtRest(); }

 private:
  void change(DeviceSource* wanted) noexcept {
    now_->write({});
    now_->disarm();
    now_ = wanted;
    if (is_armed_) now_->arm();
    now_->placed(last_.T_world_device);
    in_use_.store(now_, std::memory_order_release);
  }

  DeviceSource& first_;
  DeviceSource* now_;  // of the haptic thread, as the next two
  DeviceSample last_;
  bool is_armed_ = false;
  std::atomic<DeviceSource*> wanted_, coming_, in_use_;
};

}  // namespace kerf
