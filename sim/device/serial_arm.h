// A WoodenHaptics arm on a serial port (USB CDC): lines of text, one each way a millisecond. Never tried on hardware.
//
//   to the arm     [mA,mA,mA]\n                           currents of its motors
//   from the arm   [model,e0,e1,e2,e3,e4,e5,error]\n      one for each line it is sent; model 3: WoodenHaptics
//
// Its firmware switches the motors off after 100 ms without a line: a guard sends zero at once when Kerf is killed. Its
// encoders count from where it was switched on: calibrate() takes the place where it stands for its home. Only opened
// by its path: nothing looks for it. What is done with a hand and a force: force_arm.h.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "sim/device/force_arm.h"
#include "sim/hand/device_profile.h"

namespace kerf {

inline constexpr DeviceProfile kSerialProfile{.delay_s = 0.002, .mass_kg = 0.15, .friction = 0.1, .encoder_mm = 0.05};

struct SerialLine {
  int model = 0;
  std::array<int, 6> counts{};
  int error = 0;
};
/// Strict: without the end of the line; numbers of at most 9 digits; nothing before, between or behind. False: it is
/// none, and `out` is as it was.
bool parseSerialLine(std::string_view line, SerialLine& out) noexcept;
inline constexpr int kSerialWoody = 3;  ///< the model whose kinematics are known
/// What a line of kSerialWoody says, but for number and time. Its counts are from its home pose: as they are where it
/// was switched on there.   @param jacobian  mm per radian of each motor.
void takeSerialLine(const SerialLine& line, HandFrame& hand, Eigen::Matrix3d& jacobian) noexcept;
/// "[12,-3,0]\n", into `out`.   @return  how many bytes.
std::size_t writeSerialLine(const Vec3d& milliamperes, std::span<char, 64> out) noexcept;

class SerialArm final : public ForceArm {
 public:
  /// Errors: kNotFound, kUnreadable: it does not open, with what to do; kBadValue: no serial port; those of
  /// ZeroGuard::start().
  static Expected<std::unique_ptr<SerialArm>> open(const std::string& path, const ArmSettings& settings,
                                                   const Rigid3& start = {}, ArmListener listener = {});
  /// Writes zero.
  ~SerialArm() override;

  std::string what() const override;
  ArmCounts counts() const override;
  bool calibrate() override;
  bool isGone() const override;

 private:
  struct State;
  SerialArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
