#include "ui/app/workbench/workbench.h"

#include <utility>

#include "ui/app/base/user_files.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/view_state.h"
#include "ui/app/workbench/drilling.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/replays.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/app/workbench/tools.h"

namespace kerf {
namespace {

WorkbenchOptions withDataFolder(WorkbenchOptions options) {
  if (options.data_folder.empty()) options.data_folder = userDataFolder();
  return options;
}

template <class T, class... Arguments>
Owned<T> make(Arguments&... arguments) {
  return Owned<T>(std::make_unique<T>(arguments...));
}

}  // namespace

Workbench::Workbench(WorkbenchOptions options)
    : options_(withDataFolder(std::move(options))),
      notices(make<Notices>()),
      jobs(make<Jobs>(*notices)),
      document(make<Document>(*notices)),
      views(make<ViewState>(*notices, *document)),
      history(make<FileHistory>(options_, *notices, *jobs)),
      device(make<ForceDevice>(*this)),
      tools(make<Tools>(*this)),
      sessions(make<Sessions>(*this)),
      replays(make<Replays>(*this)),
      imports(make<Imports>(*this)),
      strokes(make<Strokes>(*this)),
      monitor(make<ToolMonitor>(*this)),
      steps(make<Steps>(*this)),
      pieces(make<ScenePieces>(*this)),
      neighbours(make<SceneNeighbours>(*this)),
      saw(make<Sawing>(*this)),
      drill(make<Drilling>(*this)),
      results(make<Results>(*this)),
      exporting(make<ExportPlan>(*this)),
      // The document takes the newest report before the parts that read it. A tool's changed file starts a job last.
      parts_{&*jobs,   &*imports, &*document, &*replays, &*neighbours, &*monitor,   &*strokes, &*steps,    &*device,
             &*pieces, &*results, &*views,    &*saw,     &*drill,      &*exporting, &*tools,   &*sessions, &*history} {}

Workbench::~Workbench() {
  jobs->abandon();
  sessions->endNow();
}

std::vector<ObjectChunks> Workbench::update() {
  tools->takeRack();
  for (Part* const part : parts_) part->update();
  return document->takeChunks();
}

void Workbench::opened(Opening how) {
  for (Part* const part : parts_) part->opened(how);
}

void Workbench::closing() {
  for (Part* const part : parts_) part->closing();
}

}  // namespace kerf
