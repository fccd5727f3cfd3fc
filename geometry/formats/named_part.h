// Names of the objects in a mesh file: `o` and `g` of OBJ, `name` of 3MF.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

inline constexpr std::size_t kLongestObjectName = 256;  ///< bytes
inline constexpr std::size_t kMostObjectNames = 4096;   ///< per file; with more, no name is read

/// Triangles of a mesh that are one object of its file: from `first_triangle` to that of the next part, or to the end.
struct NamedPart {
  std::string name{};  ///< from objectName(); empty: no name
  std::size_t first_triangle = 0;
  bool operator==(const NamedPart&) const = default;
};

/// A name from a file as one line of UTF-8, at most kLongestObjectName bytes: white space as blanks, none at the ends;
/// other control characters and bytes that are no UTF-8 as \x1b. A clean name stays unchanged.
std::string objectName(std::string_view text);

namespace internal {

std::string noteOfTooManyNames();

/// Collects the parts of a mesh while a reader appends triangles to it.
class PartList {
 public:
  /// Triangles from `first` on have this name. @pre  `first` never decreases.
  void begin(std::string_view name, std::size_t first);
  /// The parts of a mesh with this number of triangles; empty if none has a name, or with too many names.
  std::vector<NamedPart> finish(std::size_t triangles);
  /// Number of names of the triangles, without the empty name.
  std::size_t nameCount() const { return names_.size(); }
  bool hasTooMany() const { return names_.size() > kMostObjectNames; }

 private:
  void count(const std::string& name);

  std::vector<NamedPart> parts_;
  std::set<std::string> names_;  // names of parts with triangles except the last one; after finish() of all parts
};

}  // namespace internal
}  // namespace kerf
