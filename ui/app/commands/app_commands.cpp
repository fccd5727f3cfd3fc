#include "ui/app/commands/app_commands.h"

#include <fmt/format.h>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/device_commands.h"
#include "ui/app/commands/edit_commands.h"
#include "ui/app/commands/export_commands.h"
#include "ui/app/commands/file_commands.h"
#include "ui/app/commands/hand_commands.h"
#include "ui/app/commands/import_commands.h"
#include "ui/app/commands/neighbour_commands.h"
#include "ui/app/commands/piece_commands.h"
#include "ui/app/commands/point_commands.h"
#include "ui/app/commands/quit.h"
#include "ui/app/commands/replay_commands.h"
#include "ui/app/commands/saw_commands.h"
#include "ui/app/commands/settings_commands.h"
#include "ui/app/commands/tissue_commands.h"
#include "ui/app/commands/tool_commands.h"
#include "ui/app/commands/tooth_views.h"
#include "ui/app/commands/view_commands.h"

namespace kerf {
namespace {

// ---- When a command is enabled

bool always(const AppContext&) { return true; }
bool isOpen(const AppContext& c) { return c.bench.isOpen(); }
bool isShown(const AppContext& c) { return c.bench.isShown(); }
bool isIdle(const AppContext& c) { return !c.bench.job(); }
bool isOpenAndIdle(const AppContext& c) { return isOpen(c) && isIdle(c); }
bool hasPiecesAndIdle(const AppContext& c) { return piece_commands::arePieces(c) && isIdle(c); }
bool isChosenAndIdle(const AppContext& c) { return piece_commands::isChosen(c) && isIdle(c); }
bool hasJob(const AppContext& c) { return c.bench.job() != nullptr; }
bool hasLost(const AppContext& c) { return !c.bench.lostSessions().empty() && isIdle(c); }

// ---- Actions of commands

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

constexpr AppCommand kCommands[] = {
    {"file.open", "File", "Open...", "Ctrl+O", "PATH",
     "Opens a scan, a recipe or a case to cut; a scan is prepared first.", isIdle, openFile},
    {"file.open-beside", "File", "Open beside...", "", "PATH",
     "Places a scan, a recipe or a case beside what is open, where its scan is: a neighbouring tooth, the other jaw.",
     isIdle, neighbour_commands::openBeside},
    {"import.read", "", "", "", "PATH...",
     "Reads scans or label volumes and shows what was found in them, before they are prepared: the first is to be cut, "
     "the others stand beside it. A recipe, a case or a run alone is opened.",
     isIdle, importRead},
    {"import.add", "File", "Import one more...", "", "PATH",
     "Reads one more, to stand beside what is looked at already.", isImporting, importAdd},
    {"import.choose", "", "", "", "N", "Shows the choices about one of several files.", isImportingSeveral,
     importChoose},
    {"import.role", "", "", "", "N cut|beside|out|tool",
     "Says what becomes of a file: it is cut, it stands beside, it is left out, or a mesh becomes a tool of the rack. "
     "While something is open a file alone may stand beside that.",
     isImporting, importRole},
    {"import.tool-axis", "", "", "", "WAY",
     "Says which way a mesh that becomes a tool is held, from its tip to its shank: +x, -x, +y, -y, +z, -z, length, "
     "-length, thin-end, or auto: its thinnest end is the tip.",
     isImportingTool, importToolAxis},
    {"import.tool-cut", "", "", "", "MM", "Says how far above its tip it cuts, 0.1 to 50 mm.", isImportingTool,
     importToolCut},
    {"import.tissue", "", "", "", "LABEL TISSUE|none",
     "Says which tissue a label of a CT is: an id of materials.toml; none leaves it out.", isImportingLabels,
     importTissue},
    {"import.unit", "", "", "", "UNIT", "Takes the scan as mm, cm, m, um or inch.", isImportingScan, importUnit},
    {"import.close", "", "", "", "WAY", "Chooses what closes the scan: automatic, base, holes or wrap.",
     isImportingScan, importClose},
    {"import.base", "", "", "", "SHAPE [MM]",
     "Gives the base its shape, horseshoe or full, and its thickness below the scan, 2 mm if not told.",
     isImportingScan, importBase},
    {"import.smooth", "", "", "", "MM",
     "Lets the walls of a horseshoe have no waves shorter than that, 0 to 20 mm; 0: straight under the rim.",
     isImportingScan, importSmooth},
    {"import.plane", "", "", "", "on|off", "Makes the base parallel to the occlusal plane.", isImportingScan,
     importPlane},
    {"import.holes", "", "", "", "MM|auto", "Fills holes up to that length around; a longer one is a rim.",
     isImportingScan, importHoles},
    {"import.wrap", "", "", "", "MM", "Sets how wide hollows may be that a wrap bridges.", isImportingScan, importWrap},
    {"import.voxel", "", "", "", "MM|auto", "Sets the voxel size, 0.02 to 0.5 mm.", isImporting, importVoxel},
    {"import.preview", "File", "Preview the closed scan", "", "",
     "Closes the scan and shows the solid; of labels the smooth surface around their tissues.", isImporting,
     importPreview},
    {"import.start", "File", "Prepare and cut", "Enter", "", "Prepares all as chosen and opens it.", isImporting,
     importStart},
    {"import.cancel", "File", "Put the scan away", "Esc", "", "Leaves the files alone and goes back.", isImporting,
     importCancel},
    {"file.demo", "", "", "", "NAME", "Opens one of our own: molar, mandible or arch.", isIdle, openDemo},
    {"export.show", "File", "Export...", "Ctrl+E", "[on|off]",
     "Shows what is exported, in which format and where to, and checks it; or puts that away.",
     export_commands::canShow, export_commands::show},
    {"export.pieces", "", "", "", "WHICH [NAME]",
     "Chooses what is exported: all in one file, each piece in a file of its own, put-back, piece NAME, beside NAME.",
     export_commands::isShown, export_commands::choose},
    {"export.format", "", "", "", "FORMAT",
     "Chooses the format of the file by its name: stl, 3mf or another that is written.", export_commands::isShown,
     export_commands::format},
    {"export.to", "", "", "", "PATH", "Chooses the file that is written; its ending is the format.",
     export_commands::isShown, export_commands::to},
    {"export.check", "", "", "", "", "Checks again what would be exported, without writing it.",
     export_commands::isShown, export_commands::check},
    {"export.write", "", "", "", "[replace] [anyway]",
     "Writes the file, reads it back and checks it; replace: one that is there already; anyway: also what is not ready "
     "to print.",
     export_commands::isShown, export_commands::write},
    {"export.show-in-folder", "File", "Show what was exported in its folder", "", "",
     "Shows what was exported last in the file manager of the desktop.", export_commands::isWritten,
     export_commands::showInFolder},
    {"file.export", "", "", "", "PATH", "Writes the cut object as a mesh, reads it back and checks it.", isOpenAndIdle,
     exportFile},
    {"file.export-each", "", "", "", "PATH", "Writes a file a piece, NAME-PIECE.stl.", hasPiecesAndIdle,
     piece_commands::exportEach},
    {"file.export-piece", "", "", "", "PATH", "Writes the chosen piece alone.", isChosenAndIdle,
     piece_commands::exportChosen},
    {"file.export-put-back", "", "", "", "PATH",
     "Writes all pieces where they were in the scan, wherever they were moved to.", hasPiecesAndIdle,
     piece_commands::exportPutBack},
    {"file.export-beside", "", "", "", "PATH [NEIGHBOUR]",
     "Writes a neighbour with what was cut off it; if not told, the one that was cut most.",
     neighbour_commands::hasNeighboursAndIdle, neighbour_commands::exportBeside},
    {"file.close", "File", "End the session", "Ctrl+W", "",
     "Writes the session as a run that can be replayed and exported.", isOpenAndIdle, closeSession},
    {"session.recover", "File", "Recover a session", "", "[N]",
     "Finishes a session whose program was killed; 1 is the newest.", hasLost, recover},
    {"session.forget", "", "", "", "N delete", "Deletes a lost session with its log, for good.", hasLostSession,
     sessionForget},
    {"replay.open", "File", "Watch a session...", "", "PATH",
     "Shows a session that has ended as it was cut, from its beginning.", isIdle, replay_commands::open},
    {"replay.play", "", "", "", "", "Plays on; at the end: from the beginning.", replay_commands::isWatching,
     replay_commands::play},
    {"replay.pause", "", "", "", "", "Holds the session where it is.", replay_commands::isWatching,
     replay_commands::pause},
    {"replay.toggle", "Replay", "Play or pause", "K", "", "Plays on, or holds the session where it is.",
     replay_commands::isWatching, replay_commands::toggle},
    {"replay.speed", "", "", "", "FACTOR|fastest",
     "Plays 0.25 to 16 times as fast as it was cut, or as fast as it can.", replay_commands::isWatching,
     replay_commands::speed},
    {"replay.jump", "", "", "", "STEP", "Goes to the end of a step of the session; 0 is the beginning.",
     replay_commands::isWatching, replay_commands::jump},
    {"replay.time", "", "", "", "SECONDS", "Goes to a moment, in seconds of the session's own clock.",
     replay_commands::isWatching, replay_commands::time},
    {"replay.next", "Replay", "To the end of the next step", "N", "", "Goes to the end of the next step.",
     replay_commands::isWatching, replay_commands::next},
    {"replay.previous", "Replay", "To the end of the step before", "B", "", "Goes to the end of the step before.",
     replay_commands::isWatching, replay_commands::previous},
    {"replay.begin", "Replay", "To the beginning", "Shift+B", "", "Goes to the beginning of the session.",
     replay_commands::isWatching, replay_commands::begin},
    {"replay.end", "Replay", "To the end", "Shift+N", "",
     "Goes to the end of the session, and says whether its state is the one that was recorded.",
     replay_commands::isWatching, replay_commands::end},
    {"replay.go-on", "Replay", "Go on cutting from here", "", "",
     "Opens the session to cut as it is shown, at any moment: a new session goes on from it. Before its end, what was "
     "cut up to there is kept as a run of its own.",
     replay_commands::isWatchingAndIdle, replay_commands::goOn},
    {"replay.close", "Replay", "Watch no more", "Esc", "", "Puts the session away.", replay_commands::isWatching,
     replay_commands::close},
    {"recent.open", "File", "Open the last file again", "Ctrl+Shift+O", "[N]",
     "Opens a file that was opened before; 1 is the newest.", hasRecent, recentOpen},
    {"recent.forget", "", "", "", "N", "Takes a file off the list of recent files; the file stays.", hasRecent,
     recentForget},
    {"job.cancel", "File", "Cancel what is under way", "", "",
     "Ends the job under way and leaves nothing of it behind.", hasJob, cancelJob},
    {"app.quit", "File", "Quit", "Ctrl+Q", "",
     "Ends the session, writes it and closes the window; a cut that was not exported is asked about once, not in "
     "scripts.",
     always, quit::quit},
    {"app.stay", "", "", "", "", "Answers the question about a cut that was not exported: the window stays open.",
     quit::isAsking, quit::stay},

    {"edit.undo", "Edit", "Undo", "Ctrl+Z", "", "Takes back the last stroke.", isOpen, edit_commands::undo},
    {"edit.redo", "Edit", "Redo", "Ctrl+Y", "", "Does the stroke again that was taken back last.", isOpen,
     edit_commands::redo},
    {"edit.go", "", "", "", "STEP", "Goes to the end of a step of the timeline; 0 is the beginning.", isOpen,
     edit_commands::go},
    {"edit.begin", "Edit", "Back to the beginning", "Ctrl+Home", "",
     "Takes back all steps, as far back as they are kept.", isOpen, edit_commands::begin},
    {"edit.end", "Edit", "Forward to the last step", "Ctrl+End", "", "Does all steps again that were taken back.",
     isOpen, edit_commands::end},
    {"edit.branch", "Edit", "Go on with a branch", "", "[N]",
     "Goes on with steps that were taken back before others were cut, in a session of its own; N as on the timeline, "
     "if not told the last. What is open is kept, and is a branch then.",
     edit_commands::hasBranches, edit_commands::branch},

    {"palette.show", "Edit", "Commands...", "Ctrl+Shift+P", "", "Finds a command by words and runs it.", always,
     showPalette},
    {"settings.show", "Edit", "Settings...", "Ctrl+,", "", "Shows the settings, or puts them away.", hasSettings,
     showSettings},
    {"sound.volume", "", "", "", "PERCENT", "Sets how loud the drill is, 0 to 100.", hasSettings, setVolume},
    {"sound.mute", "Edit", "Mute the drill", "Ctrl+M", "[on|off]", "Silences the drill, or lets it be heard.",
     hasSettings, mute},
    {"device.leads", "Edit", "SpaceMouse: tool or view", "", "[tool|view|nothing]",
     "Lets a SpaceMouse lead the tool or the view; if not told, the other one.", hasSettings, device_commands::leads},
    {"device.gain", "", "", "", "FACTOR", "Makes a SpaceMouse 0.1 to 4 times as fast.", hasSettings,
     device_commands::gain},
    {"device.dead-band", "", "", "", "PERCENT", "So far an axis of a SpaceMouse is at rest, 0 to 50 % of its way.",
     hasSettings, device_commands::deadBand},
    {"device.dominant", "", "", "", "[on|off]", "Lets only that axis of a SpaceMouse count that is moved most.",
     hasSettings, device_commands::dominant},
    {"device.invert", "", "", "", "AXIS...|none",
     "Inverts axes of a SpaceMouse: right, away, up, pitch, roll, yaw; all others go as they are.", hasSettings,
     device_commands::invert},
    {"device.panel", "Device", "Devices...", "", "[on|off]",
     "Shows devices live: the force-feedback arm with what bounds its force, gamepad or joystick, SpaceMouse; or puts "
     "them away.",
     always, device_commands::panel},
    {"device.open", "", "", "", "NAME",
     "Opens a force-feedback device, whose hand leads the tool when it comes: bridge, bridge:PORT, or path or serial "
     "number. The open document goes on in a session that the device can bear.",
     isIdle, device_commands::open},
    {"device.close", "Device", "Close the device", "", "", "Takes all force away and gives the tool back to the mouse.",
     device_commands::isOpen, device_commands::close},
    {"device.arm", "Device", "Arm: let it give force", "", "",
     "Lets the device give force from now on, faded in. Keep a hand on it.", device_commands::isOpen,
     device_commands::arm},
    {"device.disarm", "Device", "Disarm: no force", "F8", "", "Takes the force away at once; the hand leads on.",
     device_commands::isOpen, device_commands::disarm},
    {"device.fit", "Device", "Make the session fit the device", "", "",
     "Goes on in a session of its own, coupled as the device can bear it now.", isOpenAndIdle, device_commands::fit},
    {"device.force", "", "", "", "NEWTONS", "Bounds the force of the device, 0.1 to 20 N; it may bound it more.",
     always, device_commands::force},
    {"device.scale", "", "", "", "FACTOR", "Sets how many mm of the scene a mm of the hand is, 0.05 to 5.", always,
     device_commands::scale},
    {"device.turn", "", "", "", "DEG", "Turns the device about the scene's z axis.", always, device_commands::turn},
    {"device.pedal", "", "", "", "[on|off]", "Lets the drive turn without button 1 of the device.", always,
     device_commands::pedal},
    {"device.profile", "", "", "", "MS KG N MM",
     "Says what the device is like: delay, mass, friction, step of its encoder. The next session is coupled by it.",
     always, device_commands::profile},
    {"device.place", "", "", "", "X Y Z",
     "Puts the tip of the tool there, mm: where the hand is now means that place from now on.",
     device_commands::isLeading, device_commands::place},
    {"device.test", "Device", "Test force: 0.5 N up", "", "[NEWTONS [X Y Z]]",
     "Pushes the hand gently for 1.5 s, at most 1 N, along a direction of the device; up if not told.",
     device_commands::isArmed, device_commands::test},
    {"settings.dialog", "", "", "", "own|system",
     "Asks for files by Kerf's own browser, or by the system's dialog where there is one (zenity, kdialog).",
     hasSettings, setDialog},
    {"settings.language", "", "", "", "LANGUAGE",
     "Shows the window in another language: en, de, or that of a file in the folder languages of the settings; marked: "
     "each text that can be translated stands in «».",
     hasSettings, setLanguage},
    {"settings.push", "", "", "", "", "Keeps push and depth of now for later sessions.", hasSettings, keepPush},

    {"tool.select", "", "", "", "ID", "Takes another tool.", isOpen, tool_commands::selectTool},
    {"tool.add", "Tool", "Add a tool...", "", "PATH",
     "Puts a tool's file into the rack, or reads it anew, and takes the tool.", isIdle, tool_commands::addTool},
    {"tool.next", "Tool", "Next tool", "]", "", "Takes the next tool of the rack.", isOpen, tool_commands::nextTool},
    {"tool.previous", "Tool", "Previous tool", "[", "", "Takes the tool before.", isOpen, tool_commands::previousTool},
    {"tool.favourite", "Tool", "Favourite, or no longer", "", "[ID]",
     "Puts a tool first in the rack, from now on, or no longer; if not told, the one in hand.", tool_commands::hasRack,
     tool_commands::favourite},
    {"tool.tilt", "", "", "", "DEG [AZIMUTH]",
     "Leans the tool away from the normal of the surface by 0 to 75 degrees, the shank towards an azimuth in the view: "
     "0 "
     "to the right, 90 up; if not told, as it leant or up.",
     always, hand_commands::tilt},
    {"tool.tilt-reset", "Tool", "Set upright", "", "", "Lets the tool stand square to the surface again.",
     hand_commands::isTilted, hand_commands::resetTilt},
    {"cut.force", "", "", "", "NEWTONS", "Sets how hard a pressed button pushes, 0.1 to 8 N.", always,
     tool_commands::setForce},
    {"cut.depth", "", "", "", "MM",
     "Sets how deep below the surface as loaded a stroke may go, 0 to 5 mm; along a guide to its depth.", always,
     tool_commands::setDepth},
    {"cut.deeper", "Tool", "Deeper", ".", "[MM]", "Lets a stroke go deeper, by 0.1 mm if not told.", always,
     tool_commands::deeper},
    {"cut.shallower", "Tool", "Less deep", ",", "[MM]", "Lets a stroke go less deep, by 0.1 mm if not told.", always,
     tool_commands::shallower},
    {"cut.stop-short", "", "", "", "[MM|off]",
     "Strokes stop that far short of pulp and nerve canal, 0.5 mm if not told.", always, tool_commands::stopShort},
    {"cut.spare-neighbours", "", "", "", "[MM|off]",
     "Strokes stop that far short of what stands beside, 0.2 mm if not told.", always, neighbour_commands::stopShort},
    {"cut.press", "", "", "", "X Y", "Presses the button at a pixel: a stroke begins.", isOpen, tool_commands::press},
    {"cut.drag", "", "", "", "X Y", "Moves the pressed pointer to a pixel.", isOpen, tool_commands::drag},
    {"cut.release", "", "", "", "", "Lets go of the button: the stroke ends.", isOpen, tool_commands::release},

    {"cut.nudge", "", "", "", "RIGHT UP IN",
     "Moves a stroke by so many mm: to the right and up in the picture over the surface, and in along the tool's axis, "
     "as "
     "far as the depth.",
     hand_commands::isCutting, hand_commands::nudge},
    {"cut.pedal", "Tool", "Foot pedal", "Space", "[on|off] [X Y]",
     "Holds a stroke without the button, at a pixel, under the cursor or where was cut last; the key holds it while it "
     "is "
     "down.",
     isOpen, hand_commands::pedal},
    {"cut.speed", "", "", "", "PERCENT", "Sets the spindle to a part of its nominal speed.", always,
     hand_commands::setSpeed},
    {"cut.reverse", "Tool", "Turn backwards", "T", "[on|off]",
     "Turns the drive backwards, as a motor can, until another tool is taken: diamonds cut as ever, blades and drills "
     "only rub.",
     isOpen, hand_commands::reverse},
    {"cut.irrigation", "", "", "", "PERCENT", "Sets the spray, 0 to 100 % of full.", always,
     hand_commands::setIrrigation},

    {"piece.choose", "", "", "", "PIECE", "Chooses a piece by its name or number; moves are of that.", isOpen,
     piece_commands::choose},
    {"piece.next", "Piece", "Choose the next", "Tab", "", "Chooses the next piece, after the last one none.",
     piece_commands::arePieces, piece_commands::chooseNext},
    {"piece.move", "", "", "", "X Y Z [PIECE]",
     "Moves a piece by so many mm: by its name or number, if not told the chosen one.", isOpen, piece_commands::move},
    {"piece.turn", "", "", "", "X|Y|Z DEGREES [PIECE]",
     "Turns a piece about its middle: by its name or number, if not told the chosen one.", isOpen,
     piece_commands::turn},
    {"piece.put-back", "Piece", "Put back", "", "[PIECE]",
     "Puts a piece back where it was in the scan: by its name or number, if not told the chosen one.",
     piece_commands::arePieces, piece_commands::putBack},
    {"piece.hide", "Piece", "Hide", "H", "", "Hides the chosen piece.", piece_commands::isChosen, piece_commands::hide},
    {"piece.show-all", "Piece", "Show all", "Shift+H", "", "Shows all pieces.", isOpen, piece_commands::show},
    {"piece.rename", "", "", "", "NAME", "Gives the chosen piece a name, for the list and for files.", isOpen,
     piece_commands::rename},
    {"piece.colour", "Piece", "Another colour", "", "[COLOUR|none]",
     "Gives the chosen piece a colour in the picture, kept with the session: orange, sky, green, yellow, blue, "
     "vermilion or purple; if not told, the next one.",
     piece_commands::isChosen, piece_commands::colour},
    {"neighbour.look", "", "", "", "NEIGHBOUR show|ghost|hide",
     "Shows what stands beside, makes it a ghost that is not pointed at, or hides it; the tool meets it all the same.",
     neighbour_commands::hasNeighbours, neighbour_commands::look},
    {"neighbour.work-on", "Piece", "Work on the neighbour", "", "[NEIGHBOUR]",
     "Ends the session and opens the neighbour to be cut, as in its case; what was worked on stands beside it.",
     neighbour_commands::hasNeighboursAndIdle, neighbour_commands::workOn},
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
     "Copies point, normal, tissue and thickness along the view, in the scan's frame, as text.", isOpen,
     point_commands::copyPoint},
    {"point.copy-row", "Edit", "Copy it as a row of a path", "Ctrl+Shift+C", "[X Y]",
     "Copies the tool's pose there as a row of a path: t,x,y,z,qw,qx,qy,qz.", isOpen, point_commands::copyPathRow},

