// One model part of a 3MF package: XML to objects, components and build items, as in the file.
// After the 3MF core specification 1.4, the materials extension (colour groups) and the production extension (paths).
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/formats/mesh_source.h"

namespace kerf::internal {

/// Place of an object in a component or a build item: p -> linear * p + translation.
struct ThreeMfPlacement {
  std::string path;        ///< other part with the object; empty: the same part
  std::uint32_t id = 0;    ///< id of the object
  std::size_t object = 0;  ///< its index, if in the same part
  bool is_identity = true;
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Vec3d translation = Vec3d::Zero();
};

struct ThreeMfObject {
  std::uint32_t id = 0;
  std::string name{};       ///< from objectName(); empty: none
  bool is_support = false;  ///< type "support" or "solidsupport"
  std::vector<Vec3d> vertices;
  std::vector<Triangle> triangles;
  std::vector<std::array<Rgba8, 3>> corner_colors;  ///< empty, or per triangle and corner
  std::vector<ThreeMfPlacement> components;         ///< placements of earlier objects, or of objects in other parts
};

struct ThreeMfModel {
  std::string unit = "millimeter";
  bool had_double_coordinates = false;
  std::vector<ThreeMfObject> objects;  ///< in the file's order
  std::vector<ThreeMfPlacement> items;
  std::set<std::string> skipped;  ///< known but unsupported elements ("texture2dgroup")

  /// Index of an object, or objects.size().
  std::size_t find(std::uint32_t id) const;
};

/// Parses a part in pieces. Errors with part and line: missing attributes, numbers that are not finite, indices out of
/// range, objects used before their definition, a DTD (3MF forbids it) and required extensions that Kerf lacks. Skips
/// unknown elements.
class ThreeMfModelParser {
 public:
  /// @param part  name for messages.    @param is_root  if true, build items and paths to other parts count.
  ThreeMfModelParser(const MeshSource& source, std::string_view part, bool is_root);
  ~ThreeMfModelParser();
  ThreeMfModelParser(const ThreeMfModelParser&) = delete;
  ThreeMfModelParser& operator=(const ThreeMfModelParser&) = delete;

  Expected<void> feed(std::string_view piece);
  Expected<ThreeMfModel> finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The root part of a package, from its `_rels/.rels`.
class ThreeMfRelationsParser {
 public:
  explicit ThreeMfRelationsParser(const MeshSource& source);
  ~ThreeMfRelationsParser();
  ThreeMfRelationsParser(const ThreeMfRelationsParser&) = delete;
  ThreeMfRelationsParser& operator=(const ThreeMfRelationsParser&) = delete;

  Expected<void> feed(std::string_view piece);
  Expected<std::string> finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf::internal
