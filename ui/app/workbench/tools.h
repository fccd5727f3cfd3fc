// The rack: the tools, the one in hand, and files that are read anew when they change.
//
// In a replay the tools are those of the run, and the one in hand is that of the shown moment.
#pragma once

#include <chrono>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/tool/tool.h"
#include "sim/monitor/keep_out.h"
#include "ui/app/base/job.h"
#include "ui/app/document/part.h"
#include "ui/app/tool/rack.h"

namespace kerf {

class Workbench;

/// Smaller voxels for the tool in hand, and their cost.
struct FinerVoxels {
  double now_mm = 0, mm = 0;
  double seconds = 0, bytes = 0;  ///< predicted
};

/// Window thread only.
class Tools final : public Part {
 public:
  /// Begins to read the rack, in the background.
  explicit Tools(Workbench& bench);
  ~Tools() override;

  /// Of the shown document; 0 without one.
  std::size_t count() const;
  const Tool& at(std::size_t n) const;
  std::size_t inHand() const;
  /// The tool in hand.
  const Tool& held() const { return at(inHand()); }
  void select(std::size_t n);
  /// False: no tool has that id or file.
  bool select(const std::string& id_or_file);
  /// Its id; or its file, if another tool before it has the same id.
  std::string wordFor(std::size_t n) const;

  /// The rack is still being read. update() fills it and reports errors. Opening a document waits for it in its job.
  bool isReading() const { return rack_ != nullptr; }
  /// Takes the rack once it is read.   @param waits  for that.
  void takeRack(bool waits = false);
  /// Number of leading tools for a first look. A rack chosen by the user: all of it.
  std::size_t firstLook() const { return first_look_ ? first_look_ : tools_.size(); }
  /// Error in a tool's file or mesh found since it was read, or null. The tool itself stays as read.
  const Error* error(std::size_t n) const;
  const std::vector<BrokenTool>& broken() const { return broken_; }
  /// Adds a tool's file to the rack, or rereads it, and takes the tool in hand. The open document continues in a new
  /// session: undo reaches back to here. Rejects a file that is no tool and names the fault.
  void add(const std::filesystem::path& file);
  /// Adds tools that were made of meshes, without taking one in hand.
  void addMade(std::vector<SessionTool> made);

  // ---- Of the tool in hand, for strokes and readings

  const Plunge& plunge() const { return tools_[inHand()].plunge; }
  const TouchPoints& touches() const { return tools_[inHand()].touches; }
  const Mesh& head() const { return tools_[inHand()].head; }
  /// Points on its surface, for distances.
  const ToolSamples& samples() const;

  /// Offered for a bur under 2 mm on voxels over 0.1 mm: their steps show at the margin. None: fine enough, or the
  /// scan cannot be prepared again (a case, a session, neighbours).
  std::optional<FinerVoxels> finerVoxels() const;

  // ---- For Sessions and Imports

  /// The tools of the rack, for a new session.
  std::vector<SessionTool> forSession() const;
  /// Valid while the rack is being read: OpeningOptions::coming_tools.
  const std::shared_future<std::vector<SessionTool>>& coming() const { return coming_; }
  std::filesystem::path ownFolder() const;
  /// Takes the tool of a file in hand, if it is in the rack.
  void selectFile(const std::filesystem::path& file);

  void opened(Opening how) override;
  void update() override;

 private:
  struct Row : RackTool {
    std::optional<Error> error;  // since reading
    bool is_outdated = false;    // its file was reread since a document was opened
  };
  ToolTimes timesOfRow(const Row& row) const;
  void readRack();
  void put(RackTool tool);
  void keepBroken(const BrokenTool& broken);
  void watch();
  void watchBroken();
  void toolChanged();

  Workbench& bench_;
  std::vector<Row> tools_;
  std::vector<BrokenTool> broken_;
  std::size_t in_hand_ = 0, first_look_ = 0;
  std::unique_ptr<Job<Rack>> rack_;                      // null: reading is over
  std::shared_future<std::vector<SessionTool>> coming_;  // result of rack_, for documents opened meanwhile
  mutable std::map<std::size_t, ToolSamples> samples_;   // of tools that were in hand
  std::set<std::string> told_thin_;                      // tools of this session, by their ids
  std::chrono::steady_clock::time_point next_watch_{};
};

}  // namespace kerf
