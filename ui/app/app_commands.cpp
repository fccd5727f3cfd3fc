#include "ui/app/app_commands.h"

#include "ui/app/file_commands.h"
#include "ui/app/import_commands.h"
#include "ui/app/settings_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include "ui/app/command_words.h"
#include "ui/app/piece_commands.h"
#include "ui/app/point_readout.h"
#include "ui/app/saw_commands.h"
#include "ui/app/sawing.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// ---- When a command can be given

bool always(const AppContext&) { return true; }
bool isOpen(const AppContext& c) { return c.bench.isOpen(); }
bool isIdle(const AppContext& c) { return !c.bench.job(); }
bool isOpenAndIdle(const AppContext& c) { return isOpen(c) && isIdle(c); }
bool hasPiecesAndIdle(const AppContext& c) { return piece_commands::arePieces(c) && isIdle(c); }
bool isChosenAndIdle(const AppContext& c) { return piece_commands::isChosen(c) && isIdle(c); }
bool hasSection(const AppContext& c) { return c.bench.isOpen() && c.bench.section.has_value(); }
bool hasMeasure(const AppContext& c) { return c.bench.isOpen() && !c.bench.measure.points().empty(); }
bool hasJob(const AppContext& c) { return c.bench.job() != nullptr; }
bool hasLost(const AppContext& c) { return !c.bench.lostSessions().empty() && isIdle(c); }

// ---- What commands do

Expected<void> openFile(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.open(path);
  return {};
}
Expected<void> openDemo(AppContext& c, AppWords words) {
  const auto names = demoNames();
  std::string list;
  for (const char* name : names) {
    list += (list.empty() ? "" : ", ") + std::string(name);
    if (words.empty() || words[0] != name) continue;
    c.bench.openDemo(name);
    return {};
  }
  return wrongWord(words.empty() ? "no demo" : "\"" + words[0] + "\"", "one of " + list);
}
Expected<void> exportFile(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.exportTo(path);
  return {};
}
Expected<void> closeSession(AppContext& c, AppWords) {
  c.bench.close();
  return {};
}
Expected<void> quit(AppContext& c, AppWords) {
  c.wants_quit = true;
  return {};
}
Expected<void> showPalette(AppContext& c, AppWords) {
  c.wants_palette = true;
  return {};
}
Expected<void> cancelJob(AppContext& c, AppWords) {
  c.bench.cancelJob();
  return {};
}
Expected<void> recover(AppContext& c, AppWords words) {
  KERF_TRY(n, numberOr(words, 0, 1, "N", 1, 1e6));
  c.bench.recover(static_cast<std::size_t>(n) - 1);
  return {};
}
Expected<void> undo(AppContext& c, AppWords) {
  c.bench.undo();
  return {};
}
Expected<void> redo(AppContext& c, AppWords) {
  c.bench.redo();
  return {};
}

Expected<void> selectTool(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no tool", "its id");
  if (c.bench.selectTool(words[0])) return {};
  std::string ids;
  for (std::size_t n = 0; n < c.bench.toolCount(); ++n) ids += (n ? ", " : "") + c.bench.tool(n).id;
  return wrongWord("\"" + words[0] + "\"", "one of " + ids);
}
Expected<void> addTool(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.addTool(path);
  return {};
}
std::size_t toolBeside(const AppContext& c, std::size_t way) {
  const std::size_t count = std::max<std::size_t>(c.bench.toolCount(), 1);
  return (c.bench.toolInHand() + way) % count;
}
Expected<void> nextTool(AppContext& c, AppWords) {
  c.bench.selectTool(toolBeside(c, 1));
  return {};
}
Expected<void> previousTool(AppContext& c, AppWords) {
  c.bench.selectTool(toolBeside(c, c.bench.toolCount() - 1));
  return {};
}

