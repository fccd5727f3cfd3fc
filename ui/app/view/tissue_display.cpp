#include "ui/app/view/tissue_display.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "sim/live/chunk_occlusion.h"
#include "sim/run/session/watched_run.h"
#include "ui/app/base/language.h"

namespace kerf {
namespace {

constexpr auto kPause = std::chrono::milliseconds(250);  // between two meshings of the cut
constexpr double kContactRange = 3;                      // mm: as neighbourFields()
constexpr double kLeast = 1e-6;                          // mm^3: smaller volumes are no tissue
constexpr std::uint8_t kMapGloss = 40;                   // matte: shine would read as a value

double depthIn(const KeepOut& solid, const Vec3f& p) { return std::max(0.0, -static_cast<double>(solid.distance(p))); }

KeepOutOptions depthReach(double voxel) {
  KeepOutOptions out = keepOutReach(voxel);
  out.most_depth = out.most_distance;
  return out;
}

}  // namespace

double MapScale::shareOf(double mm) const {
  return std::clamp((has_bands ? kBand * std::floor(mm / kBand) : mm) / reach_mm, 0.0, 1.0);
}

MapScale scaleOf(SurfaceColours colours, MapScale scale) {
  if (colours == SurfaceColours::kContact)
    scale.reach_mm = std::clamp(scale.reach_mm, kLeastContactReach, kMostContactReach);
  return scale;
}

Rgba8 contactColour(double mm, const MapScale& scale, const Rgba8& usual) {
  using Colour = std::array<double, 3>;
  constexpr Colour kOverlap{216, 24, 40}, kDeep{96, 0, 28}, kTouch{255, 168, 24}, kNear{40, 104, 184};
  constexpr double kStrongest = 0.85;  // of blue
  const auto mixed = [&usual](const Colour& a, const Colour& b, double t) {
    Rgba8 out = usual;
    for (std::size_t k = 0; k < 3; ++k) out[k] = static_cast<std::uint8_t>(std::lround((1 - t) * a[k] + t * b[k]));
    return out;
  };
  const Colour plain{static_cast<double>(usual[0]), static_cast<double>(usual[1]), static_cast<double>(usual[2])};
  if (mm < 0) return mixed(kOverlap, kDeep, std::min(mm / kDeepOverlap, 1.0));
  if (mm <= kContactGap) return mixed(kTouch, kTouch, 0);
  return mixed(plain, kNear, kStrongest * (1 - scale.shareOf(mm)));
}

std::optional<MapLegend> legendOf(SurfaceColours colours, const MapScale& wanted) {
  const MapScale scale = scaleOf(colours, wanted);
  const std::string reach = phrase("{:g} mm or more", scale.reach_mm);
  if (colours == SurfaceColours::kDepth) return MapLegend{"Below the original surface", "0 mm", reach, colours, scale};
  if (colours == SurfaceColours::kDistance) return MapLegend{"To pulp or nerve canal", "0 mm", reach, colours, scale};
  if (colours != SurfaceColours::kContact) return {};
  MapLegend out{"To neighbours", phrase("{:g}", kDeepOverlap), reach, colours, scale};
  for (const auto& [share, mm] : {std::pair(0.25, 0.0), {0.5, kContactGap}})
    out.ticks.push_back({share, mm, phrase("{:g}", mm)});
  return out;
}

Rgba8 MapLegend::colourAt(double share) const {
  constexpr Rgba8 kIvory{224, 214, 194, 255};
  if (of == SurfaceColours::kContact) {
    Tick from{0, kDeepOverlap, {}}, to{1, scale.reach_mm, {}};
    for (const Tick& tick : ticks) {
      if (tick.share <= share) from = tick;
      if (tick.share > share && tick.share < to.share) to = tick;
    }
    return contactColour(std::lerp(from.mm, to.mm, (share - from.share) / (to.share - from.share)), scale, kIvory);
  }
  const double shown = scale.shareOf(share * scale.reach_mm);
  return mapColour(of == SurfaceColours::kDistance ? 1 - shown : shown);
}

TissueSource tissueSourceOf(LiveRun& run, std::shared_ptr<const Structures> structures) {
  TissueSource out;
  out.view = [&run] { return run.viewScene(); };
  out.edits = [&run] { return run.editsDone(); };
  out.objects_now = [&run]() -> std::size_t { return run.thread().report().object_count; };
  out.object = run.sharedObject();
  for (const LiveNeighbour& other : run.neighbours()) out.beside.push_back(other.object);
  out.original = run.original();
  out.structures = std::move(structures);
  out.scan = run.scanColours();
  out.has_scan_colours = run.hasScanColours();
  return out;
}

TissueSource tissueSourceOf(const WatchedRun& run) {
  TissueSource out;
  out.view = [&run] { return run.viewScene(); };
  out.edits = [&run] { return run.editsDone(); };
  out.objects_now = [&run]() -> std::size_t { return run.moment().report.object_count; };
  out.object = run.objects().front();
  out.beside.assign(run.objects().begin() + 1, run.objects().end());
  out.original = run.original();
  out.structures = run.structures();
  out.scan = run.scanColours();
  out.has_scan_colours = run.hasScanColours();
  return out;
}

// ---- Calls by the workbench

void TissueDisplay::opened(TissueSource source, const MaterialTable& materials) {
  closing();
  source_ = std::move(source);
  labels_ = TissueLabels::of(*source_->object);
  for (const auto& other : source_->beside) labels_beside_.push_back(TissueLabels::of(*other));
  palette_.emplace(materials);
  const std::array<double, 256>& volumes = source_->object->volumes();
  for (const MaterialProperties& row : materials.rows()) {
    const auto number = static_cast<std::size_t>(row.material);
    if (number >= volumes.size() || volumes[number] < kLeast) continue;
    tissues_.push_back({row.material, row.id, row.name, row.color, volumes[number], TissueLook::kShow});
  }
  // An object of several tissues opens in tissue colours: a scan's colours do not show caries in enamel.
  const bool begins_with_scan = source_->has_scan_colours && tissues_.size() <= 1;
  colours_ = wanted_colours_ = begins_with_scan ? SurfaceColours::kScan : SurfaceColours::kTissue;
}

void TissueDisplay::closing() {
  TissueDisplay closed;
  closed.colours_version_ = colours_version_ + 1;
  closed.ending_ = std::move(ending_);
  if (meshing_) closed.ending_.push_back(std::move(meshing_));
  if (measuring_) closed.ending_.push_back(std::move(measuring_));
  if (measuring_contacts_) closed.ending_.push_back(std::move(measuring_contacts_));
  if (loading_) closed.ending_.push_back(std::move(loading_));
  for (const auto& job : closed.ending_) job->cancel();
  *this = std::move(closed);
}

Expected<void> TissueDisplay::update() {
  std::erase_if(ending_, [](const std::unique_ptr<AnyJob>& job) { return job->isOver(); });
  if (!source_) return {};
  if (measuring_ && measuring_->isOver()) KERF_CHECK(takeDepths());
  if (measuring_contacts_ && measuring_contacts_->isOver()) KERF_CHECK(takeContacts());
  if (loading_ && loading_->isOver()) {
    KERF_TRY(made, std::exchange(loading_, nullptr)->take());
    as_loaded_ = std::make_unique<std::vector<MeshChunkPtr>>(std::move(made));
  }
  if (meshing_ && meshing_->isOver()) KERF_CHECK(takeMeshed());
  is_dropped_ |= meshing_ && areAllShown();  // the window has dropped the chunks handed out
  if (meshing_) return {};
  if (areAllShown()) {
    meshers_.reset();
    parts_of_.reset();
    return {};
  }

  const bool is_asked = !meshers_ || meshers_->of != wanted();
  const bool is_outdated = source_->edits() != meshed_edits_ || source_->objects_now() != meshed_objects_;
  if (is_asked || (is_outdated && std::chrono::steady_clock::now() >= next_)) startMeshing();
  return {};
}

bool TissueDisplay::isBusy() const {
  if (!source_) return false;
  return meshing_ || measuring_ || measuring_contacts_ || loading_ || (!areAllShown() && parts_of_ != wanted());
}

// ---- Tissue looks

Expected<void> TissueDisplay::set(const std::string& id, TissueLook look) {
  std::string ids;
  for (SeenTissue& tissue : tissues_) {
    if (tissue.id == id || tissue.name == id) {
      tissue.look = look;
      return {};
    }
    ids += (ids.empty() ? "" : ", ") + tissue.id;
  }
  return fail({.code = Error::Code::kBadValue,
               .found = fmt::format("\"{}\"", id),
               .expected = ids.empty() ? "an object with tissues" : "one of " + ids});
}

void TissueDisplay::showAll() {
  for (SeenTissue& tissue : tissues_) tissue.look = TissueLook::kShow;
}

TissueChoices TissueDisplay::choices() const {
  TissueChoices out{wanted_colours_, {}, scale_};
  for (const SeenTissue& tissue : tissues_)
    if (tissue.look != TissueLook::kShow) out.looks.emplace_back(tissue.id, tissue.look);
  return out;
}

void TissueDisplay::choose(const TissueChoices& choices) {
  for (const auto& [id, look] : choices.looks) (void)set(id, look);
  (void)setColours(choices.colours);
  setMapScale(choices.scale);
}

bool TissueDisplay::areAllShown() const {
  return std::all_of(tissues_.begin(), tissues_.end(), [](const SeenTissue& t) { return t.look == TissueLook::kShow; });
}

TissueDisplay::Wanted TissueDisplay::wanted() const {
  Wanted out;
  out.solid.set();
  TissueSet not_hidden = out.solid;
  for (const SeenTissue& tissue : tissues_) {
    const auto number = static_cast<std::size_t>(tissue.material);
    if (tissue.look != TissueLook::kShow) out.solid.reset(number);
    if (tissue.look == TissueLook::kHide) not_hidden.reset(number);
  }
  out.is_own_ghost = not_hidden.all() && !out.solid.all();
  if (not_hidden != out.solid && !out.is_own_ghost) out.ghost = not_hidden;
  return out;
}

bool TissueDisplay::hasPart(TissuePart part) const {
  if (areAllShown() || !parts_of_) return false;
  return part == TissuePart::kSolid || parts_of_->ghost.any();
}

bool TissueDisplay::isOwnSurfaceGhost() const { return hasPart(TissuePart::kSolid) && parts_of_->is_own_ghost; }

// As LiveRun::chooseColours().
RemesherOptions TissueDisplay::colouring() const {
  RemesherOptions out;
  out.finish = [object = source_->object, labels = *labels_, palette = *palette_, scan = source_->scan,
                original = source_->original](MeshChunk& chunk, const OverlayField& field) {
    chunk.colours = tissueColours(chunk, labels, palette);
    if (scan) chunk.scan_colours = scanColours(chunk, *scan, *original);
    chunk.occlusion = occlusionOf(chunk, field);
  };
  return out;
}

void TissueDisplay::startMeshing() {
  auto view = source_->view();
  if (!view) return;
  if (!meshers_ || meshers_->of != wanted()) {
    meshers_ = std::make_shared<Meshers>();
    meshers_->of = wanted();
  }
  meshed_edits_ = source_->edits();
  meshed_objects_ = view->objects.size();
  meshing_ = std::make_unique<Job<Changes>>(
      "tissues", [view = std::move(*view), meshers = meshers_, options = colouring(), loaded = source_->object](
                     const Progress& progress) { return meshed(view, *meshers, *loaded, options, progress); });
}

Expected<TissueDisplay::Changes> TissueDisplay::meshed(const SceneView& view, Meshers& meshers,
                                                       const BakedObject& loaded, const RemesherOptions& options,
                                                       const Progress& progress) {
  Changes out;
  KERF_TRY(scene, LiveRun::copyOf(view));
  for (const SceneCopy::Object& object : scene.objects) {
    if (object.loaded > 0) continue;  // neighbours keep their own surface
    for (const TissuePart part : {TissuePart::kSolid, TissuePart::kGhost}) {
      const TissueSet& of = part == TissuePart::kSolid ? meshers.of.solid : meshers.of.ghost;
      if (part == TissuePart::kGhost && of.none()) continue;
      if (!report(progress, 0, object.name)) return cancelled();

      const auto key = std::pair(object.id, part);
      auto known = meshers.all.find(key);
      const bool is_new = known == meshers.all.end();
      if (is_new) {
        const BrickField& begin = object.begin ? *object.begin : loaded.phi0();
        auto made = std::make_unique<TissueMesher>(loaded, of, begin, options);
        known = meshers.all.emplace(key, std::move(made)).first;
      }
      std::vector<MeshChunkPtr> chunks = known->second->update(object.changed);
      if (is_new || !chunks.empty()) out.push_back({object.id, part, is_new, std::move(chunks)});
    }
  }
  return out;
}

Expected<void> TissueDisplay::takeMeshed() {
  auto changes = std::exchange(meshing_, nullptr)->take();
  next_ = std::chrono::steady_clock::now() + kPause;
  if (!changes) {
    // A piece was joined again meanwhile: the next view of the scene lacks it.
    meshers_.reset();
    if (changes.error().code == Error::Code::kNotFound) {
      meshed_edits_ = 0;
      return {};
    }
    showAll();
    return fail(std::move(changes).error());
  }
  if (std::exchange(is_dropped_, false)) {
    meshers_.reset();
    parts_of_.reset();
    return {};
  }
  parts_of_ = meshers_->of;
  std::move(changes->begin(), changes->end(), std::back_inserter(changes_));
  return {};
}

std::vector<TissueDisplay::Change> TissueDisplay::takeChanges() { return std::exchange(changes_, {}); }

// ---- As loaded

void TissueDisplay::showAsLoaded(bool is_shown) {
  is_as_loaded_shown_ = is_shown && source_;
  if (!is_as_loaded_shown_ || as_loaded_ || loading_) return;
  loading_ = std::make_unique<Job<std::vector<MeshChunkPtr>>>(
      "as loaded",
      [original = source_->original, options = colouring()](const Progress&) -> Expected<std::vector<MeshChunkPtr>> {
        return Remesher(*original, options).changedSince(0);
      });
}

// ---- Colours

TissueSection TissueDisplay::sectionAt(const Plane& plane, std::size_t beside) const {
  if (!labels_ || beside > labels_beside_.size()) return {};
  return tissueSection(plane, beside == 0 ? *labels_ : labels_beside_[beside - 1], *palette_);
}

Expected<void> TissueDisplay::setColours(SurfaceColours colours) {
  if (!source_) return {};
  if (colours == SurfaceColours::kDistance && source_->structures->isEmpty())
    return fail({.code = Error::Code::kUnsupported,
                 .found = "no pulp and no nerve canal in the open object",
                 .expected = "a case with a pulp or a nerve canal",
                 .hint = "view.colours depth"});
  if (colours == SurfaceColours::kScan && !hasScanColours())
    return fail({.code = Error::Code::kUnsupported,
                 .found = "no colours in the open scan",
                 .expected = "a scan with vertex or face colours, from PLY, OBJ, OFF or 3MF",
                 .hint = "view.colours tissue"});
  if (colours == SurfaceColours::kContact && !hasNeighbours())
    return fail({.code = Error::Code::kUnsupported,
                 .found = "no neighbour of the open object",
                 .expected = "another jaw or tooth beside it",
                 .hint = "open both files together, or use file.open-beside"});
  wanted_colours_ = colours;
  if (colours == SurfaceColours::kContact && source_->beside_fields.empty()) {  // update() continues
    if (!measuring_contacts_)
      measuring_contacts_ = std::make_unique<Job<Fields>>(
          "contacts", [beside = source_->beside](const Progress& progress) -> Expected<Fields> {
            Fields out;
            for (const auto& object : beside) {
              KeepOutOptions reach = depthReach(object->voxel());
              reach.most_distance = reach.most_depth = std::min(reach.most_distance, kContactRange);
              KERF_TRY(field, KeepOut::ofSolid(*object, reach, progress));
              out.push_back(std::move(field));
            }
            return out;
          });
    return {};
  }
  if (colours == SurfaceColours::kDepth && !depths_) {  // update() continues
    if (!measuring_)
      measuring_ = std::make_unique<Job<Depths>>(
          "depths", [original = source_->original](const Progress& progress) -> Expected<Depths> {
            KERF_TRY(object, BakedObject::make(*original, static_cast<const MaterialField*>(nullptr)));
            return KeepOut::ofSolid(*object, depthReach(object->voxel()), progress);
          });
    return {};
  }
  colours_ = colours;
  ++colours_version_;
  return {};
}

void TissueDisplay::setMapScale(const MapScale& scale) {
  if (std::exchange(scale_, scale) != scale) ++colours_version_;
}

Expected<void> TissueDisplay::takeDepths() {
  auto depths = std::exchange(measuring_, nullptr)->take();
  if (!depths) return fail(std::move(depths).error());
  depths_ = std::move(*depths);
  return setColours(wanted_colours_);
}

Expected<void> TissueDisplay::takeContacts() {
  auto fields = std::exchange(measuring_contacts_, nullptr)->take();
  if (!fields) return fail(std::move(fields).error());
  source_->beside_fields = std::move(*fields);
  return setColours(wanted_colours_);
}

std::optional<double> TissueDisplay::toNeighbours(const Vec3d& world) const {
  std::optional<double> out;
  if (!source_) return out;
  for (const Depths& field : source_->beside_fields) {
    const double distance = field->distance(world.cast<float>());
    out = std::min(out.value_or(distance), distance);
  }
  return out;
}

// 1 at the structure, 0 at the reach of the map or of the measurement.
double TissueDisplay::nearness(const Vec3d& p) const {
  constexpr double kRounding = 1e-4;  // mm
  const double distance = source_->structures->distance(p);
  return distance >= source_->structures->reach() - kRounding ? 0 : 1 - scale_.shareOf(distance);
}

const std::vector<Rgba8>& TissueDisplay::coloursBeside(const MeshChunk& chunk) const {
  return colours_ == SurfaceColours::kScan && !chunk.scan_colours.empty() ? chunk.scan_colours : chunk.colours;
}

std::vector<Rgba8> TissueDisplay::coloursOf(const MeshChunk& chunk, const Rigid3& T_world_object) const {
  if (colours_ == SurfaceColours::kContact) {
    std::vector<Rgba8> out = chunk.colours;
    const MapScale scale = scaleOf(colours_, scale_);
    for (std::size_t v = 0; v < out.size(); ++v) {
      const double mm = toNeighbours(T_world_object * Vec3d(chunk.vertices[v].cast<double>())).value_or(kContactRange);
      out[v] = contactColour(mm, scale, out[v]);
      if (mm < scale.reach_mm) out[v][3] = kMapGloss;
    }
    return out;
  }
  if (colours_ == SurfaceColours::kTissue || colours_ == SurfaceColours::kScan) return coloursBeside(chunk);
  std::vector<Rgba8> out;
  out.reserve(chunk.vertices.size());
  for (const Vec3f& p : chunk.vertices) {
    const double share =
        colours_ == SurfaceColours::kDepth ? scale_.shareOf(depthIn(*depths_, p)) : nearness(p.cast<double>());
    Rgba8 colour = mapColour(share);
    colour[3] = kMapGloss;
    out.push_back(colour);
  }
  return out;
}

}  // namespace kerf
