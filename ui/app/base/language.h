// The language of the window: maps the program's English texts to those of a translator's PO file.
//
// The English texts are the keys. All shown texts go through shownText(), or through phrase() with numbers and names;
// texts without a translation stay English. Kerf reads the .po text itself: glibc's gettext() needs the locale of the
// whole process, trusts the bytes of a .mo, and makes translators compile each change. Guide for translators:
// docs/guide/languages.md.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

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
  /// Of shown numbers: the header X-Decimal-Sign, a comma or a point; a point without it.
  char decimalSign() const { return decimal_sign_; }
  std::size_t size() const { return texts_.size(); }
  /// Translation of the whole text; else unchanged. Blanks and line breaks at the ends stay.
  std::string shown(std::string_view english) const;

 private:
  std::string name_;
  char decimal_sign_ = '.';
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

/// The decimal sign of the shown language.
char shownDecimalSign();
/// A number as the user reads it.
struct ShownNumber {
  double value = 0;
  char sign = '.';
};
template <class T>
decltype(auto) asShown(T& value, char sign) {
  if constexpr (std::is_floating_point_v<std::remove_cvref_t<T>>)
    return ShownNumber{static_cast<double>(value), sign};
  else
    return (value);
}

std::string shownPhrase(fmt::string_view english, fmt::format_args values);
/// A sentence with values: translates the format, not the values. {0} and {1} allow another order. Numbers get the
/// decimal sign of the language: for the window, not for files and commands.
template <class... A>
std::string phrase(fmt::format_string<A...> english, A&&... values) {
  [[maybe_unused]] const char sign = shownDecimalSign();
  const auto shown = [english](const auto&... v) { return shownPhrase(english, fmt::make_format_args(v...)); };
  return shown(asShown(values, sign)...);
}
/// Numbers without words, or with units only: as phrase(), without a translation.
template <class... A>
std::string shownNumbers(fmt::format_string<A...> format, A&&... values) {
  const char sign = shownDecimalSign();
  const auto shown = [&](const auto&... v) {
    return fmt::vformat(fmt::string_view(format), fmt::make_format_args(v...));
  };
  return shown(asShown(values, sign)...);
}
/// For a number that another library has formatted: its points between digits become the decimal sign.
std::string withDecimalSign(std::string number);

// ---- Files

/// PO files by id ("de" for de.po) in FOLDER/languages and assets/languages; the former wins.
std::map<std::string, std::filesystem::path> findLanguages(const std::filesystem::path& config_folder);

/// Sets the shown language. @param id  of findLanguages(); "en": English; "marked": Language::marking().
/// Errors: kNotFound, those of Language::read(); the language then stays.
Expected<void> showLanguage(const std::string& id, const std::filesystem::path& config_folder);

}  // namespace kerf

/// Takes the format of a double.
template <>
struct fmt::formatter<kerf::ShownNumber> : fmt::formatter<double> {
  auto format(const kerf::ShownNumber& number, fmt::format_context& context) const {
    fmt::memory_buffer text;
    fmt::format_context plain(fmt::appender(text), context.args(), context.locale());
    fmt::formatter<double>::format(number.value, plain);
    return std::replace_copy(text.begin(), text.end(), context.out(), '.', number.sign);
  }
};
