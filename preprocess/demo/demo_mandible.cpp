#include <algorithm>
#include <string>

#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_jaw.h"
#include "preprocess/demo/demo_teeth.h"
#include "preprocess/volume/tetrahedral_mesher.h"

namespace kerf {
namespace {

using namespace internal;

double teeth(const Vec3d& p, ToothTissue tissue) { return rowValue(tissue, Vec3d(std::abs(p.x()), p.y(), p.z()), 3.0); }
double dentin(const Vec3d& p) { return teeth(p, ToothTissue::kTooth); }
double mandibleEnamel(const Vec3d& p) { return teeth(p, ToothTissue::kEnamel); }
/// A little wider than in the single molar: the canals have to survive a coarser mesh.
double mandiblePulp(const Vec3d& p) { return teeth(p, ToothTissue::kPulp) - 0.08; }

Vec3d rgb(const Rgba8& c) { return Vec3d(c[0], c[1], c[2]); }
constexpr Rgba8 kBone{226, 211, 178, 255}, kEnamel{238, 232, 218, 255}, kDentin{219, 198, 158, 255};

/// Ivory crowns, yellow necks, bone, in soft transition.
Rgba8 outlineColor(const Vec3d& p) {
  const Vec3d q(std::abs(p.x()), p.y(), p.z());
  const double tooth = rowValue(ToothTissue::kTooth, q, 3.0);
  const Vec3d on_tooth = rgb(kDentin) + (rgb(kEnamel) - rgb(kDentin)) * smoothStep(-0.4, 0.5, heightOnNearestTooth(q));
  const Vec3d c = rgb(kBone) + (on_tooth - rgb(kBone)) * smoothStep(0.35, 0.05, tooth);
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(v)); };
  return {byte(c.x()), byte(c.y()), byte(c.z()), 255};
}

}  // namespace

Expected<DemoAnatomy> demoMandible(double detail, const Progress& progress) {
  struct Tissue {
    const char* material;
    const char* file;
    double (*value)(const Vec3d&);
    double edge_mm, coarsest_mm;
    double steepness;
    Box3 box;
    Rgba8 color;
  };
  const Box3 row{Vec3d(-36, -8, -30), Vec3d(36, 50, 4)}, jaw{Vec3d(-66, -14, -47), Vec3d(66, 108, 36)};
  const Tissue tissues[] = {
      {"nerve_canal", "nerve-canal.ply", nerveCanal, 0.4, 0.9, 1.2, jaw, {240, 196, 48, 255}},
      {"pulp", "pulp.ply", mandiblePulp, 0.17, 0.17, 2, row, {186, 58, 52, 255}},
      {"enamel", "enamel.ply", mandibleEnamel, 0.32, 0.5, 2, row, kEnamel},
      {"dentin", "teeth.ply", dentin, 0.32, 0.8, 2, row, kDentin},
      {"pdl", "pdl.ply", ligament, 0.4, 0.8, 2, row, {205, 120, 110, 255}},
      {"cancellous", "cancellous.ply", spongyBone, 0.5, 1.0, 2, jaw, {206, 150, 110, 255}},
      {"cortical", "mandible.ply", jawOutline, 0.42, 1.0, 2, jaw, kBone},
  };

  DemoAnatomy anatomy{"mandible", "Demo mandible", 0.2, {}, {}, {"mandible.ply"}};
  double done = 0;
  for (const Tissue& tissue : tissues) {
    if (!report(progress, done++ / std::size(tissues), std::string("modelling ") + tissue.material)) return cancelled();

    const double edge_mm = std::min(detail * tissue.edge_mm, tissue.coarsest_mm);
    Mesh mesh = meshImplicit(tissue.value, tissue.box, edge_mm / kEdgeToSpacing, 3, tissue.steepness);
    evenOut(mesh, tissue.value, 2);
    for (const Vec3d& p : mesh.vertices)
      mesh.vertex_colors.push_back(tissue.value == jawOutline ? outlineColor(p) : tissue.color);
    anatomy.files.push_back({tissue.file, std::move(mesh)});
    anatomy.parts.push_back({tissue.material, tissue.file});
  }
  return anatomy;
}

}  // namespace kerf
