// Text inside XML: SVG drawings, 3MF.
#pragma once

#include <string>
#include <string_view>

namespace kerf {

/// With the characters that XML keeps for itself as entities, and without control characters.
inline std::string xmlText(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

}  // namespace kerf
