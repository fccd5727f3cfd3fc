// Force feedback by the USB class of physical interface devices (PID 1.0): joysticks and wheels. EXPERIMENTAL: never
// tried on hardware. Two axes at most, forces in shares of what the device can, and Linux's own driver may own it, too.
//
//   descriptor ──▶ PidReports   which report says what, and where; devices differ
//   PidDevice:  reset, stop all, actuators on ─▶ create and load an effect each ─▶ start; then updates,
//               and starts anew; at the end stop all, free each, actuators off
//
// A guard (zero_guard.h) stops all effects when Kerf is killed, or ends and the device does not take its stop. And an
// effect lasts PidReports::kLasts and is started again long before: a device whose Kerf was stopped ends it by itself.
// One whose effects have no duration goes on; stopsByItself() tells.
//
// PidReports: functions of their arguments alone. PidDevice: a thread that writes, at most 250 updates a second.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/device/hid_descriptor.h"
#include "sim/device/hid_port.h"

namespace kerf {

enum class PidEffect : std::uint16_t { kConstant = 0x26, kSine = 0x31, kDamper = 0x41 };
enum class PidControl : std::uint16_t { kEnable = 0x97, kDisable = 0x98, kStopAll = 0x99, kReset = 0x9A };
enum class PidOperation : std::uint16_t { kStart = 0x79, kStop = 0x7B };

/// What a pool says when an effect is to be loaded.
struct PidLoad {
  std::uint8_t block = 0;  ///< its number; 0: none
  enum class Status { kNone, kSuccess, kFull, kError } status = Status::kNone;
};

class PidReports {
 public:
  using Report = std::vector<std::uint8_t>;  ///< its number first
  static constexpr double kLasts = 0.1;      ///< s that an effect goes on after its last start

  /// Error kUnsupported: it has no force feedback, or none that can be used, with what is missing.
  static Expected<PidReports> of(HidLayout layout);

  bool has(PidEffect effect) const;
  /// Its effects end by themselves.
  bool hasDuration() const;
  Report control(PidControl what) const;
  std::optional<Report> gain(double share) const;  ///< none: it has none
  Report create(PidEffect effect) const;           ///< a feature
  Report askLoad() const;                          ///< a feature to be filled
  PidLoad loadOf(std::span<const std::uint8_t> report) const;
  /// Of kLasts, at full gain, started by nothing but its start.   @param angle  that it acts along: 0 right, pi/2 away.
  Report set(PidEffect effect, std::uint8_t block, double angle) const;
  Report constant(std::uint8_t block, double share) const;            ///< 0 to 1
  Report damper(std::uint8_t block, double share, int axis) const;    ///< 0 to 1; axis 0 or 1
  Report sine(std::uint8_t block, double share, double hertz) const;  ///< 0 to 1
  Report operate(std::uint8_t block, PidOperation what) const;
  Report free(std::uint8_t block) const;

 private:
  struct Slot {
    const HidField* field = nullptr;  // null: it has none
    std::uint32_t n = 0;
  };
  explicit PidReports(HidLayout layout) : layout_(std::move(layout)) {}
  Slot find(HidReportKind kind, std::uint16_t within, HidUsage usage) const;
  const HidField* choice(HidReportKind kind, std::uint16_t within, std::uint16_t of) const;
  std::int64_t unitsOf(const HidField& field, double seconds) const;
  std::optional<std::uint8_t> numberOf(HidReportKind kind, std::uint16_t within) const;
  Report begin(HidReportKind kind, std::uint16_t within) const;
  void put(Report& report, HidReportKind kind, std::uint16_t within, std::uint16_t usage, std::int64_t value) const;
  void putShare(Report& report, std::uint16_t within, std::uint16_t usage, double share) const;
  void choose(Report& report, HidReportKind kind, std::uint16_t within, std::uint16_t of, std::uint16_t usage) const;

  HidLayout layout_;
};

/// It has force feedback of the class PID that can be used. Reads its descriptor: some ms.
bool hasForceFeedback(const HidInfo& info);

struct PidWish {
  double right = 0, away = 0;  ///< -1 to 1 of its force
  double damping = 0;          ///< 0 to 1
  double shake = 0;            ///< 0 to 1
  double shake_hz = 60;
  bool operator==(const PidWish&) const = default;
};

class PidDevice {
 public:
  static constexpr double kStale = 0.1;         ///< s: then no force
  static constexpr double kStartAgain = 0.025;  ///< s: three starts may be lost before an effect ends

  /// Errors: kUnsupported; kUnreadable: its pool gives no effect; those of HidPort::open() and ZeroGuard::start().
  static Expected<std::unique_ptr<PidDevice>> open(const HidInfo& info);
  /// Stops and frees all.
  ~PidDevice();
  PidDevice(const PidDevice&) = delete;
  PidDevice& operator=(const PidDevice&) = delete;

  /// Which effects it has.
  bool has(PidEffect effect) const noexcept;
  /// Its effects end by themselves, within PidReports::kLasts, when nothing is written any more.
  bool stopsByItself() const noexcept;
  /// The newest wish, to be repeated. Any one thread. Never waits.
  void set(const PidWish& wish) noexcept;
  bool isConnected() const noexcept;
  /// False: its guard has ended, and it is given no force any more. Any thread.
  bool isGuarded() const noexcept;

 private:
  struct State;
  explicit PidDevice(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
