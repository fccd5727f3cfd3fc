#include "ui/app/exporting.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "sim/run/placed_pieces.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

struct Output {
  fs::path file;
  std::string what;  // "piece 2", empty for all
  Mesh mesh;
  std::vector<Mesh> pieces{};  // of several in one file
};

// Vertices of every triangle, in their order: what a file has to bring back whatever its format.
Expected<void> compareWithFile(const fs::path& file, const Mesh& mesh) {
  KERF_TRY(read, readMesh(file));
  const Mesh& back = read.mesh;
  std::size_t different = back.triangles.size() == mesh.triangles.size() ? 0 : 1;
  for (std::size_t t = 0; different == 0 && t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(k);
      const Vec3d wanted = roundedToFloat(mesh.vertices[mesh.triangles[t][corner]]);
      different += roundedToFloat(back.vertices[back.triangles[t][corner]]) != wanted;
    }
  if (different == 0) return {};
  return fail({.code = Error::Code::kWriteFailed,
               .file = file.string(),
               .found = fmt::format("{} triangles read back, not those that were written", back.triangles.size()),
               .expected = fmt::format("the {} triangles of the mesh, bit for bit", mesh.triangles.size()),
               .hint = "write it again, to another disk"});
}

// Whether a slicer takes it. Pieces that were moved may reach into each other though each of them is right.
std::string verdictOf(const Output& output) {
  if (checkMesh(output.mesh).print_ready) return "ready to print";
  const bool is_each_right = std::all_of(output.pieces.begin(), output.pieces.end(),
                                         [](const Mesh& piece) { return checkMesh(piece).print_ready; });
  if (output.pieces.empty() || !is_each_right) return "NOT ready to print, see kerf check";
  return "each piece is right, but they reach into each other where they were moved to: move them apart, or export "
         "each into a file of its own";
}

Expected<std::string> write(const Output& output) {
  KERF_CHECK(writeMesh(output.file, output.mesh));
  KERF_CHECK(compareWithFile(output.file, output.mesh));
  const std::string name = output.what.empty() ? "" : fmt::format(" ({})", output.what);
  return fmt::format("{}{}: {} triangles, {}", output.file.string(), name, output.mesh.triangles.size(),
                     verdictOf(output));
}

tl::unexpected<Error> noSuchPiece() {
  return fail({.code = Error::Code::kNotFound,
               .place = "pieces",
               .found = "the piece is not in the scene, or too small to be exported",
               .expected = "one of the pieces",
               .hint = "choose it in the list of pieces"});
}

// What goes into which file.
Expected<std::vector<Output>> outputsOf(LiveResult& result, const SceneCopy& scene, const fs::path& file,
                                        const ExportChoice& choice) {
  std::vector<Output> out;
  const bool is_moved = std::any_of(result.pieces.begin(), result.pieces.end(),
                                    [&](const auto& piece) { return piece.isMoved() && !choice.is_put_back; });
  if (!choice.is_each && !choice.only && !is_moved) {
    out.push_back({file, "", std::move(result.post_op.mesh)});
    return out;
  }

  KERF_TRY(pieces, placedPieces(result.post_op.mesh, result.pieces, choice.is_put_back));
  if (choice.only) {
    for (const SceneCopy::Object& object : scene.objects)
      for (PlacedPiece& piece : pieces)
        if (object.id == *choice.only && (piece.id == object.id || result.pieces.empty()))
          out.push_back({file, piece.name, std::move(piece.mesh)});
    if (out.empty()) return noSuchPiece();
  } else if (choice.is_each) {
    const std::vector<fs::path> files = filesOfPieces(file, pieces);
    for (std::size_t n = 0; n < pieces.size(); ++n)
      out.push_back({files[n], pieces[n].name, std::move(pieces[n].mesh)});
  } else {
    Output& all = out.emplace_back(Output{file, "", together(pieces)});
    for (PlacedPiece& piece : pieces) all.pieces.push_back(std::move(piece.mesh));
  }
  return out;
}

}  // namespace

Expected<std::string> exportScene(const LiveRun& run, const SceneCopy& scene, const fs::path& file,
                                  const ExportChoice& asked, const Progress& progress) {
  ExportChoice choice = asked;
  for (const SceneCopy::Object& object : scene.objects)
    if (choice.only == object.id && object.loaded > 0) choice = {.beside = object.loaded};
  if (choice.beside > 0) choice.is_each = choice.is_put_back = false;
  KERF_TRY(result, run.postOperative(scene, {}, progress, choice.beside));
  const PostOpReport report = result.post_op.report;
  KERF_TRY(outputs, outputsOf(result, scene, file, choice));

  for (const Output& output : outputs) {
    KERF_CHECK(canWriteMesh(output.file));
    KERF_CHECK(requireNoSource(output.file, run.caseManifest()));
    for (const LiveNeighbour& other : run.neighbours()) KERF_CHECK(requireNoSource(output.file, other.known.manifest));
  }

  std::string out;
  for (const Output& output : outputs) {
    auto line = write(output);
    if (!line) {
      if (!out.empty()) line.error().hint += "; written before it: " + out;
      return fail(std::move(line).error());
    }
    out += *line + "\n";
  }
  out += fmt::format("removed {:.3f} mm3, {} vertices of the solid kept bit for bit", report.removed_volume_mm3,
                     report.source_vertices_kept);
  std::size_t moved = 0;
  for (const RunManifest::Piece& piece : result.pieces) moved += piece.isMoved();
  if (moved > 0 && !choice.is_put_back)
    out += fmt::format(" but for {} of {} pieces, which were moved", moved, result.pieces.size());
  return out;
}

}  // namespace kerf
