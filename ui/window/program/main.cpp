// kerf-sim: the window, and pictures without one.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/base/assets.h"
#include "geometry/base/build_info.h"
#include "geometry/base/text.h"
#include "geometry/formats/mesh_formats.h"
#include "sim/run/files/run_files.h"
#include "ui/app/program/command_line.h"
#include "ui/app/program/manual.h"
#include "ui/app/script/window_help.h"
#include "ui/app/view/camera.h"
#include "ui/app/view/scene.h"
#include "ui/app/view/upright.h"
#include "ui/window/main/screenshot.h"
#include "ui/window/main/workshop.h"

namespace {

struct Arguments {
  std::string replay, screenshot, view, up, size, look_at, section, script, data, unit, config, film, device,
      space_mouse;
  std::vector<std::string> scenes, tools, cases;
  double voxel = 0;
  double fps = 10, from = 0, until = std::numeric_limits<double>::infinity();
  double zoom = 1;
  int frames = 0;
  bool transparent = false, no_scale_bar = false, with_grid = false, no_shadow = false, verbose = false, gpu = false;
  bool lists_commands = false, is_watched = false;
};

int complain(const kerf::Error& error, kerf::ExitCode exit_code) {
  kerf::printText(stderr, "kerf-sim: error: {}\n", error.message());
  return exit_code;
}

kerf::Error badValue(const char* option, const std::string& found, const char* expected, const char* example) {
  return {.code = kerf::Error::Code::kBadValue,
          .file = {},
          .place = option,
          .found = "\"" + found + "\"",
          .expected = expected,
          .hint = example};
}

/// Reads exactly the characters of `text`: %n stops short of anything left over.
bool parseSize(const std::string& text, int& width, int& height) {
  int used = 0;
  return std::sscanf(text.c_str(), "%5dx%5d%n", &width, &height, &used) == 2 && used == static_cast<int>(text.size()) &&
         width >= 16 && height >= 16 && width <= 8192 && height <= 8192;
}

bool parsePoint(const std::string& text, kerf::Vec3d& p) {
  int used = 0;
  return std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &p.x(), &p.y(), &p.z(), &used) == 3 &&
         used == static_cast<int>(text.size()) && p.allFinite();
}

/// X,Y,Z,NX,NY,NZ: a point and a direction. Or a word for the point: center,NX,NY,NZ and cut,NX,NY,NZ.
bool parseSection(const std::string& text, kerf::SectionPlane& plane) {
  using Through = kerf::SectionPlane::Through;
  std::string direction = text;
  for (const auto& [word, through] : {std::pair("center,", Through::kCenter), std::pair("cut,", Through::kCut)})
    if (text.starts_with(word)) {
      plane.through = through;
      direction = text.substr(std::string_view(word).size());
    }
  if (plane.through == Through::kPoint) {
    std::size_t comma = 0;
    for (int k = 0; k < 3 && comma != text.npos; ++k) comma = text.find(',', k == 0 ? 0 : comma + 1);
    if (comma == text.npos || !parsePoint(text.substr(0, comma), plane.point)) return false;
    direction = text.substr(comma + 1);
  }
  if (!parsePoint(direction, plane.normal)) return false;
  const double length = plane.normal.norm();
  plane.normal /= length;
  return length > 1e-9 && length < 1e9;
}

bool hasPngEnding(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".png";
}

/// Content and settings of the view: values of the command line.
struct Shown {
  kerf::Camera camera;
  int width = 0, height = 0;
  std::optional<kerf::Vec3d> look_at;
  std::optional<kerf::SectionPlane> cut;
  std::optional<kerf::Vec3d> up;  ///< none: from the scan
};