Expected<void> setForce(AppContext& c, AppWords words) {
  KERF_TRY(force, numberOf(words, 0, "NEWTONS", Workbench::kLeastForce, Workbench::kMostForce));
  c.bench.setForce(force);
  return {};
}
Expected<void> setDepth(AppContext& c, AppWords words) {
  KERF_TRY(depth, numberOf(words, 0, "MM", 0, c.bench.mostDepth()));
  c.bench.deepen(depth - c.bench.depth_mm);
  return {};
}
Expected<void> deeper(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOr(words, 0, 0.1, "MM", 0, c.bench.mostDepth()));
  c.bench.deepen(mm);
  return {};
}
Expected<void> shallower(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOr(words, 0, 0.1, "MM", 0, c.bench.mostDepth()));
  c.bench.deepen(-mm);
  return {};
}

Expected<void> press(AppContext& c, AppWords words) {
  KERF_TRY(ray, rayOf(c, words));
  if (c.bench.press(ray)) return {};
  return wrongWord(fmt::format("nothing to cut at {}, {}", words[0], words[1]), "a pixel of the object");
}
Expected<void> drag(AppContext& c, AppWords words) {
  KERF_TRY(ray, rayOf(c, words));
  c.bench.drag(ray);
  return {};
}
Expected<void> release(AppContext& c, AppWords) {
  c.bench.release();
  return {};
}

// Through the pixel that the words name, or else through the cursor.
Expected<Ray> pointedRay(const AppContext& c, AppWords words) {
  if (!words.empty()) return rayOf(c, words);
  if (!c.pointer) return wrongWord("no pixel", "X Y, or the cursor over the object");
  return rayUnder(c.camera, (*c.pointer)[0], (*c.pointer)[1], c.width, c.height);
}
Expected<PointReadout> pointed(const AppContext& c, AppWords words) {
  KERF_TRY(ray, pointedRay(c, words));
  const auto readout = readoutAt(c.bench, ray);
  if (!readout) return wrongWord("nothing is there", "a pixel of the object");
  return *readout;
}
void putOut(const AppContext& c, const std::string& text) {
  if (c.set_clipboard) return c.set_clipboard(text);
  fmt::print("{}\n", text);
  std::fflush(stdout);
}
Expected<void> copyPoint(AppContext& c, AppWords words) {
  KERF_TRY(readout, pointed(c, words));
  putOut(c, textOf(readout));
  return {};
}
Expected<void> measurePoint(AppContext& c, AppWords words) {
  KERF_TRY(ray, pointedRay(c, words));
  const auto seen = c.bench.behindSection(ray);
  const auto hit = seen ? c.bench.scene().hit(*seen) : std::nullopt;
  if (!hit) return wrongWord("nothing is there", "a pixel of the object");
  c.bench.measure.add(hit->on_surface.point);
  return {};
}
Expected<void> copyMeasure(AppContext& c, AppWords) {
  putOut(c, c.bench.measure.text());
  return {};
}
Expected<void> clearMeasure(AppContext& c, AppWords) {
  c.bench.measure.clear();
  return {};
}
Expected<void> copyPathRow(AppContext& c, AppWords words) {
  KERF_TRY(readout, pointed(c, words));
  putOut(c, pathRowOf(readout));
  return {};
}

Expected<void> fit(AppContext& c, AppWords) {
  fitToBox(c.camera, c.bench.scene().bounds(), c.width, c.height);
  return {};
}
Expected<void> view(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no view", "its name");
  KERF_TRY(named, cameraFromView(words[0]));
  c.camera = named;
  return fit(c, {});
}
// Square to the view: what is nearer than a point goes.
Expected<void> cutOpen(AppContext& c, AppWords words) {
  if (c.bench.section && words.empty()) {
    c.bench.section.reset();
    return {};
  }
  Vec3d through = c.bench.scene().bounds().center();
  if (!words.empty() || c.pointer) {
    KERF_TRY(ray, pointedRay(c, words));
    if (const auto hit = c.bench.scene().hit(ray)) through = hit->on_surface.point;
  }
  c.bench.section = Plane{through, c.camera.backwards()};
  return {};
}
Expected<void> moveSection(AppContext& c, AppWords words, double way) {
  KERF_TRY(mm, numberOr(words, 0, 0.2, "MM", 0, 1000));
  c.bench.section->point += way * mm * c.bench.section->normal;
  return {};
}
Expected<void> sectionDeeper(AppContext& c, AppWords words) { return moveSection(c, words, -1); }
Expected<void> sectionNearer(AppContext& c, AppWords words) { return moveSection(c, words, 1); }

