// The language of the window: English texts of the program to those of a PO file that a translator writes.
//
// The program is written in English, and its texts are the keys. Whatever a person reads goes through shownText(), with
// numbers and names through phrase(); texts without a translation stay English. Kerf reads the .po text itself: glibc's
// gettext() needs the locale of the whole process and trusts the bytes of a .mo, and a translator would have to compile
// each change. docs/guide/languages.md is the translator's side of it.
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
  /// Errors: kNotFound; kBadFormat, also of msgctxt and msgid_plural; kBadValue, with line and text: other replacement
  /// fields or printf conversions than in the English text, "##", which is of ids, a text a second time, more than the
  /// limits above.
  static Expected<Language> read(const std::filesystem::path& file);
  /// Puts every text into «»: what is shown without them does not go through shownText().
  static Language marking();

  /// As those who speak it call it.
  const std::string& name() const { return name_; }
  std::size_t size() const { return texts_.size(); }
  /// Looked up whole; else unchanged. Blanks and line breaks at the ends stay.
  std::string shown(std::string_view english) const;

 private:
  std::string name_;
  bool is_marking_ = false;
  std::map<std::string, std::string, std::less<>> texts_;
};

// ---- What the window shows. Any thread: jobs make sentences, too.

/// From now on; null: English.
void setShownLanguage(std::shared_ptr<const Language> language);
std::shared_ptr<const Language> shownLanguage();

/// A text as a person reads it, also a printf format: a translation has the same conversions. Without a language: a
/// copy.
std::string shownText(std::string_view english);
/// A label of Dear ImGui: what stands before ## is shown, and the id is that of the English label in every language.
std::string shownLabel(std::string_view label);
/// A key with its modifiers, "Ctrl+Shift+P": whole, or each by itself.
std::string shownKey(std::string_view key);

std::string shownPhrase(fmt::string_view english, fmt::format_args values);
/// A sentence with values: the format is translated, {0} and {1} give another order, and the values stay as they are.
template <class... A>
std::string phrase(fmt::format_string<A...> english, A&&... values) {
  return shownPhrase(english, fmt::make_format_args(values...));
}

// ---- Files

/// Those in FOLDER/languages, and those of assets/languages that have no namesake there, by id: "de" of de.po.
std::map<std::string, std::filesystem::path> findLanguages(const std::filesystem::path& config_folder);

/// Shows a language from now on. @param id  of findLanguages(); "en": English; "marked": Language::marking().
/// Errors: kNotFound, those of Language::read(); then the language of before stays.
Expected<void> showLanguage(const std::string& id, const std::filesystem::path& config_folder);

}  // namespace kerf