    {"measure.point", "Edit", "Measure from here", "M", "[X Y]",
     "Sets a point of the surface: distances between points, and angles at them, are shown.", isOpen,
     point_commands::measurePoint},
    {"measure.copy", "Edit", "Copy what was measured", "", "", "Copies distances and angles as text.",
     point_commands::hasMeasure, point_commands::copyMeasure},
    {"measure.clear", "Edit", "Measure no more", "Shift+M", "", "Takes all points away.", point_commands::hasMeasure,
     point_commands::clearMeasure},

    {"view.fit", "View", "Fit", "F", "", "Shows all of the object.", isShown, view_commands::fit},
    {"view.front", "View", "Front", "1", "", "Looks along +y, where +z is up.", always, view_commands::namedView<0>},
    {"view.back", "View", "Back", "2", "", "Looks along -y.", always, view_commands::namedView<1>},
    {"view.left", "View", "Left", "3", "", "Looks along +x.", always, view_commands::namedView<2>},
    {"view.right", "View", "Right", "4", "", "Looks along -x.", always, view_commands::namedView<3>},
    {"view.top", "View", "Top", "5", "", "Looks down on the side that is up, the occlusal one of a scan.", always,
     view_commands::namedView<4>},
    {"view.bottom", "View", "Bottom", "6", "", "Looks up from below.", always, view_commands::namedView<5>},
    {"view.iso", "View", "Oblique", "7", "", "Looks from in front, above and the right.", always,
     view_commands::namedView<6>},
    {"view.occlusal", "View", "Occlusal: this tooth", "0", "[X Y]",
     "Looks square to the occlusal plane at a tooth: at a pixel, under the cursor, the chosen piece, or in the middle "
     "of the view; the front of the arch is up.",
     isShown, tooth_views::lookAt<tooth_views::ToothSide::kOcclusal>},
    {"view.buccal", "View", "Buccal: this tooth", "8", "[X Y]",
     "Looks at the buccal (labial) side of a tooth, from outside the arch.", isShown,
     tooth_views::lookAt<tooth_views::ToothSide::kBuccal>},
    {"view.lingual", "View", "Lingual: this tooth", "9", "[X Y]",
     "Looks at the lingual (palatal) side of a tooth, from inside the arch and 30 degrees above it.", isShown,
     tooth_views::lookAt<tooth_views::ToothSide::kLingual>},
    {"view.mesial", "View", "Mesial: this tooth", "Shift+8", "[X Y]",
     "Looks at the mesial side of a tooth, along the arch from its midline and 45 degrees above it.", isShown,
     tooth_views::lookAt<tooth_views::ToothSide::kMesial>},
    {"view.distal", "View", "Distal: this tooth", "Shift+9", "[X Y]",
     "Looks at the distal side of a tooth, along the arch from its end and 45 degrees above it.", isShown,
     tooth_views::lookAt<tooth_views::ToothSide::kDistal>},
    {"view.sides", "", "", "", "BUCCAL MESIAL|auto",
     "Tells which sides are buccal and mesial where no full arch does: +x, -x, +y, -y, +z, -z; auto: as the arch says.",
     isShown, tooth_views::sides},
    {"view.sides-here", "", "", "", "left|right",
     "Tells that this view is of the buccal side, with the mesial one to the left or right.", isShown,
     tooth_views::sidesHere},
    {"view.sides-left", "View", "This is buccal, mesial to the left", "", "",
     "Tells that this view is of the buccal side, with the mesial one to the left.", isShown,
     tooth_views::thisIsBuccal<true>},
    {"view.sides-right", "View", "This is buccal, mesial to the right", "", "",
     "Tells that this view is of the buccal side, with the mesial one to the right.", isShown,
     tooth_views::thisIsBuccal<false>},
    {"view.from", "", "", "", "NAME|AZ,EL", "Looks from a named side or two angles in degrees.", always,
     view_commands::view},
    {"view.up", "", "", "", "AXIS|auto",
     "Turns the view so that a side of the scan is up: +x, -x, +y, -y, +z, -z; auto: its occlusal side, as when it was "
     "opened. Coordinates stay those of the scan.",
     isShown, view_commands::up},
    {"view.section", "View", "Cut open", "X", "[X Y]",
     "Takes away what is nearer than the point under the cursor, or than the middle; again: shows all.", isShown,
     view_commands::cutOpen},
    {"view.section-deeper", "View", "Section deeper", "PageDown", "[MM]", "Moves the section away, 0.2 mm if not told.",
     view_commands::hasSection, view_commands::sectionDeeper},
    {"view.section-nearer", "View", "Section nearer", "PageUp", "[MM]",
     "Moves the section towards the viewer of before, 0.2 mm if not told.", view_commands::hasSection,
     view_commands::sectionNearer},
    {"view.plots", "View", "Plots of the last 20 s", "", "[on|off]",
     "Shows force, torque, spindle, depth and volume rate over time, or puts them away.", always, view_commands::plots},
    {"view.tissue", "", "", "", "NAME show|hide|ghost",
     "Shows a tissue, hides it, or lets what is under it shine through.", tissue_commands::hasTissues,
     tissue_commands::look},
    {"view.tissues-all", "View", "Show all tissues", "", "", "Shows all tissues.", tissue_commands::isAnyHidden,
     tissue_commands::showAll},
    {"view.colours", "", "", "", "tissue|scan|depth|distance",
     "Colours the surface by tissue, as it was scanned, by depth below it as loaded, or by distance to pulp and nerve "
     "canal. A scan with colours begins with them; where it is cut, tissue has its own.",
     isShown, tissue_commands::colours},
    {"view.colours-tissue", "View", "Colours of tissues", "", "", "Colours the surface by tissue.", isShown,
     tissue_commands::coloursOf<SurfaceColours::kTissue>},
    {"view.colours-scan", "View", "Colours of the scan", "", "", "Colours the surface as it was scanned.",
     tissue_commands::hasScanColours, tissue_commands::coloursOf<SurfaceColours::kScan>},
    {"view.colours-depth", "View", "Colours of depth", "", "", "Colours the surface by depth below it as loaded.",
     isShown, tissue_commands::coloursOf<SurfaceColours::kDepth>},
    {"view.colours-distance", "View", "Colours of distance to pulp and nerve", "", "",
     "Colours the surface by distance to pulp and nerve canal.", tissue_commands::hasStructures,
     tissue_commands::coloursOf<SurfaceColours::kDistance>},
    {"view.zoom", "", "", "", "FACTOR [X Y]",
     "Makes things larger by a factor, about the middle or a pixel as the wheel does.", always, view_commands::zoom},
    {"view.perspective", "View", "Perspective", "O", "[DEG|off]",
     "Shows near things larger, with a field of view of 5 to 90 degrees from the lower to the upper edge, the one of "
     "the "
     "settings if not told; again: parallel lines stay parallel, as at first.",
     always, view_commands::perspective},
    {"view.roll", "View", "Turn the picture", "R", "[DEG]",
     "Turns what is seen clockwise in the picture, by 15 degrees if not told.", always, view_commands::roll},
    {"view.level", "View", "Upright again", "Shift+R", "", "Takes back all turns of the picture.",
     view_commands::isRolled, view_commands::level},
    {"view.theme", "View", "Light or dark", "Ctrl+Shift+L", "[light|dark]", "Changes between light and dark panels.",
     hasSettings, setTheme},
    {"view.larger", "View", "Larger type", "Ctrl+=", "", "Makes type and panels larger.", hasSettings, makeLarger},
    {"view.smaller", "View", "Smaller type", "Ctrl+-", "", "Makes type and panels smaller.", hasSettings, makeSmaller},
    {"view.scale", "", "", "", "FACTOR", "Sets the size of type and panels, 0.75 to 3.", hasSettings, setScale},
    {"view.hints", "View", "Hints for the mouse", "", "[on|off]", "Shows or hides the hints.", hasSettings, setHints},
    {"picture.write", "", "", "", "OUT.png", "Writes what is shown as a picture.", always, view_commands::screenshot},
};

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

std::string appCommandReference() {
  std::string out =
      "# Commands of the window\n\n<!-- Written by scripts/reference from kerf-sim --commands. Do not edit: change "
      "ui/app/commands/app_commands.cpp and run it again. -->\n\n"
      "Menus, keys and scripts (`kerf-sim --script FILE`) run these. A script holds one a line; # begins a comment, "
      "words in "
      "double quotes may hold blanks. X and Y are pixels of the picture, Y downwards. Beside them a script has `wait` "
      "(until "
      "no job runs, no plane is sawn and no replay jumps), `wait SECONDS` (of the simulation), `wait device [SECONDS]` "
      "(until a force-feedback device leads the tool; 10 s at most), `print` (the state, as "
      "JSON) and `expect "
      "removed|depth|tip|loop|near|hindered|warm|sawn|triangles|pieces|beside|beside-near|beside-removed|steps|ahead|"
      "time|same|"
      "verdict|device|device-force LOW HIGH`: `tip` is the depth of the tip below the surface as loaded, `loop` the "
      "ticks "
      "of the 1 kHz loop in the last second, `hindered` 1 while the tool rests on its neck or its drive stands still, "
      "`verdict` 1 when the export panel says ready to print, 0 when not, -1 "
      "before "
      "its check; `device` is 0 without a force-feedback device, 1 when it is silent, 2 when its hand is there, 3 when "
      "it "
      "leads, 4 when it is armed; `time` is the second that is watched, "
      "`same` "
      "1 when a replay ended as recorded, 0 when not, -1 before its end. The first error ends it, "
      "with "
      "exit code 1 and the line.\n\n| command | parameters | key | what it does |\n|---|---|---|---|\n";
  for (const AppCommand& c : kCommands)
    out += fmt::format("| `{}` | {} | {} | {} |\n", c.id, c.parameters.empty() ? "" : fmt::format("`{}`", c.parameters),
                       c.key.empty() ? "" : fmt::format("`{}`", c.key), c.description);
  return out;
}

}  // namespace kerf
