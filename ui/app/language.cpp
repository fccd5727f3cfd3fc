#include "ui/app/language.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <optional>
#include <system_error>
#include <utility>

#include "geometry/base/assets.h"
#include "geometry/base/atomic_file.h"
#include "geometry/base/toml_reader.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Kind = TextPattern::Kind;

constexpr const char* kFormat = "kerf-language";
constexpr const char* kEnglish = "en";
constexpr const char* kMarked = "marked";
constexpr int kDepth = 3;                // translations within translations: the words that {*} stands for
constexpr std::size_t kMostKept = 4096;  // answers

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isBlank(char c) { return c == ' ' || c == '\t'; }
bool isLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) || static_cast<unsigned char>(c) >= 0x80; }
bool isControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }
bool hasLetter(std::string_view text) { return std::any_of(text.begin(), text.end(), isLetter); }

// Without what is written longer than it has to be, surrogates, and what is above U+10FFFF.
bool isUtf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at]);
    const std::size_t more = first < 0x80 ? 0 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3;
    const bool is_first = first < 0x80 || (first >= 0xC2 && first <= 0xF4);
    if (!is_first || at + more >= text.size()) return false;

    std::uint32_t code = more == 0 ? first : first & (0x3Fu >> more);
    for (std::size_t k = 1; k <= more; ++k) {
      const auto next = static_cast<unsigned char>(text[at + k]);
      if ((next & 0xC0) != 0x80) return false;
      code = code << 6 | (next & 0x3Fu);
    }
    const bool is_too_long = (more == 2 && code < 0x800) || (more == 3 && code < 0x10000);
    const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
    if (is_too_long || is_surrogate || code > 0x10FFFF) return false;
    at += more + 1;
  }
  return true;
}

// How long a number is that begins there; 0: none does. The digits of "mm3" and "F8" belong to a word.
std::size_t numberAt(std::string_view text, std::size_t at) {
  const char before = at == 0 ? ' ' : text[at - 1];
  if (isLetter(before) || isDigit(before)) return 0;
  std::size_t end = at;
  const bool has_sign = end < text.size() && (text[end] == '-' || text[end] == '+');
  if (has_sign && before == ' ') ++end;
  const std::size_t first = end;
  while (end < text.size() &&
         (isDigit(text[end]) || (text[end] == '.' && end > first && end + 1 < text.size() && isDigit(text[end + 1]))))
    ++end;
  return end > first ? end - at : 0;
}

std::string withoutNumbers(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = numberAt(text, at);
    out += length ? "{}" : std::string(1, text[at]);
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

// "%.1f" and "%%", in their order. A percent sign before a blank is one that is read.
std::vector<std::string> conversionsOf(std::string_view format) {
  std::vector<std::string> out;
  for (std::size_t at = format.find('%'); at != format.npos; at = format.find('%', at)) {
    std::size_t end = at + 1;
    while (end < format.size() && std::string_view("+-#.*0123456789hlLzjt").find(format[end]) != std::string_view::npos)
      ++end;
    if (end < format.size() && (format[end] == '%' || std::isalpha(static_cast<unsigned char>(format[end])))) ++end;
    out.emplace_back(format.substr(at, end - at));
    at = end;
  }
  return out;
}

bool isFormat(std::string_view text) {
  const auto all = conversionsOf(text);
  return std::any_of(all.begin(), all.end(), [](const std::string& one) {
    return one.size() > 1 && (one.back() == '%' || std::isalpha(static_cast<unsigned char>(one.back())));
  });
}

// ---- Placeholders

tl::unexpected<Error> wrongLanguage(std::string found, std::string expected) {
  return fail({.code = Error::Code::kBadValue, .found = std::move(found), .expected = std::move(expected)});
}

void addLiteral(TextPattern& pattern, char c) {
  if (pattern.pieces.empty() || pattern.pieces.back().kind != Kind::kLiteral) pattern.pieces.push_back({});
  pattern.pieces.back().literal += c;
  ++pattern.letters;
}

/// @param numbered  set: {1} is allowed, and its kind is that of the English placeholder.
Expected<TextPattern> patternOf(const std::string& text, const std::vector<Kind>* numbered) {
  constexpr const char* kExpected = "{}, {*}, {name}, or in a translation {1}";
  TextPattern out;
  std::size_t count = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '}') return wrongLanguage("a } alone", kExpected);
    if (text[at] != '{') {
      addLiteral(out, text[at]);
      continue;
    }
    const std::size_t end = text.find('}', at);
    const std::string inside = end == text.npos ? "?" : text.substr(at + 1, end - at - 1);
    const Kind kind = inside == "*" ? Kind::kAny : inside == "name" ? Kind::kName : Kind::kNumber;
    TextPattern::Piece piece{.kind = kind, .number = count};
    const bool is_numbered = inside.size() == 1 && inside[0] >= '1' && inside[0] <= '9';
    if (is_numbered && numbered && static_cast<std::size_t>(inside[0] - '1') < numbered->size()) {
      piece.number = static_cast<std::size_t>(inside[0] - '1');
      piece.kind = (*numbered)[piece.number];
    } else if (!inside.empty() && kind == Kind::kNumber) {
      return wrongLanguage("{" + (end == text.npos ? "" : inside + "}"), kExpected);
    }
    const bool is_beside = !out.pieces.empty() && out.pieces.back().kind != Kind::kLiteral;
    if (!numbered && is_beside)
      return wrongLanguage("two placeholders with nothing between them", "words between them");
    out.pieces.push_back(std::move(piece));
    ++count;
    at = end;
  }
  out.placeholders = count;
  return out;
}

