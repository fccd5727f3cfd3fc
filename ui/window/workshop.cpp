#include "ui/window/workshop.h"

#include <epoxy/gl.h>
#include <fmt/format.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <numbers>
#include <thread>
#include <utility>
#include <vector>

#include "ui/app/app_commands.h"
#include "ui/app/app_script.h"
#include "ui/app/arm_lead.h"
#include "ui/app/gamepad_map.h"
#include "ui/app/pointing.h"
#include "ui/app/sawing.h"
#include "ui/app/settings.h"
#include "ui/app/space_mouse_link.h"
#include "ui/app/stroke_pointer.h"
#include "ui/app/view_commands.h"
#include "ui/sound/alsa_output.h"
#include "ui/sound/sound_thread.h"
#include "ui/window/file_browser.h"
#include "ui/window/frame_watch.h"
#include "ui/window/gamepad.h"
#include "ui/window/gl_context.h"
#include "ui/window/gl_target.h"
#include "ui/window/glfw_error.h"
#include "ui/window/import_view.h"
#include "ui/window/key_names.h"
#include "ui/window/live_view.h"
#include "ui/window/palette.h"
#include "ui/window/panels.h"
#include "ui/window/style.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kStillAfter = 0.2;  // s without input or cut: the picture is drawn once more, smooth
constexpr double kHarder = 2;        // times the force, while Shift is down
constexpr double kNotch = 0.1;       // mm of depth, of the wheel during a stroke

// ---- Input: what happened since the last frame, in its order. Nothing is lost in a slow frame.

struct InputEvent {
  enum class Kind { kKey, kCharacter, kButton, kMove, kScroll, kDrop };
  Kind kind = Kind::kMove;
  int key = 0, modifiers = 0;  // of a button: its number. Of a move: those of Alt and Ctrl
  bool is_down = false, is_repeated = false;
  double x = 0, y = 0;            // of a wheel: notches
  double s = 0;                   // of a key: when
  std::string path{};             // of a character: itself, UTF-8
  std::vector<fs::path> paths{};  // dropped
};

std::vector<InputEvent>& eventsOf(GLFWwindow* window) {
  return *static_cast<std::vector<InputEvent>*>(glfwGetWindowUserPointer(window));
}

int heldOf(GLFWwindow* window) {
  const auto isDown = [&](int key) { return glfwGetKey(window, key) == GLFW_PRESS; };
  const bool alt = isDown(GLFW_KEY_LEFT_ALT) || isDown(GLFW_KEY_RIGHT_ALT);
  const bool ctrl = isDown(GLFW_KEY_LEFT_CONTROL) || isDown(GLFW_KEY_RIGHT_CONTROL);
  return (alt ? GLFW_MOD_ALT : 0) | (ctrl ? GLFW_MOD_CONTROL : 0);
}

std::string utf8(unsigned code) {
  const auto tail = [&](int shift) { return static_cast<char>(0x80 | ((code >> shift) & 0x3F)); };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xC0 | (code >> 6)), tail(0)};
  if (code < 0x10000) return {static_cast<char>(0xE0 | (code >> 12)), tail(6), tail(0)};
  return {static_cast<char>(0xF0 | (code >> 18)), tail(12), tail(6), tail(0)};
}

void listen(GLFWwindow* window, std::vector<InputEvent>& events) {
  using Kind = InputEvent::Kind;
  glfwSetWindowUserPointer(window, &events);
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int modifiers) {
    eventsOf(w).push_back({.kind = Kind::kKey,
                           .key = key,
                           .modifiers = modifiers,
                           .is_down = action != GLFW_RELEASE,
                           .is_repeated = action == GLFW_REPEAT,
                           .s = glfwGetTime()});
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned code) {
    eventsOf(w).push_back({.kind = Kind::kCharacter, .path = utf8(code)});
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int modifiers) {
    InputEvent e{.kind = Kind::kButton, .key = button, .modifiers = modifiers, .is_down = action == GLFW_PRESS};
    glfwGetCursorPos(w, &e.x, &e.y);
    eventsOf(w).push_back(e);
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    eventsOf(w).push_back({.kind = Kind::kMove, .modifiers = heldOf(w), .x = x, .y = y});
  });
  glfwSetScrollCallback(
      window, [](GLFWwindow* w, double, double y) { eventsOf(w).push_back({.kind = Kind::kScroll, .y = y}); });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    InputEvent drop{.kind = Kind::kDrop};
    drop.paths.assign(paths, paths + count);
    eventsOf(w).push_back(std::move(drop));
  });
}

