// Controls of Dear ImGui with text: all words of the window go through here and into the chosen language
// (ui/app/base/language.h). scripts/check-texts forbids those of ImGui:: elsewhere.
//
// The calls match Dear ImGui's, but take words, never printf formats. Ids are those of the English labels in every
// language. Thread: that of the window, within a frame.
#pragma once

#include <imgui.h>

#include <string>
#include <string_view>

namespace kerf::ui {

/// Text of a control: one of Kerf's, which is translated, or a name or a value, which is not.
class Words {
 public:
  // Implicit: controls nearly always take such a text.
  Words(const char* text) : text_(text) {}
  Words(const std::string& text) : text_(text) {}
  Words(std::string_view text) : text_(text) {}

  std::string shown() const;
  /// With the id of the English label behind it.
  std::string label() const;

 private:
  friend Words asItIs(std::string_view);
  std::string_view text_;  // of the call
  bool is_name_ = false;
};

/// No translation: names of files, pieces and planes; also text that is already translated.
Words asItIs(std::string_view name);

// ---- Words

void text(const Words& words);
void textColored(const ImVec4& colour, const Words& words);
void textDisabled(const Words& words);
void textWrapped(const Words& words);
void bulletText(const Words& words);
/// For the previous item, hovered or not: the caller checks.
void setTooltip(const Words& words);
/// Draws at a place of the window. @param at  window units.
void addText(ImDrawList& list, const ImVec2& at, ImU32 colour, const Words& words);
/// Size as drawn by text() and addText(), window units.
ImVec2 textSize(const Words& words);

/// The text, or its beginning and "..." within a width.   @param text  as shown.
std::string beginThatFits(const std::string& text, float width);

/// On the line of the previous item, at a place from the window's left edge, or behind that item if it is longer.
void sameLineAt(float place);

/// The next button goes on the line of the previous item if it fits there.
void sameLineFor(const Words& label);

// ---- Controls. A given width is a minimum: longer words make it larger.

bool button(const Words& label, const ImVec2& size = {0, 0});
bool smallButton(const Words& label);
bool checkbox(const Words& label, bool* is_on);
bool radioButton(const Words& label, bool is_on);
bool selectable(const Words& label, bool is_selected = false, ImGuiSelectableFlags flags = 0,
                const ImVec2& size = {0, 0});
/// @param format  of printf, with the words beside the number: translated as a whole.
bool sliderFloat(const Words& label, float* value, float low, float high, const char* format,
                 ImGuiSliderFlags flags = 0);
/// A decimal comma counts as a point.   @param format  of printf, for one number and its unit.
bool inputFloat(const Words& label, float* value, const char* format, ImGuiInputTextFlags flags = 0);
bool inputFloat3(const Words& label, float values[3], const char* format, ImGuiInputTextFlags flags = 0);
bool inputText(const Words& label, char* text, std::size_t size, ImGuiInputTextFlags flags = 0);
bool inputTextWithHint(const Words& label, const Words& hint, char* text, std::size_t size);
bool beginCombo(const Words& label, const Words& chosen);
void progressBar(float share, const ImVec2& size);  ///< percent
void progressBar(float share, const ImVec2& size, const Words& words);
bool treeNode(const Words& label);
bool collapsingHeader(const Words& label);

// ---- Windows, menus

bool begin(const Words& title, bool* is_open = nullptr, ImGuiWindowFlags flags = 0);
bool beginMenu(const Words& label);
/// @param key  "Ctrl+Z"
bool menuItem(const Words& label, const Words& key = "", bool is_enabled = true);
/// Of menus, lists and menus at the cursor; a question keeps its keys.   @return  false: none is open.
bool closeTopmostPopup();
/// The text field in use can take its typing back.
bool canUndoTyping();
void openPopup(const Words& title);
bool isPopupOpen(const Words& title);
bool beginPopup(const Words& title);
bool beginPopupModal(const Words& title, bool* is_open = nullptr, ImGuiWindowFlags flags = 0);

}  // namespace kerf::ui
