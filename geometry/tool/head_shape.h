// The heads of burs by name. A name only selects an outline. Cutting, collision and drawing use outlines only, so a
// form without a name is a `profile` in the file, without C++.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "geometry/outline/outline.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

/// A corner of a free outline. `arc_radius` belongs to the segment from the previous corner: 0 a line, > 0 an arc that
/// bulges out, < 0 one that hollows the head. mm.
struct ProfilePoint {
  double height = 0, diameter = 0, arc_radius = 0;
};

/// Numbers of a head in a tool file, mm and degrees. NaN: not given.
struct HeadNumbers {
  static constexpr double kUnsaid = std::numeric_limits<double>::quiet_NaN();
  double head_diameter = kUnsaid, head_length = kUnsaid;
  double tip_diameter = kUnsaid, top_diameter = kUnsaid, widest_at = kUnsaid, edge_radius = kUnsaid;
  double point_length = kUnsaid, point_angle = kUnsaid, dome_height = kUnsaid;
  std::vector<ProfilePoint> profile;
  std::vector<OutlinePiece> outline;  ///< in place of profile: x is the radius, y the height
};

/// A number of HeadNumbers as a key of the file.
struct HeadKey {
  const char* name;
  double low, high;
  const char* unit;
  double HeadNumbers::*value;
  const char* meaning;
};
/// All of them, in the order in which a file states them.
std::span<const HeadKey> headKeys();

/// Error in the numbers of a head: key, expected value, remedy.
struct HeadMistake {
  std::string key, expected, hint;
};

struct HeadShape {
  struct Key {
    const char* name;
    double example;        ///< in head diameters (angles: degrees): a head that looks like one
    const char* unsaid{};  ///< meaning of a missing key; null: it is required
  };
  const char* name;
  const char* outline;    ///< for display
  std::vector<Key> keys;  ///< beside head_diameter
  bool takes_profile = false;
  /// Numbers to outline: closed, tip at height 0. Its largest width is head_diameter, except for a profile, which has
  /// its own.
  tl::expected<RevolvedProfile, HeadMistake> (*build)(const HeadNumbers&) = nullptr;
};

/// The visible list: a new shape is one function and one entry in head_shape.cpp.
std::span<const HeadShape> headShapes();
const HeadShape* findHeadShape(const std::string& name);

}  // namespace kerf
