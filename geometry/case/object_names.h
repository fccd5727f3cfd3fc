// Names of the objects in the source files of a case ("tooth 36"), for its pieces and exports.
//
// Kerf reads the names from the sources, which a case keeps byte for byte, so a case of any age has them. An uncut,
// unmoved vertex keeps its bits: its place in the source gives its object.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/named_part.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// A mesh and its objects, as writeMesh() takes them.
struct NamedMesh {
  Mesh mesh{};
  std::vector<NamedPart> objects{};  ///< empty: none has a name
};

class ObjectNames {
 public:
  ObjectNames() = default;
  /// Names from the OBJ and 3MF files among the sources. A changed or unreadable file has no names; this is no error.
  /// @cost  reads these files.
  static ObjectNames ofCase(const std::filesystem::path& folder, const CaseManifest& manifest);
  /// Names from one mesh, mm.
  static ObjectNames ofMesh(const Mesh& mesh, std::span<const NamedPart> objects);

  bool isEmpty() const { return names_.size() < 2; }
  /// Name of the object with most triangles, by their corners; empty: an object without a name, or no object.
  std::string nameOf(const Mesh& mesh) const;
  /// The mesh with each solid under the name of nameOf(). Solids of several names stand one name after the other, those
  /// without a name first, and otherwise in their order. A mesh of one name keeps its order.
  /// @pre closed.   @cost  as solidsOf().
  NamedMesh grouped(const Mesh& mesh) const;
  /// The same for a file; unchanged if the format holds no names.   @param file  its extension is the format.
  NamedMesh grouped(const Mesh& mesh, const std::filesystem::path& file) const;

 private:
  using Place = std::array<float, 3>;
  struct Vertex {
    Place place;
    std::uint32_t name;
    auto operator<=>(const Vertex&) const = default;
  };
  void add(const Mesh& mesh, double scale_to_mm, std::span<const NamedPart> objects);
  void finish(bool is_all);
  std::uint32_t numberOf(const std::string& name);
  std::uint32_t nameAt(const Vec3d& p) const;

  std::vector<std::string> names_{""};
  std::vector<Vertex> vertices_;   // sorted; without places shared by two objects
  std::uint32_t name_of_all_ = 0;  // the common name of all objects; 0: several names, or objects without a name
  bool has_unnamed_ = false;
};

}  // namespace kerf
