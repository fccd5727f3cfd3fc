#include "ui/window/gl/widgets.h"

#include <imgui_internal.h>  // the stack of open popups

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "ui/app/base/language.h"

namespace kerf::ui {

std::string Words::shown() const { return is_name_ ? std::string(text_) : shownText(text_); }
std::string Words::label() const { return is_name_ ? std::string(text_) : shownLabel(text_); }

Words asItIs(std::string_view name) {
  Words out(name);
  out.is_name_ = true;
  return out;
}

// ---- Words

void text(const Words& words) { ImGui::TextUnformatted(words.shown().c_str()); }

void textColored(const ImVec4& colour, const Words& words) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  text(words);
  ImGui::PopStyleColor();
}

void textDisabled(const Words& words) { textColored(ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled), words); }
void textWrapped(const Words& words) { ImGui::TextWrapped("%s", words.shown().c_str()); }
void bulletText(const Words& words) { ImGui::BulletText("%s", words.shown().c_str()); }
void setTooltip(const Words& words) { ImGui::SetTooltip("%s", words.shown().c_str()); }

void addText(ImDrawList& list, const ImVec2& at, ImU32 colour, const Words& words) {
  list.AddText(at, colour, words.shown().c_str());
}

ImVec2 textSize(const Words& words) { return ImGui::CalcTextSize(words.shown().c_str()); }

std::string beginThatFits(const std::string& text, float width) {
  std::string out = text;
  while (!out.empty() && ImGui::CalcTextSize(out.c_str()).x > width) {
    std::size_t end = out.size() - (out == text ? 1 : 4);                             // the dots are gone, too
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // whole characters
    out = end == 0 ? "" : text.substr(0, end) + "...";
  }
  return out;
}

void sameLineAt(float place) {
  const float end = ImGui::GetItemRectMax().x - ImGui::GetWindowPos().x + ImGui::GetStyle().ItemInnerSpacing.x;
  ImGui::SameLine(std::max(place, end));
}

void sameLineFor(const Words& label) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float width = ImGui::CalcTextSize(label.label().c_str(), nullptr, true).x + 2 * style.FramePadding.x;
  const float end = ImGui::GetItemRectMax().x - ImGui::GetWindowPos().x + style.ItemSpacing.x + width;
  if (end <= ImGui::GetWindowContentRegionMax().x) ImGui::SameLine();
}

// ---- Controls

bool button(const Words& label, const ImVec2& size) {
  const std::string shown = label.label();
  ImVec2 wide = size;
  if (size.x > 0) {
    const float words = ImGui::CalcTextSize(shown.c_str(), nullptr, true).x;
    wide.x = std::max(size.x, words + 2 * ImGui::GetStyle().FramePadding.x);
  }
  return ImGui::Button(shown.c_str(), wide);
}

bool smallButton(const Words& label) { return ImGui::SmallButton(label.label().c_str()); }
bool checkbox(const Words& label, bool* is_on) { return ImGui::Checkbox(label.label().c_str(), is_on); }
bool radioButton(const Words& label, bool is_on) { return ImGui::RadioButton(label.label().c_str(), is_on); }

bool selectable(const Words& label, bool is_selected, ImGuiSelectableFlags flags, const ImVec2& size) {
  return ImGui::Selectable(label.label().c_str(), is_selected, flags, size);
}

bool sliderFloat(const Words& label, float* value, float low, float high, const char* format, ImGuiSliderFlags flags) {
  const std::string id = label.label(), text = shownText(format);
  const ImGuiID number = ImGui::GetCurrentWindow()->GetID(id.c_str());
  const auto isTyped = [number] { return ImGui::TempInputIsActive(number); };
  if (isTyped()) {  // Dear ImGui knows the point only
    for (ImWchar& typed : ImGui::GetIO().InputQueueCharacters)
      if (typed == ',') typed = '.';
    return ImGui::SliderFloat(id.c_str(), value, low, high, text.c_str(), flags);
  }
  if (shownDecimalSign() == '.') return ImGui::SliderFloat(id.c_str(), value, low, high, text.c_str(), flags);
  ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0, 0, 0, 0));
  const bool is_changed = ImGui::SliderFloat(id.c_str(), value, low, high, text.c_str(), flags);
  ImGui::PopStyleColor();
  if (isTyped() || !ImGui::IsItemVisible()) return is_changed;
  std::array<char, 128> shown{};
  std::snprintf(shown.data(), shown.size(), text.c_str(), static_cast<double>(*value));
  ImGui::RenderTextClipped(ImGui::GetItemRectMin(), ImGui::GetItemRectMax(), withDecimalSign(shown.data()).c_str(),
                           nullptr, nullptr, {0.5f, 0.5f});
  return is_changed;
}