// ---- The system wants it to end: what was cut is written first

volatile std::sig_atomic_t is_told_to_end = 0;

void endWhenTold() {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) std::signal(number, [](int) { is_told_to_end = 1; });
}

// ---- GLFW, its window and Dear ImGui, taken down in reverse

struct Desktop {
  GLFWwindow* window = nullptr;
  bool is_started = false, has_panels = false;
  float scale = 1;

  ~Desktop() {
    if (has_panels) {
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplGlfw_Shutdown();
      ImGui::DestroyContext();
    }
    if (window) glfwDestroyWindow(window);
    if (is_started) glfwTerminate();
  }

  Expected<void> open(const WorkshopOptions& options, std::vector<InputEvent>& events) {
    if (!glfwInit()) return fail(noWindow("no window can be opened: " + lastGlfwError()));
    is_started = true;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    window = glfwCreateWindow(options.width, options.height, "Kerf", nullptr, nullptr);
    if (!window) return fail(noWindow("no window can be opened: " + lastGlfwError()));

    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    listen(window, events);  // before Dear ImGui, which passes on what it gets
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind in the working folder
    ImGui_ImplGlfw_InitForOpenGL(window, true);
    has_panels = true;
    if (!ImGui_ImplOpenGL3_Init("#version 330 core")) return fail(noWindow("Dear ImGui found no OpenGL 3.3"));

    float y = 1;
    glfwGetWindowContentScale(window, &scale, &y);
    scale = std::max(scale, 1.0f);
    return {};
  }

  // Type and panels anew, between two frames.   @param factor  times the scale of the display.
  void restyle(Theme theme, float factor) const {
    ImGui::GetIO().Fonts->Clear();
    loadFont(scale * factor);
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
    applyStyle(theme, scale * factor);
  }

  static void loadFont(float scale) {
    std::error_code ignored;
    for (const char* const font :
         {"/usr/share/fonts/opentype/inter/Inter-Regular.otf", "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"})
      if (fs::exists(font, ignored) && ImGui::GetIO().Fonts->AddFontFromFileTTF(font, 15 * scale)) return;
  }
};

