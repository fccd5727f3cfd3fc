#include "ui/window/panels/device_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/workbench/force_device.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kWidth = 330, kBox = 140;  // window units

void say(AppContext& context, const Expected<void>& done) {
  if (!done) context.bench.notices->complain(done.error());
}
void command(AppContext& context, const char* id) { say(context, runAppCommand(context, id)); }

void wrapped(const ImVec4& colour, const std::string& text) {
  ImGui::PushTextWrapPos(0);
  ui::textColored(colour, text);
  ImGui::PopTextWrapPos();
}

void line(const char* name, const std::string& value, const ImVec4* colour = nullptr) {
  ui::textColored(styleColours().quiet, name);
  ui::sameLineAt(scaled(112));
  colour ? ui::textColored(*colour, value) : ui::text(value);
}

// A share of -1 to 1 as a bar from the middle.
void axisBar(const char* name, double share) {
  ui::textColored(styleColours().quiet, name);
  ui::sameLineAt(scaled(60));
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x - scaled(48), height = ImGui::GetTextLineHeight();
  const float middle = at.x + 0.5f * width,
              end = middle + 0.5f * width * static_cast<float>(std::clamp(share, -1., 1.));
  ImDrawList* const draw = ImGui::GetWindowDrawList();
  draw->AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), 3);
  draw->AddRectFilled({std::min(middle, end), at.y + 2}, {std::max(middle, end), at.y + height - 2},
                      ImGui::GetColorU32(styleColours().accent), 2);
  ImGui::Dummy({width, height});
  ImGui::SameLine();
  ui::text(shownNumbers("{:+.2f}", share));
}

void drawButtons(std::uint64_t down, std::initializer_list<const char*> names) {
  int n = 0;
  for (const char* const name : names) {
    if (n > 0) ImGui::SameLine();
    const bool is_down = down >> n & 1;
    const std::string mark = is_down ? "[x] " : "[ ] ";
    ui::textColored(is_down ? styleColours().accent : styleColours().quiet, ui::asItIs(mark + shownText(name)));
    ++n;
  }
}

// ---- The places reached by the hand, from above and from the side, and its force

struct Side {
  const char* name;
  int across, up;
};

void drawReach(const ArmView& view, const Side& side) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float size = scaled(kBox);
  ImDrawList* const draw = ImGui::GetWindowDrawList();
  draw->AddRectFilled(at, {at.x + size, at.y + size}, ImGui::GetColorU32(ImGuiCol_FrameBg), 4);

  const Vec3d hand = view.hand.pose.translation;
  Box3 box = view.reached;
  if (view.is_there) box.add(hand);
  if (!box.isEmpty()) {
    constexpr double kLeast = 20;  // mm: a hand at rest does not fill the picture
    const double reach = std::max({box.size()[side.across], box.size()[side.up], kLeast}) * 1.15;
    const Vec3d middle = box.center();
    const auto pixel = [&](const Vec3d& p) {
      return ImVec2(at.x + size * static_cast<float>(0.5 + (p[side.across] - middle[side.across]) / reach),
                    at.y + size * static_cast<float>(0.5 - (p[side.up] - middle[side.up]) / reach));
    };
    const ImVec2 low = pixel(box.min), high = pixel(box.max);
    draw->AddRect({low.x, high.y}, {high.x, low.y}, ImGui::GetColorU32(styleColours().quiet));
    if (view.is_there) {
      const ImVec2 here = pixel(hand);
      const double most = std::max(view.most_force, 0.1);
      const float long_way = 0.4f * size;
      const ImVec2 tip(here.x + long_way * static_cast<float>(view.felt.force[side.across] / most),
                       here.y - long_way * static_cast<float>(view.felt.force[side.up] / most));
      if (view.felt.force.norm() > 1e-3) draw->AddLine(here, tip, ImGui::GetColorU32(styleColours().warning), 2);
      draw->AddCircleFilled(here, scaled(4), ImGui::GetColorU32(styleColours().accent));
    }
  }
  ui::addText(*draw, {at.x + 4, at.y + 2}, ImGui::GetColorU32(styleColours().quiet), side.name);
  ImGui::Dummy({size, size});
}