// Dear ImGui's field drops a decimal comma: "2,5" would become 25.
bool inputFloat(const Words& label, float* value, const char* format, ImGuiInputTextFlags flags) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), shownText(format).c_str(), static_cast<double>(*value));
  withDecimalSign(text.data()).copy(text.data(), text.size() - 1);
  if (!ImGui::InputText(label.label().c_str(), text.data(), text.size(), flags | ImGuiInputTextFlags_AutoSelectAll))
    return false;
  std::replace(text.begin(), text.end(), ',', '.');
  char* end = nullptr;
  const float typed = std::strtof(text.data(), &end);
  if (end == text.data() || !std::isfinite(typed)) return false;
  *value = typed;
  return true;
}

bool inputFloat3(const Words& label, float values[3], const char* format, ImGuiInputTextFlags flags) {
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x, width = (ImGui::CalcItemWidth() - 2 * gap) / 3;
  bool is_changed = false;
  ImGui::PushID(label.label().c_str());
  for (int n = 0; n < 3; ++n) {
    if (n > 0) ImGui::SameLine(0, gap);
    ImGui::PushID(n);
    ImGui::SetNextItemWidth(width);
    is_changed |= inputFloat("##value", &values[n], format, flags);
    ImGui::PopID();
  }
  ImGui::PopID();
  return is_changed;
}

bool inputText(const Words& label, char* text, std::size_t size, ImGuiInputTextFlags flags) {
  return ImGui::InputText(label.label().c_str(), text, size, flags);
}

bool inputTextWithHint(const Words& label, const Words& hint, char* text, std::size_t size) {
  return ImGui::InputTextWithHint(label.label().c_str(), hint.shown().c_str(), text, size);
}

bool beginCombo(const Words& label, const Words& chosen) {
  return ImGui::BeginCombo(label.label().c_str(), chosen.shown().c_str());
}

void progressBar(float share, const ImVec2& size) { ImGui::ProgressBar(share, size); }

void progressBar(float share, const ImVec2& size, const Words& words) {
  ImGui::ProgressBar(share, size, words.shown().c_str());
}

bool treeNode(const Words& label) { return ImGui::TreeNode(label.label().c_str()); }
bool collapsingHeader(const Words& label) { return ImGui::CollapsingHeader(label.label().c_str()); }

// ---- Windows, menus

// A window that appears leaves the keys to a text being typed.
bool begin(const Words& title, bool* is_open, ImGuiWindowFlags flags) {
  if (ImGui::GetIO().WantTextInput) flags |= ImGuiWindowFlags_NoFocusOnAppearing;
  return ImGui::Begin(title.label().c_str(), is_open, flags);
}

bool beginMenu(const Words& label) { return ImGui::BeginMenu(label.label().c_str()); }

bool menuItem(const Words& label, const Words& key, bool is_enabled) {
  return ImGui::MenuItem(label.label().c_str(), key.shown().c_str(), false, is_enabled);
}

bool closeTopmostPopup() {
  const ImGuiContext& now = *ImGui::GetCurrentContext();
  if (now.OpenPopupStack.empty()) return false;
  const ImGuiWindow* const top = now.OpenPopupStack.back().Window;
  if (top && (top->Flags & ImGuiWindowFlags_Modal)) return false;
  ImGui::ClosePopupToLevel(now.OpenPopupStack.Size - 1, true);
  return true;
}

bool canUndoTyping() {
  const ImGuiContext& now = *ImGui::GetCurrentContext();
  return now.ActiveId != 0 && now.ActiveId == now.InputTextState.ID && now.InputTextState.GetUndoAvailCount() > 0;
}

void openPopup(const Words& title) { ImGui::OpenPopup(title.label().c_str()); }
bool isPopupOpen(const Words& title) { return ImGui::IsPopupOpen(title.label().c_str()); }
bool beginPopup(const Words& title) { return ImGui::BeginPopup(title.label().c_str()); }

bool beginPopupModal(const Words& title, bool* is_open, ImGuiWindowFlags flags) {
  return ImGui::BeginPopupModal(title.label().c_str(), is_open, flags);
}

}  // namespace kerf::ui