Expected<void> zoom(AppContext& c, AppWords words) {
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", 0.01, 100));
  zoomBy(c.camera, factor);
  return {};
}
template <std::size_t N>
Expected<void> namedView(AppContext& c, AppWords) {
  const std::string words[] = {std::string(namedViews()[N].name)};
  return view(c, words);
}
Expected<void> screenshot(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  if (c.screenshot) return c.screenshot(path);
  return wrongWord("nothing is drawn here", "a window, or a picture without one");
}

constexpr AppCommand kCommands[] = {
    {"file.open", "File", "Open...", "Ctrl+O", "PATH",
     "Opens a scan, a recipe or a case to cut; a scan is prepared first.", isIdle, openFile},
    {"import.read", "", "", "", "PATH",
     "Reads a scan and shows what was found in it, before it is prepared; a recipe or a case is opened.", isIdle,
     importRead},
    {"import.unit", "", "", "", "UNIT", "Takes the scan as mm, cm, m, um or inch.", isImporting, importUnit},
    {"import.close", "", "", "", "WAY", "Chooses what closes the scan: automatic, base, holes or wrap.", isImporting,
     importClose},
    {"import.base", "", "", "", "SHAPE [MM]",
     "Gives the base its shape, horseshoe or full, and its thickness below the scan, 2 mm if not told.", isImporting,
     importBase},
    {"import.plane", "", "", "", "on|off", "Makes the base parallel to the occlusal plane.", isImporting, importPlane},
    {"import.holes", "", "", "", "MM|auto", "Fills holes up to that length around; a longer one is a rim.", isImporting,
     importHoles},
    {"import.wrap", "", "", "", "MM", "Sets how wide hollows may be that a wrap bridges.", isImporting, importWrap},
    {"import.voxel", "", "", "", "MM|auto", "Sets the voxel size, 0.02 to 0.5 mm.", isImporting, importVoxel},
    {"import.preview", "File", "Preview the closed scan", "", "", "Closes the scan and shows the solid.", isImporting,
     importPreview},
    {"import.start", "File", "Prepare and cut", "Enter", "", "Prepares the scan as chosen and opens it.", isImporting,
     importStart},
    {"import.cancel", "File", "Put the scan away", "Esc", "", "Leaves the scan alone and goes back.", isImporting,
     importCancel},
    {"file.demo", "", "", "", "NAME", "Opens one of our own: molar, mandible or arch.", isIdle, openDemo},
    {"file.export", "File", "Export...", "Ctrl+E", "PATH",
     "Writes the cut object as a mesh, reads it back and checks it.", isOpenAndIdle, exportFile},
    {"file.export-each", "File", "Export each piece...", "", "PATH", "Writes a file a piece, NAME-PIECE.stl.",
     hasPiecesAndIdle, piece_commands::exportEach},
    {"file.export-piece", "File", "Export the chosen piece...", "", "PATH", "Writes the chosen piece alone.",
     isChosenAndIdle, piece_commands::exportChosen},
    {"file.export-put-back", "File", "Export pieces put back...", "", "PATH",
     "Writes all pieces where they were in the scan, wherever they were moved to.", hasPiecesAndIdle,
     piece_commands::exportPutBack},
    {"file.close", "File", "End the session", "Ctrl+W", "",
     "Writes the session as a run that can be replayed and exported.", isOpenAndIdle, closeSession},
    {"session.recover", "File", "Recover a session", "", "[N]",
     "Finishes a session whose program was killed; 1 is the newest.", hasLost, recover},
    {"session.forget", "", "", "", "N delete", "Deletes a lost session with its log, for good.", hasLostSession,
     sessionForget},
    {"recent.open", "File", "Open the last file again", "Ctrl+Shift+O", "[N]",
     "Opens a file that was opened before; 1 is the newest.", hasRecent, recentOpen},
    {"recent.forget", "", "", "", "N", "Takes a file off the list of recent files; the file stays.", hasRecent,
     recentForget},
    {"job.cancel", "File", "Cancel what is under way", "", "",
     "Ends the job under way and leaves nothing of it behind.", hasJob, cancelJob},
    {"app.quit", "File", "Quit", "Ctrl+Q", "", "Ends the session, writes it and closes the window.", always, quit},

    {"edit.undo", "Edit", "Undo", "Ctrl+Z", "", "Takes back the last stroke.", isOpen, undo},
    {"edit.redo", "Edit", "Redo", "Ctrl+Y", "", "Does the stroke again that was taken back last.", isOpen, redo},

    {"palette.show", "Edit", "Commands...", "Ctrl+Shift+P", "", "Finds a command by words and runs it.", always,
     showPalette},
    {"settings.show", "Edit", "Settings...", "Ctrl+,", "", "Shows the settings, or puts them away.", hasSettings,
     showSettings},
    {"settings.push", "", "", "", "", "Keeps push and depth of now for later sessions.", hasSettings, keepPush},

    {"tool.select", "", "", "", "ID", "Takes another tool.", isOpen, selectTool},
    {"tool.add", "Tool", "Add a tool...", "", "PATH",
     "Puts a tool's file into the rack, or reads it anew, and takes the tool.", isIdle, addTool},
    {"tool.next", "Tool", "Next tool", "]", "", "Takes the next tool of the rack.", isOpen, nextTool},
    {"tool.previous", "Tool", "Previous tool", "[", "", "Takes the tool before.", isOpen, previousTool},
    {"cut.force", "", "", "", "NEWTONS", "Sets how hard a pressed button pushes, 0.1 to 8 N.", always, setForce},
    {"cut.depth", "", "", "", "MM",
     "Sets how deep below the surface as loaded a stroke may go, 0 to 5 mm; along a guide to its depth.", always,
     setDepth},
    {"cut.deeper", "Tool", "Deeper", ".", "[MM]", "Lets a stroke go deeper, by 0.1 mm if not told.", always, deeper},
    {"cut.shallower", "Tool", "Less deep", ",", "[MM]", "Lets a stroke go less deep, by 0.1 mm if not told.", always,
     shallower},
    {"cut.press", "", "", "", "X Y", "Presses the button at a pixel: a stroke begins.", isOpen, press},
    {"cut.drag", "", "", "", "X Y", "Moves the pressed pointer to a pixel.", isOpen, drag},
    {"cut.release", "", "", "", "", "Lets go of the button: the stroke ends.", isOpen, release},

    {"piece.choose", "", "", "", "PIECE", "Chooses a piece by its name or number; moves are of that.", isOpen,
     piece_commands::choose},
    {"piece.next", "Piece", "Choose the next", "Tab", "", "Chooses the next piece, after the last one none.",
     piece_commands::arePieces, piece_commands::chooseNext},
    {"piece.move", "", "", "", "X Y Z", "Moves the chosen piece by so many mm.", isOpen, piece_commands::move},
    {"piece.turn", "", "", "", "X|Y|Z DEGREES", "Turns the chosen piece about its middle.", isOpen,
     piece_commands::turn},
    {"piece.put-back", "Piece", "Put back", "", "", "Puts the chosen piece back where it was in the scan.",
     piece_commands::isChosen, piece_commands::putBack},
    {"piece.hide", "Piece", "Hide", "H", "", "Hides the chosen piece.", piece_commands::isChosen, piece_commands::hide},
    {"piece.show-all", "Piece", "Show all", "Shift+H", "", "Shows all pieces.", isOpen, piece_commands::show},
    {"piece.rename", "", "", "", "NAME", "Gives the chosen piece a name, for the list and for files.", isOpen,
     piece_commands::rename},
    {"saw.pick-points", "Saw", "Plane from three points", "P", "", "Picks three points of the surface, by mouse.",
     isOpen, saw_commands::pickPoints},
    {"saw.pick-line", "Saw", "Plane from a line", "L", "", "Draws a line across the bone, by mouse.", isOpen,
     saw_commands::pickLine},
    {"saw.pick-face", "Saw", "Plane under a face", "", "", "Picks a face, by mouse.", isOpen, saw_commands::pickFace},
    {"saw.pick-nothing", "Saw", "Leave picking", "Esc", "", "Leaves picking; nothing is planned.",
     saw_commands::isPicking, saw_commands::pickNothing},
    {"saw.plane-from-points", "", "", "", "X1 Y1 X2 Y2 X3 Y3",
     "Plans a plane through three points of the surface, at pixels.", isOpen, saw_commands::fromPoints},
    {"saw.line", "", "", "", "X1 Y1 X2 Y2", "Plans a plane through a line of the picture, along the view.", isOpen,
     saw_commands::line},
    {"saw.plane-from-view", "Saw", "Plane upright in this view", "", "[X Y]",
     "Plans a plane that is seen edge-on, through the middle of the view or a pixel.", isOpen, saw_commands::fromView},
    {"saw.plane-from-face", "", "", "", "X Y [MM]",
     "Plans a plane parallel to the surface at a pixel, 1 mm under it if not told.", isOpen, saw_commands::fromFace},
    {"saw.plane", "", "", "", "X Y Z NX NY NZ", "Plans a plane through a point, mm, square to a normal.", isOpen,
     saw_commands::fromNumbers},
    {"saw.choose", "", "", "", "NAME", "Chooses another planned plane.", saw_commands::hasPlane, saw_commands::choose},
    {"saw.rename", "", "", "", "NAME", "Gives the chosen plane another name.", saw_commands::hasPlane,
     saw_commands::rename},
    {"saw.delete", "Saw", "Delete the plane", "", "", "Takes the chosen plane out of the plan.", saw_commands::hasPlane,
     saw_commands::remove},
    {"saw.move", "", "", "", "MM", "Moves the chosen plane along its normal.", saw_commands::hasPlane,
     saw_commands::move},
    {"saw.turn", "", "", "", "DEG", "Turns the chosen plane about the way the teeth go in.", saw_commands::hasPlane,
     saw_commands::turn},
    {"saw.tilt", "", "", "", "DEG", "Turns the chosen plane about its line along the teeth.", saw_commands::hasPlane,
     saw_commands::tilt},
    {"saw.approach", "", "", "", "DEG", "Turns, within the chosen plane, the way the teeth go in.",
     saw_commands::hasPlane, saw_commands::approach},
    {"saw.width", "", "", "", "MM", "Bounds the chosen plane along the teeth, at most to the blade.",
     saw_commands::hasPlane, saw_commands::width},
    {"saw.depth", "", "", "", "MM", "Bounds how deep the chosen plane goes, at most to the blade's reach.",
     saw_commands::hasPlane, saw_commands::depth},
    {"saw.fit", "Saw", "Fit the plane to bone and blade", "", "", "Bounds the chosen plane to bone and blade anew.",
     saw_commands::hasPlane, saw_commands::fit},
    {"saw.save", "", "", "", "FILE", "Writes all planned planes to a file.", isOpen, saw_commands::save},
    {"saw.load", "", "", "", "FILE", "Reads planned planes from a file or a session's folder.", isOpen,
     saw_commands::load},
    {"saw.cut", "Saw", "Cut this plane now", "", "[NEWTONS]",
     "Saws the chosen plane with the saw in hand, pushed with 5 N at most if not told.", saw_commands::hasPlane,
     saw_commands::cut},
    {"saw.stop", "Saw", "Stop sawing", "", "", "Breaks a planned cut off and draws the blade out.",
     saw_commands::isCutting, saw_commands::stop},
    {"saw.guide", "Saw", "Guide the blade", "G", "[on|off]",
     "Keeps a saw moved by mouse in the chosen plane, or lets it free.", isOpen, saw_commands::guide},

    {"point.copy", "Edit", "Copy the point under the cursor", "Ctrl+C", "[X Y]",
     "Copies point, normal, tissue and thickness along the view, in the scan's frame, as text.", isOpen, copyPoint},
    {"point.copy-row", "Edit", "Copy it as a row of a path", "Ctrl+Shift+C", "[X Y]",
     "Copies the tool's pose there as a row of a path: t,x,y,z,qw,qx,qy,qz.", isOpen, copyPathRow},

    {"measure.point", "Edit", "Measure from here", "M", "[X Y]",
     "Sets a point of the surface: distances between points, and angles at them, are shown.", isOpen, measurePoint},
    {"measure.copy", "Edit", "Copy what was measured", "", "", "Copies distances and angles as text.", hasMeasure,
     copyMeasure},
    {"measure.clear", "Edit", "Measure no more", "Shift+M", "", "Takes all points away.", hasMeasure, clearMeasure},

    {"view.fit", "View", "Fit", "F", "", "Shows all of the object.", isOpen, fit},
    {"view.front", "View", "Front", "1", "", "Looks along +y.", always, namedView<0>},
    {"view.back", "View", "Back", "2", "", "Looks along -y.", always, namedView<1>},
    {"view.left", "View", "Left", "3", "", "Looks along +x.", always, namedView<2>},
    {"view.right", "View", "Right", "4", "", "Looks along -x.", always, namedView<3>},
    {"view.top", "View", "Top", "5", "", "Looks down on the occlusal side, along -z.", always, namedView<4>},
    {"view.bottom", "View", "Bottom", "6", "", "Looks up from below, along +z.", always, namedView<5>},
    {"view.iso", "View", "Oblique", "7", "", "Looks from in front, above and the right.", always, namedView<6>},
    {"view.from", "", "", "", "NAME|AZ,EL", "Looks from a named side or two angles in degrees.", always, view},
    {"view.section", "View", "Cut open", "X", "[X Y]",
     "Takes away what is nearer than the point under the cursor, or than the middle; again: shows all.", isOpen,
     cutOpen},
    {"view.section-deeper", "View", "Section deeper", "PageDown", "[MM]", "Moves the section away, 0.2 mm if not told.",
     hasSection, sectionDeeper},
    {"view.section-nearer", "View", "Section nearer", "PageUp", "[MM]",
     "Moves the section towards the viewer of before, 0.2 mm if not told.", hasSection, sectionNearer},
    {"view.zoom", "", "", "", "FACTOR", "Makes things larger by a factor.", always, zoom},
    {"view.theme", "View", "Light or dark", "Ctrl+Shift+L", "[light|dark]", "Changes between light and dark panels.",
     hasSettings, setTheme},
    {"view.larger", "View", "Larger type", "Ctrl+=", "", "Makes type and panels larger.", hasSettings, makeLarger},
    {"view.smaller", "View", "Smaller type", "Ctrl+-", "", "Makes type and panels smaller.", hasSettings, makeSmaller},
    {"view.scale", "", "", "", "FACTOR", "Sets the size of type and panels, 0.75 to 3.", hasSettings, setScale},
    {"view.hints", "View", "Hints for the mouse", "", "[on|off]", "Shows or hides the hints.", hasSettings, setHints},
    {"picture.write", "", "", "", "OUT.png", "Writes what is shown as a picture.", always, screenshot},
};

