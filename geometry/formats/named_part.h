// Names of the objects in a mesh file: `o` and `g` of OBJ, `name` of 3MF.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

inline constexpr std::size_t kLongestObjectName = 256;  ///< bytes
inline constexpr std::size_t kMostNamedParts = 4096;    ///< of a file; with more of them no name is read

/// Triangles of a mesh that are one object of its file: from `first_triangle` to that of the next part, or to the end.
struct NamedPart {
  std::string name{};  ///< of objectName(); empty: the object has none
  std::size_t first_triangle = 0;
  bool operator==(const NamedPart&) const = default;
};

/// A name from a file as one line of UTF-8, at most kLongestObjectName bytes: control characters and bytes that are no
/// UTF-8 as \x1b, blanks at its ends removed. A name that is clean already stays as it is.
std::string objectName(std::string_view text);

namespace internal {

/// Collects the parts of a mesh while a reader appends triangles to it.
class PartList {
 public:
  /// Triangles from `first` on have this name. @pre  `first` never decreases.
  void begin(std::string_view name, std::size_t first);
  /// The parts of a mesh of `count` triangles; empty if none has a name, or if there are too many.
  std::vector<NamedPart> finish(std::size_t count);
  bool hasTooMany() const { return has_too_many_; }

 private:
  std::vector<NamedPart> parts_;
  bool has_too_many_ = false;
};

}  // namespace internal
}  // namespace kerf
