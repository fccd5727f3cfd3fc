#include "ui/app/program/help_page.h"

#include <fmt/format.h>

#include <cstddef>
#include <sstream>

namespace kerf {
namespace {

constexpr std::size_t kLineWidth = 80, kNoteColumn = 48;

// Fills lines with the words of a text.
std::string filled(const std::string& text, std::size_t indent) {
  const std::string blanks(indent, ' ');
  std::istringstream words(text);
  std::string out, line;

  for (std::string word; words >> word;) {
    if (!line.empty() && indent + line.size() + 1 + word.size() > kLineWidth) {
      out += blanks + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  if (!line.empty()) out += blanks + line + "\n";
  return out;
}

}  // namespace

std::string plainText(const HelpEntry& entry) {
  std::string out = "  " + entry.term;
  if (!entry.note.empty()) out = fmt::format("{:<{}}  {}", out, kNoteColumn - 2, entry.note);
  return out + "\n" + filled(entry.text, 6);
}

std::string plainText(const HelpPage& page) {
  std::string out = page.summary + "\n";
  for (const HelpSection& section : page.sections) {
    out += "\n" + section.title + "\n" + filled(section.text, 2);
    for (const HelpEntry& entry : section.entries) out += plainText(entry);
  }
  return out;
}

std::string nameOf(const HelpEntry& entry) { return entry.term.substr(0, entry.term.find(' ')); }

std::vector<const HelpEntry*> findEntries(std::span<const HelpPage> pages, const std::string& name) {
  std::vector<const HelpEntry*> out;
  for (const HelpPage& page : pages)
    for (const HelpSection& section : page.sections)
      for (const HelpEntry& entry : section.entries)
        if (nameOf(entry) == name) out.push_back(&entry);
  return out;
}

}  // namespace kerf