// ---- Scripts

Expected<std::vector<std::string>> wordsOf(const std::string& line) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < line.size();) {
    if (std::isspace(static_cast<unsigned char>(line[at]))) {
      ++at;
      continue;
    }
    if (line[at] == '#') break;
    if (line[at] == '"') {
      const std::size_t end = line.find('"', at + 1);
      if (end == line.npos) return wrongWord(line, "a closing quote");
      out.push_back(line.substr(at + 1, end - at - 1));
      at = end + 1;
      continue;
    }
    std::size_t end = at;
    while (end < line.size() && !std::isspace(static_cast<unsigned char>(line[end]))) ++end;
    out.push_back(line.substr(at, end - at));
    at = end;
  }
  return out;
}

void frameOf(const std::function<void()>& frame) {
  frame();
  std::this_thread::sleep_for(std::chrono::milliseconds(16));
}

Expected<void> wait(AppContext& c, AppWords words, const std::function<void()>& frame) {
  if (words.empty()) {
    do frameOf(frame);
    while (c.bench.job() || isPreviewing(c) || c.bench.saw().isCutting() ||
           (c.bench.isOpen() && c.bench.scene().triangleCount() == 0));
    return {};
  }
  KERF_TRY(seconds, numberOf(words, 0, "SECONDS", 0, 36000));
  if (!c.bench.isOpen()) return wrongWord("nothing is open", "a session whose clock runs");
  frame();
  const auto until = c.bench.report().tick + static_cast<std::uint64_t>(seconds / kTick);
  while (c.bench.isOpen() && c.bench.report().tick < until) frameOf(frame);
  return {};
}

