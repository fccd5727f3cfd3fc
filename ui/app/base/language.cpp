#include "ui/app/base/language.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "geometry/base/assets.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// ---- A PO file

struct PoRow {
  std::size_t line = 0;
  bool is_fuzzy = false, is_complete = false;
  std::string english{}, translated{};
};

// Appends a quoted text.   @return  false: text outside the quotes, or an unknown escape.
bool appendQuoted(std::string_view quoted, std::string& out) {
  if (quoted.size() < 2 || !quoted.starts_with('"') || !quoted.ends_with('"')) return false;
  quoted = quoted.substr(1, quoted.size() - 2);
  for (std::size_t at = 0; at < quoted.size(); ++at) {
    constexpr std::string_view kEscapes = "\\\"nt", kMeant = "\\\"\n\t";
    const bool is_escape = quoted[at] == '\\';
    if (is_escape && ++at == quoted.size()) return false;
    const std::size_t known = kEscapes.find(quoted[at]);
    if (is_escape ? known == kEscapes.npos : quoted[at] == '"' || static_cast<unsigned char>(quoted[at]) < ' ')
      return false;
    out += is_escape ? kMeant[known] : quoted[at];
  }
  return true;
}

// Parts that a translation must keep: replacement fields {}, {1:.2f} by number, with their formats; printf conversions
// and percent signs in order. None: the text has other braces.
std::optional<std::map<std::size_t, std::string>> keptOf(std::string_view text) {
  std::map<std::size_t, std::string> out;
  std::size_t automatic = 0, numbered = 0, percents = 10;  // keys after the one-digit field numbers
  for (std::size_t at = text.find_first_of("{}%"); at != text.npos; at = text.find_first_of("{}%", at)) {
    if (text[at] == '%') {
      const std::size_t end = std::min(text.find_first_not_of("+-#.*0123456789hlLzjt", at + 1), text.size() - 1);
      const bool is_read = text[end] != '%' && !std::isalpha(static_cast<unsigned char>(text[end]));
      const std::size_t length = is_read || end == at ? 1 : end + 1 - at;
      out[percents++] = text.substr(at, length);
      at += length;
      continue;
    }
    const std::size_t end = text.find_first_of("{}", at + 1);
    if (text[at] == '}' || end == text.npos || text[end] == '{') return {};
    const std::string_view inside = text.substr(at + 1, end - at - 1);
    const std::size_t colon = std::min(inside.find(':'), inside.size());
    const bool is_numbered = colon == 1 && std::isdigit(static_cast<unsigned char>(inside[0]));
    if ((colon > 0 && !is_numbered) || (is_numbered ? automatic : numbered) > 0 || automatic > 9) return {};
    const std::size_t number = is_numbered ? static_cast<std::size_t>(inside[0] - '0') : automatic++;
    if (is_numbered) ++numbered;
    if (!out.emplace(number, inside.substr(colon)).second) return {};
    at = end + 1;
  }
  return out;
}

// Null: no fault.
const char* faultOf(const PoRow& row) {
  if (std::max(row.english.size(), row.translated.size()) > Language::kLongestText) return "more than 2000 bytes";
  if ((row.english + row.translated).find("##") != std::string::npos) return "##, reserved for ids";
  const auto kept = keptOf(row.english);
  if (!kept || kept != keptOf(row.translated)) return "{} or % that differ from the English text, or repeat";
  return nullptr;
}

// ---- Shown language

// Global, like the style: one window.
std::mutex shown_mutex;
std::shared_ptr<const Language> shown_now;

}  // namespace

// ---- A language

