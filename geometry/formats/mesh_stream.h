// Reading a mesh from a stream, such as standard input: by its content, as readMesh() does for a file.
#pragma once

#include <istream>
#include <string>

#include "geometry/formats/mesh_io.h"

namespace kerf {

/// @param name  in errors.   Errors: as for a file; kUnreadable for more than kLargestStream bytes.
Expected<MeshFile> readMeshStream(std::istream& in, const std::string& name);

inline constexpr std::size_t kLargestStream = std::size_t{4} << 30;

}  // namespace kerf
