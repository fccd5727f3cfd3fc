#include "ui/window/main/workshop.h"

#include <epoxy/gl.h>
#include <fmt/format.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <functional>
#include <numbers>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "geometry/base/text.h"
#include "ui/app/base/language.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/commands/quit_commands.h"
#include "ui/app/commands/view_commands.h"
#include "ui/app/commands/zoom.h"
#include "ui/app/controller/game_controller.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/app/hand/gamepad_map.h"
#include "ui/app/hand/space_mouse_link.h"
#include "ui/app/hand/stroke_pointer.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/drilling.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/replays.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/app/workbench/tools.h"
#include "ui/sound/alsa_output.h"
#include "ui/sound/sound_thread.h"
#include "ui/window/draw/import_view.h"
#include "ui/window/draw/live_view.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/desktop.h"
#include "ui/window/gl/gl_context.h"
#include "ui/window/gl/key_names.h"
#include "ui/window/gl/theme.h"
#include "ui/window/main/recent_pictures.h"
#include "ui/window/panels/export_panel.h"
#include "ui/window/panels/import_trim.h"
#include "ui/window/panels/panels.h"
#include "ui/window/screens/debrief.h"
#include "ui/window/screens/file_chooser.h"
#include "ui/window/screens/palette.h"
#include "ui/window/screens/quit_question.h"
#include "ui/window/screens/session_end.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kStillAfter = 0.2;  // s without input or cut: then draws the picture once more, smooth
constexpr double kHarder = 2;        // factor of the force, while Shift is down
constexpr double kNotch = 0.1;       // mm of depth a notch of the wheel, during a stroke

// ---- The loop

// Of all that the panels draw in a frame: equal ones draw the same.
std::size_t fingerprintOf(const ImDrawData& data) {
  std::size_t out = 0;
  const auto add = [&out](const auto& items) {
    const std::string_view bytes(reinterpret_cast<const char*>(items.Data),
                                 static_cast<std::size_t>(items.size_in_bytes()));
    out = (out ^ std::hash<std::string_view>{}(bytes)) * 0x100000001b3ull;
  };
  for (int n = 0; n < data.CmdListsCount; ++n) {
    const ImDrawList& list = *data.CmdLists[n];
    add(list.VtxBuffer);
    add(list.IdxBuffer);
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;
      for (const float edge : {clip.x, clip.y, clip.z, clip.w})
        out = (out ^ std::hash<float>{}(edge)) * 0x100000001b3ull;
    }
  }
  return out;
}

class Workshop {
 public:
  explicit Workshop(const WorkshopOptions& options)
      : options_(options),
        bench_(remembering(options.bench)),
        settings_(options.config),
        space_mouse_link_(options.space_mouse) {}

  Expected<int> run() {
    endWhenTold();
    const Settings& kept = settings_.values;
    const bool is_sized = options_.has_size || kept.window_width == 0 || kept.window_height == 0;
    KERF_CHECK(
        desktop_.open(is_sized ? options_.width : kept.window_width, is_sized ? options_.height : kept.window_height));
    KERF_TRY(view, LiveView::create());
    view_ = std::move(view);
    view_->setBeforeClear([this] {
      recent_picture_.take(*view_, bench_, camera_);
      recent_picture_.forget();
    });
    KERF_TRY(import_view, ImportView::create());
    import_view_ = std::move(import_view);
    const std::string driver = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    is_software_ = driver.find("llvmpipe") != driver.npos || driver.find("softpipe") != driver.npos;
    applySettings();
    context_.set_clipboard = [this](const std::string& text) {
      glfwSetClipboardString(desktop_.window(), text.c_str());
    };
    context_.asks_before_quit = true;
    context_.ask_for_file = [this](std::string_view id) { askForFile(*findAppCommand(id)); };
    panels_.ask_for_file = [this](const AppCommand& command) { askForFile(command); };
    if (settings_.error()) bench_.notices->complain(*settings_.error());
    say(showLanguage(settings_.values.language, settings_.path().parent_path()));
    bench_.strokes->setForce(settings_.values.force_N);
    bench_.strokes->depth_mm = settings_.values.depth_mm;
    if (settings_.values.is_perspective)
      setFieldOfView(camera_, settings_.values.perspective_deg * std::numbers::pi / 180);
    files_.setFolder(settings_.values.last_folder);
    if (!options_.replay.empty())
      bench_.replays->open(options_.replay);
    else
      bench_.imports->beginAll(options_.open);

    while (!wants_end_) KERF_CHECK(frame());
    game_controller_.shake({});
    rememberSize();
    const auto ended = endAll(bench_, *view_);
    import_view_.reset();
    view_.reset();
    if (!ended) return fail(ended.error());
    return frames_;
  }