Expected<Language> Language::read(const fs::path& file) {
  const auto wrong = [&](Error::Code code, std::string place, std::string found, std::string expected) {
    return fail({.code = code,
                 .file = file.string(),
                 .place = std::move(place),
                 .found = std::move(found),
                 .expected = std::move(expected)});
  };
  std::error_code failed;
  if (!fs::is_regular_file(file, failed)) return wrong(Error::Code::kNotFound, "", "no such file", "a PO file");
  if (fs::file_size(file, failed) > kMostBytes || failed)
    return wrong(Error::Code::kBadFormat, "", "more than 1 MiB", "a PO file of at most 1 MiB");

  std::vector<PoRow> rows;
  std::ifstream in(file, std::ios::binary);
  std::size_t n = 0;
  bool is_fuzzy = false;
  for (std::string line; std::getline(in, line);) {
    ++n;
    std::string_view rest = line;
    rest = rest.substr(0, rest.find_last_not_of(" \t\r") + 1);
    if (rest.empty() || rest[0] == '#') {
      is_fuzzy |= rest.starts_with("#,") && rest.find("fuzzy") != rest.npos;
      continue;
    }
    const bool is_open = !rows.empty() && !rows.back().is_complete;  // without its msgstr so far
    if (rest.starts_with("msgid ") && !is_open) {
      rows.push_back({.line = n, .is_fuzzy = std::exchange(is_fuzzy, false)});
      rest.remove_prefix(6);
    } else if (rest.starts_with("msgstr ") && is_open) {
      rows.back().is_complete = true;
      rest.remove_prefix(7);
    }
    if (rows.empty() || !appendQuoted(rest, rows.back().is_complete ? rows.back().translated : rows.back().english))
      return wrong(Error::Code::kBadFormat, fmt::format("line {}", n), line.substr(0, 60),
                   "msgid and msgstr with texts in quotes; contexts (msgctxt) and plurals are not supported");
  }
  if (rows.size() > kMostTexts)
    return wrong(Error::Code::kBadFormat, "", fmt::format("{} texts", rows.size()),
                 fmt::format("at most {}", kMostTexts));

  Language out;
  for (PoRow& row : rows) {
    const std::string place = fmt::format("line {}, \"{}\"", row.line, row.english);
    if (row.english.empty()) {
      constexpr std::string_view kName = "X-Language-Name: ";
      const std::size_t begin = row.translated.find(kName);
      if (row.translated.find("charset=UTF-8") == std::string::npos || begin == std::string::npos) break;
      out.name_ = row.translated.substr(begin + kName.size());
      out.name_.resize(std::min(out.name_.find('\n'), out.name_.size()));
      constexpr std::string_view kSign = "X-Decimal-Sign: ";
      if (const std::size_t sign = row.translated.find(kSign); sign != std::string::npos) {
        const std::string_view rest = std::string_view(row.translated).substr(sign + kSign.size());
        const std::string_view given = rest.substr(0, rest.find('\n'));
        if (given != "," && given != ".")
          return wrong(Error::Code::kBadValue, place, "X-Decimal-Sign: " + std::string(given), "a comma or a point");
        out.decimal_sign_ = given[0];
      }
      if (out.name_.size() > 60 || out.name_.find("##") != std::string::npos)
        return wrong(Error::Code::kBadValue, place, out.name_, "X-Language-Name: at most 60 bytes, without ##");
    } else if (!row.translated.empty() && !row.is_fuzzy) {
      if (const char* const fault = faultOf(row))
        return wrong(Error::Code::kBadValue, place, fault, "each field, conversion and percent sign as in English");
      if (!out.texts_.emplace(std::move(row.english), std::move(row.translated)).second)
        return wrong(Error::Code::kBadValue, place, "a duplicate text", "each text once");
    }
  }
  if (out.name_.empty())
    return wrong(Error::Code::kBadFormat, "", "no header with charset=UTF-8 and X-Language-Name",
                 "msgid \"\" at the beginning, as in assets/languages/de.po");
  return out;
}

Language Language::marking() {
  Language out;
  out.name_ = "«»";
  out.is_marking_ = true;
  return out;
}

