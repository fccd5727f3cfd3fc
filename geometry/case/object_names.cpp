#include "geometry/case/object_names.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/solids.h"

namespace kerf {
namespace {

constexpr std::uint32_t kNoName = 0, kNowhere = std::numeric_limits<std::uint32_t>::max();

bool canHoldNames(const CaseSource& source) {
  const auto rows = meshFormats();
  return std::any_of(rows.begin(), rows.end(),
                     [&](const MeshFormatRow& row) { return row.carries.object_names && source.format == row.name; });
}

std::array<float, 3> placeOf(const Vec3d& p) {
  const auto single = [](double x) { return static_cast<float>(x) + 0.0f; };  // -0 is 0
  return {single(p[0]), single(p[1]), single(p[2])};
}

// Votes for the names, by their numbers; the first of those with most.
std::uint32_t mostOf(const std::map<std::uint32_t, std::size_t>& votes) {
  std::uint32_t out = kNoName;
  std::size_t most = 0;
  for (const auto& [name, count] : votes) {
    if (count <= most) continue;
    most = count;
    out = name;
  }
  return out;
}

// The triangles, and the vertices as they are used, in the order of the triangles' names.
NamedMesh ordered(const Mesh& mesh, const std::vector<std::uint32_t>& name_of, const std::vector<std::string>& names) {
  const auto sorted = [](const std::vector<std::uint32_t>& keys) {
    std::vector<std::uint32_t> out(keys.size());
    for (std::uint32_t n = 0; n < out.size(); ++n) out[n] = n;
    std::stable_sort(out.begin(), out.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
    return out;
  };
  std::vector<std::uint32_t> name_of_vertex(mesh.vertices.size(), kNowhere), place(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) name_of_vertex[v] = std::min(name_of_vertex[v], name_of[t]);

  NamedMesh out;
  for (const std::uint32_t v : sorted(name_of_vertex)) {
    place[v] = static_cast<std::uint32_t>(out.mesh.vertices.size());
    out.mesh.vertices.push_back(mesh.vertices[v]);
    if (mesh.hasVertexColors()) out.mesh.vertex_colors.push_back(mesh.vertex_colors[v]);
  }
  std::uint32_t last = kNowhere;
  for (const std::uint32_t t : sorted(name_of)) {
    if (name_of[t] != last) out.objects.push_back({names[name_of[t]], out.mesh.triangles.size()});
    last = name_of[t];
    const Triangle& v = mesh.triangles[t];
    out.mesh.triangles.push_back({place[v[0]], place[v[1]], place[v[2]]});
    if (mesh.hasFaceColors()) out.mesh.face_colors.push_back(mesh.face_colors[t]);
  }
  return out;
}

}  // namespace

ObjectNames ObjectNames::ofCase(const std::filesystem::path& folder, const CaseManifest& manifest) {
  ObjectNames out;
  bool is_all = true;
  for (const CaseSource& source : manifest.sources) {
    const std::filesystem::path file = folder / source.stored_as;
    const auto read = canHoldNames(source) && requireSha256(file, source.sha256, "")
                          ? readMesh(file)
                          : Expected<MeshFile>(fail({.code = Error::Code::kUnsupported}));
    is_all &= read.has_value();
    if (read) out.add(read->mesh, source.scale_to_mm, read->objects);
  }
  out.finish(is_all);
  return out;
}

ObjectNames ObjectNames::ofMesh(const Mesh& mesh, std::span<const NamedPart> objects) {
  ObjectNames out;
  out.add(mesh, 1, objects);
  out.finish(true);
  return out;
}

std::uint32_t ObjectNames::numberOf(const std::string& name) {
  const auto known = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
  if (known == names_.size()) names_.push_back(name);
  return static_cast<std::uint32_t>(known);
}

void ObjectNames::add(const Mesh& mesh, double scale_to_mm, std::span<const NamedPart> objects) {
  has_unnamed_ |= objects.empty();
  std::vector<std::uint32_t> name_of(mesh.vertices.size(), kNowhere);
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const std::uint32_t name = numberOf(objects[n].name);
    has_unnamed_ |= name == kNoName;
    const std::size_t end = n + 1 < objects.size() ? objects[n + 1].first_triangle : mesh.triangles.size();
    for (std::size_t t = objects[n].first_triangle; t < end; ++t)
      for (const std::uint32_t v : mesh.triangles[t])
        if (std::exchange(name_of[v], name) != name)
          vertices_.push_back({placeOf(mesh.vertices[v] * scale_to_mm), name});
  }
  if (!objects.empty()) return;
  for (const Vec3d& p : mesh.vertices) vertices_.push_back({placeOf(p * scale_to_mm), kNoName});
}

void ObjectNames::finish(bool is_all) {
  if (is_all && !has_unnamed_ && names_.size() == 2) name_of_all_ = 1;
  if (isEmpty() || name_of_all_ > 0) {
    vertices_ = {};
    return;
  }
  std::sort(vertices_.begin(), vertices_.end());
  vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
  std::vector<Vertex> sure;
  for (std::size_t n = 0; n < vertices_.size(); ++n) {
    const bool is_shared = (n > 0 && vertices_[n - 1].place == vertices_[n].place) ||
                           (n + 1 < vertices_.size() && vertices_[n + 1].place == vertices_[n].place);
    if (!is_shared) sure.push_back(vertices_[n]);
  }
  vertices_ = std::move(sure);
}

std::uint32_t ObjectNames::nameAt(const Vec3d& p) const {
  const Vertex wanted{placeOf(p), 0};
  const auto at = std::lower_bound(vertices_.begin(), vertices_.end(), wanted);
  return at != vertices_.end() && at->place == wanted.place ? at->name : kNowhere;
}

NamedMesh ObjectNames::grouped(const Mesh& mesh, const std::filesystem::path& file) const {
  const MeshFormatRow* const format = formatOfExtension(file.extension().string());
  if (format != nullptr && format->carries.object_names) return grouped(mesh);
  return {mesh, {}};
}

std::string ObjectNames::nameOf(const Mesh& mesh) const {
  if (isEmpty() || name_of_all_ > 0) return names_[name_of_all_];
  std::vector<std::uint32_t> name_of(mesh.vertices.size());
  for (std::size_t v = 0; v < name_of.size(); ++v) name_of[v] = nameAt(mesh.vertices[v]);
  std::map<std::uint32_t, std::size_t> votes;
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t)
      if (name_of[v] != kNowhere) ++votes[name_of[v]];
  return names_[mostOf(votes)];
}

