#include "ui/app/session/exporting.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/export/plane_parts_mesh.h"
#include "ui/app/base/language.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// Checks that the file returns the vertices of every triangle in order, in any format.
Expected<Mesh> readBack(const fs::path& file, const Mesh& mesh) {
  KERF_TRY(read, readMesh(file));
  Mesh& back = read.mesh;
  std::size_t different = back.triangles.size() == mesh.triangles.size() ? 0 : 1;
  for (std::size_t t = 0; different == 0 && t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(k);
      const Vec3d wanted = roundedToFloat(mesh.vertices[mesh.triangles[t][corner]]);
      different += roundedToFloat(back.vertices[back.triangles[t][corner]]) != wanted;
    }
  if (different == 0) return std::move(back);
  return fail({.code = Error::Code::kWriteFailed,
               .file = file.string(),
               .found = fmt::format("{} triangles read back that differ from the written ones", back.triangles.size()),
               .expected = fmt::format("the {} triangles of the mesh, bit for bit", mesh.triangles.size()),
               .hint = "write it to another disk"});
}

tl::unexpected<Error> noSuchPiece() {
  return fail({.code = Error::Code::kNotFound,
               .place = "pieces",
               .found = "the piece is not in the scene, or too small to be exported",
               .expected = "one of the pieces",
               .hint = "choose it in the list of pieces"});
}

// Pieces cut without a kerf touch, and moved ones may intersect, although each is right.
ExportPart partOfExport(std::string piece, Mesh mesh, std::span<const PlacedPiece> together = {}) {
  ExportPart out;
  out.piece = std::move(piece);
  out.report = checkMesh(mesh);
  out.mesh = std::move(mesh);
  const auto is_right = [](const PlacedPiece& one) { return checkMesh(one.mesh).print_ready; };
  out.is_met = !out.report.print_ready && !together.empty() && std::all_of(together.begin(), together.end(), is_right);
  return out;
}

ExportPart partOfPiece(PlacedPiece& piece) {
  std::vector<NamedPart> objects = objectsOf({&piece, 1});
  ExportPart out = partOfExport(piece.name, std::move(piece.mesh));
  out.objects = std::move(objects);
  return out;
}

// Contents of each file.
Expected<std::vector<ExportPart>> partsOfExport(LiveResult& result, const SceneCopy& scene, const ExportChoice& choice,
                                                const ObjectNames& names) {
  std::vector<ExportPart> out;
  const bool is_as_in_case = std::none_of(result.pieces.begin(), result.pieces.end(), [&](const auto& piece) {
    return isNamedByUser(piece.name) || (piece.isMoved() && !choice.is_put_back);
  });
  const std::size_t touching = countTouching(result.pieces, choice.is_put_back);
  if (!choice.is_each && choice.only.empty() && is_as_in_case && touching == 0) {
    out.push_back(partOfExport("", std::move(result.post_op.mesh)));
    return out;
  }

  KERF_TRY(pieces, placedPieces(result.post_op.mesh, result.pieces, choice.is_put_back, names));
  if (!choice.only.empty()) {
    const auto is_wanted = [&](std::uint32_t id) {
      return std::find(choice.only.begin(), choice.only.end(), id) != choice.only.end();
    };
    const bool has_whole = std::any_of(scene.objects.begin(), scene.objects.end(),
                                       [&](const SceneCopy::Object& object) { return is_wanted(object.id); });
    std::erase_if(pieces,
                  [&](const PlacedPiece& piece) { return result.pieces.empty() ? !has_whole : !is_wanted(piece.id); });
    std::erase_if(result.pieces, [&](const RunManifest::Piece& piece) { return !is_wanted(piece.id); });
    if (pieces.size() == 1) out.push_back(partOfPiece(pieces.front()));
    if (pieces.size() > 1) {
      out.push_back(partOfExport("", together(pieces), pieces));
      out.back().touching = out.back().is_met ? countTouching(result.pieces, choice.is_put_back) : 0;
      out.back().objects = objectsOf(pieces);
    }
  } else if (choice.is_each) {
    for (PlacedPiece& piece : pieces) out.push_back(partOfPiece(piece));
  } else {
    out.push_back(partOfExport("", is_as_in_case ? std::move(result.post_op.mesh) : together(pieces), pieces));
    out.back().touching = out.back().is_met ? touching : 0;
    if (!is_as_in_case) out.back().objects = objectsOf(pieces);
  }
  if (out.empty()) return noSuchPiece();
  return out;
}