void printState(const AppContext& c) {
  nlohmann::json j{{"open", c.bench.isOpen()},
                   {"name", c.bench.name()},
                   {"removed_mm3", c.bench.removedMm3()},
                   {"force_N", c.bench.force},
                   {"depth_mm", c.bench.depth_mm},
                   {"ticks", c.bench.report().tick},
                   {"pieces", c.bench.scene().shown().size()},
                   {"triangles", c.bench.scene().triangleCount()},
                   {"planes", c.bench.saw().plan().planes().size()},
                   {"sawn_percent", 100 * c.bench.saw().lastShare()}};
  if (c.bench.importPlan()) j["import"] = nlohmann::json::parse(importState(*c.bench.importPlan()));
  if (c.bench.isOpen()) j["tool"] = c.bench.tool(c.bench.toolInHand()).id;
  if (const auto depth = c.bench.depthNow()) j["depth_now_mm"] = *depth;
  fmt::print("{}\n", j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  std::fflush(stdout);
}

Expected<void> expect(const AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("nothing", "removed, depth, sawn, triangles or pieces, and its range");
  KERF_TRY(low, numberOf(words, 1, "LOW", -1e12, 1e12));
  KERF_TRY(high, numberOf(words, 2, "HIGH", -1e12, 1e12));
  double value = 0;
  if (words[0] == "removed")
    value = c.bench.removedMm3();
  else if (words[0] == "depth")
    value = c.bench.depthNow().value_or(0);
  else if (words[0] == "sawn")
    value = 100 * c.bench.saw().lastShare();
  else if (words[0] == "triangles")
    value = static_cast<double>(c.bench.scene().triangleCount());
  else if (words[0] == "pieces")
    value = static_cast<double>(c.bench.scene().shown().size());
  else
    return wrongWord("\"" + words[0] + "\"", "removed, depth, sawn, triangles or pieces");
  if (value >= low && value <= high) return {};
  return wrongWord(fmt::format("{} {:g}", words[0], value), fmt::format("{:g} to {:g}", low, high));
}

// Notices that are errors end a script.
Expected<void> failOnError(const AppContext& c, std::size_t& seen) {
  for (; seen < c.bench.notices().size(); ++seen)
    if (const Notice& notice = c.bench.notices()[seen]; notice.is_error) return wrongWord(notice.text, "no error");
  return {};
}

}  // namespace

