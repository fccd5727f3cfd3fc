// A force-feedback arm as the device of the haptic thread, over any transport: a bridge, HID, a recording.
//
//   transport ──newest hand──▶ ┌──────────┐ ──sample──▶ haptic thread
//   transport ◀─newest wish─── │ ForceArm │ ◀──force─── haptic thread
//      window ──settings─────▶ └──────────┘ ──ArmFelt─▶ window
//
// The transport has a thread of its own, which is the only one that waits for the device. All arrows are latest-value
// mailboxes: a late force is worse than a lost one.
//
// Force reaches the device only if all of it holds: enable(true) was called; the haptic thread runs (arm()); the newest
// hand is less than kDeadMan old and says that it is ready (switched on, calibrated); the haptic thread wrote less than
// kDeadMan ago; no force was other than finite. When it begins to hold the
// force fades in. When it ends to hold the very next frame says zero. The deadline that a frame carries counts from the
// same news, so a device that keeps it gives no force kDeadMan after them, whichever thread or program has stopped: and
// the way of the frame, which is short unless the transport is stopped between its look at the clock and its call of
// the system.
//
// A torque goes the same way, to a device that says it gives one, with a guard of its own: at most what it says it can.
//
// Buttons: 1 is the pedal; while 2 is held the tool stays where it is and the hand moves on (clutch), without force.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "sim/device/device_frame.h"
#include "sim/device/force_guard.h"
#include "sim/device/workspace_map.h"
#include "sim/hand/device_source.h"
#include "sim/hand/triple_buffer.h"
#include "sim/live/time_histogram.h"

namespace kerf {

/// Told of each message of a device by the transport's thread, before it is taken: a report, a datagram.
using ArmListener = std::function<void(std::int64_t came_ns, std::span<const std::uint8_t> message)>;

/// How the hand is taken, and how hard it may be pushed.
struct ArmSettings {
  ForceLimits limits{};        ///< beside what the device says it can
  WorkspaceMap map{};          ///< turn and scale; the offset is met when the hand first appears
  bool pedal_is_down = false;  ///< without button 1
  double speed = 1;            ///< of the nominal one while the pedal is down, -1 to 1; negative: backwards
  double irrigation = 1;       ///< 0 to 1
};

/// Since it was opened.
struct ArmCounts {
  std::uint64_t hands = 0;          ///< that were taken
  std::uint64_t refused = 0;        ///< malformed; nothing of them is used
  std::string last_fault;           ///< of the last one that was refused: "its length"
  std::uint64_t old = 0;            ///< that came after a newer one
  std::uint64_t others = 0;         ///< from another sender while the first one talks
  std::uint64_t forces = 0;         ///< sent
  bool is_talking = false;          ///< the newest hand is less than kDeadMan old
  bool is_enabled = false;          ///< the last force that was sent said so
  std::int64_t newest_came_ns = 0;  ///< deviceClock(); 0: nothing has come yet
  /// What keeps it from talking, with what to do; empty: nothing is known. "it was unplugged", ...
  std::string trouble;
};

/// What the haptic thread has done with the newest hand.
struct ArmFelt {
  Vec3d force = Vec3d::Zero();   ///< N, device frame, behind all bounds
  Vec3d torque = Vec3d::Zero();  ///< N mm, the same
  double wanted = 0;             ///< N, before them
  double age_ms = 0;             ///< of the hand that it answers
  double ramp = 0;               ///< share of the fading-in, 0 to 1
  bool is_valid = false;         ///< the hand was taken
  bool is_armed = false;         ///< the guard lets force through
  bool is_clamped = false;       ///< the force is bound in size or rate, now
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

  /// The force frame that says what the haptic thread wrote last, as long as that is news; else zero, not enabled. Its
  /// deadline is what is left of kDeadMan since the older news, of hand and haptic thread: however often it is sent,
  /// and however late this thread is, the device gives no force beyond that. For the transport.
  /// @param newest  the hand it answers.   @param now  deviceClock().   @rt safe.
  ForceFrame answer(const Hand& newest, std::int64_t now) noexcept;
};

class ForceArm : public DeviceSource {
 public:
  static constexpr double kDeadMan = 0.02;     ///< s
  static constexpr double kMostTestForce = 1;  ///< N
  static constexpr double kTestSeconds = 1.5;  ///< s of a test force: swells and fades

  /// @param start  of the tool, world: there the hand finds it.
  explicit ForceArm(const ArmSettings& settings, const Rigid3& start = {});

  /// "bridge, port 4417 of this machine".
  virtual std::string what() const = 0;
  /// Any thread.
  virtual ArmCounts counts() const = 0;
  /// It is unplugged and does not come back by itself: open it anew. Any thread.
  virtual bool isGone() const { return false; }
  /// Nothing comes any more, ever: a recording at its end. Any thread.
  virtual bool isOver() const { return false; }
  /// What the device said of itself last. False: nothing yet. Any thread.
  bool lastHand(HandFrame& out) const;

  /// Whether it may give force; at first not. After a force that was not finite: off, then on again. Any thread.
  void enable(bool may_give_force) noexcept { link_.may_give_force.store(may_give_force, std::memory_order_release); }
  bool isEnabled() const noexcept { return link_.may_give_force.load(std::memory_order_acquire); }

  // ---- One thread, the window's

  void set(const ArmSettings& settings) noexcept;
  /// A force along a direction of the device that swells and fades within kTestSeconds, beside what is felt and within
  /// all bounds; at most kMostTestForce, N. Nothing without enable(true).
  void testForce(const Vec3d& force) noexcept;
  /// Fetches what the haptic thread did last; false: nothing new.
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
  /// A hand has come: for the haptic thread and for lastHand(). The transport's thread.
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