// Writes one file.   @return  a line about it.
Expected<std::string> write(const ExportPart& part, const ObjectNames& names, const fs::path& file, bool& is_ready) {
  const NamedMesh named = part.objects.empty() ? names.grouped(part.mesh, file) : NamedMesh{part.mesh, part.objects};
  KERF_CHECK(writeMesh(file, named.mesh, {.objects = named.objects}));
  KERF_TRY(back, readBack(file, named.mesh));
  ExportPart read;
  read.report = checkMesh(back);
  read.is_met = part.is_met;
  read.touching = part.touching;
  is_ready &= read.report.print_ready;
  const std::string name = part.piece.empty() ? "" : fmt::format(" ({})", part.piece);
  return phrase("{}{}: {} triangles, {}", file.string(), name, back.triangles.size(), shownText(read.verdict()));
}

}  // namespace

std::string ExportPart::verdict() const {
  if (report.print_ready) return "ready to print";
  if (!is_met) return "NOT ready to print; see kerf check";
  if (touching > 0)
    return "each piece is ready to print, but pieces touch along a cut without kerf: export one file per piece";
  return "each piece is valid, but the moved pieces overlap: move them apart, or export one file per piece";
}

bool PreparedExport::isReady() const {
  return std::all_of(parts.begin(), parts.end(), [](const ExportPart& part) { return part.report.print_ready; });
}

std::vector<fs::path> PreparedExport::filesFor(const fs::path& file) const {
  if (!is_each) return {file};
  std::vector<PlacedPiece> names(parts.size());
  for (std::size_t n = 0; n < parts.size(); ++n) names[n].name = parts[n].piece;
  return filesOfPieces(file, names);
}

std::string PreparedExport::summary() const {
  std::string out = phrase("removed {:.3f} mm3, {} vertices of the solid kept bit for bit", removed_mm3, vertices_kept);
  if (moved > 0) out += phrase(" except in {} of {} pieces, which were moved", moved, pieces);
  return out;
}

Expected<PreparedExport> prepareExport(const LiveRun& run, const SceneCopy& scene, const ExportChoice& asked,
                                       const Progress& progress) {
  constexpr double kOfExport = 0.85;  // the check takes the rest
  ExportChoice choice = asked;
  for (const SceneCopy::Object& object : scene.objects)
    if (asked.only.size() == 1 && asked.only.front() == object.id && object.loaded > 0)
      choice = {.beside = object.loaded};
  if (choice.beside > 0) choice.is_each = choice.is_put_back = false;
  const Progress first = [&](double done, std::string_view step) { return report(progress, kOfExport * done, step); };
  KERF_TRY(result, run.postOperative(scene, {}, first, choice.beside));

  PreparedExport out;
  out.is_each = choice.is_each;
  out.removed_mm3 = result.post_op.report.removed_volume_mm3;
  out.vertices_kept = result.post_op.report.source_vertices_kept;
  out.pieces = result.pieces.size();
  for (const RunManifest::Piece& piece : result.pieces) out.moved += piece.isMoved() && !choice.is_put_back;
  if (!report(progress, kOfExport, "checking")) return cancelledBeforeWriting();
  const LiveNeighbour* const other = choice.beside > 0 ? &run.neighbours()[choice.beside - 1] : nullptr;
  out.names = other ? ObjectNames::ofCase(other->known.folder, other->known.manifest)
                    : ObjectNames::ofCase(run.caseFolder(), run.caseManifest());
  KERF_TRY(parts, partsOfExport(result, scene, choice, out.names));
  out.parts = std::move(parts);
  return out;
}

Expected<WrittenExport> writeExport(const PreparedExport& prepared, const LiveRun& run, const fs::path& file) {
  WrittenExport out;
  out.files = prepared.filesFor(file);
  for (const fs::path& one : out.files) {
    KERF_CHECK(canWriteMesh(one));
    KERF_CHECK(requireNoSource(one, run.caseManifest()));
    for (const LiveNeighbour& other : run.neighbours()) KERF_CHECK(requireNoSource(one, other.known.manifest));
  }

  out.is_ready = true;
  for (std::size_t n = 0; n < prepared.parts.size(); ++n) {
    auto line = write(prepared.parts[n], prepared.names, out.files[n], out.is_ready);
    if (!line) {
      if (!out.text.empty()) line.error().hint += "; already written: " + out.text;
      return fail(std::move(line).error());
    }
    out.text += *line + "\n";
  }
  out.text += prepared.summary();
  return out;
}

}  // namespace kerf
