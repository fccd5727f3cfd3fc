// Converts textures of mesh files (JPEG, PNG) to colours of vertices.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/formats/mesh_source.h"

namespace kerf::internal {

/// Reads a file that a mesh file names, below the folder of the mesh: by its path or, if unreadable, by the last part.
/// Of an absolute path only the last part counts, since it comes from another machine.
Expected<MeshSource> loadBeside(const MeshSource& mesh, std::string_view name, std::size_t limit);

/// Averages the colours of a vertex's corners: a textured mesh has one for each chart that meets there.
class TexturePainter {
 public:
  explicit TexturePainter(const MeshSource& mesh) : mesh_(mesh) {}
  ~TexturePainter();
  TexturePainter(const TexturePainter&) = delete;
  TexturePainter& operator=(const TexturePainter&) = delete;

  /// Reads a picture at its first use. Null, with a reason for finish(), if it cannot be used: missing, damaged,
  /// neither JPEG nor PNG, more than 64 million pixels together with those before it.
  struct Picture;
  const Picture* picture(const std::string& name);
  void paint(std::uint32_t vertex, const Rgba8& color);
  /// (0, 0) is the lower left corner of the picture; beyond 0 to 1 it repeats.
  void paint(std::uint32_t vertex, const Picture& picture, double u, double v);
  /// Sets the colours of the vertices, if any was painted, and notes unreadable textures.
  void finish(MeshFile& file);

 private:
  Expected<std::unique_ptr<Picture>> load(const std::string& name);

  const MeshSource& mesh_;
  std::size_t pixels_left_ = std::size_t{1} << 26;
  std::map<std::string, std::unique_ptr<Picture>> pictures_;
  std::vector<std::string> missing_;
  std::vector<std::array<double, 4>> sums_;  // red, green, blue, number of corners
};

}  // namespace kerf::internal
