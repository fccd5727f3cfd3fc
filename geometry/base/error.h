// Kerf's only error type: failure, place, found and expected value, remedy.
#pragma once

#include <string>
#include <tl/expected.hpp>

namespace kerf {

/// A failure a user can act on. Every field but `code` and `found` may be empty.
struct Error {
  enum class Code {
    kNotFound,
    kUnreadable,
    kBadFormat,
    kBadValue,
    kUnsupported,
    kEmpty,
    kGeometry,
    kWriteFailed,
    kCancelled
  };
  Code code = Code::kBadValue;
  // The empty initialisers let a caller name only the fields it fills, without a warning about the rest.
  std::string file{};      ///< path as the user gave it
  std::string place{};     ///< "line 12", "byte 84", "key tool.head_diameter", "triangle 17"
  std::string found{};     ///< found value or state
  std::string expected{};  ///< expected value or state
  std::string hint{};      ///< remedy

  /// One line: "FILE: PLACE: FOUND; expected EXPECTED. Try: HINT."
  std::string message() const;
};

template <class T>
using Expected = tl::expected<T, Error>;

/// `return fail({.code = Error::Code::kBadFormat, .file = path, .found = "an empty file"});`
inline tl::unexpected<Error> fail(Error e) { return tl::unexpected<Error>(std::move(e)); }

}  // namespace kerf

/// Returns the error of an Expected<> from the enclosing function, or stores the value in `var`.
#define KERF_TRY(var, expression)                                              \
  auto var##_or_error = (expression);                                          \
  if (!var##_or_error) return ::kerf::fail(std::move(var##_or_error).error()); \
  auto& var = *var##_or_error
/// The same for an Expected<void>.
#define KERF_CHECK(expression)                                                                              \
  do {                                                                                                      \
    if (auto kerf_check_ = (expression); !kerf_check_) return ::kerf::fail(std::move(kerf_check_).error()); \
  } while (false)
