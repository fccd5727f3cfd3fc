#include "ui/window/gl/picture_textures.h"

#include <epoxy/gl.h>

#include <cstdint>

#include "ui/window/gl/image.h"

namespace kerf {
namespace {

ImTextureID handleOf(unsigned texture) { return reinterpret_cast<void*>(static_cast<std::uintptr_t>(texture)); }

}  // namespace

ImTextureID PictureTextures::of(const std::filesystem::path& picture) {
  const auto [entry, is_new] = textures_.try_emplace(picture, 0);
  if (!is_new) return handleOf(entry->second);
  const auto image = readPng(picture);
  if (!image) return nullptr;

  GLint bound = 0;
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  glGenTextures(1, &entry->second);
  glBindTexture(GL_TEXTURE_2D, entry->second);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, image->width, image->height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               image->rgba.data());
  glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  return handleOf(entry->second);
}

void PictureTextures::clear() {
  for (const auto& [path, texture] : textures_)
    if (texture) glDeleteTextures(1, &texture);
  textures_.clear();
}

}  // namespace kerf
