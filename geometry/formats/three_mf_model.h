// One model part of a 3MF package: XML to objects, components and build items, as they stand in the file.
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

/// Where a component or a build item puts an object: p -> linear * p + translation.
struct ThreeMfPlacement {
  std::string path;        ///< other part the object is in; empty: the same part
  std::uint32_t id = 0;    ///< of the object
  std::size_t object = 0;  ///< its index, if in the same part
  bool is_identity = true;
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Vec3d translation = Vec3d::Zero();
};

struct ThreeMfObject {
  std::uint32_t id = 0;
  std::string name{};       ///< of objectName(); empty: none
  bool is_support = false;  ///< type "support" or "solidsupport"
  std::vector<Vec3d> vertices;
  std::vector<Triangle> triangles;
  std::vector<std::array<Rgba8, 3>> corner_colors;  ///< empty, or per triangle and corner
  std::vector<ThreeMfPlacement> components;         ///< of objects before this one, or in other parts
};

struct ThreeMfModel {
  std::string unit = "millimeter";
  bool had_double_coordinates = false;
  std::vector<ThreeMfObject> objects;  ///< in the file's order
  std::vector<ThreeMfPlacement> items;
  std::set<std::string> skipped;  ///< what has a meaning but was not read ("texture2dgroup")

  /// Index of an object, or objects.size().
  std::size_t find(std::uint32_t id) const;
};

/// Parses a part as it comes in. Strict about what it understands: missing attributes, numbers that are not finite,
/// indices out of range, objects used before they are defined, a DTD (3MF forbids it) and extensions the file requires
/// but we lack are errors with part and line. Elements it does not know are skipped.
class ThreeMfModelParser {
 public:
  /// @param part  name for messages.    @param is_root  whether build items and paths to other parts count.
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

/// The part a package begins with, from its `_rels/.rels`.
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