 private:
  static WorkbenchOptions remembering(WorkbenchOptions options) {
    options.keeps_recent = true;
    return options;
  }

  // Unless the command line set it.
  void rememberSize() {
    if (options_.has_size || options_.frames > 0 || window_width_ < 2) return;
    settings_.values.window_width = window_width_;
    settings_.values.window_height = window_height_;
    if (!settings_.error()) say(settings_.save());
  }

  Expected<void> frame() {
    const bool comes_at_once = options_.frames > 0 || desktop_.isBehind() || !enters_.empty();
    comes_at_once ? glfwPollEvents() : glfwWaitEventsTimeout(pause());
    glfwGetWindowSize(desktop_.window(), &window_width_, &window_height_);
    glfwGetFramebufferSize(desktop_.window(), &context_.width, &context_.height);
    if (context_.width == 0 || context_.height == 0 || window_width_ == 0) {  // minimised
      bench_.strokes->release();                                              // no cutting while hidden
      bench_.device->arm().pause(true);
      (void)desktop_.takeEvents();
      (void)game_controller_.read();
      game_controller_.shake({});
      files_.takeAnswer(context_);
      view_->update(bench_);
      printNotices();
      glfwWaitEventsTimeout(0.1);
      endIfAsked();
      if (context_.is_asking_to_quit) glfwRestoreWindow(desktop_.window());
      return {};
    }

    bench_.device->arm().pause(files_.isShown());
    view_->update(bench_);
    printNotices();
    if (ImGui::GetFrameCount() > 0) context_.margins = marginsOf(context_, pixels());
    fitUntilUsed();
    if (bench_.document->isShown() && !bench_.document->scene().bounds().isEmpty())
      recent_picture_.updateBox(*bench_.document);
    updateImport();
    updateSound();
    applySettings();
    desktop_.beginFrame();
    handleInput();
    if (panels_.import.shows_guides) drawImportGuides(context_, pixels());
    drawTrimLine(context_, pixels());
    drawPanels(context_, panels_, over_);
    if (std::exchange(context_.wants_palette, false)) palette_.show();
    if (const AppCommand* const command = drawPalette(context_, palette_)) askForFile(*command);
    files_.update(context_);
    ImGui::Render();

    const bool is_still = secondsSince(last_input_) > kStillAfter && !bench_.strokes->isPressed() &&
                          !bench_.device->isLed() && !bench_.replays->isPlaying();
    KERF_CHECK(show(is_still));
    // Waits until all of the surface is on the graphics card and no hand is at work.
    if (is_still && !view_->isUploading() && recent_picture_.isDue()) recent_picture_.take(*view_, bench_, camera_);
    endIfAsked();
    wants_end_ |= options_.frames > 0 && frames_ >= options_.frames;
    return {};
  }

  // Draws picture and panels, unless the window shows just that already.
  Expected<void> show(bool is_still) {
    const bool is_smooth = is_still && !is_software_, is_importing = bench_.imports->isImporting();
    const LiveView::Edges edges = is_smooth  ? LiveView::Edges::kSmooth
                                  : is_still ? LiveView::Edges::kByAndBy
                                             : LiveView::Edges::kFast;
    const int width = context_.width, height = context_.height;
    const std::size_t panels = fingerprintOf(*ImGui::GetDrawData());
    const bool is_whole = !desktop_.takeDamage() && panels == panels_shown_ && is_importing == is_import_shown_;
    rests_ = options_.frames == 0 && is_whole &&
             (is_importing ? is_still && import_view_->isDrawn(camera_, width, height, is_smooth)
                           : view_->isDrawn(bench_, camera_, width, height, edges));
    if (rests_) return {};

    if (is_importing)
      KERF_CHECK(import_view_->draw(camera_, width, height, is_smooth));
    else
      KERF_CHECK(view_->draw(bench_, camera_, width, height, edges));
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(desktop_.window());
    panels_shown_ = panels;
    is_import_shown_ = is_importing;
    ++frames_;
    return {};
  }

