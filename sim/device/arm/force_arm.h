// A force-feedback arm as the device of the haptic thread, over any transport: a bridge, HID, a recording.
//
//   transport ──newest hand──▶ ┌──────────┐ ──sample──▶ haptic thread
//   transport ◀─newest wish─── │ ForceArm │ ◀──force─── haptic thread
//      window ──settings─────▶ └──────────┘ ──ArmFelt─▶ window
//
// The transport has a thread of its own, the only one that waits for the device. All arrows are latest-value mailboxes:
// a late force is worse than a lost one.
//
// Force reaches the device only if all of these hold: enable(true) was called; the haptic thread runs (arm()); the
// newest hand is less than kDeadMan old and ready (switched on, calibrated); the haptic thread wrote less than kDeadMan
// ago; every force was finite. When they begin to hold, the force fades in. When one ceases, the very next frame says
// zero. A frame's deadline counts from the same news, so a device that keeps it gives no force kDeadMan after them,
// whichever thread or program has stopped. Added to that is the way of the frame, which is short unless the transport
// is stopped between its look at the clock and its call of the system.
//
// A torque goes the same way, to a device that reports torque, with a guard of its own: at most the reported limit.
//
// Buttons: 1 is the pedal; while 2 is held the tool stays where it is and the hand moves on (clutch), without force.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "sim/device/frame/device_frame.h"
#include "sim/device/frame/force_guard.h"
#include "sim/device/frame/workspace_map.h"
#include "sim/hand/device_source.h"
#include "sim/hand/triple_buffer.h"
#include "sim/live/time_histogram.h"

namespace kerf {

/// The transport's thread calls it with each message of a device, before taking it: a report, a datagram.
using ArmListener = std::function<void(std::int64_t came_ns, std::span<const std::uint8_t> message)>;

/// Use of the hand, and limits of force.
struct ArmSettings {
  ForceLimits limits{};        ///< besides the device's reported limits
  WorkspaceMap map{};          ///< turn and scale; the offset is set when the hand first appears
  bool pedal_is_down = false;  ///< without button 1
  double speed = 1;            ///< part of the nominal speed while the pedal is down, -1 to 1; negative: backwards
  double irrigation = 1;       ///< 0 to 1
};

/// Counts since it was opened.
struct ArmCounts {
  std::uint64_t hands = 0;          ///< accepted messages: well-formed, not old, not from another sender
  std::uint64_t refused = 0;        ///< malformed messages; not used
  std::string last_fault;           ///< of the last malformed message: "its length"
  std::uint64_t old = 0;            ///< that came after a newer one
  std::uint64_t others = 0;         ///< from another sender while the first one talks
  std::uint64_t forces = 0;         ///< sent frames
  bool is_talking = false;          ///< the newest hand is less than kDeadMan old
  bool is_enabled = false;          ///< as in the last sent frame
  std::int64_t newest_came_ns = 0;  ///< deviceClock(); 0: nothing has come yet
  /// Why it does not talk, with a remedy; empty: unknown. "it was unplugged", ...
  std::string trouble;
};

/// Use of the newest hand by the haptic thread.
struct ArmFelt {
  Vec3d force = Vec3d::Zero();   ///< N, device frame, within all limits
  Vec3d torque = Vec3d::Zero();  ///< N mm, the same
  double wanted = 0;             ///< N, before the limits
  double age_ms = 0;             ///< of the hand that the force answers
  double ramp = 0;               ///< share of the fading-in, 0 to 1
  bool is_valid = false;         ///< the hand was used
  bool is_armed = false;         ///< the guard lets force through
  bool is_clamped = false;       ///< the force is limited in size or rate, now
  bool has_fault = false;        ///< a force was not finite: switched off until enable(false)
  bool is_clutched = false;
  double pedal = 0;
};

/// The mailboxes between a transport and the haptic thread; each has one writer and one reader.
struct ArmLink {
  struct Hand {
    HandFrame frame;
    std::int64_t came_ns = 0;  ///< deviceClock(); 0: none yet
  };
  struct Wish {
    Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();  ///< device frame, N, N mm
    bool is_enabled = false;
    std::int64_t written_ns = 0;
    std::uint64_t hand_number = 0, hand_time_ns = 0;
  };
  TripleBuffer<Hand> hands;
  TripleBuffer<Wish> wishes;
  std::atomic<bool> may_give_force{false};