// What was cut or is being exported is written before the window goes; what is being opened is cancelled. The first
// error of that, or of a script before it.
Expected<void> endAll(Workbench& bench, LiveView& view) {
  const std::size_t seen = bench.notices().size();
  const auto wait = [&] {
    while (bench.job()) {
      if (!bench.isWriting()) bench.cancelJob();
      view.update(bench);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  bench.release();  // nobody holds the tool any more
  wait();
  bench.close();
  wait();
  for (std::size_t n = seen; n < bench.notices().size(); ++n)
    if (bench.notices()[n].is_error)
      return fail({.code = Error::Code::kWriteFailed, .place = "ending the session", .found = bench.notices()[n].text});
  return {};
}

// ---- The loop

class Workshop {
 public:
  explicit Workshop(const WorkshopOptions& options)
      : options_(options),
        bench_(remembering(options.bench)),
        settings_(options.config),
        space_mouse_link_(options.space_mouse) {}

  Expected<int> run() {
    endWhenTold();
    KERF_CHECK(desktop_.open(options_, events_));
    KERF_TRY(view, LiveView::create());
    view_ = std::move(view);
    view_->setBeforeClear([this] {
      takePicture();
      box_ = {};
    });
    KERF_TRY(import_view, ImportView::create());
    import_view_ = std::move(import_view);
    const std::string driver = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    is_software_ = driver.find("llvmpipe") != driver.npos || driver.find("softpipe") != driver.npos;
    applySettings();
    context_.set_clipboard = [this](const std::string& text) { glfwSetClipboardString(desktop_.window, text.c_str()); };
    panels_.ask_for_file = [this](const AppCommand& command) { askForFile(command); };
    if (settings_.error()) bench_.complain(*settings_.error());
    bench_.setForce(settings_.values.force_N);
    bench_.depth_mm = settings_.values.depth_mm;
    if (settings_.values.is_perspective)
      setFieldOfView(camera_, settings_.values.perspective_deg * std::numbers::pi / 180);
    browser_.setFolder(settings_.values.last_folder);
    if (!options_.replay.empty())
      bench_.watch(options_.replay);
    else
      bench_.beginImports(options_.open);

    while (!wants_end_) KERF_CHECK(frame());
    const auto ended = endAll(bench_, *view_);
    import_view_.reset();
    view_.reset();
    if (!ended) return fail(ended.error());
    return frames_;
  }

 private:
  static WorkbenchOptions remembering(WorkbenchOptions options) {
    options.keeps_recent = true;
    options.asks_about_runs = true;
    return options;
  }

  Expected<void> frame() {
    const bool is_idle = !bench_.isShown() && !bench_.job();
    options_.frames > 0 ? glfwPollEvents() : glfwWaitEventsTimeout(is_idle ? 0.25 : 1.0 / 60);
    glfwGetWindowSize(desktop_.window, &window_width_, &window_height_);
    glfwGetFramebufferSize(desktop_.window, &context_.width, &context_.height);
    if (context_.width == 0 || context_.height == 0 || window_width_ == 0) {  // minimised
      bench_.release();                                                       // unseen nothing is cut
      bench_.arm().pause(true);
      events_.clear();
      view_->update(bench_);
      glfwWaitEventsTimeout(0.1);
      wants_end_ = glfwWindowShouldClose(desktop_.window) || is_told_to_end;
      return {};
    }

    bench_.arm().pause(browser_.isShown());
    view_->update(bench_);
    if (!bench_.scene().bounds().isEmpty() && view_->takeFitWanted()) fitFirst();
    if (bench_.isShown() && !bench_.scene().bounds().isEmpty()) box_ = bench_.scene().bounds();
    updateImport();
    updateSound();
    applySettings();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    handleInput();
    if (panels_.import.shows_guides) drawImportGuides(context_, pixels());
    drawPanels(context_, panels_, over_);
    if (std::exchange(context_.wants_palette, false)) palette_.show();
    if (const AppCommand* const command = drawPalette(context_, palette_)) askForFile(*command);
    chooseFile();
    ImGui::Render();

    const bool is_still =
        secondsSince(last_input_) > kStillAfter && !bench_.isPressed() && !bench_.isLed() && !bench_.isPlaying();
    const bool is_smooth = is_still && !is_software_;
    if (bench_.isImporting())
      KERF_CHECK(import_view_->draw(camera_, context_.width, context_.height, is_smooth));
    else
      KERF_CHECK(view_->draw(bench_, camera_, context_.width, context_.height, is_smooth));
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(desktop_.window);

    // Not in the frame that uploads all of the surface, and not while a hand is at work.
    if (is_still && std::exchange(is_picture_due_, false)) takePicture();
    ++frames_;
    wants_end_ = context_.wants_quit || glfwWindowShouldClose(desktop_.window) || is_told_to_end ||
                 (options_.frames > 0 && frames_ >= options_.frames);
    return {};
  }

  // From the first session on. Without a device all is silent, and that is said once.
  void updateSound() {
    const Settings& now = settings_.values;
    const double volume = now.is_muted ? 0 : 0.01 * now.sound_volume;
    if (!sound_ && bench_.isOpen() && volume > 0) sound_ = std::make_unique<SoundThread>(openAlsa);
    if (!sound_) return;

    DrillSoundInput heard;
    if (bench_.isOpen()) {
      const std::size_t n = bench_.toolInHand();
      heard = drillSoundOf(bench_.report(), bench_.tool(n), bench_.run()->model().tools[n].drive, volume);
    }
    sound_->play(heard);
    if (const auto error = sound_->takeError()) bench_.say("The drill is silent: " + error->found);
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

  void fitFirst() {
    camera_before_import_.reset();  // what is open now is another one than before
    const auto camera = cameraFromView(options_.view);
    firstView(context_, camera ? *camera : Camera{});
    setTitle(bench_.name());
    box_ = bench_.scene().bounds();
    picture_of_ = bench_.source();
    is_picture_due_ = true;
  }

  // A small picture of what is open, for the first screen: when it was opened, and again as it was left.
  void takePicture() {
    if (picture_of_.empty() || box_.isEmpty()) return;
    Camera camera = camera_;
    fitToBox(camera, box_, kCardWidth, kCardHeight);
    view_->hover({});
    auto image = view_->picture(bench_, camera, kCardWidth, kCardHeight);
    if (!image) return;  // a list without a picture is no failure
    writing_picture_ = std::make_unique<Job<void>>(
        "a picture", [image = std::move(*image), to = bench_.recent().pictureOf(picture_of_)](const Progress&) {
          std::error_code ignored;
          fs::create_directories(to.parent_path(), ignored);
          return writePng(to, image);
        });
  }

  void setTitle(const std::string& what) {
    glfwSetWindowTitle(desktop_.window, (what.empty() ? "Kerf" : what + " - Kerf").c_str());
  }

  // While a scan is imported the session that is open, if any, rests; its view comes back when the scan is put away.
  void updateImport() {
    const ImportSet* const set = bench_.importSet();
    import_view_->update(set ? std::optional(set->picture(panels_.import.shows_solid)) : std::nullopt);
    if (set && !camera_before_import_) camera_before_import_ = camera_;
    if (!set && camera_before_import_) {
      if (!view_->isFitWanted()) {
        camera_ = *camera_before_import_;
        setTitle(bench_.isOpen() ? bench_.name() : "");
      }
      camera_before_import_.reset();
    }
    if (set && import_view_->takeFitWanted()) {
      viewScan(context_, pixels());
      setTitle("Import " + set->cut().file.filename().string());
    }
  }

  // ---- Input

  double pixels() const { return static_cast<double>(context_.width) / window_width_; }
  Pixel pointer() const { return pixels() * Pixel(x_, y_); }
  Ray rayAt(double x, double y) const { return rayAtPixel(pixels() * Pixel(x, y)); }
  Ray rayAtPixel(const Pixel& at) const { return rayUnder(camera_, at[0], at[1], context_.width, context_.height); }

  void handleInput() {
    const ImGuiIO& io = ImGui::GetIO();
    for (const InputEvent& e : std::exchange(events_, {})) {
      last_input_ = Clock::now();
      switch (e.kind) {
        case InputEvent::Kind::kDrop:
          bench_.importMore(e.paths);
          break;
        case InputEvent::Kind::kKey:
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
    pressHarder(io.KeyShift && !bench_.isOnPedal());  // there Shift is a larger step
    panels_.pixels = pixels();
    context_.pointer = io.WantCaptureMouse ? std::nullopt : std::optional(std::array{pointer()[0], pointer()[1]});
    panels_.piece_drag.hover(context_, pointer());
    const bool is_on_handle = panels_.piece_drag.lit().has_value();
    const bool is_picking = bench_.saw().picking.what() != SawPicking::What::kNothing;
    const bool is_on_panel = io.WantCaptureMouse && !is_led_by_device_;
    const bool hovers = !is_on_panel && held_ == kNone && !is_on_handle && !is_picking && !bench_.isImporting();
    over_ = hovers ? bench_.over(rayAtPixel(stroke_.at())) : std::nullopt;
    if (bench_.isPressed() || bench_.isLed() || bench_.saw().isCutting()) over_.reset();
    view_->hover(over_);
  }

  // Gamepad and SpaceMouse. Of a window that does not have the focus they are nobody's.
  void takeDevices() {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - std::exchange(devices_read_, now)).count();
    const bool is_ours =
        bench_.isOpen() && !bench_.isImporting() && glfwGetWindowAttrib(desktop_.window, GLFW_FOCUSED) == GLFW_TRUE;
    gamepad_.update(context_, stroke_, is_ours ? readGamepad() : std::nullopt, seconds);
    shakePad(is_ours);
    if (const auto news = space_mouse_link_.news()) bench_.say(*news);
    const auto knob = space_mouse_link_.read();
    if (context_.shows_device) panels_.devices = {knob, space_mouse_link_.name(), space_mouse_link_.trouble()};
    space_mouse_.update(context_, stroke_, settings_.values.space_mouse, is_ours ? knob : std::nullopt, seconds);
    if (!gamepad_.isUsed() && !space_mouse_.isUsed()) return;
    is_led_by_device_ = true;
    last_input_ = now;
  }

  // The pad shakes while it drills, and stands still out of focus, in a pause, and when nothing turns.
  void shakePad(bool is_ours) {
    const bool shakes = is_ours && gamepad_.isUsed() && bench_.isPressed();
    const Rumble wanted = shakes ? rumbleOf(bench_.report(), bench_.driveShare()) : Rumble{};
    if (const auto told = pad_rumble_.update(gamepadId(), wanted)) bench_.say(*told);
  }

  // While text is typed only the window's own end is a command.
  void key(const InputEvent& e, bool is_text) {
    if (!e.is_down) return keyUp(e.key);
    if (takesForceAway(e)) return;
    if (palette_.isShown()) return paletteKey(e.key);
    if (browser_.isShown() && (e.key == GLFW_KEY_ENTER || e.key == GLFW_KEY_KP_ENTER)) return browser_.accept();
    if (browser_.isShown() && e.key == GLFW_KEY_ESCAPE) return browser_.cancel();
    if (context_.shows_settings && e.key == GLFW_KEY_ESCAPE) {
      context_.shows_settings = false;
      return;
    }
    const bool is_alt = e.key == GLFW_KEY_LEFT_ALT || e.key == GLFW_KEY_RIGHT_ALT;
    if (is_alt && !e.is_repeated) return stroke_.tapAlt(context_, e.s);
    if (!is_text && leadsStroke(e)) return;
    const int modifiers = e.modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_SHIFT | GLFW_MOD_ALT);
    for (const AppCommand& command : appCommands()) {
      if (command.key.empty() || keyChord(command.key) != KeyChord{e.key, modifiers}) continue;
      if (is_text && command.id != "app.quit") return;
      if (!command.is_enabled(context_)) continue;  // Esc leaves what there is to leave
      if (command.parameters == "PATH")
        askForFile(command);
      else
        say(command.run(context_, {}));
      if (std::exchange(context_.wants_palette, false)) palette_.show();  // the next characters are for it
      return;
    }
  }

  // Whatever else has the keys.
  bool takesForceAway(const InputEvent& e) {
    const AppCommand& disarm = *findAppCommand("device.disarm");
    if (keyChord(disarm.key).key != e.key || !disarm.is_enabled(context_)) return false;
    say(disarm.run(context_, {}));
    return true;
  }

  // The foot pedal ends with its key.
  void keyUp(int key) {
    if (key == GLFW_KEY_SPACE && bench_.isOnPedal()) bench_.release();
  }

  // Keys that hold a stroke or nudge it.
  bool leadsStroke(const InputEvent& e) {
    if (e.key == GLFW_KEY_SPACE && e.modifiers == 0 && bench_.watched()) {
      if (!e.is_repeated) say(runAppCommand(context_, "replay.toggle", {}));
      return true;
    }
    if (e.key == GLFW_KEY_SPACE && e.modifiers == 0) {
      const bool is_over_picture = context_.pointer.has_value();
      if (!e.is_repeated && bench_.isOpen() && !bench_.isImporting())
        bench_.stepOnPedal(is_over_picture ? std::optional(rayAtPixel(stroke_.at())) : std::nullopt);
      return true;
    }
    if (!bench_.isPressed()) return false;
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
    const bool tilts = (modifiers & GLFW_MOD_ALT) && held_ == kNone && bench_.isOpen();
    return {tilts, (modifiers & GLFW_MOD_CONTROL) != 0, (modifiers & GLFW_MOD_SHIFT) != 0};
  }

  // What is typed comes as characters.
  void paletteKey(int key) {
    if (key == GLFW_KEY_ESCAPE) palette_.back();
    if (key == GLFW_KEY_BACKSPACE) palette_.erase();
    if (key == GLFW_KEY_UP) palette_.move(-1);
    if (key == GLFW_KEY_DOWN) palette_.move(1);
    if (key != GLFW_KEY_ENTER && key != GLFW_KEY_KP_ENTER) return;
    if (const AppCommand* const command = palette_.accept(context_)) askForFile(*command);
  }

  void say(const Expected<void>& done) {
    if (!done) bench_.complain(done.error());
  }

  // Points or a line of a plane are picked with the left button.
  bool isPicking(const InputEvent& e) const {
    return e.key == GLFW_MOUSE_BUTTON_LEFT && bench_.saw().picking.what() != SawPicking::What::kNothing;
  }

  void button(const InputEvent& e, bool is_on_panel) {
    x_ = e.x;
    y_ = e.y;
    SawPicking& picking = bench_.saw().picking;
    if (isPicking(e) && !is_on_panel && e.is_down && bench_.isOpen())
      return say(picking.press(bench_.saw(), rayAt(x_, y_)));
    if (!e.is_down && picking.lineFrom() && e.key == GLFW_MOUSE_BUTTON_LEFT)
      return say(picking.release(bench_.saw(), rayAt(x_, y_)));

    if (!e.is_down) {
      if (e.key == GLFW_MOUSE_BUTTON_LEFT) {
        panels_.piece_drag.release(context_, pointer());
        stroke_.release(context_);
      }
      if (e.key == held_) held_ = kNone;
      return;
    }
    if (is_on_panel) return;
    palette_.hide();
    if (e.key == GLFW_MOUSE_BUTTON_LEFT && panels_.piece_drag.press(context_, pointer())) return;
    if (e.key != GLFW_MOUSE_BUTTON_LEFT || bench_.isImporting() || !stroke_.press(context_, pointer())) {
      held_ = e.key;
      pans_ = e.key == GLFW_MOUSE_BUTTON_MIDDLE || (e.modifiers & GLFW_MOD_SHIFT);
    }
  }

  void move(const InputEvent& e) {
    const double dx = (e.x - x_) * pixels(), dy = (e.y - y_) * pixels();
    x_ = e.x;
    y_ = e.y;
    is_led_by_device_ = false;
    if (panels_.piece_drag.isOn()) return panels_.piece_drag.move(context_, pointer());
    stroke_.move(context_, pointer(), heldKeys(e.modifiers));
    if (bench_.isPressed() && !bench_.isOnPedal()) return;
    bench_.saw().picking.move(rayAt(x_, y_));
    if (held_ == kNone) return;
    pans_ ? pan(camera_, dx, dy, context_.height) : orbit(camera_, dx, dy);
  }

  void scroll(double notches) {
    if (bench_.isPressed()) return bench_.deepen(-kNotch * notches);
    zoomAt(context_, pointer()[0], pointer()[1], std::pow(1.15, notches));
  }

  void pressHarder(bool is_wanted) {
    const bool is_harder = is_wanted && bench_.isPressed();
    if (is_harder == is_harder_) return;
    is_harder_ = is_harder;
    bench_.pushHarder(is_harder ? kHarder : 1);
  }

  // ---- Files

  void askForFile(const AppCommand& command) {
    asked_for_ = &command;
    const bool opens = command.id == "file.open" || command.id == "file.open-beside" || command.id == "import.read" ||
                       command.id == "import.add" || command.id == "replay.open" || command.id == "tool.add";
    browser_.show(opens ? FileBrowser::Purpose::kOpen : FileBrowser::Purpose::kSave,
                  opens ? "" : bench_.name() + "-cut.stl", command.id == "file.open");
  }

  void chooseFile() {
    const auto file = browser_.draw();
    if (!file || !asked_for_) return;
    if (browser_.folder() != settings_.values.last_folder) {
      settings_.values.last_folder = browser_.folder();
      if (const auto kept = settings_.save(); !kept && !settings_.error()) bench_.complain(kept.error());
    }
    std::vector<fs::path> several = browser_.takeOthers();
    if (asked_for_->id == "file.open" && !several.empty()) {
      several.insert(several.begin(), *file);
      if (asked_for_->is_enabled(context_)) bench_.importMore(several);
      return;
    }
    const std::vector<std::string> words{file->string()};
    // By hand a scan is looked at before it is prepared; in a script file.open takes the defaults.
    const AppCommand* const command = asked_for_->id == "file.open" ? findAppCommand("import.read") : asked_for_;
    if (command->is_enabled(context_)) (void)command->run(context_, words);
  }

  static constexpr int kNone = -1;
  const WorkshopOptions& options_;
  std::vector<InputEvent> events_;
  Desktop desktop_;  // before what needs its context
  Workbench bench_;
  Camera camera_;
  SettingsFile settings_;
  std::optional<Settings> applied_;  // theme and scale of the panels
  AppContext context_{.bench = bench_, .camera = camera_, .settings = &settings_};
  std::unique_ptr<LiveView> view_;
  std::unique_ptr<ImportView> import_view_;
  std::optional<Camera> camera_before_import_;
  std::unique_ptr<Job<void>> writing_picture_;
  std::unique_ptr<SoundThread> sound_;
  bool is_picture_due_ = false;
  fs::path picture_of_;  // what was shown last, and its box
  Box3 box_;
  PanelState panels_;
  FileBrowser browser_;
  CommandPalette palette_;
  const AppCommand* asked_for_ = nullptr;
  StrokePointer stroke_;
  GamepadHand gamepad_;
  PadRumble pad_rumble_;
  SpaceMouseLink space_mouse_link_;
  SpaceMouseHand space_mouse_;
  Clock::time_point devices_read_ = Clock::now();
  bool is_led_by_device_ = false;  // the mouse has not moved since
  std::optional<ToolOverSurface> over_;
  Clock::time_point last_input_ = Clock::now();
  double x_ = 0, y_ = 0;  // of the pointer, window units
  int window_width_ = 1, window_height_ = 1;
  int held_ = kNone;
  bool pans_ = false, is_harder_ = false, wants_end_ = false, is_software_ = true;
  int frames_ = 0;
};

}  // namespace

Expected<int> runWorkshop(const WorkshopOptions& options) {
  // The software renderer draws in the calling thread: the other core is the haptic thread's.
  ::setenv("LP_NUM_THREADS", std::thread::hardware_concurrency() <= 2 ? "0" : "2", 0);
  return Workshop(options).run();
}

namespace {

// What is done with the workbench while nobody looks at it.
using Play = std::function<Expected<void>(AppContext& context, const std::function<void()>& frame)>;

Expected<void> runOffscreen(const WorkshopOptions& options, const Play& play) {
  ::setenv("LP_NUM_THREADS", std::thread::hardware_concurrency() <= 2 ? "0" : "2", 0);
  const auto gl = OffscreenContext::create(true);
  if (!gl) return fail(gl.error());
  KERF_TRY(view, LiveView::create());
  Workbench bench(options.bench);
  KERF_TRY(camera, cameraFromView(options.view));
  const Camera first = camera;
  SettingsFile settings(options.config);
  AppContext context{
      .bench = bench, .camera = camera, .width = options.width, .height = options.height, .settings = &settings};
  context.screenshot = [&](const fs::path& png) -> Expected<void> {
    view->update(bench);
    KERF_TRY(image, view->picture(bench, camera, context.width, context.height));
    return writePng(png, image);
  };
  LiveView& shown = *view;
  std::optional<internal::GlTarget> screen;
  if (options.is_watched) screen.emplace(options.width, options.height);
  FrameWatch watch;
  const auto frame = [&] {
    watch.begin(bench);
    shown.update(bench);
    if (!bench.scene().bounds().isEmpty() && shown.takeFitWanted()) firstView(context, first);
    if (!screen) return;
    glBindFramebuffer(GL_FRAMEBUFFER, screen->id());
    if (const auto drawn = shown.draw(bench, camera, context.width, context.height, false); !drawn)
      bench.complain(drawn.error());
    glFinish();
    watch.end(bench);
  };
  if (!options.replay.empty())
    bench.watch(options.replay);
  else if (options.open.size() == 1)
    bench.open(options.open.front());
  else if (options.open.size() > 1)
    bench.openAll(options.open);
  auto played = play(context, frame);
  const auto ended = endAll(bench, *view);
  view.reset();
  if (screen) fmt::print("{}\n", watch.summary());
  screen.reset();
  for (const Notice& notice : bench.notices())
    if (!notice.is_error) fmt::print("{}\n", notice.text);
  if (!played) return fail(std::move(played).error());
  if (!ended) return fail(ended.error());
  return {};
}

}  // namespace

Expected<void> runWorkshopScript(const fs::path& script, const WorkshopOptions& options) {
  return runOffscreen(options,
                      [&](AppContext& context, const auto& frame) { return runScript(context, script, frame); });
}

Expected<std::size_t> runWorkshopFilm(const FilmOptions& film, const WorkshopOptions& options) {
  std::size_t pictures = 0;
  KERF_CHECK(runOffscreen(options, [&](AppContext& context, const auto& frame) -> Expected<void> {
    KERF_TRY(written, filmReplay(context, film, frame));
    pictures = written;
    return {};
  }));
  return pictures;
}

}  // namespace kerf
