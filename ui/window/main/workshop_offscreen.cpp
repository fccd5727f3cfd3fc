// The workbench without a window: scripts and films, drawn off screen. With one: workshop.cpp.
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <csignal>
#include <cstdlib>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include "geometry/base/text.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/view_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/script/app_script.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/replays.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/tools.h"
#include "ui/window/draw/live_view.h"
#include "ui/window/gl/frame_watch.h"
#include "ui/window/gl/gl_context.h"
#include "ui/window/gl/gl_target.h"
#include "ui/window/gl/image.h"
#include "ui/window/gl/picture_legend.h"
#include "ui/window/main/workshop.h"
#include "ui/window/screens/session_end.h"

namespace kerf {

namespace fs = std::filesystem;

namespace {

// Runs the workbench without a window.
using Play = std::function<Expected<void>(AppContext& context, const std::function<void()>& frame)>;

Expected<void> runOffscreen(const WorkshopOptions& options, const Play& play) {
  ::setenv("LP_NUM_THREADS", std::thread::hardware_concurrency() <= 2 ? "0" : "2", 0);
  const auto gl = OffscreenContext::create(true);
  if (!gl) return fail(gl.error());
  KERF_TRY(view, LiveView::create());
  Workbench bench(options.bench);
  bench.tools->takeRack(true);  // does not wait for frames
  KERF_TRY(camera, cameraFromView(options.view));
  const Camera first = camera;
  SettingsFile settings(options.config);
  AppContext context{
      .bench = bench, .camera = camera, .width = options.width, .height = options.height, .settings = &settings};
  context.screenshot = [&](const fs::path& png) -> Expected<void> {
    view->update(bench);
    KERF_TRY(image, view->picture(bench, camera, context.width, context.height));
    if (const auto legend = legendOf(bench.views->tissues().colours(), bench.views->tissues().mapScale()))
      drawLegend(image, *legend);
    return writePng(png, image);
  };
  LiveView& shown = *view;
  std::optional<internal::GlTarget> screen;
  if (options.is_watched) screen.emplace(options.width, options.height);
  FrameWatch watch;
  const auto frame = [&] {
    context.wants_quit |= toldToEnd() != 0;
    watch.begin(bench);
    shown.update(bench);
    if (!bench.document->scene().bounds().isEmpty() && shown.takeFitWanted()) firstView(context, first);
    if (!screen) return;
    glBindFramebuffer(GL_FRAMEBUFFER, screen->id());
    if (const auto drawn = shown.draw(bench, camera, context.width, context.height, LiveView::Edges::kFast); !drawn)
      bench.notices->complain(drawn.error());
    glFinish();
    watch.end(bench);
  };
  if (!options.replay.empty())
    bench.replays->open(options.replay);
  else if (options.open.size() == 1)
    bench.sessions->open(options.open.front());
  else if (options.open.size() > 1)
    bench.sessions->openAll(options.open);
  auto played = play(context, frame);
  const auto ended = endAll(bench, *view);
  view.reset();
  if (screen) printText("{}\n", watch.summary());
  screen.reset();
  for (const Notice& notice : bench.notices->list())
    if (!notice.is_error) printText("{}\n", notice.text);
  if (!played) return fail(std::move(played).error());
  if (!ended) return fail(ended.error());
  return {};
}

}  // namespace

Expected<void> runWorkshopScript(const fs::path& script, const WorkshopOptions& options) {
  endWhenTold();
  auto done =
      runOffscreen(options, [&](AppContext& context, const auto& frame) { return runScript(context, script, frame); });
  if (const int number = toldToEnd()) {  // the signal was deferred: raises it now
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
  return done;
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