/// Errors concern the command line.
kerf::Expected<Shown> read(const Arguments& arguments) {
  Shown shown;
  KERF_TRY(camera, kerf::cameraFromView(arguments.view.empty() ? "iso" : arguments.view));
  shown.camera = camera;
  if (!arguments.up.empty() && arguments.up != "auto") {
    auto up = kerf::axisFromName(arguments.up);
    if (!up) return kerf::fail(badValue("--up", arguments.up, "auto, or one of +x, -x, +y, -y, +z, -z", "--up auto"));
    shown.up = *up;
  }
  shown.width = arguments.screenshot.empty() ? 1280 : 1200;
  shown.height = arguments.screenshot.empty() ? 800 : 900;
  if (!arguments.size.empty() && !parseSize(arguments.size, shown.width, shown.height))
    return kerf::fail(badValue("--size", arguments.size, "WxH, 16 to 8192 pixels a side", "--size 1200x900"));

  if (kerf::Vec3d p; !arguments.look_at.empty()) {
    if (!parsePoint(arguments.look_at, p))
      return kerf::fail(badValue("--look-at", arguments.look_at, "X,Y,Z in mm", "--look-at 0,0,5"));
    shown.look_at = p;
  }

  if (kerf::SectionPlane plane; !arguments.section.empty()) {
    if (!parseSection(arguments.section, plane))
      return kerf::fail(badValue("--section", arguments.section,
                                 "X,Y,Z,NX,NY,NZ: a point in mm and a direction; or center or cut instead of the point",
                                 "--section center,0,1,0"));
    shown.cut = plane;
  }

  if (!arguments.screenshot.empty() && !hasPngEnding(arguments.screenshot))
    return kerf::fail(badValue("--screenshot", arguments.screenshot, "a name that ends in .png",
                               std::filesystem::path(arguments.screenshot).replace_extension(".png").c_str()));
  return shown;
}

/// Runs the main window, or a script instead.
kerf::Expected<void> cut(const Arguments& arguments, const Shown& shown) {
  kerf::WorkshopOptions options;
  options.open.assign(arguments.scenes.begin(), arguments.scenes.end());
  options.replay = arguments.replay;
  options.bench.data_folder = arguments.data;
  options.config = arguments.config;
  options.bench.tools = arguments.tools;
  options.bench.voxel_mm = arguments.voxel;
  options.bench.unit = arguments.unit;
  options.bench.device = arguments.device;
  options.space_mouse = arguments.space_mouse;
  options.has_size = !arguments.size.empty();
  options.width = shown.width;
  options.height = shown.height;
  options.frames = arguments.frames;
  options.is_watched = arguments.is_watched;
  options.tells = arguments.verbose;
  if (!arguments.view.empty()) options.view = arguments.view;
  if (!arguments.film.empty()) {
    const kerf::FilmOptions film{arguments.film, arguments.fps, arguments.from, arguments.until};
    KERF_TRY(pictures, kerf::runWorkshopFilm(film, options));
    kerf::printText("{} pictures written: {}\n", pictures, arguments.film);
    return {};
  }
  if (!arguments.script.empty()) return kerf::runWorkshopScript(arguments.script, options);

  KERF_TRY(frames, kerf::runWorkshop(options));
  if (arguments.verbose) kerf::printText(stderr, "kerf-sim: {} frames drawn\n", frames);
  return {};
}