  // Seconds to wait for an event. Pads, knobs and arms send none.
  double pause() const {
    const bool has_device =
        !game_controller_.name().empty() || !space_mouse_link_.name().empty() || bench_.device->arm().isOpen();
    if (!rests_ || has_device) return 1.0 / 60;
    return bench_.jobs->running() ? 0.1 : bench_.document->isShown() ? 0.2 : 0.25;
  }

  // For a terminal, if enabled.
  void printNotices() {
    if (!options_.tells) return;
    for (const auto& notices = bench_.notices->list(); told_ < notices.size(); ++told_)
      printText(stderr, "kerf-sim: {}: {}\n", notices[told_].is_error ? "error" : "note", notices[told_].text);
  }

  // The window's close button asks like the command; a signal does not.
  void endIfAsked() {
    if (glfwWindowShouldClose(desktop_.window())) {
      glfwSetWindowShouldClose(desktop_.window(), GLFW_FALSE);
      say(runAppCommand(context_, "app.quit"));
    }
    wants_end_ = context_.wants_quit || toldToEnd() != 0;
  }

  // From the first session on. Without a device there is no sound, and one notice.
  void updateSound() {
    const Settings& now = settings_.values;
    const double volume = now.is_muted ? 0 : 0.01 * now.sound_volume;
    if (!sound_ && bench_.document->isOpen() && volume > 0) sound_ = std::make_unique<SoundThread>(openAlsa);
    if (!sound_) return;

    DrillSoundInput heard;
    if (bench_.document->isOpen()) {
      const std::size_t n = bench_.tools->inHand();
      heard = drillSoundOf(bench_.document->report(), bench_.tools->at(n),
                           bench_.document->run()->model().tools[n].drive, volume);
    }
    sound_->play(heard);
    if (const auto error = sound_->takeError())
      bench_.notices->say(phrase("No drill sound: no sound device opens. {}", error->found));
  }

  // Theme and scale, if they have changed.
  void applySettings() {
    const Settings& now = settings_.values;
    if (applied_ && applied_->theme == now.theme && applied_->ui_scale == now.ui_scale) return;
    applied_ = now;
    desktop_.restyle(now.theme, static_cast<float>(now.ui_scale));
    const StyleColours& colours = styleColours();
    view_->setBackground(colours.background_middle, colours.background_edge);
    import_view_->setBackground(colours.background_middle, colours.background_edge);
  }

  static double secondsSince(Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  }

  // Pieces of a session arrive one after the other: fits again until the user does something.
  void fitUntilUsed() {
    const Box3 box = bench_.document->scene().bounds();
    if (box.isEmpty()) return;
    if (view_->takeFitWanted()) {
      fitted_at_ = Clock::now();
    } else if (last_input_ > fitted_at_ || (box.min == fitted_.min && box.max == fitted_.max) ||
               !bench_.document->isOpen() || bench_.device->isLed() || bench_.steps->done() > 0) {
      return;
    }
    fitted_ = box;
    fitFirst();
  }

  void fitFirst() {
    camera_before_import_.reset();  // another document is open now
    const auto camera = cameraFromView(options_.view);
    firstView(context_, camera ? *camera : Camera{});
    setTitle(bench_.document->name());
    recent_picture_.opened(*bench_.document);
  }

  // `what` is shown unchanged: a name, or translated words.
  void setTitle(const std::string& what) {
    glfwSetWindowTitle(desktop_.window(), (what.empty() ? "Kerf" : what + " - Kerf").c_str());
  }

  // During an import an open session pauses; its view returns when the import is closed.
  void updateImport() {
    const ImportSet* const set = bench_.imports->set();
    const bool shows_solid = panels_.import.shows_solid && !bench_.imports->drawing.isOn();
    import_view_->update(set ? std::optional(set->picture(shows_solid)) : std::nullopt);
    if (set && !camera_before_import_) camera_before_import_ = camera_;
    if (!set && camera_before_import_) {
      if (!view_->isFitWanted()) {
        camera_ = *camera_before_import_;
        setTitle(bench_.document->isOpen() ? bench_.document->name() : "");
      }
      camera_before_import_.reset();
    }
    if (set && import_view_->takeFitWanted()) {
      viewScan(context_);
      setTitle(phrase("Import {}", set->entries().front().file.filename().string()));
    }
  }