std::vector<Kind> kindsOf(const TextPattern& pattern) {
  std::vector<Kind> out;
  for (const auto& piece : pattern.pieces)
    if (piece.kind != Kind::kLiteral) out.push_back(piece.kind);
  return out;
}

// Each placeholder of the English text once, and of its kind.
bool hasAll(const TextPattern& translated, const std::vector<Kind>& kinds) {
  std::vector<bool> is_there(kinds.size(), false);
  for (const auto& piece : translated.pieces) {
    if (piece.kind == Kind::kLiteral) continue;
    if (piece.number >= kinds.size() || is_there[piece.number] || piece.kind != kinds[piece.number]) return false;
    is_there[piece.number] = true;
  }
  return std::all_of(is_there.begin(), is_there.end(), [](bool there) { return there; });
}

struct Match {
  std::size_t begin = 0, end = 0;
};

// Compares a text with a pattern; {*} and {name} are as short as the rest lets them be. The last of them is made longer
// when the rest does not fit, so it takes no more than characters times pieces.
bool matches(std::string_view text, const TextPattern& pattern, std::vector<Match>& found) {
  const auto& pieces = pattern.pieces;
  found.assign(pattern.placeholders, {});
  std::size_t at = 0, n = 0;
  std::optional<std::size_t> star;  // piece of the last {*} or {name}
  const auto step = [&]() -> bool {
    if (n == pieces.size()) return at == text.size();
    const auto& piece = pieces[n];
    if (piece.kind == Kind::kLiteral) {
      if (text.substr(at, piece.literal.size()) != piece.literal) return false;
      at += piece.literal.size();
    } else if (piece.kind == Kind::kNumber) {
      const std::size_t length = numberAt(text, at);
      if (length == 0) return false;
      found[piece.number] = {at, at + length};
      at += length;
    } else {
      if (at == text.size() || text[at] == '\n') return false;
      star = n;
      found[piece.number] = {at, at + 1};
      ++at;
    }
    ++n;
    return true;
  };
  while (true) {
    const bool is_end = n == pieces.size() && at == text.size();
    if (is_end) return true;
    if (step()) continue;
    if (!star) return false;
    Match& longer = found[pieces[*star].number];
    if (longer.end >= text.size() || text[longer.end] == '\n') return false;
    at = ++longer.end;
    n = *star + 1;
  }
}

// Whether a file can have a row for it. A letter alone is a key, the same in every language.
bool canHaveRow(std::string_view english) {
  const bool has_marks =
      english.find_first_of(std::string_view("{}\0", 3)) != english.npos || english.find("##") != english.npos;
  return english.size() > 1 && english.size() <= Language::kLongestText && !has_marks && isUtf8(english);
}

// ---- What is shown

// Of one window, as the style is.
std::shared_ptr<const Language>& shownNow() {
  static std::shared_ptr<const Language> language;
  return language;
}

std::string quotedText(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += std::string("\\") + c;
    else if (isControl(c))
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + "\"";
}

}  // namespace

// ---- A language

