#include "ui/window/main/recent_pictures.h"

#include <system_error>
#include <utility>

#include "sim/run/files/run_manifest.h"
#include "ui/app/commands/zoom.h"
#include "ui/app/document/file_history.h"
#include "ui/app/import/session_list.h"
#include "ui/window/gl/image.h"
#include "ui/window/screens/first_screen.h"

namespace kerf {

void RecentPicture::opened(const Document& document) {
  updateBox(document);
  of_ = document.source();
  session_ = document.isOpen() ? document.sessionFolder() : std::filesystem::path();
  is_due_ = true;
}

void RecentPicture::take(LiveView& view, Workbench& bench, const Camera& camera) {
  is_due_ = false;
  if (of_.empty() || box_.isEmpty()) return;
  Camera fitted = camera;
  fitToBox(fitted, box_, kCardWidth, kCardHeight);
  view.hover({});
  auto image = view.picture(bench, fitted, kCardWidth, kCardHeight);
  if (!image) return;
  writing_ = std::make_unique<Job<void>>("a picture",
                                         [image = std::move(*image), to = bench.history->recent().pictureOf(of_),
                                          session = session_](const Progress&) -> Expected<void> {
                                           std::error_code ignored;
                                           // A session without cuts has no folder any more.
                                           if (isRun(session)) (void)writePng(session / kSessionPicture, image);
                                           // An opened session keeps its own picture.
                                           if (to.filename() == kSessionPicture) return {};
                                           std::filesystem::create_directories(to.parent_path(), ignored);
                                           return writePng(to, image);
                                         });
}

}  // namespace kerf
