#include "ui/window/draw/live_pages.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "ui/window/gl/gl_program.h"

namespace kerf::internal {
namespace {

constexpr Rgba8 kUncoloured = {233, 221, 197, 140};

std::int16_t shortOf(float unit) {
  return static_cast<std::int16_t>(std::lround(32767 * std::clamp(unit, -1.0f, 1.0f)));
}

bool isSound(const MeshChunk& chunk, std::size_t colours, std::size_t occlusion) {
  const std::size_t count = chunk.vertices.size();
  if (chunk.normals.size() != count) return false;
  if ((colours && colours != count) || (occlusion && occlusion != count)) return false;
  const auto isInside = [&](const std::array<std::uint16_t, 3>& t) {
    return t[0] < count && t[1] < count && t[2] < count;
  };
  const auto isFinite = [](const Vec3f& p) { return p.allFinite(); };
  return std::all_of(chunk.triangles.begin(), chunk.triangles.end(), isInside) &&
         std::all_of(chunk.vertices.begin(), chunk.vertices.end(), isFinite) &&
         std::all_of(chunk.normals.begin(), chunk.normals.end(), isFinite);
}

}  // namespace

LiveChunk liveChunk(const MeshChunk& chunk, std::span<const Rgba8> colours, std::span<const std::uint8_t> occlusion) {
  LiveChunk out;
  if (chunk.isEmpty() || !isSound(chunk, colours.size(), occlusion.size())) return out;

  out.vertices.resize(chunk.vertices.size());
  for (std::size_t v = 0; v < out.vertices.size(); ++v) {
    LiveVertex& vertex = out.vertices[v];
    const Vec3f& n = chunk.normals[v];
    vertex.position = chunk.vertices[v];
    vertex.normal = {shortOf(n[0]), shortOf(n[1]), shortOf(n[2])};
    if (!occlusion.empty()) vertex.open = shortOf(static_cast<float>(occlusion[v]) / 255);
    vertex.color = colours.empty() ? kUncoloured : colours[v];
    out.box.add(Vec3d(chunk.vertices[v].cast<double>()));
  }

  out.triangles = chunk.triangles;
  return out;
}

LivePage::~LivePage() {
  if (!vertex_array_) return;
  glDeleteVertexArrays(1, &vertex_array_);
  glDeleteBuffers(1, &vertex_buffer_);
  glDeleteBuffers(1, &index_buffer_);
}

void LivePage::set(const Vec3i& brick, LiveChunk chunk) {
  const std::array<int, 3> key{brick[0], brick[1], brick[2]};
  is_dirty_ = true;
  if (chunk.triangles.empty())
    chunks_.erase(key);
  else
    chunks_[key] = std::move(chunk);
}

std::size_t LivePage::upload() {
  if (!is_dirty_) return 0;
  is_dirty_ = false;
  waited_ = 0;

  std::vector<LiveVertex> vertices;
  triangles_.clear();
  first_of_chunk_.clear();
  ranges_.clear();
  chosen_.reset();
  box_ = {};
  double area = 0;
  for (const auto& [key, chunk] : chunks_) {
    const auto base = static_cast<std::uint32_t>(vertices.size());
    first_of_chunk_.push_back(triangles_.triangles());
    ranges_.push_back({.first = 0, .count = 0, .box = chunk.box});
    box_.add(chunk.box);
    vertices.insert(vertices.end(), chunk.vertices.begin(), chunk.vertices.end());
    for (const LiveVertex& vertex : chunk.vertices) triangles_.addVertex(vertex.position);
    for (const auto& t : chunk.triangles) {
      triangles_.addTriangle(base + t[0], base + t[1], base + t[2]);
      const Vec3f& a = chunk.vertices[t[0]].position;
      const Vec3f ab = chunk.vertices[t[1]].position - a, ac = chunk.vertices[t[2]].position - a;
      area += 0.5 * static_cast<double>(ab.cross(ac).norm());
    }
  }
  first_of_chunk_.push_back(triangles_.triangles());
  mean_edge_ = triangles() == 0 ? 0 : std::sqrt(2.3 * area / static_cast<double>(triangles()));

  if (!vertex_array_) {
    glGenVertexArrays(1, &vertex_array_);
    glGenBuffers(1, &vertex_buffer_);
    glGenBuffers(1, &index_buffer_);
  }
  glBindVertexArray(vertex_array_);
  glBindBuffer(GL_ARRAY_BUFFER, vertex_buffer_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer_);
  const std::size_t bytes = vertices.size() * sizeof(LiveVertex);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), vertices.data(), GL_DYNAMIC_DRAW);

  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(LiveVertex), bufferOffset(offsetof(LiveVertex, position)));
  glVertexAttribPointer(1, 4, GL_SHORT, GL_TRUE, sizeof(LiveVertex), bufferOffset(offsetof(LiveVertex, normal)));
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(LiveVertex), bufferOffset(offsetof(LiveVertex, color)));
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
  return bytes;
}

std::size_t LivePage::choose(const Sight& sight) {
  if (chosen_ == sight) return 0;
  chosen_ = sight;

  triangles_.look(sight);
  std::vector<std::uint32_t> seen;
  seen.reserve(3 * triangles());
  for (std::size_t c = 0; c < ranges_.size(); ++c) {
    ranges_[c].first = seen.size();
    triangles_.choose(first_of_chunk_[c], first_of_chunk_[c + 1], seen);
    ranges_[c].count = seen.size() - ranges_[c].first;
  }

  const std::size_t bytes = seen.size() * sizeof(std::uint32_t);
  glBindVertexArray(vertex_array_);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), seen.data(), GL_DYNAMIC_DRAW);
  return bytes;
}

}  // namespace kerf::internal