std::span<const AppCommand> appCommands() { return kCommands; }

const AppCommand* findAppCommand(std::string_view id) {
  for (const AppCommand& command : kCommands)
    if (command.id == id) return &command;
  return nullptr;
}

Expected<void> runAppCommand(AppContext& context, std::string_view id, AppWords parameters) {
  const AppCommand* const command = findAppCommand(id);
  if (!command)
    return fail({.code = Error::Code::kNotFound,
                 .found = fmt::format("\"{}\"", id),
                 .expected = "a command of the window",
                 .hint = "kerf-sim --commands lists them"});
  if (!command->is_enabled(context))
    return fail({.code = Error::Code::kUnsupported,
                 .found = fmt::format("{} can not be done now", id),
                 .expected = "an open case, and no job under way",
                 .hint = "in a script: wait"});
  return command->run(context, parameters);
}

Expected<std::vector<std::string>> wordsOfLine(const std::string& line) { return wordsOf(line); }

std::string appCommandReference() {
  std::string out =
      "# Commands of the window\n\n<!-- Written by scripts/reference from kerf-sim --commands. Do not edit: change "
      "ui/app/app_commands.cpp and run it again. -->\n\n"
      "Menus, keys and scripts (`kerf-sim --script FILE`) run these. A script holds one a line; # begins a comment, "
      "words in "
      "double quotes may hold blanks. X and Y are pixels of the picture, Y downwards. Beside them a script has `wait` "
      "(until "
      "no job runs and no plane is sawn), `wait SECONDS` (of the simulation), `print` (the state, as JSON) and `expect "
      "removed|depth|sawn|triangles|pieces LOW HIGH`. The first error ends it, "
      "with "
      "exit code 1 and the line.\n\n| command | parameters | key | what it does |\n|---|---|---|---|\n";
  for (const AppCommand& c : kCommands)
    out += fmt::format("| `{}` | {} | {} | {} |\n", c.id, c.parameters.empty() ? "" : fmt::format("`{}`", c.parameters),
                       c.key.empty() ? "" : fmt::format("`{}`", c.key), c.description);
  return out;
}

