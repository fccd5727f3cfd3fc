// Proof at compile time that a table has a row for every enumerator of an enum.
#pragma once

#include <cstddef>
#include <string_view>
#include <type_traits>

namespace kerf {

/// True if a value of an enum has a name. The compiler spells an enumerator by its name and any other value as a cast,
/// "(Response)3".
template <auto kValue>
consteval bool isEnumerator() {
  return std::string_view(__PRETTY_FUNCTION__).find("= (") == std::string_view::npos;
}

/// True if row n of a table belongs to the enumerator of value n, for all n, and the enum has no further one.
///
///   inline constexpr std::array kRows = {Row{Colour::kRed, "red"}, Row{Colour::kBlue, "blue"}};
///   static_assert(hasRowForEach<kRows, &Row::colour>(), "each colour needs its row, in order");
///
/// @pre the enumerators are 0, 1, 2, ... without a gap.
template <const auto& kRows, auto kMember>
consteval bool hasRowForEach() {
  for (std::size_t n = 0; n < kRows.size(); ++n)
    if (static_cast<std::size_t>(kRows[n].*kMember) != n) return false;
  using Enum = std::remove_cvref_t<decltype(kRows[0].*kMember)>;
  return isEnumerator<static_cast<Enum>(kRows.size() - 1)>() && !isEnumerator<static_cast<Enum>(kRows.size())>();
}

}  // namespace kerf