kerf::Expected<void> draw(const Arguments& a, const Shown& shown) {
  return kerf::writeScreenshot({.file = a.screenshot,
                                .scene = a.scenes.front(),
                                .unit = a.unit,
                                .camera = shown.camera,
                                .width = shown.width,
                                .height = shown.height,
                                .zoom = a.zoom,
                                .look_at = shown.look_at,
                                .section = shown.cut,
                                .up = shown.up,
                                .has_shadow = !a.no_shadow,
                                .is_transparent = a.transparent,
                                .has_scale_bar = !a.no_scale_bar,
                                .has_grid = a.with_grid,
                                .uses_gpu = a.gpu,
                                .tells = a.verbose});
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments a;
  CLI::App app(
      "Cuts a scan, a case or the result of a run by hand in a window; draws pictures.\n"
      "Mouse: left cuts, right turns, middle moves, wheel zooms. Keys and commands: kerf help window.");
  app.name("kerf-sim");
  app.set_version_flag("--version", kerf::versionText("kerf-sim", KERF_WINDOW_LIBRARIES));
  app.add_option("scene", a.scenes,
                 "a mesh file (" + kerf::readableFormats() +
                     "), a case folder, a run folder or a session file (.kerf) to continue; of several, the first is "
                     "the object to cut, the others are neighbours")
      ->type_name("MESH|CASE|RUN|SESSION");
  app.add_option("--script", a.script, "run the commands of a file instead of opening a window; needs no display")
      ->type_name("FILE");
  app.add_option("--replay", a.replay, "replay an ended session from the beginning; kerf-sim RUN continues it")
      ->type_name("RUN");
  auto* film = app.add_option("--film", a.film,
                              "with --replay: write pictures of the replay to a new folder instead of opening a "
                              "window: frame-00001.png, ...; needs no display")
                   ->type_name("DIR");
  app.add_option("--fps", a.fps, "with --film: pictures per simulated second")
      ->capture_default_str()
      ->needs(film)
      ->check(CLI::Range(0.001, kerf::FilmOptions::kMostFps));
  app.add_option("--from", a.from, "with --film: start time, s")->needs(film)->capture_default_str();
  app.add_option("--until", a.until, "with --film: end time, s (default: the end of the session)")->needs(film);
  app.add_flag("--watch", a.is_watched,
               "draw the frames of a script as the window does; print frame times, delay from cut to picture, and "
               "timing of the 1 kHz loop");
  app.add_flag("--commands", a.lists_commands,
               "list the commands of the window and of its scripts, as kerf help window and kerf help script");
  app.add_option("--tool", a.tools, "a tool of the rack, by id or file; repeat for several (default: a selection)")
      ->type_name("TOOL")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--voxel", a.voxel, "voxel size of an opened scan, mm (default: as kerf bake chooses)")
      ->type_name("MM")
      ->check(CLI::Range(0.01, 2.0));
  app.add_option("--unit", a.unit,
                 "unit of an opened or drawn scan: mm, cm, m, um or inch (default: from the file, or by its size)")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "cm", "m", "um", "inch"}));
  app.add_option("--case", a.cases,
                 "folder of the case if the run was moved without it. Repeat for the cases of neighbours")
      ->type_name("FOLDER")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--device", a.device,
                 "force-feedback device that controls the tool: bridge, bridge:PORT, replay:FILE, or path or serial "
                 "number from kerf devices; device.arm turns its force on")
      ->type_name("NAME");
  app.add_option("--space-mouse", a.space_mouse, "SpaceMouse to use if several are plugged in")
      ->type_name("PATH|SERIAL");
  app.add_option("--config", a.config, "folder for settings (default: ~/.config/kerf)")->type_name("FOLDER");
  app.add_option("--data", a.data, "folder for cases and sessions (default: ~/.local/share/kerf)")->type_name("FOLDER");

  app.add_option("--screenshot", a.screenshot,
                 "write a picture instead of opening a window; needs no display and no GPU")
      ->type_name("OUT.png");
  app.add_option("--view", a.view,
                 "front, back, left, right, top (or occlusal), bottom, iso, or AZ,EL in degrees: AZ 0 looks along +y, "
                 "90 from +x; EL 90 from above (+z) (default: iso for pictures, top for cutting)")
      ->type_name("NAME");
  app.add_option(
         "--up", a.up,
         "side that is up: +x, -x, +y, -y, +z, -z, or auto (default): away from a base or an open underside; in the "
         "window the occlusal side (view.up). View names depend on it; coordinates stay those of the scan")
      ->type_name("AXIS");
  app.add_option("--size", a.size, "pixels of the picture (default 1200x900) or the window (1280x800)")
      ->type_name("WxH");
  app.add_option("--zoom", a.zoom, "zoom factor; 1 fits the object")
      ->type_name("F")
      ->check(CLI::Range(0.001, 1000.0))
      ->capture_default_str();

  app.add_option("--look-at", a.look_at, "point at the centre of the picture, mm (default: the middle of the mesh)")
      ->type_name("X,Y,Z");
  app.add_option("--section", a.section,
                 "show a section of a case or a run: a point of the plane, mm, and the direction of the removed side. "
                 "Instead of the point: center (middle of the object) or cut (middle of the removed volume of a run)")
      ->type_name("X,Y,Z,NX,NY,NZ | center,NX,NY,NZ | cut,NX,NY,NZ");

  app.add_flag("--transparent", a.transparent, "no background and no ground shadow");
  app.add_flag("--no-shadow", a.no_shadow, "no ground shadow");
  app.add_flag("--no-scale-bar", a.no_scale_bar, "no scale bar in the picture");
  app.add_flag("--grid", a.with_grid,
               "draw a grid in mm, right and up in the view from the scan's origin: the coordinates of kerf pick --at. "
               "From the top with +z up, these are x and y");
  app.add_flag("--gpu", a.gpu, "draw the picture on the graphics card; its bytes then depend on the card");
  for (const char* const option :
       {"--zoom", "--look-at", "--section", "--transparent", "--no-shadow", "--no-scale-bar", "--grid", "--gpu"})
    app.get_option(option)->needs(app.get_option("--screenshot"));
  app.get_option("--screenshot")->excludes(app.get_option("--script"));
  app.add_option("--frames", a.frames, "close the window after N frames (for tests)")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("-v,--verbose", a.verbose, "print the OpenGL driver and the notices of the window");
  app.footer(
      "Exit code 0: done; 1: failed, also without a display or OpenGL 3.3; 2: wrong command line.\n"
      "Kerf is a training and lab tool, not a medical device.");
  kerf::requireFiniteNumbers(app);

  if (kerf::isManualRequest(argc, argv)) return kerf::answerManualRequest(app, argv[2]);
  if (const auto end = kerf::parseCommandLine(app, argc, argv)) return *end;
  if (a.lists_commands) {
    for (const kerf::HelpPage& page : kerf::windowHelp()) kerf::printText("{}\n", kerf::plainText(page));
    return kerf::kOk;
  }
  if (const auto assets = kerf::requireAssets(); !assets) return complain(assets.error(), kerf::kFailed);
  if (a.scenes.empty() && !a.screenshot.empty())
    return complain(badValue("scene", "", "a mesh, a case or a run to draw", "kerf-sim --screenshot OUT.png molar.stl"),
                    kerf::kUsage);
  if (!a.replay.empty() && !(a.scenes.empty() && a.screenshot.empty()))
    return complain(
        badValue("--replay", a.replay, "no other scene, and no --screenshot", "picture.write OUT.png in a script"),
        kerf::kUsage);
  if (!a.film.empty() && (a.replay.empty() || !a.script.empty()))
    return complain(badValue("--film", a.film, "--replay RUN with it, and no --script",
                             "kerf-sim --replay molar.run --film frames"),
                    kerf::kUsage);
  if (a.scenes.size() > 1 && !a.screenshot.empty())
    return complain(
        badValue("scene", a.scenes[1], "one mesh, case or run to draw", "kerf-sim --screenshot OUT.png molar.stl"),
        kerf::kUsage);
  const auto shown = read(a);
  if (!shown) return complain(shown.error(), kerf::kUsage);
  if (!a.cases.empty()) kerf::setPlacesOfCases({a.cases.begin(), a.cases.end()});
  const auto done = a.screenshot.empty() ? cut(a, *shown) : draw(a, *shown);
  return done ? kerf::kOk : complain(done.error(), kerf::kFailed);
} catch (const std::exception& e) {
  std::fprintf(stderr, "kerf-sim: error: %s\n", e.what());
  return kerf::kFailed;
}