  // ---- Input

  double pixels() const { return static_cast<double>(context_.width) / window_width_; }
  Pixel pointer() const { return pixels() * Pixel(x_, y_); }
  Ray rayAt(double x, double y) const { return rayAtPixel(pixels() * Pixel(x, y)); }
  Ray rayAtPixel(const Pixel& at) const { return rayUnder(camera_, at[0], at[1], context_.width, context_.height); }

  void handleInput() {
    const ImGuiIO& io = ImGui::GetIO();
    if (!enters_.empty() && !desktop_.isBehind()) {
      key(enters_.front(), io.WantTextInput);
      enters_.pop_front();
    }
    for (const InputEvent& e : desktop_.takeEvents()) {
      last_input_ = Clock::now();
      switch (e.kind) {
        case InputEvent::Kind::kDrop:
          bench_.imports->addMore(e.paths);
          break;
        case InputEvent::Kind::kKey:
          // Enter ends a text: in slow frames a part of it still waits for the panels.
          if (isEnter(e) && io.WantTextInput && !palette_.isShown() && (desktop_.isBehind() || !enters_.empty()))
            enters_.push_back(e);
          else
            key(e, io.WantTextInput);
          break;
        case InputEvent::Kind::kCharacter:
          if (palette_.isShown()) palette_.type(e.path);
          break;
        case InputEvent::Kind::kButton:
          button(e, io.WantCaptureMouse);
          break;
        case InputEvent::Kind::kMove:
          move(e);
          break;
        case InputEvent::Kind::kScroll:
          if (!io.WantCaptureMouse) scroll(e.y);
          break;
      }
    }
    takeDevices();
    pressHarder(io.KeyShift && !bench_.strokes->isOnPedal());  // Shift means a larger step there
    panels_.pixels = pixels();
    context_.pointer = io.WantCaptureMouse ? std::nullopt : std::optional(std::array{pointer()[0], pointer()[1]});
    panels_.piece_drag.hover(context_, pointer());
    const bool is_on_handle = panels_.piece_drag.lit().has_value();
    const bool is_picking = bench_.saw->picking.what() != SawPicking::What::kNothing || bench_.drill->isPlanning();
    const bool is_on_panel = io.WantCaptureMouse && !is_led_by_device_;
    const bool hovers = !is_on_panel && held_ == kNone && !is_on_handle && !is_picking &&
                        !bench_.imports->isImporting() && (leftButtonCuts(context_) || is_led_by_device_);
    over_ = hovers ? bench_.strokes->over(rayAtPixel(stroke_.at())) : std::nullopt;
    if (bench_.strokes->isPressed() || bench_.device->isLed() || bench_.saw->isCutting()) over_.reset();
    view_->hover(over_);
  }