Expected<void> Language::add(const std::string& english, const std::string& translated) {
  if (english.size() > kLongestText || translated.size() > kLongestText)
    return wrongLanguage("a text of more than 2000 bytes", "a shorter one");
  for (const std::string* text : {&english, &translated}) {
    if (text->find("##") != text->npos) return wrongLanguage("##", "the words that are shown, without an id");
    if (text->find('\0') != text->npos) return wrongLanguage("a character 0", "words");
  }
  if (isFormat(english) && conversionsOf(english) != conversionsOf(translated))
    return wrongLanguage("other conversions than in the English text",
                         fmt::format("{}", fmt::join(conversionsOf(english), " ")));

  KERF_TRY(from, patternOf(english, nullptr));
  const std::vector<Kind> kinds = kindsOf(from);
  KERF_TRY(to, patternOf(translated, &kinds));
  if (!hasAll(to, kinds))
    return wrongLanguage("not the placeholders of the English text",
                         "each of them once, numbered as {1} in another order");
  if (kinds.empty()) {
    exact_.emplace(english, translated);
    return {};
  }
  if (from.letters == 0) return wrongLanguage("a text of placeholders alone", "words beside them");
  patterns_.push_back({std::move(from), std::move(to)});
  return {};
}

Expected<Language> Language::read(const fs::path& file) {
  std::error_code failed;
  if (!fs::is_regular_file(file, failed))
    return fail({.code = Error::Code::kNotFound,
                 .file = file.string(),
                 .found = "no such file",
                 .expected = "texts of a language"});
  if (fs::file_size(file, failed) > kMostBytes || failed)
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .found = "more than 1 MiB",
                 .expected = "texts of a language"});

  KERF_TRY(root, parseToml(file));
  TomlTable table(root, file, "");
  const std::string format = table.get<std::string>("format", "\"kerf-language\"");
  if (!table.failed() && format != kFormat) table.reject("format", "\"" + format + "\"", "\"kerf-language\"");
  (void)table.number("version", 1, 1, "");
  Language out;
  out.name_ = table.get<std::string>("name", "the language's name, as those who speak it call it");
  if (!table.failed() && (out.name_.empty() || out.name_.size() > 60 || out.name_.find("##") != out.name_.npos))
    table.reject("name", "\"" + out.name_ + "\"", "a name of at most 60 bytes, without ##");
  if (!table.failed() && std::any_of(out.name_.begin(), out.name_.end(), isControl))
    table.reject("name", "a control character", "a name that can be read");
  table.allow("texts");
  KERF_CHECK(table.finish());

  const toml::table* const texts = root["texts"].as_table();
  const auto wrongAt = [&](const toml::node& node, const std::string& text, Error error) {
    error.file = file.string();
    error.place = fmt::format("line {}, \"{}\"", node.source().begin.line, text);
    return fail(std::move(error));
  };
  if (!texts)
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .found = "no table [texts]",
                 .expected = "[texts], and rows \"English\" = \"translated\" under it"});
  if (texts->size() > kMostTexts)
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .found = fmt::format("{} texts", texts->size()),
                 .expected = fmt::format("at most {}", kMostTexts)});
  for (const auto& [key, node] : *texts) {
    const std::string english(key.str());
    const auto translated = node.value<std::string>();
    if (!node.is_string() || !translated)
      return wrongAt(node, english,
                     {.code = Error::Code::kBadFormat,
                      .found = "a value of another type",
                      .expected = "a text in quotes; \"\" if it is not translated yet"});
    if (translated->empty()) continue;
    if (auto added = out.add(english, *translated); !added) return wrongAt(node, english, std::move(added).error());
  }

  // The most telling first; of equal ones by their text, whatever order the file has.
  std::stable_sort(out.patterns_.begin(), out.patterns_.end(),
                   [](const Row& a, const Row& b) { return a.english.letters > b.english.letters; });
  return out;
}

Language Language::marking() {
  Language out;
  out.name_ = "«»";
  out.is_marking_ = true;
  return out;
}

bool Language::find(std::string_view english, int depth, std::string& out) const {
  if (const auto row = exact_.find(english); row != exact_.end()) {
    out = row->second;
    return true;
  }
  if (depth == 0 || english.size() > kLongestText) return false;
  std::vector<Match> found;
  for (const Row& row : patterns_) {
    if (!matches(english, row.english, found)) continue;
    out.clear();
    for (const auto& piece : row.translated.pieces) {
      if (piece.kind == Kind::kLiteral) {
        out += piece.literal;
        continue;
      }
      const Match& match = found[piece.number];
      const std::string_view words = english.substr(match.begin, match.end - match.begin);
      std::string inside(words);
      if (piece.kind == Kind::kAny && !find(words, depth - 1, inside)) inside = words;
      out += inside;
    }
    return true;
  }
  return false;
}