Expected<Ray> rayOf(const AppContext& c, AppWords words, std::size_t n) {
  KERF_TRY(x, numberOf(words, n, "X", -1e5, 1e5));
  KERF_TRY(y, numberOf(words, n + 1, "Y", -1e5, 1e5));
  return rayUnder(c.camera, x, y, c.width, c.height);
}

Ray rayUnder(const Camera& camera, double x, double y, int width, int height) {
  constexpr double kOff = 300;  // mm: farther off than any case is large
  const double mm = camera.mmPerPixel(height);
  Ray ray;
  ray.direction = -camera.backwards();
  ray.origin = camera.target + mm * (x - 0.5 * width) * camera.right() - mm * (y - 0.5 * height) * camera.up() +
               kOff * camera.backwards();
  return ray;
}

std::array<double, 2> pixelOf(const Camera& camera, const Vec3d& point, int width, int height) {
  const Vec3d from_target = (point - camera.target) / camera.mmPerPixel(height);
  return {0.5 * width + camera.right().dot(from_target), 0.5 * height - camera.up().dot(from_target)};
}

void firstView(AppContext& context, const Camera& otherwise) {
  context.camera = otherwise;
  if (const auto& normal = context.bench.occlusalNormal()) {
    context.camera.elevation = std::asin(std::clamp(normal->z(), -1.0, 1.0));
    context.camera.azimuth = std::abs(normal->z()) > 0.999 ? 0 : std::atan2(normal->x(), -normal->y());
  }
  fitToBox(context.camera, context.bench.scene().bounds(), context.width, context.height);
}