NamedMesh ObjectNames::grouped(const Mesh& mesh) const {
  NamedMesh out;
  if (isEmpty() || name_of_all_ > 0 || mesh.triangles.empty()) {
    out.mesh = mesh;
    if (name_of_all_ > 0) out.objects.push_back({names_[name_of_all_], 0});
    return out;
  }

  const Solids solids = solidsOf(mesh);
  std::vector<std::uint32_t> name_at(mesh.vertices.size());
  for (std::size_t v = 0; v < name_at.size(); ++v) name_at[v] = nameAt(mesh.vertices[v]);
  std::vector<std::map<std::uint32_t, std::size_t>> votes(solids.count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      if (name_at[v] != kNowhere) ++votes[solids.label[t]][name_at[v]];

  std::vector<std::uint32_t> of_solid, name_of(mesh.triangles.size());
  for (const auto& of_one : votes) of_solid.push_back(mostOf(of_one));
  for (std::size_t t = 0; t < name_of.size(); ++t) name_of[t] = of_solid[solids.label[t]];
  if (std::any_of(of_solid.begin(), of_solid.end(), [&](std::uint32_t name) { return name != of_solid[0]; }))
    return ordered(mesh, name_of, names_);
  out.mesh = mesh;
  if (of_solid[0] != kNoName) out.objects.push_back({names_[of_solid[0]], 0});
  return out;
}

}  // namespace kerf
