// Exports of the open document: the moment of their snapshot, and whether the present cut was exported.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>

#include "geometry/base/progress.h"
#include "ui/app/document/part.h"
#include "ui/app/session/exporting.h"
#include "ui/app/tool/cut_stamp.h"

namespace kerf {

class Workbench;

/// For an export job: waits for the scene.   Error kCancelled.
Expected<SceneCopy> waitForScene(std::future<SceneView>& given, const Progress& progress);

/// Window thread only.
class Results final : public Part {
 public:
  explicit Results(Workbench& bench) : bench_(bench) {}

  /// Exports the present post-operative mesh, reads it back and compares. A job; cutting may go on.
  void exportTo(const std::filesystem::path& file, const ExportChoice& choice = {});
  /// The object in work was cut or moved since its last complete export, if any. An export of one piece of several
  /// does not count. The session itself is always kept. False during an export.
  bool hasUnexportedCut() const;

  // ---- For ExportPlan and Sessions

  /// Says in a notice why that file may not be written: nothing is open, no format, or it is an opened file.
  bool mayExportTo(const std::filesystem::path& file);
  /// Ends the stroke and orders the scene for a job, which the caller starts in the same frame.
  std::shared_ptr<std::future<SceneView>> orderScene();
  /// State of the last scene that was handed over. None: cutting was going on.
  const std::optional<CutStamp>& handedOver() const { return handed_over_; }
  /// The present state. None: commands are still under way.
  std::optional<CutStamp> stampNow() const;
  /// A complete export of that state was written.
  void markExported(const std::optional<CutStamp>& state) { exported_ = state; }
  /// The session continues another one, whose cut was not exported.
  void markUnexported() { has_unexported_before_ = true; }

  void opened(Opening how) override;
  /// Hands the scene over once the last stroke is meshed, or after a second if cutting goes on.
  void update() override;

 private:
  bool isSettled();

  Workbench& bench_;
  /// A job that waits for its export data until the last stroke is meshed.
  struct Handover {
    std::promise<SceneView> scene;
    std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
    std::uint64_t sent = 0;                  // commands sent so far: answered before the handover
    std::optional<std::uint64_t> done_at{};  // tick at which all commands were done
  };
  std::optional<Handover> handover_;
  std::optional<CutStamp> handed_over_, exported_;  // the last ones
  bool has_unexported_before_ = false;
};

}  // namespace kerf