  /// The force frame with the haptic thread's last force while its news are fresh; else zero, not enabled. The deadline
  /// is the rest of kDeadMan since the older news, of hand and haptic thread: however often it is sent, and however
  /// late this thread is, the device gives no force beyond that. For the transport.
  /// @param newest  the hand it answers.   @param now  deviceClock().   @rt safe.
  ForceFrame answer(const Hand& newest, std::int64_t now) noexcept;
};

class ForceArm : public DeviceSource {
 public:
  static constexpr double kDeadMan = 0.02;     ///< s
  static constexpr double kMostTestForce = 1;  ///< N
  static constexpr double kTestSeconds = 1.5;  ///< s of a test force: swells and fades

  /// @param start  pose of the tool, world, where the hand begins.
  explicit ForceArm(const ArmSettings& settings, const Rigid3& start = {});

  /// "bridge, port 4417 of this machine".
  virtual std::string what() const = 0;
  /// Any thread.
  virtual ArmCounts counts() const = 0;
  /// It is unplugged and does not come back by itself: open it again. Any thread.
  virtual bool isGone() const { return false; }
  /// No more messages can come: a recording at its end. Any thread.
  virtual bool isOver() const { return false; }
  /// The last accepted hand frame, with the device's limits. False: none yet. Any thread.
  bool lastHand(HandFrame& out) const;

  /// Allows force; at first off. After a force that was not finite: off, then on again. Any thread.
  void enable(bool may_give_force) noexcept { link_.may_give_force.store(may_give_force, std::memory_order_release); }
  bool isEnabled() const noexcept { return link_.may_give_force.load(std::memory_order_acquire); }

  // ---- One thread, the window's

  void set(const ArmSettings& settings) noexcept;
  /// A force along a direction of the device that swells and fades within kTestSeconds, added to the felt force and
  /// within all limits; at most kMostTestForce, N. No effect without enable(true).
  void testForce(const Vec3d& force) noexcept;
  /// Fetches the haptic thread's last result; false: nothing new.
  bool update() noexcept { return felt_.update(); }
  const ArmFelt& felt() const noexcept { return felt_.front(); }
  /// Ages of the hands that forces answered, every tenth of a second.
  bool updateAges() noexcept { return ages_.update(); }
  const TimeHistogram& ages() const noexcept { return ages_.front(); }

  // ---- The haptic thread

  void arm() noexcept override { is_armed_ = true; }
  DeviceSample read() noexcept override;
  void write(const DeviceForce& force) noexcept override;
  void placed(const Rigid3& T_world_tool) noexcept override;
  void disarm() noexcept override;

 protected:
  /// Publishes a hand to the haptic thread and lastHand(). Called by the transport's thread.
  void publish(const ArmLink::Hand& hand);
  ArmLink link_;

 private:
  void takeSettings() noexcept;
  bool isUsable(const ArmLink::Hand& hand, std::int64_t now) const noexcept;
  Vec3d testNow() noexcept;

  struct Test {
    std::uint64_t number = 0;
    Vec3d force = Vec3d::Zero();
  };
  mutable std::mutex told_mutex_;
  ArmLink::Hand told_;  // guarded by told_mutex_

  std::uint64_t tests_asked_ = 0;  // the window's thread
  TripleBuffer<ArmSettings> settings_;
  TripleBuffer<Test> tests_;
  TripleBuffer<ArmFelt> felt_;
  TripleBuffer<TimeHistogram> ages_;

  // The haptic thread alone.
  ArmSettings now_;
  ForceGuard guard_, torque_guard_;
  void guardTorque() noexcept;
  WorkspaceMap map_;
  DeviceSample sample_;
  HandFrame hand_;  // of the last read()
  std::int64_t hand_came_ = 0;
  std::int64_t wrote_ = 0;  // deviceClock() of the last write(); 0: none yet
  ArmFelt felt_now_;
  TimeHistogram ages_now_;
  std::uint64_t test_ = 0;  // the number of the one under way
  double test_left_ = 0;    // s
  Vec3d test_force_ = Vec3d::Zero();
  bool has_met_ = false, is_clutched_ = false, is_armed_ = false;
};

}  // namespace kerf