  // Gamepad and SpaceMouse. A window without the focus ignores them.
  void takeDevices() {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - std::exchange(devices_read_, now)).count();
    const bool is_ours = bench_.document->isOpen() && !bench_.imports->isImporting() &&
                         glfwGetWindowAttrib(desktop_.window(), GLFW_FOCUSED) == GLFW_TRUE;
    const auto pad = game_controller_.read();
    gamepad_.update(context_, stroke_, is_ours ? pad : std::nullopt, seconds);
    shakePad(is_ours);
    if (const auto news = game_controller_.news()) bench_.notices->say(*news);
    if (const auto news = space_mouse_link_.news()) bench_.notices->say(*news);
    const auto knob = space_mouse_link_.read();
    showDevices(knob, pad);
    space_mouse_.update(context_, stroke_, settings_.values.space_mouse, is_ours ? knob : std::nullopt, seconds);
    if (!gamepad_.isUsed() && !space_mouse_.isUsed()) return;
    is_led_by_device_ = true;
    last_input_ = now;
  }

  // The pad shakes while it drills. It stands still out of focus, in a pause, and when nothing turns.
  void shakePad(bool is_ours) {
    const bool shakes = is_ours && gamepad_.isUsed() && bench_.strokes->isPressed();
    game_controller_.shake(shakes ? rumbleOf(bench_.document->report(), bench_.monitor->driveShare()) : Rumble{});
  }

  // For their panel, while it is shown.
  void showDevices(const std::optional<SpaceMouseState>& knob, const std::optional<GamepadState>& pad) {
    if (!context_.panels["device"]) return;
    panels_.devices = {knob, space_mouse_link_.name(), space_mouse_link_.trouble(),   space_mouse_link_.battery(),
                       pad,  game_controller_.name(),  game_controller_.isJoystick(), game_controller_.canShake()};
  }

  static bool isEnter(const InputEvent& e) {
    return e.is_down && (e.key == GLFW_KEY_ENTER || e.key == GLFW_KEY_KP_ENTER);
  }

  // During text input only closing the window and Ctrl with a letter that no field uses are commands.
  void key(const InputEvent& e, bool is_text) {
    if (!e.is_down) return keyUp(e.key);
    if (takesForceAway(e)) return;
    if (palette_.isShown()) return paletteKey(e.key);
    if (files_.takesKeys() && (e.key == GLFW_KEY_ENTER || e.key == GLFW_KEY_KP_ENTER)) return files_.accept();
    if (files_.takesKeys() && e.key == GLFW_KEY_ESCAPE) return files_.cancel();
    const bool is_enter = e.key == GLFW_KEY_ENTER || e.key == GLFW_KEY_KP_ENTER;
    if (e.key == GLFW_KEY_ESCAPE && (ui::closeTopmostPopup() || closeDebrief(context_) || dismissErrors())) return;
    if (is_enter || e.key == GLFW_KEY_ESCAPE)
      if (quitQuestionKey(context_, is_enter) || exportPanelKey(context_, is_enter)) return;
    for (const char* const panel : {"keys", "messages", "about", "settings", "sessions"})
      if (context_.panels[panel] && e.key == GLFW_KEY_ESCAPE) {
        context_.panels[panel] = panel == std::string_view("sessions") && panels_.sessions.stopAsking();
        return;
      }
    const bool is_alt = e.key == GLFW_KEY_LEFT_ALT || e.key == GLFW_KEY_RIGHT_ALT;
    if (is_alt && !e.is_repeated) return stroke_.tapAlt(context_, e.s);
    const int modifiers = e.modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_SHIFT | GLFW_MOD_ALT);
    // A name typed beside its field runs no commands, nor does a key that would edit it.
    const bool is_typing = e.key < GLFW_KEY_F1 && (modifiers & ~GLFW_MOD_SHIFT) == 0;
    if (is_typing && !is_text && bench_.exporting->isShown() && !bench_.exporting->isDone()) return;
    if (!is_text && (leadsStroke(e) || showsAsLoaded(e))) return;
    for (const AppCommand& command : appCommands()) {
      if (command.key.empty() || keyChord(command.key) != KeyChord{e.key, modifiers}) continue;
      if (is_text && command.id != "app.quit" && !passesText(e.key, modifiers)) return;
      if (!command.is_enabled(context_)) continue;  // Esc runs its first enabled command
      if (asksForFile(command))
        askForFile(command);
      else
        say(command.run(context_, {}));
      if (std::exchange(context_.wants_palette, false)) palette_.show();  // it gets the next characters
      return;
    }
  }

  bool dismissErrors() {
    if (!panels_.notices.hasError(bench_.notices->list())) return false;
    panels_.notices.shown.clear();
    return true;
  }

  // Ctrl with a letter that no text field uses. Ctrl+Z belongs to the field only after typing there.
  static bool passesText(int key, int modifiers) {
    if (!(modifiers & GLFW_MOD_CONTROL) || key < GLFW_KEY_A || key > GLFW_KEY_Z) return false;
    if (key == GLFW_KEY_Z) return !ui::canUndoTyping();
    return key != GLFW_KEY_A && key != GLFW_KEY_C && key != GLFW_KEY_V && key != GLFW_KEY_X && key != GLFW_KEY_Y;
  }

  // Works whichever control has the keys.
  bool takesForceAway(const InputEvent& e) {
    const AppCommand& disarm = *findAppCommand("device.disarm");
    if (keyChord(disarm.key).key != e.key || !disarm.is_enabled(context_)) return false;
    say(disarm.run(context_, {}));
    return true;
  }

  // While its key is down.
  bool showsAsLoaded(const InputEvent& e) {
    const AppCommand& command = *findAppCommand("view.as-loaded");
    if (keyChord(command.key) != KeyChord{e.key, e.modifiers} || !command.is_enabled(context_)) return false;
    if (!e.is_repeated) runIfEnabled(context_, command.id, std::vector<std::string>{"on"});
    is_look_held_ = true;
    return true;
  }

  // The foot pedal ends with its key, and so does the look back.
  void keyUp(int key) {
    if (const AppCommand& back = *findAppCommand("view.as-loaded");
        keyChord(back.key).key == key && std::exchange(is_look_held_, false))
      runIfEnabled(context_, back.id, std::vector<std::string>{"off"});
    if (key == GLFW_KEY_SPACE && bench_.strokes->isOnPedal())
      runIfEnabled(context_, "cut.pedal", std::vector<std::string>{"off"});
  }

  // At the pointer, or over a panel where the last stroke was. A place beside the object is no error.
  void stepOnPedal() {
    std::vector<std::string> words{"on"};
    if (context_.pointer)
      for (std::string& word : wordsOf({stroke_.at()[0], stroke_.at()[1]})) words.push_back(std::move(word));
    (void)runAppCommand(context_, "cut.pedal", words);
  }

  // Keys that hold a stroke or nudge it.
  bool leadsStroke(const InputEvent& e) {
    if (e.key == GLFW_KEY_SPACE && e.modifiers == 0 && bench_.document->watched()) {
      if (!e.is_repeated) say(runAppCommand(context_, "replay.toggle", {}));
      return true;
    }
    if (e.key == GLFW_KEY_SPACE && e.modifiers == 0) {
      if (!e.is_repeated && bench_.document->isOpen() && !bench_.imports->isImporting()) stepOnPedal();
      return true;
    }
    if (!bench_.strokes->isPressed()) return false;
    const std::optional<Vec3d> direction = nudgeOf(e.key);
    if (!direction) return false;
    stroke_.nudge(context_, *direction, heldKeys(e.modifiers));
    return true;
  }

  static std::optional<Vec3d> nudgeOf(int key) {
    switch (key) {
      case GLFW_KEY_RIGHT:
        return Vec3d::UnitX();
      case GLFW_KEY_LEFT:
        return -Vec3d::UnitX();
      case GLFW_KEY_UP:
        return Vec3d::UnitY();
      case GLFW_KEY_DOWN:
        return -Vec3d::UnitY();
      case GLFW_KEY_END:
        return Vec3d::UnitZ();
      case GLFW_KEY_HOME:
        return -Vec3d::UnitZ();
      default:
        return {};
    }
  }

  HeldKeys heldKeys(int modifiers) const {
    const bool tilts = (modifiers & GLFW_MOD_ALT) && held_ == kNone && bench_.document->isOpen();
    return {tilts, (modifiers & GLFW_MOD_CONTROL) != 0, (modifiers & GLFW_MOD_SHIFT) != 0};
  }

  // Typed text comes as characters.
  void paletteKey(int key) {
    if (key == GLFW_KEY_ESCAPE) palette_.back();
    if (key == GLFW_KEY_BACKSPACE) palette_.erase();
    if (key == GLFW_KEY_UP) palette_.move(-1);
    if (key == GLFW_KEY_DOWN) palette_.move(1);
    if (key != GLFW_KEY_ENTER && key != GLFW_KEY_KP_ENTER) return;
    if (const AppCommand* const command = palette_.accept(context_)) askForFile(*command);
  }

  void say(const Expected<void>& done) {
    if (!done) bench_.notices->complain(done.error());
  }

  // The left button picks points or a line of a plane.
  bool isPicking(const InputEvent& e) const {
    return e.key == GLFW_MOUSE_BUTTON_LEFT && bench_.saw->picking.what() != SawPicking::What::kNothing;
  }

  // False beside the model: the view turns.
  bool placesHole() {
    if (!bench_.drill->isPlanning() || bench_.drill->isDrilling() || bench_.imports->isImporting()) return false;
    if (!bench_.document->scene().hit(rayAt(x_, y_))) return false;
    say(runAppCommand(context_, "drill.click", wordsOf({pointer()[0], pointer()[1]})));
    return true;
  }

  // With Ctrl, to the chosen ones. False beside the pieces.
  bool addsPiece() {
    const auto hit = bench_.document->scene().hit(rayAt(x_, y_));
    if (!hit || !bench_.document->isOpen() || !arePiecesNeeded(context_) || bench_.imports->isImporting()) return false;
    std::vector<std::string> words = wordsOf({pointer()[0], pointer()[1]});
    words.emplace_back("add");
    say(runAppCommand(context_, "piece.pick", words));
    return true;
  }

  // The left button draws a line over a scan in import.
  bool takesTrim(const InputEvent& e, bool is_on_panel) {
    TrimDrawing& drawing = bench_.imports->drawing;
    if (e.key != GLFW_MOUSE_BUTTON_LEFT || !drawing.isOn() || !bench_.imports->plan()) return false;
    if (e.is_down) {
      if (!is_on_panel) drawing.press(pointer());
      return !is_on_panel;
    }
    if (!drawing.isDrawing()) return false;
    std::vector<std::string> words;
    for (const Pixel& p : drawing.release())
      for (std::string& word : wordsOf({p[0], p[1]})) words.push_back(std::move(word));
    const bool is_line = drawing.what() == TrimDrawing::What::kLine;
    if (!words.empty()) say(runAppCommand(context_, is_line ? "import.trim-line" : "import.trim-lasso", words));
    return true;
  }

  void button(const InputEvent& e, bool is_on_panel) {
    x_ = e.x;
    y_ = e.y;
    if (takesTrim(e, is_on_panel)) return;
    SawPicking& picking = bench_.saw->picking;
    if (isPicking(e) && !is_on_panel && e.is_down && bench_.document->isOpen())
      return say(picking.press(*bench_.saw, rayAt(x_, y_)));
    if (!e.is_down && picking.lineFrom() && e.key == GLFW_MOUSE_BUTTON_LEFT)
      return say(picking.release(*bench_.saw, rayAt(x_, y_)));

    if (!e.is_down) {
      if (e.key == GLFW_MOUSE_BUTTON_LEFT) {
        panels_.piece_drag.release(context_, pointer());
        stroke_.release(context_);
      }
      if (e.key == held_) held_ = kNone;
      if (e.key == GLFW_MOUSE_BUTTON_RIGHT && right_pressed_) openMenuAt(*std::exchange(right_pressed_, std::nullopt));
      return;
    }
    if (is_on_panel) return;
    if (e.key == GLFW_MOUSE_BUTTON_RIGHT) right_pressed_ = pointer();
    palette_.hide();
    if (e.key == GLFW_MOUSE_BUTTON_LEFT && placesHole()) return;
    if (e.key == GLFW_MOUSE_BUTTON_LEFT && (e.modifiers & GLFW_MOD_CONTROL) && addsPiece()) return;
    if (e.key == GLFW_MOUSE_BUTTON_LEFT && panels_.piece_drag.press(context_, pointer())) return;
    if (e.key != GLFW_MOUSE_BUTTON_LEFT || bench_.imports->isImporting() || !leftButtonCuts(context_) ||
        !stroke_.press(context_, pointer())) {
      held_ = e.key;
      pans_ = e.key == GLFW_MOUSE_BUTTON_MIDDLE || (e.modifiers & GLFW_MOD_SHIFT);
      pivot_ = pans_ ? std::nullopt : pointUnder(context_, pointer()[0], pointer()[1]);
    }
  }

  // A right click: a drag has reset its place.
  void openMenuAt(const Pixel& pressed) {
    if (screenOf(bench_) != Screen::kCut || bench_.strokes->isPressed()) return;
    const auto hit = bench_.document->scene().hit(rayAt(x_, y_));
    if (hit && arePiecesNeeded(context_) && !bench_.pieces->isSelected(hit->id))
      runIfEnabled(context_, "piece.pick", wordsOf({pressed[0], pressed[1]}));
    panels_.menu_at = std::array{pressed[0], pressed[1]};
  }

  void move(const InputEvent& e) {
    const double dx = (e.x - x_) * pixels(), dy = (e.y - y_) * pixels();
    x_ = e.x;
    y_ = e.y;
    is_led_by_device_ = false;
    constexpr double kStill = 4;  // window units
    if (right_pressed_ && (pointer() - *right_pressed_).norm() > kStill * pixels()) right_pressed_.reset();
    if (bench_.imports->drawing.isDrawing()) return bench_.imports->drawing.move(pointer());
    if (panels_.piece_drag.isOn()) return panels_.piece_drag.move(context_, pointer());
    stroke_.move(context_, pointer(), heldKeys(e.modifiers));
    if (bench_.strokes->isPressed() && !bench_.strokes->isOnPedal()) return;
    bench_.saw->picking.move(rayAt(x_, y_));
    if (held_ == kNone) return;
    if (pans_)
      pan(camera_, dx, dy, context_.height);
    else
      orbitAbout(camera_, pivot_.value_or(camera_.target), dx, dy);
  }

  void scroll(double notches) {
    if (bench_.imports->drawing.isDrawing()) return;  // the line is one of pixels
    if (bench_.strokes->isPressed())
      return runIfEnabled(context_, notches < 0 ? "cut.deeper" : "cut.shallower",
                          wordsOf({std::min(kNotch * std::abs(notches), bench_.strokes->mostDepth())}));
    zoomAt(context_, pointer()[0], pointer()[1], std::pow(1.15, notches));
  }

  void pressHarder(bool is_wanted) {
    const bool is_harder = is_wanted && bench_.strokes->isPressed();
    if (is_harder == is_harder_) return;
    is_harder_ = is_harder;
    runIfEnabled(context_, "cut.push-harder", wordsOf({is_harder ? kHarder : 1}));
  }

  // ---- Files

  void askForFile(const AppCommand& command) { files_.ask(context_, command); }

  static constexpr int kNone = -1;
  const WorkshopOptions& options_;
  Desktop desktop_;  // before members that need its context
  Workbench bench_;
  Camera camera_;
  SettingsFile settings_;
  std::optional<Settings> applied_;  // theme and scale of the panels
  AppContext context_{.bench = bench_, .camera = camera_, .settings = &settings_};
  std::unique_ptr<LiveView> view_;
  std::unique_ptr<ImportView> import_view_;
  std::optional<Camera> camera_before_import_;
  RecentPicture recent_picture_;
  std::unique_ptr<SoundThread> sound_;
  PanelState panels_;
  FileChooser files_;
  CommandPalette palette_;
  StrokePointer stroke_;
  GamepadHand gamepad_;
  GameController game_controller_;
  SpaceMouseLink space_mouse_link_;
  SpaceMouseHand space_mouse_;
  Clock::time_point devices_read_ = Clock::now();
  bool is_led_by_device_ = false;  // the mouse has not moved since
  std::optional<ToolOverSurface> over_;
  Clock::time_point last_input_ = Clock::now();
  std::deque<InputEvent> enters_;  ///< waiting until the panels have the text before them
  Clock::time_point fitted_at_{};  ///< the first view of the document
  Box3 fitted_;                    ///< then
  bool is_look_held_ = false;      ///< the key of view.as-loaded is down
  double x_ = 0, y_ = 0;           // of the pointer, window units
  int window_width_ = 1, window_height_ = 1;
  int held_ = kNone;
  std::optional<Pixel> right_pressed_;  // place of the right button's press
  std::optional<Vec3d> pivot_;          // place under the cursor when the turn began
  bool pans_ = false, is_harder_ = false, wants_end_ = false, is_software_ = true;
  bool rests_ = false, is_import_shown_ = false;  // the last frame changed nothing; of the last one drawn
  std::size_t panels_shown_ = 0;                  // fingerprintOf()
  int frames_ = 0;
  std::size_t told_ = 0;  // notices
};

}  // namespace

Expected<int> runWorkshop(const WorkshopOptions& options) {
  // The software renderer draws in the calling thread: the other core is the haptic thread's.
  ::setenv("LP_NUM_THREADS", std::thread::hardware_concurrency() <= 2 ? "0" : "2", 0);
  return Workshop(options).run();
}

}  // namespace kerf
