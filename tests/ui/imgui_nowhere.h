// Dear ImGui without a display: the text and the places of what the panels draw.
#pragma once

#include <imgui.h>

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "ui/window/gl/font.h"
#include "ui/window/gl/theme.h"

namespace kerf::test {

inline void append(std::string& text, unsigned code) {  // UTF-8
  if (code < 0x80) {
    text += static_cast<char>(code);
  } else if (code < 0x800) {
    text += static_cast<char>(0xC0 | code >> 6);
    text += static_cast<char>(0x80 | (code & 0x3F));
  } else {
    text += static_cast<char>(0xE0 | code >> 12);
    text += static_cast<char>(0x80 | (code >> 6 & 0x3F));
    text += static_cast<char>(0x80 | (code & 0x3F));
  }
}

// Dear ImGui without an output.
class ImGuiNowhere {
 public:
  explicit ImGuiNowhere(const ImVec2& size = {1280, 800}, float scale = 1) {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = size;
    if (!addFont(*io.Fonts, 15 * scale)) io.Fonts->AddFontDefault();
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
    for (const ImFontGlyph& glyph : io.Fonts->Fonts[0]->Glyphs)
      if (glyph.Visible) letters_[{glyph.U0, glyph.V0}] = glyph.Codepoint;
    applyStyle(Theme::kLight, scale);
  }
  ~ImGuiNowhere() { ImGui::DestroyContext(); }
  ImGuiNowhere(const ImGuiNowhere&) = delete;
  ImGuiNowhere& operator=(const ImGuiNowhere&) = delete;

  // Draws a frame.   @return  all its words without blanks, identified by the places of their letters in the texture:
  // the visible text, from any widget. A letter that does not follow the previous one starts a line.
  std::string draw(const std::function<void()>& what) {
    ImGui::GetIO().DeltaTime = 1.0f / 60;
    ImGui::NewFrame();
    what();
    ImGui::Render();

    std::string out;
    const ImDrawData& data = *ImGui::GetDrawData();
    for (int n = 0; n < data.CmdListsCount; ++n) {
      const ImVector<ImDrawVert>& corners = data.CmdLists[n]->VtxBuffer;
      ImVec2 end{-1e6f, 0};
      for (int k = 0; k + 3 < corners.Size; ++k) {
        const auto letter = letters_.find({corners[k].uv.x, corners[k].uv.y});
        if (letter == letters_.end()) continue;
        constexpr float kBlank = 12, kLine = 14;
        const ImVec2 at = corners[k].pos;
        if (at.x < end.x - 3 || at.x > end.x + kBlank || std::abs(at.y - end.y) > kLine) out += '\n';
        append(out, letter->second);
        end = {corners[k + 1].pos.x, at.y};
        k += 3;
      }
      out += '\n';
    }
    return out;
  }

  // Letters of the last frame that an edge cuts at the left or right, each with its line.
  std::string cutLetters() const {
    std::string out;
    const ImDrawData& data = *ImGui::GetDrawData();
    for (int n = 0; n < data.CmdListsCount; ++n) {
      const ImDrawList& list = *data.CmdLists[n];
      for (const ImDrawCmd& command : list.CmdBuffer)
        for (unsigned k = 0; k + 5 < command.ElemCount; k += 3) {
          const ImDrawVert& low = list.VtxBuffer[list.IdxBuffer[static_cast<int>(command.IdxOffset + k)]];
          const ImDrawVert& high = list.VtxBuffer[list.IdxBuffer[static_cast<int>(command.IdxOffset + k + 2)]];
          const auto letter = letters_.find({low.uv.x, low.uv.y});
          if (letter == letters_.end() || high.pos.y < command.ClipRect.y || low.pos.y > command.ClipRect.w) continue;
          if (low.pos.x >= command.ClipRect.x - 1 && high.pos.x <= command.ClipRect.z + 1) continue;
          append(out, letter->second);
          out += " at " + std::to_string(low.pos.x) + ", " + std::to_string(low.pos.y) + '\n';
        }
    }
    return out;
  }

 private:
  std::map<std::pair<float, float>, unsigned> letters_;  // by their upper left corner
};

}  // namespace kerf::test
