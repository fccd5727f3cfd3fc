#include "ui/app/import/label_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include "geometry/mesh/solids.h"
#include "preprocess/volume/label_names.h"
#include "preprocess/volume/label_surface.h"
#include "preprocess/volume/label_volume.h"
#include "ui/app/base/language.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using LabelClock = std::chrono::steady_clock;
using LabelWeight = Finding::Weight;

constexpr std::size_t kLabelsByItselfUpTo = 60'000'000;  // voxels: smoothing takes some seconds

double labelSecondsSince(LabelClock::time_point then) {
  return std::chrono::duration<double>(LabelClock::now() - then).count();
}

tl::unexpected<Error> wrongLabels(std::string found, std::string expected) {
  return fail({.code = Error::Code::kBadValue, .found = std::move(found), .expected = std::move(expected)});
}

std::size_t voxelsOf(const LabelVolume& v) {
  return static_cast<std::size_t>(v.size[0]) * static_cast<std::size_t>(v.size[1]) *
         static_cast<std::size_t>(v.size[2]);
}

// ---- Reading

// Areas of the faces between labels, and the box of the labelled voxels.
void survey(const LabelVolume& v, LabelsFound& out) {
  const Eigen::Matrix3d axes = v.axes();
  const std::array<double, 3> face = {axes.col(1).cross(axes.col(2)).norm(), axes.col(2).cross(axes.col(0)).norm(),
                                      axes.col(0).cross(axes.col(1)).norm()};
  const auto meet = [&](std::uint16_t a, std::uint16_t b, int axis) {
    if (a != b) out.walls_mm2[{std::min(a, b), std::max(a, b)}] += face[static_cast<std::size_t>(axis)];
  };
  const auto labelAt = [&](int i, int j, int k) -> std::uint16_t {
    return i < 0 || j < 0 || k < 0 ? std::uint16_t{0} : v.at(i, j, k);
  };
  const auto [nx, ny, nz] = v.size;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const std::uint16_t here = v.at(i, j, k);
        meet(here, labelAt(i - 1, j, k), 0);
        meet(here, labelAt(i, j - 1, k), 1);
        meet(here, labelAt(i, j, k - 1), 2);
        if (here == 0) continue;
        if (i == nx - 1) meet(here, 0, 0);
        if (j == ny - 1) meet(here, 0, 1);
        if (k == nz - 1) meet(here, 0, 2);
        out.box.add(v.toWorld({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}));
      }
}

// ---- The surface

struct Wanted {
  std::vector<std::uint16_t> labels;
  std::map<std::uint16_t, Rgba8> colours;
};

Expected<ClosedPreview> surfaceOf(const LabelVolume& volume, const Wanted& wanted, const Progress& progress) {
  const auto began = LabelClock::now();
  KERF_TRY(smooth, SmoothLabels::create(volume, wanted.labels, {}, partOf(progress, 0, 0.7)));
  KERF_TRY(mesh, smooth.surface(partOf(progress, 0.7, 0.9)));

  ClosedPreview out;
  for (const LabelVolumeReport& r : smooth.reports())
    if (r.pieces_now < r.pieces)
      out.changes.push_back(
          phrase("label {}: {} of {} pieces remain; specks vanish or merge", r.label, r.pieces_now, r.pieces));
  out.volume_mm3 = signedVolume(mesh);
  out.area_mm2 = surfaceArea(mesh);

  // A face has the colour of the label under it.
  const double under = 0.3 * volume.spacing.minCoeff();
  mesh.face_colors.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const Vec3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3d normal = (b - a).cross(c - a).normalized();
    const auto colour = wanted.colours.find(smooth.labelAt((a + b + c) / 3 - under * normal));
    mesh.face_colors.push_back(colour == wanted.colours.end() ? wanted.colours.begin()->second : colour->second);
  }
  out.solid = std::make_shared<const Mesh>(std::move(mesh));
  out.seconds = labelSecondsSince(began);
  return out;
}

// A quoted TOML string.
std::string quotedLabel(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + '"';
}

}  // namespace

Expected<LabelsFound> readLabels(const fs::path& file, const Progress& progress) {
  const auto began = LabelClock::now();
  KERF_TRY(volume, readLabelVolume(file, {}, partOf(progress, 0, 0.7)));
  if (!report(progress, 0.7, "counting labels")) return cancelled();
  LabelsFound out;
  out.file = file.has_filename() ? file : file.parent_path();  // a folder path may end in a slash
  out.format = volume.format;
  const auto names = labelNames(file);
  for (const LabelCount& count : countLabels(volume)) {
    if (count.label == 0) continue;
    const auto name = names.find(count.label);
    out.labels.push_back({count.label, name == names.end() ? "" : name->second, count.voxels,
                          static_cast<double>(count.voxels) * volume.voxelVolume()});
  }
  if (out.labels.empty())
    return fail({.code = Error::Code::kEmpty,
                 .file = file.string(),
                 .found = "a volume without labels",
                 .expected = "labels from 1 upwards",
                 .hint = "segment it first, for example with 3D Slicer"});
  if (!report(progress, 0.8, "finding walls between labels")) return cancelled();
  survey(volume, out);
  out.volume = std::make_shared<const LabelVolume>(std::move(volume));
  out.seconds = labelSecondsSince(began);
  return out;
}