// ---- The arm

void drawState(const ArmView& view) {
  const StyleColours& colours = styleColours();
  if (!view.is_there)
    line("State", "no data: no force", &colours.warning);
  else if (!view.is_leading)
    line("State", "ready");
  else if (!view.is_armed)
    line("State", "controls tool, not armed");
  else
    line("State", "controls tool, ARMED", &colours.good);
  if (!view.missing.empty()) wrapped(colours.warning, view.missing);
}

void drawHand(const ArmView& view) {
  const Vec3d& p = view.hand.pose.translation;
  line("Hand", shownNumbers("{:+7.1f} {:+7.1f} {:+7.1f} mm", p[0], p[1], p[2]));
  drawReach(view, {"from above", 0, 1});
  ImGui::SameLine();
  drawReach(view, {"from the front", 0, 2});
  const Vec3d size = view.reached.isEmpty() ? Vec3d(Vec3d::Zero()) : view.reached.size();
  line("Range used", shownNumbers("{:.0f} x {:.0f} x {:.0f} mm", size[0], size[1], size[2]));
  line("in the scene",
       shownNumbers("{:.0f} x {:.0f} x {:.0f} mm", view.scale * size[0], view.scale * size[1], view.scale * size[2]));
  drawButtons(view.hand.buttons, {"pedal", "clutch", "3", "4"});
}

void drawSafety(const ArmView& view) {
  const StyleColours& colours = styleColours();
  const float share = static_cast<float>(view.felt.force.norm() / std::max(view.most_force, 0.01));
  ui::progressBar(view.is_leading ? share : 0, {-1, 0},
                  phrase("{:.2f} of max. {:.2g} N", view.felt.force.norm(), view.most_force));
  line("Fade-in", shownNumbers("{:.0f} %", 100 * view.felt.ramp));
  if (view.felt.has_fault)
    line("Limits", "invalid force: OFF", &colours.warning);
  else
    line("Limits", view.felt.is_clamped ? "limiting the force" : "no limit active",
         view.felt.is_clamped ? &colours.warning : nullptr);
  const bool is_old = view.felt.age_ms > 1000 * ForceArm::kDeadMan;
  line("Data age", shownNumbers("{:.1f} ms", view.felt.age_ms), is_old ? &colours.warning : nullptr);
  line("p50 p99 p99.9", shownNumbers("{:.2f}  {:.2f}  {:.2f} ms", view.age_p50_ms, view.age_p99_ms, view.age_p999_ms));
  line("Frames", phrase("{} received, {} rejected", view.counts.hands, view.counts.refused));
}

void drawArming(AppContext& context, const ArmView& view) {
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  if (view.is_armed) {
    if (strongButton("Disarm", "F8", half)) command(context, "device.disarm");
  } else if (strongButton("Arm", "", half)) {
    command(context, "device.arm");
  }
  ImGui::SameLine();
  if (plainButton("Test: 0.5 N up", "", half)) command(context, "device.test");
  if (plainButton("Fit session", "", half)) command(context, "device.fit");
}

void drawChoices(AppContext& context) {
  ArmLead& arm = context.bench.device->arm();
  ArmChoice choice = arm.choice();
  bool is_set = false;
  const auto slider = [&](const char* id, double& value, double low, double high, const char* text) {
    float now = static_cast<float>(value);
    ImGui::SetNextItemWidth(-1);
    if (!ui::sliderFloat(id, &now, static_cast<float>(low), static_cast<float>(high), text,
                         ImGuiSliderFlags_AlwaysClamp))
      return;
    value = static_cast<double>(now);
    is_set = true;
  };
  constexpr double kHighForce = 8, kHighScale = 2;  // farther: by command
  slider("##most", choice.most_force, ArmChoice::kLeastForce, std::max(kHighForce, choice.most_force),
         "force limit %.1f N");
  slider("##scale", choice.scale, ArmChoice::kLeastScale, std::max(kHighScale, choice.scale), "1 mm of hand = %.2f mm");
  slider("##turn", choice.turn_deg, -180, 180, "turned by %.0f deg");
  is_set |= ui::checkbox("Run drive without pedal", &choice.pedal_is_down);
  if (is_set) arm.choose(choice);
}

