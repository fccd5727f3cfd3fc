// The window's core: the open document and the parts that work on it, shared by the window and its scripts. No OpenGL,
// no keys.
//
// All calls come from one thread, once a frame update(). Long work is a job and never blocks that thread. A unit
// includes the header of each part that it uses; this one names them only. The command tables (ui/app/commands) give
// the functions of the parts names, keys and menu places.
#pragma once

#include <memory>
#include <vector>

#include "ui/app/document/part.h"
#include "ui/app/document/workbench_options.h"

namespace kerf {

class Document;
class Drilling;
class ExportPlan;
class FileHistory;
class ForceDevice;
class Imports;
class Jobs;
class Notices;
class Replays;
class Results;
class Sawing;
class SceneNeighbours;
class ScenePieces;
class Sessions;
class Steps;
class Strokes;
class ToolMonitor;
class Tools;
class ViewState;
struct ObjectChunks;

/// Owns a part. A part of a const Workbench is const.
template <class T>
class Owned {
 public:
  explicit Owned(std::unique_ptr<T> part) : part_(std::move(part)) {}
  T* operator->() { return part_.get(); }
  const T* operator->() const { return part_.get(); }
  T& operator*() { return *part_; }
  const T& operator*() const { return *part_; }

 private:
  std::unique_ptr<T> part_;
};

class Workbench {
 public:
  explicit Workbench(WorkbenchOptions options = {});
  ~Workbench();  ///< ends the open session as Sessions::close(), and waits
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  /// Once a frame: collects results of jobs, mesher and haptic thread.   @return chunks of the surface that changed.
  std::vector<ObjectChunks> update();
  const WorkbenchOptions& options() const { return options_; }

  // ---- For Sessions and Replays: tell all parts

  void opened(Opening how);
  void closing();

 private:
  WorkbenchOptions options_;

 public:
  // In the order of construction: a part may use earlier ones in its constructor and destructor.
  Owned<Notices> notices;             ///< messages to the user
  Owned<Jobs> jobs;                   ///< the running job
  Owned<Document> document;           ///< case or replay, scene, newest report
  Owned<ViewState> views;             ///< section, measure, tissues and colours
  Owned<FileHistory> history;         ///< recent files, lost sessions
  Owned<ForceDevice> device;          ///< a force-feedback device that leads the tool
  Owned<Tools> tools;                 ///< the rack, and the tool in hand
  Owned<Sessions> sessions;           ///< opens, ends and reopens documents
  Owned<Replays> replays;             ///< ended sessions in replay
  Owned<Imports> imports;             ///< scans before they are prepared
  Owned<Strokes> strokes;             ///< cutting by mouse: force, depth, spray, pedal
  Owned<ToolMonitor> monitor;         ///< depth of the tip, distances, drive, heat, plots
  Owned<Steps> steps;                 ///< undo, redo, timeline, branches
  Owned<ScenePieces> pieces;          ///< pieces of the object: moves, names, colours
  Owned<SceneNeighbours> neighbours;  ///< neighbours of the object
  Owned<Sawing> saw;                  ///< planned planes and cuts
  Owned<Drilling> drill;              ///< planned holes
  Owned<Results> results;             ///< snapshots for an export, and whether the cut was exported
  Owned<ExportPlan> exporting;        ///< the export panel's model

 private:
  std::vector<Part*> parts_;  // in the order of update()
};

}  // namespace kerf
