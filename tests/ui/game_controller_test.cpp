// The window's gamepad or joystick, on devices simulated by SDL.
#include "ui/app/controller/game_controller.h"

#include <SDL2/SDL.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace kerf::game_controller_test {
namespace {

// Last rumble command of a simulated gamepad.
struct Motors {
  int strong = -1, weak = -1, words = 0;
};
int onRumble(void* user, Uint16 strong, Uint16 weak) {
  auto& motors = *static_cast<Motors*>(user);
  motors = {strong, weak, motors.words + 1};
  return 0;
}

// A device simulated by SDL, plugged in for its lifetime.
class Simulated {
 public:
  Simulated(SDL_JoystickType type, const char* name, int axes, int buttons, int hats, Motors* motors = nullptr,
            Uint16 vendor = 0, Uint16 product = 0) {
    SDL_VirtualJoystickDesc what{};
    what.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
    what.type = static_cast<Uint16>(type);
    what.naxes = static_cast<Uint16>(axes);
    what.nbuttons = static_cast<Uint16>(buttons);
    what.nhats = static_cast<Uint16>(hats);
    what.vendor_id = vendor;
    what.product_id = product;
    what.name = name;
    what.userdata = motors;
    if (motors) what.Rumble = onRumble;
    const int index = SDL_JoystickAttachVirtualEx(&what);
    EXPECT_GE(index, 0) << SDL_GetError();
    device_ = SDL_JoystickOpen(index);
    id_ = SDL_JoystickInstanceID(device_);
  }
  ~Simulated() { unplug(); }
  void unplug() {
    if (!device_) return;
    for (int n = 0; n < SDL_NumJoysticks(); ++n)
      if (SDL_JoystickGetDeviceInstanceID(n) == id_) SDL_JoystickDetachVirtual(n);
    SDL_JoystickClose(device_);
    device_ = nullptr;
  }
  void axis(int n, double share) { SDL_JoystickSetVirtualAxis(device_, n, static_cast<Sint16>(32767 * share)); }
  void button(int n, bool is_down) { SDL_JoystickSetVirtualButton(device_, n, is_down ? 1 : 0); }
  void hat(Uint8 value) { SDL_JoystickSetVirtualHat(device_, 0, value); }

 private:
  SDL_Joystick* device_ = nullptr;
  SDL_JoystickID id_ = -1;
};

constexpr SDL_JoystickType kPad = SDL_JOYSTICK_TYPE_GAMECONTROLLER, kStick = SDL_JOYSTICK_TYPE_FLIGHT_STICK;

TEST(GameController, AGamepadIsFoundReadAndLost) {
  GameController controller;
  if (controller.read()) GTEST_SKIP() << "a device is plugged in: " << controller.name();
  EXPECT_EQ(controller.news(), std::nullopt);

  Simulated pad(kPad, "Pad", 6, 15, 0);
  ASSERT_TRUE(controller.read());
  EXPECT_EQ(controller.news(), "Pad is ready");
  EXPECT_EQ(controller.news(), std::nullopt) << "once";
  EXPECT_FALSE(controller.isJoystick());
  EXPECT_FALSE(controller.canShake()) << "it has no motors";
  controller.shake({1, 1});

  pad.axis(SDL_CONTROLLER_AXIS_LEFTX, 1);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, -1);
  pad.axis(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 1);
  pad.button(SDL_CONTROLLER_BUTTON_A, true);
  pad.button(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER, true);
  (void)controller.read();
  const GamepadState now = *controller.read();
  EXPECT_EQ(now.left_stick, Eigen::Vector2d(1, -1)) << "down is +";
  EXPECT_EQ(now.right_trigger, 1);
  EXPECT_TRUE(now.a && now.right_bumper);
  EXPECT_FALSE(now.left_bumper);

  pad.unplug();
  EXPECT_FALSE(controller.read());
  EXPECT_EQ(controller.news(), "Pad was unplugged");
  const Simulated again(kPad, "Other pad", 6, 15, 0);
  EXPECT_TRUE(controller.read());
  EXPECT_EQ(controller.name(), "Other pad");
}

TEST(GameController, ShakesUntilItIsToldOtherwiseOrTheTimeIsOver) {
  GameController controller;
  if (controller.read()) GTEST_SKIP() << "a device is plugged in: " << controller.name();
  Motors motors;
  const Simulated pad(kPad, "Pad", 6, 15, 0, &motors);
  (void)controller.read();
  ASSERT_TRUE(controller.canShake());
  controller.shake({0.5, 1});
  EXPECT_NEAR(motors.strong, 32768, 1);
  EXPECT_EQ(motors.weak, 65535);
  controller.shake({});
  EXPECT_EQ(motors.strong, 0);
  EXPECT_EQ(motors.weak, 0);

  controller.shake({1, 0});
  EXPECT_EQ(motors.strong, 65535);
  const auto began = std::chrono::steady_clock::now();
  while (motors.strong != 0 && std::chrono::steady_clock::now() - began < std::chrono::seconds(20)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    (void)controller.read();
  }
  EXPECT_EQ(motors.strong, 0) << "by the end of its time";
  const int words = motors.words;
  for (int n = 0; n < 10; ++n) controller.shake({});
  EXPECT_EQ(motors.words, words) << "SDL sends a change alone";
}

TEST(GameController, AJoystickLeadsAsAGamepadDoesUntilThereIsOne) {
  GameController controller;
  if (controller.read()) GTEST_SKIP() << "a device is plugged in: " << controller.name();
  Motors motors;
  Simulated stick(kStick, "Stick", 4, 6, 1, &motors);
  ASSERT_TRUE(controller.read());
  EXPECT_TRUE(controller.isJoystick());
  EXPECT_EQ(controller.news(), "Stick is ready");
  stick.axis(0, 1);
  stick.axis(1, -1);
  stick.axis(2, 1);
  stick.hat(SDL_HAT_DOWN);
  for (const int n : {0, 1, 3}) stick.button(n, true);
  (void)controller.read();
  const GamepadState now = *controller.read();
  EXPECT_EQ(now.left_stick, Eigen::Vector2d(1, -1));
  EXPECT_EQ(now.right_stick, Eigen::Vector2d(1, 1)) << "twist, and the hat downwards";
  EXPECT_EQ(now.right_trigger, 1);
  EXPECT_EQ(now.left_trigger, 0);
  EXPECT_TRUE(now.a && now.right_bumper);
  EXPECT_FALSE(now.left_bumper);
  controller.shake({1, 1});
  EXPECT_EQ(motors.words, 0) << "its motors may be strong";

  Simulated pad(kPad, "Pad", 6, 15, 0);
  (void)controller.read();
  EXPECT_EQ(controller.name(), "Pad");
  pad.unplug();
  (void)controller.read();
  EXPECT_EQ(controller.name(), "Stick");
}

TEST(GameController, ASpaceMouseIsNoJoystick) {
  GameController controller;
  if (controller.read()) GTEST_SKIP() << "a device is plugged in: " << controller.name();
  const Simulated knob(SDL_JOYSTICK_TYPE_UNKNOWN, "SpaceNavigator", 6, 2, 0, nullptr, 0x046d, 0xc626);
  EXPECT_FALSE(controller.read());
}

}  // namespace
}  // namespace kerf::game_controller_test
