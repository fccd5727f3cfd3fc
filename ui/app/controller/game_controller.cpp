#include "ui/app/controller/game_controller.h"

#include <SDL2/SDL.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/hand/space_mouse_link.h"

namespace kerf {
namespace {

constexpr double kFullAxis = 32767;
constexpr int kFirstTwist = 2;  // after the axes of the stick

double stickShare(int value) { return std::clamp(value / kFullAxis, -1.0, 1.0); }

Uint16 motorOf(double share) { return static_cast<Uint16>(std::lround(65535 * std::clamp(share, 0.0, 1.0))); }

// Gamepads first, then joysticks. SDL lists a SpaceMouse as a joystick.
std::vector<int> candidates() {
  std::vector<int> pads, joysticks;
  for (int n = 0; n < SDL_NumJoysticks(); ++n) {
    if (SDL_IsGameController(n))
      pads.push_back(n);
    else if (!isSpaceMouse(SDL_JoystickGetDeviceVendor(n), SDL_JoystickGetDeviceProduct(n)))
      joysticks.push_back(n);
  }
  pads.insert(pads.end(), joysticks.begin(), joysticks.end());
  return pads;
}

}  // namespace

struct GameController::State {
  State();
  ~State();
  void choose();
  void open(int index);
  void close();
  GamepadState readPad() const;
  GamepadState readStick() const;

  bool has_sdl = false;
  int listed = 0;  // devices at the last choice
  SDL_GameController* pad = nullptr;
  SDL_Joystick* device = nullptr;  // of `pad` too; null: none is open
  int twist = -1;                  // axis of a joystick; negative: it has none
  std::string name, told_name, trouble;
};

GameController::State::State() {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
  SDL_SetHint(SDL_HINT_JOYSTICK_HIDAPI, "0");
  has_sdl = SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) == 0;
  if (!has_sdl) {
    trouble = phrase("Cannot read gamepads: {}", SDL_GetError());
    return;
  }
  // Kerf polls states, so no events fill SDL's queue.
  SDL_JoystickEventState(SDL_IGNORE);
  SDL_GameControllerEventState(SDL_IGNORE);
}

GameController::State::~State() {
  close();
  if (has_sdl) SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
}

void GameController::State::choose() {
  const bool is_attached = device && SDL_JoystickGetAttached(device) == SDL_TRUE;
  const int count = SDL_NumJoysticks();
  if (std::exchange(listed, count) == count && (is_attached || !device)) return;
  const std::vector<int> choices = candidates();
  if (is_attached && !choices.empty() &&
      SDL_JoystickGetDeviceInstanceID(choices.front()) == SDL_JoystickInstanceID(device))
    return;
  close();
  for (const int index : choices) {
    open(index);
    if (device) return;
    const char* const called = SDL_JoystickNameForIndex(index);
    trouble = std::string(called ? called : "A gamepad") + " cannot be opened: " + SDL_GetError() +
              ". Check the rights of /dev/input, then plug it in again";
  }
}

void GameController::State::open(int index) {
  if (SDL_IsGameController(index)) {
    pad = SDL_GameControllerOpen(index);
    device = pad ? SDL_GameControllerGetJoystick(pad) : nullptr;
  } else {
    device = SDL_JoystickOpen(index);
  }
  if (!device) return;
  const char* const called = SDL_JoystickName(device);
  name = called && *called ? called : pad ? "gamepad" : "joystick";
  for (int axis = kFirstTwist; !pad && twist < 0 && axis < SDL_JoystickNumAxes(device); ++axis)
    if (std::abs(stickShare(SDL_JoystickGetAxis(device, axis))) <= GamepadLimits::kStickRest) twist = axis;
}

void GameController::State::close() {
  if (pad)
    SDL_GameControllerClose(pad);
  else if (device)
    SDL_JoystickClose(device);
  pad = nullptr;
  device = nullptr;
  twist = -1;
  name.clear();
}

GamepadState GameController::State::readPad() const {
  const auto axis = [&](SDL_GameControllerAxis which) { return stickShare(SDL_GameControllerGetAxis(pad, which)); };
  const auto isDown = [&](SDL_GameControllerButton which) { return SDL_GameControllerGetButton(pad, which) != 0; };
  GamepadState out;
  out.left_stick = {axis(SDL_CONTROLLER_AXIS_LEFTX), axis(SDL_CONTROLLER_AXIS_LEFTY)};
  out.right_stick = {axis(SDL_CONTROLLER_AXIS_RIGHTX), axis(SDL_CONTROLLER_AXIS_RIGHTY)};
  out.left_trigger = axis(SDL_CONTROLLER_AXIS_TRIGGERLEFT);
  out.right_trigger = axis(SDL_CONTROLLER_AXIS_TRIGGERRIGHT);
  out.a = isDown(SDL_CONTROLLER_BUTTON_A);
  out.left_bumper = isDown(SDL_CONTROLLER_BUTTON_LEFTSHOULDER);
  out.right_bumper = isDown(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER);
  return out;
}

GamepadState GameController::State::readStick() const {
  const auto axis = [&](int which) { return stickShare(SDL_JoystickGetAxis(device, which)); };
  const auto isDown = [&](int which) { return SDL_JoystickGetButton(device, which) != 0; };
  const int hat = SDL_JoystickGetHat(device, 0);
  const auto share = [&](int plus, int minus) { return (hat & plus ? 1.0 : 0.0) - (hat & minus ? 1.0 : 0.0); };
  GamepadState out;
  out.left_stick = {axis(0), axis(1)};
  out.right_stick = {(twist < 0 ? 0 : axis(twist)) + share(SDL_HAT_RIGHT, SDL_HAT_LEFT),
                     share(SDL_HAT_DOWN, SDL_HAT_UP)};
  out.right_trigger = isDown(0) ? 1 : 0;
  out.a = isDown(1);
  out.left_bumper = isDown(2);
  out.right_bumper = isDown(3);
  return out;
}

GameController::GameController() : state_(std::make_unique<State>()) {}
GameController::~GameController() = default;

std::optional<GamepadState> GameController::read() {
  State& s = *state_;
  if (!s.has_sdl) return {};
  SDL_JoystickUpdate();
  s.choose();
  if (!s.device) return {};
  return s.pad ? s.readPad() : s.readStick();
}

std::optional<std::string> GameController::news() {
  State& s = *state_;
  if (!s.trouble.empty()) return std::exchange(s.trouble, {});
  const std::string before = std::exchange(s.told_name, s.name);
  if (s.name == before) return {};
  return s.name.empty() ? phrase("{} was unplugged", before) : phrase("{} is ready", s.name);
}

const std::string& GameController::name() const noexcept { return state_->name; }
bool GameController::isJoystick() const noexcept { return state_->device && !state_->pad; }
bool GameController::canShake() const noexcept {
  return state_->pad && SDL_GameControllerHasRumble(state_->pad) == SDL_TRUE;
}

void GameController::shake(const Rumble& wanted) {
  if (!canShake()) return;
  SDL_GameControllerRumble(state_->pad, motorOf(wanted.strong), motorOf(wanted.weak),
                           static_cast<Uint32>(1000 * kShakeSeconds));
}

}  // namespace kerf
