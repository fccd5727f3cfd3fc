#include "ui/window/gamepad.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace kerf {

std::optional<GamepadState> readGamepad() {
  GLFWgamepadstate state;
  for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
    if (!glfwJoystickIsGamepad(id) || !glfwGetGamepadState(id, &state)) continue;
    const auto axis = [&](int n) { return static_cast<double>(state.axes[n]); };
    const auto trigger = [&](int n) { return 0.5 * (1 + axis(n)); };
    GamepadState out;
    out.left_stick = {axis(GLFW_GAMEPAD_AXIS_LEFT_X), axis(GLFW_GAMEPAD_AXIS_LEFT_Y)};
    out.right_stick = {axis(GLFW_GAMEPAD_AXIS_RIGHT_X), axis(GLFW_GAMEPAD_AXIS_RIGHT_Y)};
    out.left_trigger = trigger(GLFW_GAMEPAD_AXIS_LEFT_TRIGGER);
    out.right_trigger = trigger(GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER);
    out.a = state.buttons[GLFW_GAMEPAD_BUTTON_A] == GLFW_PRESS;
    out.left_bumper = state.buttons[GLFW_GAMEPAD_BUTTON_LEFT_BUMPER] == GLFW_PRESS;
    out.right_bumper = state.buttons[GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER] == GLFW_PRESS;
    return out;
  }
  return {};
}

std::optional<PadId> gamepadId() {
  for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
    if (!glfwJoystickIsGamepad(id)) continue;
    const char* const guid = glfwGetJoystickGUID(id);
    return guid ? padIdOf(guid) : std::nullopt;
  }
  return {};
}

std::string gamepadName() {
  for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
    if (!glfwJoystickIsGamepad(id)) continue;
    const char* const name = glfwGetGamepadName(id);
    return name ? name : "";
  }
  return {};
}

}  // namespace kerf
