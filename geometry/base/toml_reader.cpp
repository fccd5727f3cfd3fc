#include "geometry/base/toml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

#include "geometry/base/text.h"

namespace kerf {
namespace {

// Letters to insert, delete, exchange or swap with their neighbour to get from a to b (Damerau 1964; Levenshtein 1965).
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before, last, row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

// The commonest slip of all: 1,6 for 1.6.
std::string decimalComma(const std::string& content, const toml::source_position& at) {
  std::istringstream lines(content);
  std::string line;
  for (toml::source_index n = 0; n < at.line; ++n) std::getline(lines, line);

  const auto isDigit = [&](std::size_t n) { return n < line.size() && line[n] >= '0' && line[n] <= '9'; };
  const std::size_t comma = line.find(',', at.column > 1 ? at.column - 2 : 0);
  if (comma == line.npos || comma == 0 || comma + 1 < at.column || !isDigit(comma - 1) || !isDigit(comma + 1))
    return "";
  return fmt::format("a decimal point: {}.{}", line[comma - 1], line[comma + 1]);
}

}  // namespace

std::vector<std::string> nearestNames(const std::string& found, std::vector<std::string> names, std::size_t most) {
  std::vector<std::pair<std::size_t, std::string>> near;
  for (std::string& name : names)
    if (const std::size_t d = editDistance(found, name); d <= found.size() / 2)  // farther is no resemblance
      near.emplace_back(d, std::move(name));

  std::sort(near.begin(), near.end());
  std::vector<std::string> out;
  for (auto& [distance, name] : near)
    if (out.size() < most && (out.empty() || out.back() != name)) out.push_back(std::move(name));
  return out;
}

std::string nearestName(const std::string& found, const std::vector<std::string>& names) {
  const std::vector<std::string> near = nearestNames(found, names, 1);
  return near.empty() ? "" : near[0];
}

void TomlTable::missing(const std::string& key, const std::string& expected) {
  if (error_) return;
  keep({.code = Error::Code::kBadFormat,
        .file = file_.string(),
        .place = place(key, &table_),
        .found = "missing",
        .expected = expected});
  is_missing_ = true;
}

void TomlTable::reject(const std::string& key, std::string found, std::string expected, std::string hint) {
  const toml::node* node = table_.get(key);
  keep({.code = Error::Code::kBadValue,
        .file = file_.string(),
        .place = place(key, node ? node : &table_),
        .found = std::move(found),
        .expected = std::move(expected),
        .hint = std::move(hint)});
}

double TomlTable::number(const std::string& key, double low, double high, const char* unit) {
  used_.insert(key);
  const std::string expected = fmt::format("a number from {} to {} {}", low, high, unit);
  const toml::node* node = table_.get(key);
  if (!node) {
    missing(key, expected);
    return low;
  }

  const auto value = node->is_number() ? node->value<double>() : std::nullopt;
  if (!value) {
    std::string hint;
    if (const auto text = node->value<std::string>())  // "1.6 mm"
      if (const std::size_t digits = text->find_first_not_of("+-0123456789."); digits > 0 && !text->empty())
        hint = fmt::format("{} = {}, without quotes or unit", key, text->substr(0, digits));
    keep({.code = Error::Code::kBadFormat,
          .file = file_.string(),
          .place = place(key, node),
          .found = "a value of another type",
          .expected = expected,
          .hint = hint});
    return low;
  }

  if (!(*value >= low && *value <= high)) {
    reject(key, fmt::format("{}", *value), expected);
    return low;
  }
  return *value;
}

std::string TomlTable::place(const std::string& key, const toml::node* node) const {
  const std::string full = name_.empty() ? key : name_ + "." + key;
  return node && node->source().begin.line > 0 ? fmt::format("line {}, key {}", node->source().begin.line, full)
                                               : "key " + full;
}

std::vector<std::string> TomlTable::strings(const std::string& key) {
  used_.insert(key);
  std::vector<std::string> out;
  const toml::node* node = table_.get(key);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (!array) {
    keep({.code = Error::Code::kBadFormat,
          .file = file_.string(),
          .place = place(key, node ? node : &table_),
          .found = "missing",
          .expected = "a list of strings"});
    return out;
  }
  for (const toml::node& item : *array) {
    if (const auto text = item.value<std::string>())
      out.push_back(*text);
    else
      keep({.code = Error::Code::kBadFormat,
            .file = file_.string(),
            .place = place(key, &item),
            .found = "not a string",
            .expected = "a list of strings"});
  }
  return out;
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t count) {
  used_.insert(key);
  std::vector<double> out;
  const toml::node* node = table_.get(key);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (array)
    for (const toml::node& item : *array)
      if (const auto value = item.is_number() ? item.value<double>() : std::nullopt; value && std::isfinite(*value))
        out.push_back(*value);
  if (!array || out.size() != count || array->size() != count) {
    keep({.code = Error::Code::kBadFormat,
          .file = file_.string(),
          .place = place(key, node ? node : &table_),
          .found = node ? "of another form" : "missing",
          .expected = fmt::format("a list of {} finite numbers", count)});
    out.assign(count, 0);
  }
  return out;
}

std::vector<Vec3d> TomlTable::points(const std::string& key) {
  used_.insert(key);
  std::vector<Vec3d> out;
  const toml::node* node = table_.get(key);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (array)
    for (const toml::node& item : *array) {
      const toml::array* point = item.as_array();
      if (!point || point->size() != 3) break;
      Vec3d p;
      for (std::size_t k = 0; k < 3; ++k) {
        const toml::node& number = (*point)[k];
        const auto value = number.is_number() ? number.value<double>() : std::nullopt;
        p[static_cast<Eigen::Index>(k)] = value.value_or(std::numeric_limits<double>::quiet_NaN());
      }
      if (!p.allFinite()) break;
      out.push_back(p);
    }
  if (!array || out.empty() || out.size() != array->size()) {
    keep({.code = Error::Code::kBadFormat,
          .file = file_.string(),
          .place = place(key, node ? node : &table_),
          .found = node ? "of another form" : "missing",
          .expected = "a list of points, as [[0, 0, 5], [10, 0, 5]]"});
    out.assign(1, Vec3d::Zero());
  }
  return out;
}

const toml::array* TomlTable::tables(const std::string& key) {
  used_.insert(key);
  const toml::node* node = table_.get(key);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (!node)
    missing(key, "one or more [[" + key + "]]");
  else if (!array || !array->is_array_of_tables())
    keep({.code = Error::Code::kBadFormat,
          .file = file_.string(),
          .place = place(key, node),
          .found = "of another form",
          .expected = "one or more [[" + key + "]]"});
  return array;
}

Expected<void> TomlTable::finish() {
  if (!error_ || is_missing_)
    for (const auto& [key, node] : table_) {
      const std::string found(key.str());
      if (used_.contains(found)) continue;
      std::string known;
      for (const std::string& name : used_) known += (known.empty() ? "" : ", ") + name;
      const auto hint = hints_.find(found);
      error_ = Error{Error::Code::kBadFormat,
                     file_.string(),
                     place(found, &node),
                     "unknown key",
                     "one of " + known,
                     hint != hints_.end() ? hint->second : nearestName(found, {used_.begin(), used_.end()})};
      break;
    }
  if (error_) return fail(*error_);
  return {};
}

Expected<toml::table> parseToml(const std::filesystem::path& file) {
  constexpr std::size_t kMostBytes = 16 << 20;  // 400 000 poses
  auto content_or_error = readSmallFile(file, kMostBytes);
  if (!content_or_error) {
    Error error = std::move(content_or_error).error();
    const bool is_large = error.code == Error::Code::kBadFormat;
    error.expected = is_large ? "a TOML file of a few kB" : "a TOML file";
    if (is_large) error.found = fmt::format("more than {} MB", kMostBytes >> 20);
    if (is_large) error.hint = "a path of many poses is read from .csv";
    return fail(std::move(error));
  }
  return parseTomlText(*content_or_error, file);
}

Expected<toml::table> parseTomlText(const std::string& content, const std::filesystem::path& file) {
  // toml++ limits how deep values nest, but not how long a dotted key is, and it walks the tables of one recursively.
  constexpr int kMostDots = 500;
  std::istringstream lines(content);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    // Keys stand before the first '=' or in inline tables; a line of numbers in a list has neither.
    const std::size_t equals = line.find('=');
    const bool is_list = equals == std::string::npos && line.find(',') != std::string::npos;
    const bool has_tables = line.find('{') != std::string::npos;
    if (is_list && !has_tables) continue;
    const auto end =
        has_tables || equals == std::string::npos ? line.end() : line.begin() + static_cast<std::ptrdiff_t>(equals);
    if (std::count(line.begin(), end, '.') > kMostDots)
      return fail({.code = Error::Code::kBadFormat,
                   .file = file.string(),
                   .place = fmt::format("line {}", number),
                   .found = fmt::format("more than {} dots in a key", kMostDots),
                   .expected = "keys of a few words"});
  }
  try {
    return toml::parse(content, file.string());
  } catch (const toml::parse_error& e) {
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .place = fmt::format("line {}, column {}", e.source().begin.line, e.source().begin.column),
                 .found = std::string(e.description()),
                 .expected = "TOML",
                 .hint = decimalComma(content, e.source().begin)});
  }
}

}  // namespace kerf