std::string Language::shown(std::string_view english) const {
  if (is_marking_) {
    const auto isLetter = [](unsigned char c) { return std::isalpha(c) || c >= 0x80; };
    const bool is_marked = english.starts_with("«") && english.ends_with("»");
    const bool is_read = std::any_of(english.begin(), english.end(), isLetter);
    return is_marked || !is_read ? std::string(english) : "«" + std::string(english) + "»";
  }
  const std::size_t begin = english.find_first_not_of(" \n");
  if (begin == english.npos) return std::string(english);
  const std::size_t end = english.find_last_not_of(" \n") + 1;
  const auto row = texts_.find(english.substr(begin, end - begin));
  if (row == texts_.end()) return std::string(english);
  return std::string(english.substr(0, begin)) + row->second + std::string(english.substr(end));
}

// ---- Shown texts

void setShownLanguage(std::shared_ptr<const Language> language) {
  const std::lock_guard lock(shown_mutex);
  shown_now = std::move(language);
}

std::shared_ptr<const Language> shownLanguage() {
  const std::lock_guard lock(shown_mutex);
  return shown_now;
}

std::string shownText(std::string_view english) {
  const auto language = shownLanguage();
  return language ? language->shown(english) : std::string(english);
}

std::string shownLabel(std::string_view label) {
  const std::size_t id = label.find("##");
  if (id == 0) return std::string(label);
  const bool is_whole_id = id != label.npos && label.substr(id).starts_with("###");
  return shownText(label.substr(0, id)) + (is_whole_id ? "" : "###") + std::string(label.substr(is_whole_id ? id : 0));
}

std::string shownKey(std::string_view key) {
  const std::string whole = shownText(key);
  const std::size_t plus = key.find('+');
  if (whole != key || plus == key.npos) return whole;
  return shownText(key.substr(0, plus)) + "+" + shownKey(key.substr(plus + 1));
}

char shownDecimalSign() {
  const auto language = shownLanguage();
  return language ? language->decimalSign() : '.';
}

std::string withDecimalSign(std::string number) {
  const char sign = shownDecimalSign();
  for (std::size_t n = 1; n + 1 < number.size(); ++n)
    if (number[n] == '.' && std::isdigit(static_cast<unsigned char>(number[n - 1])) &&
        std::isdigit(static_cast<unsigned char>(number[n + 1])))
      number[n] = sign;
  return number;
}

std::string shownPhrase(fmt::string_view english, fmt::format_args values) {
  try {
    return fmt::vformat(shownText({english.data(), english.size()}), values);
  } catch (const fmt::format_error&) {
    return fmt::vformat(english, values);
  }
}

// ---- Files

std::map<std::string, fs::path> findLanguages(const fs::path& config_folder) {
  std::vector<fs::path> folders{config_folder / "languages"};
  for (fs::path& folder : findAssets("languages")) folders.push_back(std::move(folder));
  std::map<std::string, fs::path> out;
  for (const fs::path& folder : folders) {
    std::error_code failed;
    for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
      if (at->path().extension() == ".po") out.emplace(at->path().stem().string(), at->path());
  }
  return out;
}

Expected<void> showLanguage(const std::string& id, const fs::path& config_folder) {
  std::shared_ptr<const Language> shown;  // none: English
  const auto known = findLanguages(config_folder);
  if (id == "marked") {
    shown = std::make_shared<const Language>(Language::marking());
  } else if (const auto one = known.find(id); id != "en" && one != known.end()) {
    KERF_TRY(language, Language::read(one->second));
    shown = std::make_shared<const Language>(std::move(language));
  } else if (id != "en") {
    std::string ids = "en";
    for (const auto& [other, file] : known) ids += ", " + other;
    return fail({.code = Error::Code::kNotFound,
                 .found = "no language \"" + id + "\"",
                 .expected = "one of " + ids,
                 .hint = "put " + id + ".po into " + (config_folder / "languages").string()});
  }
  setShownLanguage(std::move(shown));
  return {};
}

}  // namespace kerf
