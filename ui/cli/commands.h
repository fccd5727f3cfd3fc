// The commands of the program kerf. A new command needs a source, its line in CMakeLists.txt, and two lines here:
// declaration and row. The table, which only main.cpp reads, gives `kerf --help` and the error for an unknown command.
#pragma once

#include "ui/cli/command.h"

namespace kerf::cli {

/// Gives a command its options, footer and CLI11 callback.
/// @param command  with name and description.    @param exit_code  return value of main; set by the callback.
using AddOptions = void(CLI::App& command, int& exit_code);

AddOptions addBake, addCheck, addCompare, addCut, addDemo, addDemoMolar, addDevices, addExport, addHelp, addInfo,
    addLive, addPick, addPlot, addPrepare, addRecover, addReplay, addTool, addTrim;

struct CommandRow {
  const char* name;     ///< as typed
  const char* summary;  ///< one line of `kerf --help`
  AddOptions* add;
  const char* group;  ///< heading in `kerf --help`, in order of first use
};

inline constexpr const char* kWorkflow = "Commands from scan to mesh";
inline constexpr const char* kInspect = "Commands for files and tools";
inline constexpr const char* kExamples = "Commands for examples";
inline constexpr const char* kOther = "Other commands";

inline constexpr CommandRow kCommands[] = {
    {"bake", "Turn mesh files or a case recipe into a case: closed solid, distance field, materials, point shell",
     addBake, kWorkflow},
    {"cut", "Cut a case with a tool along a path", addCut, kWorkflow},
    {"live", "Cut a case with a force-feedback device behind a bridge, without a window", addLive, kWorkflow},
    {"replay", "Replay the session of a run and compare state and force, bit for bit", addReplay, kWorkflow},
    {"recover", "Recover a session of the window from its log after a crash", addRecover, kWorkflow},
    {"export", "Write the post-operative mesh of a run, or the closed solid of a case", addExport, kWorkflow},
    {"trim", "Cut a solid by planes into two, or a die out of a model, closed by flat faces", addTrim, kWorkflow},
    {"prepare",
     "Make a solid ready for a printer: hollow, drains, a label, on the bed; report the wall and trapped resin",
     addPrepare, kWorkflow},
    {"check", "Check if a mesh is ready to print, and list the reasons if not (exit 0 yes, 1 no)", addCheck, kInspect},
    {"compare", "Measure how far two meshes differ: planned and achieved, before and after", addCompare, kInspect},
    {"info", "Describe a mesh, a label volume, a case, a run or a tool", addInfo, kInspect},
    {"pick", "Pick a point in a view: coordinates in mm, normal, tissue, thickness", addPick, kInspect},
    {"plot", "Draw a run over time: force, load, speed, temperature, distance, removed volume, as SVG", addPlot,
     kInspect},
    {"devices", "List, probe and record connected devices; compute the coupling that a device can hold", addDevices,
     kInspect},
    {"tool", "List, check, draw, start, import and bake tools", addTool, kInspect},
    {"demo", "Write synthetic anatomy: tissues, with a recipe to bake them", addDemo, kExamples},
    {"demo-molar", "Write a synthetic lower first molar for experiments", addDemoMolar, kExamples},
    {"help", "Explain a command of kerf, the commands of the window, or their scripts", addHelp, kOther},
};

}  // namespace kerf::cli