std::string Language::shown(std::string_view english) const {
  if (!hasLetter(english)) return std::string(english);
  if (is_marking_) return "«" + std::string(english) + "»";
  if (const auto known = asked_.find(english); known != asked_.end()) return known->second;

  // Blanks at the ends are of the layout.
  std::size_t begin = 0, end = english.size();
  while (begin < end && isBlank(english[begin])) ++begin;
  while (end > begin && isBlank(english[end - 1])) --end;
  const std::string_view words = english.substr(begin, end - begin);

  std::string out;
  if (find(words, kDepth, out)) {
    out = std::string(english.substr(0, begin)) + out + std::string(english.substr(end));
  } else if (const std::size_t line = english.find('\n'); line != english.npos) {
    for (std::size_t from = 0; from <= english.size();) {
      const std::size_t to = std::min(english.find('\n', from), english.size());
      out += shown(english.substr(from, to - from));
      if (to < english.size()) out += '\n';
      from = to + 1;
    }
  } else {
    out = english;
    if (missing_.size() < kMostTexts && canHaveRow(words)) missing_.insert(withoutNumbers(words));
  }

  if (asked_.size() >= kMostKept) asked_.clear();
  asked_.emplace(english, out);
  return out;
}

// ---- What the window shows

void setShownLanguage(std::shared_ptr<const Language> language) { shownNow() = std::move(language); }
const Language* shownLanguage() { return shownNow().get(); }

std::string shownText(std::string_view english) {
  const Language* const language = shownNow().get();
  return language ? language->shown(english) : std::string(english);
}

std::string shownLabel(std::string_view label) {
  const std::size_t id = label.find("##");
  if (id == 0) return std::string(label);
  const std::string words = shownText(label.substr(0, id));
  if (id == label.npos) return words + "###" + std::string(label);
  const bool is_whole_id = label.substr(id).starts_with("###");
  return words + (is_whole_id ? std::string(label.substr(id)) : "###" + std::string(label));
}

std::string shownFormat(std::string_view format) {
  std::string out = shownText(format);
  return conversionsOf(out) == conversionsOf(format) ? out : std::string(format);
}

// ---- Files

std::vector<LanguageFile> findLanguages(const fs::path& config_folder) {
  std::vector<fs::path> folders{config_folder / "languages"};
  for (fs::path& folder : findAssets("languages")) folders.push_back(std::move(folder));

  std::vector<LanguageFile> out;
  for (const fs::path& folder : folders) {
    std::error_code failed;
    for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
      const std::string id = at->path().stem().string();
      const auto is_same = [&](const LanguageFile& one) { return one.id == id; };
      if (at->path().extension() != ".toml" || std::any_of(out.begin(), out.end(), is_same)) continue;
      out.push_back({id, at->path()});
    }
  }
  std::sort(out.begin(), out.end(), [](const LanguageFile& a, const LanguageFile& b) { return a.id < b.id; });
  return out;
}

Expected<void> showLanguage(const std::string& id, const fs::path& config_folder) {
  if (id == kEnglish || id == kMarked) {
    setShownLanguage(id == kEnglish ? nullptr : std::make_shared<const Language>(Language::marking()));
    return {};
  }
  std::string known = kEnglish;
  for (const LanguageFile& one : findLanguages(config_folder)) {
    known += ", " + one.id;
    if (one.id != id) continue;
    KERF_TRY(language, Language::read(one.file));
    setShownLanguage(std::make_shared<const Language>(std::move(language)));
    return {};
  }
  return fail({.code = Error::Code::kNotFound,
               .found = "no language \"" + id + "\"",
               .expected = "one of " + known,
               .hint = "put " + id + ".toml into " + (config_folder / "languages").string()});
}

Expected<std::size_t> writeMissingTexts(const fs::path& file) {
  const Language* const language = shownLanguage();
  if (!language)
    return fail({.code = Error::Code::kUnsupported,
                 .found = "the window is in English",
                 .expected = "another language; its file may hold no text as yet",
                 .hint = "settings.language"});
  std::error_code ignored;
  if (fs::exists(file, ignored))
    return fail({.code = Error::Code::kWriteFailed,
                 .file = file.string(),
                 .found = "there already",
                 .expected = "a new file: a translation is not written over"});

  KERF_TRY(out, AtomicFile::create(file));
  out.stream() << "format = \"" << kFormat << "\"\nversion = 1\nname = " << quotedText(language->name())
               << "\n\n# {}: a number, {*}: any words, {name}: a name. \"\": not translated yet.\n[texts]\n";
  for (const std::string& text : language->missing()) out.stream() << quotedText(text) << " = \"\"\n";
  KERF_CHECK(out.commit());
  return language->missing().size();
}

}  // namespace kerf