std::optional<Material> tissueByName(const std::string& name) {
  // The first matching row counts: a canal in a bone is a canal.
  struct Row {
    std::string_view word;
    Material tissue;
  };
  static constexpr std::array<Row, 38> kWords = {{{"sinus", Material::kNone},
                                                  {"airway", Material::kNone},
                                                  {"pharynx", Material::kNone},
                                                  {"background", Material::kNone},
                                                  {"removed", Material::kNone},
                                                  {"pulp", Material::kPulp},
                                                  {"root canal", Material::kPulp},
                                                  {"canal", Material::kNerveCanal},
                                                  {"nerve", Material::kNerveCanal},
                                                  {"alveolar inf", Material::kNerveCanal},
                                                  {"caries", Material::kCaries},
                                                  {"decay", Material::kCaries},
                                                  {"enamel", Material::kEnamel},
                                                  {"dentin", Material::kDentin},
                                                  {"implant", Material::kComposite},
                                                  {"restoration", Material::kComposite},
                                                  {"filling", Material::kComposite},
                                                  {"composite", Material::kComposite},
                                                  {"bridge", Material::kComposite},
                                                  {"crown", Material::kComposite},
                                                  {"ligament", Material::kPdl},
                                                  {"pdl", Material::kPdl},
                                                  {"gingiva", Material::kGingiva},
                                                  {"gum", Material::kGingiva},
                                                  {"cancellous", Material::kCancellous},
                                                  {"trabecul", Material::kCancellous},
                                                  {"spongios", Material::kCancellous},
                                                  {"cortical", Material::kCortical},
                                                  {"molar", Material::kDentin},
                                                  {"incisor", Material::kDentin},
                                                  {"canine", Material::kDentin},
                                                  {"tooth", Material::kDentin},
                                                  {"teeth", Material::kDentin},
                                                  {"mandib", Material::kCortical},
                                                  {"maxill", Material::kCortical},
                                                  {"jaw", Material::kCortical},
                                                  {"skull", Material::kCortical},
                                                  {"bone", Material::kCortical}}};
  std::string low = name;
  std::transform(low.begin(), low.end(), low.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  for (const auto& [word, tissue] : kWords)
    if (low.find(word) != low.npos) return tissue == Material::kNone ? std::nullopt : std::optional(tissue);
  return Material::kGeneric;
}

LabelPlan::LabelPlan(LabelsFound found, MaterialTable materials, double voxel_mm)
    : found_(std::move(found)), materials_(std::move(materials)), voxel_mm_(voxel_mm) {
  for (const LabelFound& label : found_.labels)
    if (const auto tissue = tissueByName(label.name); tissue && materials_.find(*tissue))
      tissues_[label.label] = *tissue;
}

std::vector<Finding> LabelPlan::findings() const {
  const LabelVolume& v = *found_.volume;
  std::vector<Finding> out;
  out.push_back({LabelWeight::kFine, "Volume",
                 shownNumbers("{}, {} x {} x {} voxels of {:.3g} x {:.3g} x {:.3g} mm", found_.format, v.size[0],
                              v.size[1], v.size[2], v.spacing[0], v.spacing[1], v.spacing[2])});
  const Vec3d size = found_.box.size();
  const double across = size.norm();
  out.push_back({across > 3 && across < 400 ? LabelWeight::kFine : LabelWeight::kDoubtful, "Size",
                 phrase("labelled region: {:.1f} x {:.1f} x {:.1f} mm", size[0], size[1], size[2])});
  const bool has_names = std::any_of(found_.labels.begin(), found_.labels.end(),
                                     [](const LabelFound& label) { return !label.name.empty(); });
  const std::string labels = fmt::format("{} label{}", found_.labels.size(), found_.labels.size() == 1 ? "" : "s");
  out.push_back(has_names
                    ? Finding{LabelWeight::kFine, "Labels", labels + ", tissues assigned by name: check them"}
                    : Finding{LabelWeight::kDoubtful, "Labels",
                              labels + " without names: Kerf cuts them as generic tissue unless you assign tissues"});
  if (isEmpty())
    out.push_back({LabelWeight::kDoubtful, "Tissue", "no label has a tissue: choose a tissue for at least one"});
  const double thinnest = v.spacing.minCoeff();
  if (voxel() > 1.01 * thinnest)
    out.push_back({LabelWeight::kDoubtful, "Voxels",
                   phrase("coarser than the volume, {:.3g} mm: thin parts are lost", thinnest)});
  return out;
}

// ---- Choices

std::optional<Material> LabelPlan::tissue(std::uint16_t label) const {
  const auto known = tissues_.find(label);
  return known == tissues_.end() ? std::nullopt : std::optional(known->second);
}

Expected<void> LabelPlan::setTissue(std::uint16_t label, const std::string& tissue) {
  std::string all;
  for (const LabelFound& known : found_.labels) all += (all.empty() ? "" : ", ") + std::to_string(known.label);
  if (std::none_of(found_.labels.begin(), found_.labels.end(), [&](const auto& l) { return l.label == label; }))
    return wrongLabels(fmt::format("label {}", label), "one of " + all);
  if (tissue == "none") {
    if (tissues_.erase(label) > 0) changed();
    return {};
  }
  const MaterialProperties* const row = materials_.find(tissue);
  if (!row) return wrongLabels("\"" + tissue + "\"", "none, or one of " + materials_.ids());
  if (this->tissue(label) == row->material) return {};
  tissues_[label] = row->material;
  changed();
  return {};
}

Expected<void> LabelPlan::setVoxel(double mm) {
  if (mm != 0 && !(mm >= ImportPlan::kFinestVoxel && mm <= ImportPlan::kCoarsestVoxel))
    return wrongLabels(fmt::format("a voxel of {:g} mm", mm),
                       fmt::format("{:g} to {:g} mm", ImportPlan::kFinestVoxel, ImportPlan::kCoarsestVoxel));
  voxel_mm_ = mm;
  return {};
}

double LabelPlan::suggestedVoxel() const { return voxelFor(areaMm2()); }

// ---- Results

double LabelPlan::areaMm2() const {
  constexpr double kStaircase = 1.5;  // mean area of voxel faces over the area of the surface
  if (preview()) return preview()->area_mm2;
  double faces = 0;
  for (const auto& [labels, mm2] : found_.walls_mm2)
    if (tissues_.count(labels.first) != tissues_.count(labels.second)) faces += mm2;
  return faces / kStaircase;
}

double LabelPlan::volumeMm3() const {
  double out = 0;
  for (const LabelFound& label : found_.labels)
    if (tissues_.count(label.label) > 0) out += label.volume_mm3;
  return out;
}

Prediction LabelPlan::prediction() const {
  // From one CT of a skull, 360 x 360 x 330 voxels: 66 s on two cores and 2.0 GB until the picture.
  constexpr double kSecondsPerVoxel = 2.5e-7, kBytesPerVoxel = 20;  // smoothing, in the box of the labelled voxels
  double voxels = found_.box.size().prod();
  for (const double mm : found_.volume->spacing) voxels /= mm;
  const double smoothing = previewSeconds() > 0 ? previewSeconds() : kSecondsPerVoxel * voxels;
  Prediction out = predict(areaMm2(), voxel(), found_.seconds + smoothing);
  out.bytes += 2 * static_cast<double>(voxelsOf(*found_.volume)) + kBytesPerVoxel * voxels;
  return out;
}

std::string LabelPlan::recipe() const {
  std::string out = "# Written by kerf-sim from the import settings of a label volume.\n";
  out += fmt::format("format = \"kerf-recipe\"\nversion = 1\nname = {}\nvoxel = {:g}\n",
                     quotedLabel(found_.file.stem().stem().string()), voxel());
  for (const LabelFound& label : found_.labels)
    if (const auto tissue = tissues_.find(label.label); tissue != tissues_.end()) {
      std::string called = label.called();
      std::replace_if(
          called.begin(), called.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
      out += fmt::format("\n[[part]]  # {}\nmaterial = \"{}\"\nlabel = {}\n", called,
                         materials_.find(tissue->second)->id, label.label);
    }
  std::error_code ignored;
  out += fmt::format("\n[labels]\nvolume = {}\n", quotedLabel(fs::absolute(found_.file, ignored).string()));
  return out;
}

// ---- The surface

bool LabelPlan::startsByItself() const { return !isEmpty() && voxelsOf(*found_.volume) <= kLabelsByItselfUpTo; }

std::unique_ptr<Job<ClosedPreview>> LabelPlan::makePreview() const {
  if (isEmpty()) return nullptr;
  Wanted wanted;
  for (const auto& [label, tissue] : tissues_) {
    wanted.labels.push_back(label);
    wanted.colours[label] = materials_.find(tissue)->color;
  }
  return std::make_unique<Job<ClosedPreview>>(
      "smoothing " + found_.file.filename().string(),
      [volume = found_.volume, wanted](const Progress& progress) { return surfaceOf(*volume, wanted, progress); });
}

}  // namespace kerf
