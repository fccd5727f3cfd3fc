// Text inside XML: SVG drawings, 3MF.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "geometry/base/text.h"

namespace kerf {

/// Text with XML's reserved characters as entities, without control characters, and with '?' for forbidden ones: bytes
/// that are no UTF-8, U+FFFE and U+FFFF.
inline std::string xmlText(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8Length(text, at);
    const char c = text[at];
    const std::string_view whole = text.substr(at, length);
    if (whole == "\xef\xbf\xbe" || whole == "\xef\xbf\xbf")
      out += '?';
    else if (length > 1)
      out += whole;
    else if (length == 0)
      out += '?';
    else if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

}  // namespace kerf
