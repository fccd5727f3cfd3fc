// Strict reading of Kerf's TOML files: the reader requests every known key, and any other key is an error.
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

/// One table. Failed look-ups do not throw: finish() returns the first error.
class TomlTable {
 public:
  TomlTable(const toml::table& table, std::filesystem::path file, std::string name)
      : table_(table), file_(std::move(file)), name_(std::move(name)) {}

  template <class T>
  T get(const std::string& key, const char* expected) {
    used_.insert(key);
    const toml::node* node = table_.get(key);
    if (!node) {
      missing(key, expected);
      return T{};
    }
    // Integers must be integers in the file: toml++ casts a float such as 1e308, which is undefined behaviour.
    const bool is_wrong = std::is_integral_v<T> && !std::is_same_v<T, bool> && !node->is_integer();
    if (const auto value = is_wrong ? std::optional<T>{} : node->value<T>()) return *value;
    keep({.code = Error::Code::kBadFormat,
          .file = file_.string(),
          .place = place(key, node),
          .found = "a value of another type",
          .expected = expected});
    return T{};
  }
  /// The same for a key that may be left out.
  template <class T>
  T getOr(const std::string& key, T fallback, const char* expected) {
    return table_.contains(key) ? get<T>(key, expected) : (allow(key), fallback);
  }
  /// A number in [low, high], in `unit`. Integers count, NaN does not.
  double number(const std::string& key, double low, double high, const char* unit = "mm");
  double numberOr(const std::string& key, double fallback, double low, double high, const char* unit = "mm") {
    return table_.contains(key) ? number(key, low, high, unit) : (allow(key), fallback);
  }
  bool has(const std::string& key) const { return table_.contains(key); }
  const toml::node* node(const std::string& key) const { return table_.get(key); }
  void allow(const std::string& key) { used_.insert(key); }  ///< read elsewhere
  /// Keeps an error about a key's value, unless there is one already.
  void reject(const std::string& key, std::string found, std::string expected, std::string hint = "");
  bool failed() const { return error_.has_value(); }
  /// Hint for this unknown key, such as a common synonym of a known key. Default: the nearest known key.
  void explain(const std::string& unknown_key, std::string hint) { hints_[unknown_key] = std::move(hint); }
  std::vector<std::string> strings(const std::string& key);
  const toml::array* tables(const std::string& key);
  std::vector<double> numbers(const std::string& key, std::size_t count);
  /// A list of at least one point, each three finite numbers: [[0, 0, 5], [10, 0, 5]].
  std::vector<Vec3d> points(const std::string& key);

  /// The first error, or one for the first unknown key (with the nearest known key). An unknown key precedes a missing
  /// one: most often it is the missing key, misspelt.
  Expected<void> finish();

 private:
  std::string place(const std::string& key, const toml::node* node) const;
  void missing(const std::string& key, const std::string& expected);
  void keep(Error e) {
    if (!error_) error_ = std::move(e);
  }
  const toml::table& table_;
  std::filesystem::path file_;
  std::string name_;
  std::set<std::string> used_;
  std::map<std::string, std::string> hints_;
  std::optional<Error> error_;
  bool is_missing_ = false;  // error_ is about a missing key
};

/// The name with the smallest edit distance to `found`; empty if none resembles it.
std::string nearestName(const std::string& found, const std::vector<std::string>& names);
/// The same, up to `most` names, the nearest first.
std::vector<std::string> nearestNames(const std::string& found, std::vector<std::string> names, std::size_t most);

/// Parses a file; syntax errors name line and column.
Expected<toml::table> parseToml(const std::filesystem::path& file);
/// The same for its text.   @param file  for errors.
Expected<toml::table> parseTomlText(const std::string& content, const std::filesystem::path& file);

}  // namespace kerf
