#include "ui/window/file_browser.h"

#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <system_error>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_formats.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr const char* kTitle = "Choose a file###file-browser";

}  // namespace

void FileBrowser::show(Purpose purpose, const std::string& name) {
  purpose_ = purpose;
  is_shown_ = wants_popup_ = true;
  std::snprintf(name_, sizeof(name_), "%s", name.c_str());
  goTo(folder_);
}

void FileBrowser::goTo(const fs::path& folder) {
  std::error_code failed;
  fs::directory_iterator in(folder, failed);
  error_ = failed ? folder.string() + ": " + failed.message() : "";
  if (failed) return;

  folder_ = folder;
  entries_.clear();
  for (const fs::directory_entry& e : in) {
    Entry entry{e.path().filename().string(), e.is_directory(failed), false};
    entry.is_case = entry.is_folder && isCase(e.path());
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
  return (format && format->read) || (purpose_ == Purpose::kOpen && ending == ".toml");
}

std::optional<fs::path> FileBrowser::draw() {
  if (!is_shown_) return {};
  if (std::exchange(wants_popup_, false)) ImGui::OpenPopup(kTitle);
  ImGui::SetNextWindowSize({640, 460}, ImGuiCond_Appearing);
  bool stays = true;
  if (!ImGui::BeginPopupModal(kTitle, &stays)) {
    is_shown_ = stays && is_shown_;
    return {};
  }

  std::optional<fs::path> chosen;
  if (ImGui::Button("Up") && folder_.has_parent_path()) goTo(folder_.parent_path());
  ImGui::SameLine();
  if (const char* home = std::getenv("HOME"); ImGui::Button("Home") && home) goTo(home);
  ImGui::SameLine();
  ImGui::TextUnformatted(folder_.c_str());
  if (!error_.empty()) ImGui::TextWrapped("%s", error_.c_str());

  ImGui::BeginChild("entries", {0, -2.2f * ImGui::GetFrameHeightWithSpacing()}, true);
  std::optional<fs::path> next;
  for (const Entry& entry : entries_) {
    const std::string label = entry.is_case     ? entry.name + "   (case)"
                              : entry.is_folder ? entry.name + "/"
                                                : entry.name;
    if (!ImGui::Selectable(label.c_str(), entry.name == name_, ImGuiSelectableFlags_AllowDoubleClick)) continue;
    std::snprintf(name_, sizeof(name_), "%s", entry.name.c_str());
    const bool enters = entry.is_folder && !entry.is_case;
    if (enters) next = folder_ / entry.name;
    if (!enters && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) chosen = folder_ / entry.name;
  }
  ImGui::EndChild();
  if (next) {
    goTo(*next);
    if (purpose_ == Purpose::kOpen) name_[0] = 0;
  }

  ImGui::SetNextItemWidth(-1);
  if (purpose_ == Purpose::kSave && ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  const bool is_entered = ImGui::InputText("##name", name_, sizeof(name_), ImGuiInputTextFlags_EnterReturnsTrue);
  const char* const verb = purpose_ == Purpose::kOpen ? "Open" : "Export";
  if ((ImGui::Button(verb, {110, 0}) || is_entered) && name_[0] != 0) chosen = folder_ / name_;
  ImGui::SameLine();
  const bool is_cancelled = ImGui::Button("Cancel", {110, 0});
  if (chosen || is_cancelled) {
    ImGui::CloseCurrentPopup();
    is_shown_ = false;
  }
  ImGui::EndPopup();
  return chosen;
}

}  // namespace kerf
