// The mesh writers behind the table of formats. Each writes to a stream that the caller checks and closes.
#pragma once

#include <iosfwd>

#include "geometry/formats/mesh_writer.h"

namespace kerf::internal {

// By OpenMesh, in kerf_files.
Expected<void> writeStl(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options);
Expected<void> writeOff(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options);
// Our own.
Expected<void> writePly(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options);
Expected<void> writeObj(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options);
Expected<void> writeThreeMf(std::ostream& out, const Mesh& mesh, const MeshWriteOptions& options);

}  // namespace kerf::internal
