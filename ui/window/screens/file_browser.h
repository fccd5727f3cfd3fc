// A file dialog inside the window: works on any display, and in tests.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kerf {

class FileBrowser {
 public:
  enum class Purpose { kOpen, kSave };
  /// Shows the browser at the next draw(). @param name  suggested, for kSave.   @param takes_several  Ctrl and a click
  /// choose further files: takeOthers().
  void show(Purpose purpose, const std::string& name = {}, bool takes_several = false);
  /// Label of the button for Purpose::kSave, in English.
  void setSaveLabel(const char* label) { save_label_ = label; }
  bool isShown() const { return is_shown_; }
  /// Current folder, and the first one at the next show. Setting a missing folder changes nothing.
  const std::filesystem::path& folder() const { return folder_; }
  void setFolder(const std::filesystem::path& folder);
  /// Enter and Escape. A tap shorter than a frame counts; Dear ImGui would miss it.
  void accept() { is_accepted_ = true; }
  void cancel() { is_escaped_ = true; }
  /// Draws the browser, if shown. @return the chosen file, once.
  std::optional<std::filesystem::path> draw();
  /// Further files chosen together with the last file from draw(), in the order of the clicks.
  std::vector<std::filesystem::path> takeOthers();

 private:
  struct Entry {
    std::string name;
    bool is_folder = false, is_case = false, is_run = false;  // a run is chosen like a case
  };
  void goTo(const std::filesystem::path& folder);
  bool isListed(const Entry& entry) const;
  void choose(const Entry& entry, bool adds);

  Purpose purpose_ = Purpose::kOpen;
  const char* save_label_ = "Export";
  bool is_shown_ = false, wants_popup_ = false, takes_several_ = false;
  bool is_accepted_ = false, is_escaped_ = false;  // since the last frame
  std::filesystem::path folder_ = std::filesystem::current_path();
  std::vector<Entry> entries_;
  std::vector<std::string> others_;  // beside name_
  std::string error_;
  std::string asked_;  // kSave: existing file that the user would replace
  char name_[512] = {};
};

}  // namespace kerf
