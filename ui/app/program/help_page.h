// Topics of `kerf help` beside the commands, as text for a terminal. manual.h writes them as manual pages.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace kerf {

struct HelpEntry {
  std::string term;  ///< as typed: "view.roll [DEG]"
  std::string note;  ///< beside the term: its key; may be empty
  std::string text;
};

struct HelpSection {
  std::string title;
  std::string text;  ///< before the entries; may be empty
  std::vector<HelpEntry> entries;
};

struct HelpPage {
  std::string name;     ///< as typed: "window"
  std::string summary;  ///< one line, without a full stop
  std::vector<HelpSection> sections;
};

/// Lines of at most 80 characters, except for longer words and terms.
std::string plainText(const HelpPage& page);
std::string plainText(const HelpEntry& entry);

/// The word that names an entry: "view.roll" for "view.roll [DEG]".
std::string nameOf(const HelpEntry& entry);
/// Entries of that name on all pages: `wait` has several.
std::vector<const HelpEntry*> findEntries(std::span<const HelpPage> pages, const std::string& name);

}  // namespace kerf
