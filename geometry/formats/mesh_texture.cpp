#include "geometry/formats/mesh_texture.h"

#include <stb/stb_image.h>

#include <algorithm>
#include <cmath>

namespace kerf::internal {
namespace {

constexpr std::size_t kLargestPicture = std::size_t{256} << 20;  // bytes of the file

}  // namespace

Expected<MeshSource> loadBeside(const MeshSource& mesh, std::string_view name, std::size_t limit) {
  const std::filesystem::path folder = std::filesystem::path(mesh.file).parent_path();
  const std::size_t slash = name.find_last_of("/\\:");
  const bool is_absolute = name.starts_with('/') || name.starts_with('\\') || name.find(':') == 1;
  if (!is_absolute) {
    Expected<MeshSource> found = loadMeshSource(folder / name, limit);
    if (found || slash == name.npos) return found;
  }
  return loadMeshSource(folder / name.substr(slash + 1), limit);
}

struct TexturePainter::Picture {
  struct Free {
    void operator()(stbi_uc* pixels) const { stbi_image_free(pixels); }
  };
  int width = 0, height = 0;
  std::unique_ptr<stbi_uc[], Free> rgb;
};

TexturePainter::~TexturePainter() = default;

Expected<std::unique_ptr<TexturePainter::Picture>> TexturePainter::load(const std::string& name) {
  KERF_TRY(file, loadBeside(mesh_, name, kLargestPicture));
  const auto wrong = [&](std::string found) { return fail({.file = name, .found = std::move(found)}); };
  // The decoders of other formats have had too many faults.
  if (!file.text().starts_with("\xff\xd8\xff") && !file.text().starts_with("\x89PNG\r\n\x1a\n"))
    return wrong("neither a JPEG nor a PNG picture");

  const auto* bytes = reinterpret_cast<const stbi_uc*>(file.bytes.get());
  const int size = static_cast<int>(file.size);
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(bytes, size, &width, &height, &channels) || width < 1 || height < 1)
    return wrong("a damaged picture");
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (pixels > pixels_left_) return wrong("more than 64 million pixels");
  // At most four channels of 16 bits: the library would unpack data beyond that too.
  constexpr std::size_t kBytesAPixel = 8, kOfHeads = 1 << 20;
  if (file.size > kBytesAPixel * pixels + kOfHeads) return wrong("more data than its pixels take");

  auto picture = std::make_unique<Picture>();
  picture->rgb.reset(stbi_load_from_memory(bytes, size, &picture->width, &picture->height, &channels, 3));
  if (!picture->rgb || picture->width != width || picture->height != height) return wrong("a damaged picture");
  pixels_left_ -= pixels;
  return picture;
}

const TexturePainter::Picture* TexturePainter::picture(const std::string& name) {
  const auto [at, is_new] = pictures_.try_emplace(name);
  if (is_new) {
    if (auto loaded = load(name))
      at->second = std::move(*loaded);
    else
      missing_.push_back(inQuotes(name) + " (" + loaded.error().found + ")");
  }
  return at->second.get();
}

void TexturePainter::paint(std::uint32_t vertex, const Rgba8& color) {
  if (sums_.size() <= vertex) sums_.resize(vertex + 1);
  for (std::size_t k = 0; k < 3; ++k) sums_[vertex][k] += color[k];
  sums_[vertex][3] += 1;
}

void TexturePainter::paint(std::uint32_t vertex, const Picture& picture, double u, double v) {
  if (!std::isfinite(u) || !std::isfinite(v)) return;
  const auto pixel = [](double x, int count) {
    if (x < 0 || x > 1) x -= std::floor(x);
    return std::min(static_cast<std::size_t>(x * count), static_cast<std::size_t>(count - 1));
  };
  const std::size_t column = pixel(u, picture.width);
  const std::size_t row = static_cast<std::size_t>(picture.height) - 1 - pixel(v, picture.height);
  const stbi_uc* rgb = &picture.rgb[3 * (row * static_cast<std::size_t>(picture.width) + column)];
  paint(vertex, {rgb[0], rgb[1], rgb[2], 255});
}

void TexturePainter::finish(MeshFile& file) {
  if (!sums_.empty()) {
    std::vector<Rgba8>& colors = file.mesh.vertex_colors;
    colors.assign(file.mesh.vertices.size(), kNoColor);
    for (std::size_t v = 0; v < sums_.size(); ++v)
      for (std::size_t k = 0; k < 3 && sums_[v][3] > 0; ++k)
        colors[v][k] = static_cast<std::uint8_t>(std::lround(sums_[v][k] / sums_[v][3]));
    file.notes.emplace_back("Colours come from " + std::string(pictures_.empty() ? "materials" : "the texture") +
                            ", one for each vertex.");
  }
  std::string list;
  for (const std::string& name : missing_) list += (list.empty() ? "" : ", ") + name;
  if (!list.empty()) file.notes.emplace_back("Textures or materials were not read: " + list + ".");
}

}  // namespace kerf::internal
