// Ended sessions in replay: sim/run/session/watched_run.h. No cutting meanwhile: Document::isOpen() is false.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "ui/app/document/part.h"

namespace kerf {

class Workbench;

/// Window thread only. The run itself: Document::watched().
class Replays final : public Part {
 public:
  explicit Replays(Workbench& bench) : bench_(bench) {}

  /// Loads a run and shows its beginning. Closes the open document. A job.
  void open(const std::filesystem::path& run_folder);
  bool isPlaying() const;
  void end();
  /// Opens the run to continue cutting from the shown moment. Before its end, it keeps that state as a new run first.
  /// Error kUnsupported: the run is seeking another moment.
  Expected<void> goOnCutting();

  void opened(Opening how) override;
  void update() override;

 private:
  Workbench& bench_;
  bool has_told_of_verdict_ = false;
};

}  // namespace kerf