void drawArm(AppContext& context) {
  const ArmView view = context.bench.device->arm().view();
  heading("Force-feedback device");
  if (view.what.empty()) {
    wrapped(styleColours().quiet,
            "No device is open. A bridge is a small driver program for your device. To try one, start "
            "kerf-bridge-simulated.");
    if (plainButton("Wait for a bridge", "", -1))
      say(context, runAppCommand(context, "device.open", std::vector<std::string>{"bridge"}));
    return;
  }
  ui::text(ui::asItIs(view.what));
  drawState(view);
  drawHand(view);
  heading("Force");
  drawSafety(view);
  drawArming(context, view);
  heading("Motion mapping");
  drawChoices(context);
}

void drawKnob(const DevicePanelState& state) {
  heading("SpaceMouse");
  if (!state.knob) {
    wrapped(state.knob_trouble.empty() ? styleColours().quiet : styleColours().warning,
            state.knob_trouble.empty() ? "No SpaceMouse is plugged in." : state.knob_trouble);
    return;
  }
  ui::text(ui::asItIs(state.knob_name));
  constexpr const char* kNames[] = {"right", "away", "up", "pitch", "roll", "yaw"};
  for (std::size_t n = 0; n < 6; ++n) axisBar(kNames[n], state.knob->axes[n]);
  drawButtons(state.knob->buttons, {"tool/view", "undo"});
  if (state.knob_battery) line("Battery", textOf(*state.knob_battery));
}

// ---- Gamepad or joystick

// A share of 0 to 1.
void triggerBar(const char* name, double share) {
  ui::textColored(styleColours().quiet, name);
  ui::sameLineAt(scaled(112));
  ui::progressBar(static_cast<float>(std::clamp(share, 0., 1.)), {-1, 0});
}

void drawPad(const DevicePanelState& state) {
  heading(state.is_joystick ? "Joystick" : "Gamepad");
  if (!state.pad) {
    wrapped(styleColours().quiet, "No gamepad or joystick is plugged in.");
    return;
  }
  const GamepadState& pad = *state.pad;
  ui::text(ui::asItIs(state.pad_name));
  axisBar("tool x", pad.left_stick[0]);
  axisBar("tool y", -pad.left_stick[1]);
  axisBar("view x", pad.right_stick[0]);
  axisBar("view y", -pad.right_stick[1]);
  triggerBar(state.is_joystick ? "Button 1: drill" : "Right: drill", pad.right_trigger);
  if (!state.is_joystick) triggerBar("Left: slow", pad.left_trigger);
  const std::uint64_t down = (pad.a ? 1U : 0U) | (pad.left_bumper ? 2U : 0U) | (pad.right_bumper ? 4U : 0U);
  drawButtons(down, {"undo", "previous tool", "next tool"});
  if (!state.is_joystick)
    wrapped(styleColours().quiet,
            state.can_pad_shake ? "Vibrates while drilling." : "No vibration: its driver has no rumble.");
}

}  // namespace

void drawDevicePanel(AppContext& context, const DevicePanelState& state) {
  if (!context.panels["device"]) return;
  const FrameArea free = frameLayout(context).free;
  ImGui::SetNextWindowPos({free.right - scaled(8), free.top + scaled(8)}, ImGuiCond_Appearing, {1, 0});
  ImGui::SetNextWindowSize({scaled(kWidth), 0}, ImGuiCond_Always);
  ImGui::SetNextWindowSizeConstraints({0, 0}, {scaled(kWidth), free.height() - scaled(16)});
  ImGui::SetNextWindowBgAlpha(1);  // covers other panels
  ui::begin("Devices", &context.panels["device"], ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse);
  drawArm(context);
  drawKnob(state);
  drawPad(state);
  ImGui::End();
}

}  // namespace kerf
