// The language of the window: English texts of the program to those of a file that a translator writes.
//
// The program is written in English, and its texts are the keys. Whatever a person reads goes through shownText();
// what a file does not have stays English. docs/guide/languages.md is the translator's side of it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// A text or a translation, taken apart at its placeholders.
struct TextPattern {
  enum class Kind { kLiteral, kNumber, kAny, kName };
  struct Piece {
    Kind kind = Kind::kLiteral;
    std::string literal{};   ///< of kLiteral
    std::size_t number = 0;  ///< of a placeholder: which one of the English text is meant, from 0
  };
  std::vector<Piece> pieces{};
  std::size_t placeholders = 0;
  std::size_t letters = 0;  ///< bytes of all literals: the pattern that has most of them goes first
};

/// The texts of one language. A file:
///
///     format = "kerf-language"
///     version = 1
///     name = "Deutsch"                             # as those who speak it call it
///     [texts]
///     "Cancel" = "Abbrechen"
///     "about {} s left" = "noch etwa {} s"         # {}: a number
///     "Goes through the {*}" = "Geht durch: {*}"   # {*}: any words of one line, translated in turn
///     "Only {name}" = "Nur {name}"                 # {name}: the user's own words of one line, as they are
///     "Step {} of {}" = "Von {2} Schritten: {1}"   # numbered where the order is another one
///
/// A text with the translation "" is not translated yet. Not for several threads: it remembers what it was asked.
class Language {
 public:
  static constexpr std::size_t kMostBytes = 1 << 20, kMostTexts = 20000, kLongestText = 2000;

  /// Errors: kNotFound; kBadFormat, kBadValue with line and text: a placeholder that is missing, there twice or
  /// unknown, another printf conversion than in the English text, "##", which is of ids, a control character in the
  /// name, or more than the limits above.
  static Expected<Language> read(const std::filesystem::path& file);
  /// Puts every text into «»: what is shown without them does not go through shownText().
  static Language marking();

  /// As those who speak it call it.
  const std::string& name() const { return name_; }
  std::size_t size() const { return exact_.size() + patterns_.size(); }
  /// Whole, by placeholders, or line by line; else as it is. Blanks at the ends stay.
  /// Cost: a look-up in a table; of a text that was not asked for before a comparison with all that have placeholders.
  std::string shown(std::string_view english) const;
  /// What was asked for so far, has no translation and could have one in a file: UTF-8 without { } and ##, of more than
  /// one letter, which is a key. Numbers as {}; sorted, at most kMostTexts.
  const std::set<std::string>& missing() const { return missing_; }

 private:
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
  };
  using Texts = std::unordered_map<std::string, std::string, Hash, std::equal_to<>>;
  struct Row {
    TextPattern english, translated;
  };

  Expected<void> add(const std::string& english, const std::string& translated);
  bool find(std::string_view english, int depth, std::string& out) const;

  std::string name_;
  bool is_marking_ = false;
  Texts exact_;
  std::vector<Row> patterns_;
  mutable Texts asked_;
  mutable std::set<std::string> missing_;
};

// ---- What the window shows. One thread.

/// From now on; null: English.
void setShownLanguage(std::shared_ptr<const Language> language);
const Language* shownLanguage();

/// A text as a person reads it. Cost without a language: a copy.
std::string shownText(std::string_view english);
/// A label of Dear ImGui: what stands before ## is shown, and the id is that of the English label in every language.
std::string shownLabel(std::string_view label);
/// A printf format of a slider. A translation with other conversions than the English one is not taken.
std::string shownFormat(std::string_view format);

// ---- Files

struct LanguageFile {
  std::string id;  ///< "de": the name of the file
  std::filesystem::path file;
};
/// Those in FOLDER/languages, and those of assets/languages that have no namesake there; by id.
std::vector<LanguageFile> findLanguages(const std::filesystem::path& config_folder);

/// Shows a language from now on. @param id  of findLanguages(); "en": English; "marked": Language::marking().
/// Errors: kNotFound, those of Language::read(); then the language of before stays.
Expected<void> showLanguage(const std::string& id, const std::filesystem::path& config_folder);

/// Writes the texts of the shown language that have no translation so far, each with "", as a language file.
/// @return  how many.   Errors: kUnsupported: English is shown; kWriteFailed, also if the file is there already.
Expected<std::size_t> writeMissingTexts(const std::filesystem::path& file);

}  // namespace kerf
