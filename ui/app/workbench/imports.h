// Imports: files that are read and shown before they are prepared.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "ui/app/document/part.h"
#include "ui/app/import/trim_drawing.h"

namespace kerf {

class ImportPlan;
class ImportSet;
class Workbench;
struct MeshToolOrder;
struct SessionTool;

/// Window thread only.
class Imports final : public Part {
 public:
  explicit Imports(Workbench& bench);
  ~Imports() override;

  /// Reads a scan or a label volume and waits for the user's decisions: set(). Opens a single recipe, case or run at
  /// once. A job.
  void begin(const std::filesystem::path& path);
  /// The same for several files: the first is cut, the others become neighbours, unless the user changes this. Tools
  /// among them go into the rack. A job.
  void beginAll(const std::vector<std::filesystem::path>& paths);
  /// Reads more neighbours into the current import. Without an import: as beginAll(). A job.
  void addMore(const std::vector<std::filesystem::path>& paths);
  /// The current import, or null. It stays until it is open for cutting, or cancelled.
  ImportSet* set() const { return import_.get(); }
  bool isImporting() const { return import_ != nullptr; }
  /// The scan of the import whose choices are shown. Null: no import, or the shown entry is no scan.
  ImportPlan* plan() const;
  /// Prepares all entries as decided and opens them. Writes future tools below the data folder first and adds them to
  /// the rack. A job. If it fails, the plans stay for another remedy.
  void start();
  void cancel();

  // ---- For other parts

  /// Ends the import, if there is one.
  void putAway();
  /// Adds the tools among files to the rack.   @return the other files.
  std::vector<std::filesystem::path> takeTools(const std::vector<std::filesystem::path>& paths);

  void update() override;

  /// A line over the picture that cuts a part of plan() away.
  TrimDrawing drawing;

 private:
  void read(std::vector<std::filesystem::path> paths, const std::string& title, bool is_more);
  void makeTools(std::vector<MeshToolOrder> orders);
  void takeMadeTools(std::vector<SessionTool> made);
  void open();
  void openBeside();

  Workbench& bench_;
  std::unique_ptr<ImportSet> import_;
  std::vector<std::unique_ptr<ImportSet>> ending_;  // their previews are being cancelled
};

}  // namespace kerf
