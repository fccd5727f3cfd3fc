// The open document: a case that is being cut, or an ended session in replay, with its scene and its newest report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/field/material.h"
#include "sim/hand/guided_hand.h"
#include "sim/hand/hand_switch.h"
#include "sim/hand/mouse_hand.h"
#include "sim/monitor/structures.h"
#include "sim/run/session/live_run.h"
#include "ui/app/document/jobs.h"
#include "ui/app/import/opening.h"
#include "ui/app/session/neighbours.h"
#include "ui/app/view/live_scene.h"

namespace kerf {

class WatchedRun;

/// The devices of a run, which they outlive.
struct Hands {
  std::unique_ptr<MouseHand> mouse;
  std::shared_ptr<HandSwitch> leading;  ///< mouse or arm
  std::unique_ptr<GuidedHand> guided;
};

/// A run after its document has ended, for the job that writes it.
struct EndingRun {
  Hands hands;
  std::unique_ptr<LiveRun> run;
  std::uint64_t sent = 0;  ///< commands
  std::string name;
  std::filesystem::path folder;
};

/// All members from the window thread. The run's own threads have their interfaces in LiveRun.
class Document final : public Part {
 public:
  explicit Document(Notices& notices);
  ~Document() override;

  bool isOpen() const { return run_ != nullptr; }
  /// An object is shown, for cutting or in replay.
  bool isShown() const { return run_ || watched_; }
  /// Increases with each newly opened document: earlier pictures are outdated.
  std::uint64_t generation() const { return generation_; }
  /// The document was only reopened: the view stays.
  bool keepsView() const { return keeps_view_; }
  const std::string& name() const { return name_; }
  /// The opened scan, recipe, case or run, never written to. It stays until another document is open.
  const std::filesystem::path& source() const { return source_; }
  const std::vector<std::filesystem::path>& sourcesBeside() const { return sources_beside_; }
  /// Choices with which its source was prepared. None: a case or a session was opened.
  const std::optional<PrepareOptions>& prepared() const { return prepared_; }
  const std::filesystem::path& sessionFolder() const { return session_; }
  /// Best view direction of a scan of several teeth, and the dental arch, in the scan's frame; each may be missing.
  const OcclusalSide& occlusal() const { return occlusal_; }
  /// A neighbour as loaded stands over the teeth of the object, such as the other jaw; one of the same arch does not.
  bool isInOcclusion() const { return occlusal_.normal && isNeighbourTowards(*occlusal_.normal); }
  /// A neighbour as loaded lies in that direction, within 45 degrees between the centres.
  bool isNeighbourTowards(const Vec3d& direction) const;
  /// Null if nothing is open for cutting.
  LiveRun* run() { return run_.get(); }
  const LiveRun* run() const { return run_.get(); }
  /// Null if no session is in replay.
  WatchedRun* watched() { return watched_.get(); }
  const WatchedRun* watched() const { return watched_.get(); }
  LiveScene& scene() { return scene_; }
  const LiveScene& scene() const { return scene_; }
  /// Pulp and nerve canals as loaded. Null: nothing is open.
  const Structures* structures() const { return structures_.get(); }
  std::shared_ptr<const Structures> sharedStructures() const { return structures_; }
  const NeighbourFields& neighbourFields() const { return neighbour_fields_; }
  const MaterialTable& materials() const { return materials_; }
  /// Display name of a tissue: "enamel".
  std::string nameOf(Material material) const;

  const HapticReport& report() const { return report_; }
  /// report() is new in this frame.
  bool hasNews() const { return has_news_; }
  const HapticTimes& times() const { return times_; }
  double removedMm3() const { return removed_mm3_; }
  /// Removed volume of one tissue in this session, mm^3. Slightly below 0 where a border crosses the cut.
  double removedOf(Material material) const;

  // ---- Commands to the 1 kHz thread

  /// False if its queue is full.
  bool send(const Command& command);
  /// Number of commands sent in this session.
  std::uint64_t sent() const { return sent_; }
  /// All of them are done or refused.
  bool isAnswered() const { return answered() >= sent_; }
  std::uint64_t answered() const { return report_.counts.commands_done + report_.counts.commands_refused; }
  /// Of an open run.
  Hands& hands() { return hands_; }

  // ---- For Sessions and Replays, which open and end it

  void open(Opened loaded, Hands hands, Opening how);
  void watch(std::unique_ptr<WatchedRun> run, const OcclusalSide& occlusal);
  EndingRun end();
  void endWatching();

  /// Takes the newest report and chunks.
  void update() override;
  /// Chunks of the surface that changed since the last call.
  std::vector<ObjectChunks> takeChunks();

 private:
  void forget();
  void takeRun();
  void takeWatched();

  Notices& notices_;
  MaterialTable materials_{{}};
  std::string name_;
  std::filesystem::path source_, session_;
  std::vector<std::filesystem::path> sources_beside_;
  std::optional<PrepareOptions> prepared_;
  OcclusalSide occlusal_;
  Hands hands_;  // outlives run_
  std::unique_ptr<LiveRun> run_;
  std::unique_ptr<WatchedRun> watched_;
  LiveScene scene_;
  std::shared_ptr<const Structures> structures_;
  NeighbourFields neighbour_fields_;
  std::uint64_t generation_ = 0;
  bool keeps_view_ = false, has_news_ = false, has_told_of_log_ = false;
  HapticReport report_;
  HapticTimes times_;
  double removed_mm3_ = 0;
  std::uint64_t sent_ = 0;
  std::vector<ObjectChunks> fresh_;  // not handed out yet
};

}  // namespace kerf
