// Reading a mesh from a stream, such as standard input: by its content, as readMesh() of a file does.
#pragma once

#include <istream>
#include <string>

#include "geometry/formats/mesh_io.h"

namespace kerf {

/// @param name  what errors call it.   Errors: as of a file; kUnreadable for more than kLargestStream bytes.
Expected<MeshFile> readMeshStream(std::istream& in, const std::string& name);

inline constexpr std::size_t kLargestStream = std::size_t{4} << 30;

}  // namespace kerf
