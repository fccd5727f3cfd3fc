// Pictures of files as textures: each is read once.
#pragma once

#include <imgui.h>

#include <filesystem>
#include <map>

namespace kerf {

/// Owns textures: its OpenGL context is current in every call, the destructor included.
class PictureTextures {
 public:
  PictureTextures() = default;
  ~PictureTextures() { clear(); }
  PictureTextures(const PictureTextures&) = delete;
  PictureTextures& operator=(const PictureTextures&) = delete;

  /// The texture of a PNG file. Null: missing or damaged.
  ImTextureID of(const std::filesystem::path& picture);
  /// Reads all pictures again.
  void clear();

 private:
  std::map<std::filesystem::path, unsigned> textures_;  // 0: no picture
};

}  // namespace kerf
