// The language of the window: maps the program's English texts to those of a translator's PO file.
//
// The English texts are the keys. All shown texts go through shownText(), or through phrase() with numbers and names;
// texts without a translation stay English. Kerf reads the .po text itself: glibc's gettext() needs the locale of the
// whole process, trusts the bytes of a .mo, and makes translators compile each change. Guide for translators:
// docs/guide/languages.md.
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "geometry/base/error.h"

namespace kerf {

/// The texts of one language.
class Language {
 public:
  static constexpr std::size_t kMostBytes = 1 << 20, kMostTexts = 20000, kLongestText = 2000;

  /// A PO file in UTF-8, with the header X-Language-Name. Fuzzy texts count as untranslated.
  /// Errors: kNotFound; kBadFormat, also for msgctxt and msgid_plural; kBadValue, with line and text: replacement
  /// fields or printf conversions that differ from the English text, "##" (reserved for ids), a duplicate text, more
  /// than the limits above.
  static Expected<Language> read(const std::filesystem::path& file);
  /// Puts every text into «»: shown texts without them bypass shownText().
  static Language marking();

  /// Name in the language itself.
  const std::string& name() const { return name_; }
  std::size_t size() const { return texts_.size(); }
  /// Translation of the whole text; else unchanged. Blanks and line breaks at the ends stay.
  std::string shown(std::string_view english) const;

 private:
  std::string name_;
  bool is_marking_ = false;
  std::map<std::string, std::string, std::less<>> texts_;
};

// ---- Shown texts. Any thread, because jobs make sentences too.

/// Sets the language; null: English.
void setShownLanguage(std::shared_ptr<const Language> language);
std::shared_ptr<const Language> shownLanguage();

/// A translated text or printf format; a translation has the same conversions. Without a language: a copy.
std::string shownText(std::string_view english);
/// A label of Dear ImGui: translates the part before ##; the id is that of the English label in every language.
std::string shownLabel(std::string_view label);
/// A key with its modifiers, "Ctrl+Shift+P": translated whole, or part by part.
std::string shownKey(std::string_view key);

std::string shownPhrase(fmt::string_view english, fmt::format_args values);
/// A sentence with values: translates the format, not the values. {0} and {1} allow another order.
template <class... A>
std::string phrase(fmt::format_string<A...> english, A&&... values) {
  return shownPhrase(english, fmt::make_format_args(values...));
}

// ---- Files

/// PO files by id ("de" for de.po) in FOLDER/languages and assets/languages; the former wins.
std::map<std::string, std::filesystem::path> findLanguages(const std::filesystem::path& config_folder);

/// Sets the shown language. @param id  of findLanguages(); "en": English; "marked": Language::marking().
/// Errors: kNotFound, those of Language::read(); the language then stays.
Expected<void> showLanguage(const std::string& id, const std::filesystem::path& config_folder);

}  // namespace kerf
