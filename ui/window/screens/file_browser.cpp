#include "ui/window/screens/file_browser.h"

#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_formats.h"
#include "sim/run/files/run_manifest.h"
#include "ui/app/base/language.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr const char* kTitle = "Choose a file###file-browser";

}  // namespace

void FileBrowser::show(Purpose purpose, const std::string& name, bool takes_several) {
  purpose_ = purpose;
  takes_several_ = takes_several;
  is_shown_ = wants_popup_ = true;
  asked_.clear();
  is_accepted_ = is_escaped_ = false;
  std::snprintf(name_, sizeof(name_), "%s", name.c_str());
  goTo(folder_);
}

void FileBrowser::setFolder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_directory(folder, ignored)) folder_ = folder;
}

void FileBrowser::goTo(const fs::path& folder) {
  std::error_code failed;
  fs::directory_iterator in(folder, failed);
  error_ = failed ? folder.string() + ": " + failed.message() : "";
  if (failed) return;

  folder_ = folder;
  others_.clear();
  entries_.clear();
  for (const fs::directory_entry& e : in) {
    Entry entry{e.path().filename().string(), e.is_directory(failed), false};
    entry.is_run = entry.is_folder && isRun(e.path());
    entry.is_case = entry.is_run || (entry.is_folder && isCase(e.path()));
    if (isListed(entry)) entries_.push_back(std::move(entry));
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    const bool a_first = a.is_folder && !a.is_case, b_first = b.is_folder && !b.is_case;
    return a_first != b_first ? a_first : a.name < b.name;
  });
}

bool FileBrowser::isListed(const Entry& entry) const {
  if (entry.name.starts_with(".")) return false;
  if (entry.is_folder) return true;
  const std::string ending = fs::path(entry.name).extension().string();
  const MeshFormatRow* const format = formatOfExtension(ending);
  return (format && format->read) || ending == ".kerf" || (purpose_ == Purpose::kOpen && ending == ".toml");
}

// @param adds  toggles the entry in the choice; else it becomes the only one.
void FileBrowser::choose(const Entry& entry, bool adds) {
  const auto known = std::find(others_.begin(), others_.end(), entry.name);
  if (adds && known != others_.end()) {
    others_.erase(known);
  } else if (adds && name_[0] != 0) {
    if (entry.name != name_) others_.push_back(entry.name);
  } else {
    others_.clear();
    std::snprintf(name_, sizeof(name_), "%s", entry.name.c_str());
  }
}

std::vector<fs::path> FileBrowser::takeOthers() {
  std::vector<fs::path> out;
  for (const std::string& name : std::exchange(others_, {})) out.push_back(folder_ / name);
  return out;
}

std::optional<fs::path> FileBrowser::draw() {
  if (!is_shown_) return {};
  if (std::exchange(wants_popup_, false)) ui::openPopup(kTitle);
  ImGui::SetNextWindowSize({scaled(640), scaled(460)}, ImGuiCond_Appearing);
  bool stays = true;
  if (!ui::beginPopupModal(kTitle, &stays)) {
    is_shown_ = stays && is_shown_;
    return {};
  }

  std::optional<fs::path> chosen;
  if (ui::button("Go up") && folder_.has_parent_path()) goTo(folder_.parent_path());
  ImGui::SameLine();
  if (const char* home = std::getenv("HOME"); ui::button("Home") && home) goTo(home);
  ImGui::SameLine();
  ui::text(ui::asItIs(folder_.string()));
  if (!error_.empty()) ui::textWrapped(error_);

  ImGui::BeginChild("entries", {0, -2.2f * ImGui::GetFrameHeightWithSpacing()}, true);
  std::optional<fs::path> next;
  for (const Entry& entry : entries_) {
    const std::string label = entry.is_run      ? entry.name + shownText("   (run)")
                              : entry.is_case   ? entry.name + shownText("   (case)")
                              : entry.is_folder ? entry.name + "/"
                                                : entry.name;
    const bool is_chosen =
        entry.name == name_ || std::find(others_.begin(), others_.end(), entry.name) != others_.end();
    if (!ui::selectable(ui::asItIs(label), is_chosen, ImGuiSelectableFlags_AllowDoubleClick)) continue;
    const bool enters = entry.is_folder && !entry.is_case;
    choose(entry, takes_several_ && !enters && ImGui::GetIO().KeyCtrl);
    if (enters) next = folder_ / entry.name;
    const bool is_double = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    if (!enters && is_double && purpose_ == Purpose::kOpen) chosen = folder_ / entry.name;
  }
  ImGui::EndChild();
  if (next) {
    goTo(*next);
    if (purpose_ == Purpose::kOpen) name_[0] = 0;
  }

  ImGui::SetNextItemWidth(-1);
  if (purpose_ == Purpose::kSave && ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ui::inputText("##name", name_, sizeof(name_));
  if (asked_ != name_) asked_.clear();
  const char* const verb = purpose_ == Purpose::kOpen ? "Open" : !asked_.empty() ? "Replace" : save_label_;
  const bool is_entered = std::exchange(is_accepted_, false);
  if ((ui::button(verb, {scaled(110), 0}) || is_entered) && name_[0] != 0) {
    std::error_code ignored;
    const bool replaces = purpose_ == Purpose::kSave && fs::exists(folder_ / name_, ignored);
    if (replaces && asked_.empty())
      asked_ = name_;
    else
      chosen = folder_ / name_;
  }
  ImGui::SameLine();
  const bool is_escape = std::exchange(is_escaped_, false);
  const bool is_cancelled = ui::button("Cancel", {scaled(110), 0}) || is_escape;
  if (takes_several_) {
    ImGui::SameLine();
    ui::textDisabled(others_.empty() ? "Ctrl and click: add neighbours" : "the first file is the object to cut");
  }
  if (!asked_.empty()) {
    ImGui::SameLine();
    ui::text("File exists. Replace it?");
  }
  if (chosen || is_cancelled) {
    ImGui::CloseCurrentPopup();
    is_shown_ = false;
  }
  ImGui::EndPopup();
  return chosen;
}

}  // namespace kerf