void fitToBox(Camera& camera, const Box3& box, int width, int height) {
  if (box.isEmpty()) return;
  Mesh corners;
  for (int n = 0; n < 8; ++n) corners.vertices.push_back(box.corner(n));
  fitTo(camera, corners, width, height);
}

Expected<void> runScript(AppContext& context, const fs::path& script, const std::function<void()>& frame) {
  std::ifstream in(script);
  if (!in)
    return fail({.code = Error::Code::kNotFound,
                 .file = script.string(),
                 .found = "cannot be read",
                 .expected = "lines of commands",
                 .hint = "kerf-sim --commands lists them"});
  std::size_t seen = 0;
  std::string line;
  for (int n = 1; std::getline(in, line) && !context.wants_quit; ++n) {
    const auto done = [&]() -> Expected<void> {
      KERF_TRY(words, wordsOf(line));
      if (words.empty()) return {};
      const AppWords parameters = AppWords(words).subspan(1);
      if (words[0] == "wait")
        KERF_CHECK(wait(context, parameters, frame));
      else if (words[0] == "expect")
        KERF_CHECK(expect(context, parameters));
      else if (words[0] == "print")
        printState(context);
      else
        KERF_CHECK(runAppCommand(context, words[0], parameters));
      frame();
      return failOnError(context, seen);
    }();
    if (done) continue;
    Error error = done.error();
    error.file = script.string();
    error.place = fmt::format("line {}: {}", n, line);
    return fail(std::move(error));
  }
  return {};
}

}  // namespace kerf
