#include "sim/run/cut/haptic_cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "geometry/base/atomic_file.h"
#include "geometry/field/vdb_io.h"
#include "geometry/tool/handpiece.h"
#include "sim/hand/device_profile.h"
#include "sim/monitor/monitor.h"
#include "sim/pieces/joined_field.h"
#include "sim/run/cut/cut_observer.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_output.h"
#include "sim/run/files/small_cut.h"
#include "sim/run/scene/cut_scene.h"
#include "sim/run/session/added_materials.h"
#include "sim/run/session/session_pieces.h"
#include "sim/run/sweep/sweep_cutter.h"
#include "sim/run/sweep/tool_resolution.h"
#include "sim/session/session.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::Bodies;
using internal::CutInputs;
using internal::CutObservers;
using internal::CutScene;
using internal::nothingWritten;

constexpr std::uint64_t kSnapshotTicks = 10'000;  // between two snapshots in the log, at least

DeviceProfile profileOf(const DeviceHand::Options& device) {
  DeviceProfile profile;
  profile.delay_s = device.delay_ticks * kTick;
  profile.mass_kg = device.mass_kg;
  profile.friction = device.friction;
  profile.encoder_mm = device.encoder_mm;
  return profile;
}

StepSettings settingsOf(const HapticCutOptions& options) {
  StepSettings settings = options.step;
  if (options.hand == HandKind::kDevice)
    settings.coupling = couplingFor(profileOf(options.device), options.step.coupling).settings;
  if (options.hand == HandKind::kForce) settings.coupling.stiffness = ForceHand::kStiffness;
  settings.rendering = options.hand == HandKind::kFeed ? Rendering::kRigid : Rendering::kCoupled;
  return settings;
}

std::unique_ptr<VirtualHand> makeHand(const CutPath& path, const HapticCutOptions& o, const Model& model) {
  switch (o.hand) {
    case HandKind::kForce: {
      ForceHand::Options force = o.force;
      force.free_speed = o.add.empty() ? o.spindle * model.tools[0].drive.speed : 0;
      return std::make_unique<ForceHand>(path, model.settings.coupling, force);
    }
    case HandKind::kDevice:
      return std::make_unique<DeviceHand>(path, o.device);
    default:
      return std::make_unique<FeedHand>(path);
  }
}

// Makes the tool add this material to the case from the first tick on; empty: it cuts.
Expected<void> chooseMaterial(Session& session, const MaterialTable& materials, const std::string& id) {
  if (id.empty()) return {};
  auto row = materials.require(id);
  if (!row) {
    row.error().place = "--add";
    return fail(std::move(row).error());
  }
  if (session.apply(AddMaterial{static_cast<std::uint8_t>(row->material), 0})) return {};
  return fail({.code = Error::Code::kBadValue,
               .place = "--add",
               .found = "\"" + id + "\"",
               .expected = "a material that can be cut",
               .hint = "another id, or contact stiffness and cutting energy in its row of materials.toml"});
}

// ---- Simulate

// Course of a simulation.
struct Simulated {
  std::uint64_t ticks = 0;
  double removed_mm3 = 0, added_mm3 = 0;  // of the case
  double short_of_end_mm = 0;
  bool is_complete = false, is_out_of_time = false;
  std::string ended;
};

// Why the virtual hand gives no more samples.
void endByHand(const VirtualHand& hand, const HapticCutOptions& options, Simulated& end) {
  const auto* force = dynamic_cast<const ForceHand*>(&hand);
  end.is_complete = !(force && force->gaveUp());
  end.ended = end.is_complete ? "end of the path"
                              : fmt::format("no progress in {} s at {} N", options.force.patience, options.force.force);
}

// Ticks until the hand is done or the time is over, and shows each tick to the observers.
Expected<Simulated> simulate(Session& session, const CutInputs& inputs, const HapticCutOptions& options,
                             CutObservers& observers, const Progress& progress) {
  const std::unique_ptr<VirtualHand> hand = makeHand(inputs.path, options, session.model());
  const auto limit = static_cast<std::uint64_t>(options.time_limit / kTick);
  Simulated out;
  DeviceSample sample;
  StepOutput tick;
  tick.T_world_tool = session.state().body.pose;

  while (true) {
    if (out.ticks % 64 == 0 && !report(progress, 0.05 + 0.85 * hand->progress(), "cutting")) return nothingWritten();
    if (out.ticks >= limit) {
      out.ended = fmt::format("time limit of {} s", options.time_limit);
      out.is_out_of_time = true;
      break;
    }
    if (!hand->next(tick, sample)) {
      endByHand(*hand, options, out);
      break;
    }
    sample.pedal *= options.is_reversed ? -options.spindle : options.spindle;
    sample.irrigation = options.irrigation;
    session.tick(sample, tick);
    ++out.ticks;
    if (tick.status & kStepBadSample)
      return fail({.code = Error::Code::kBadValue,
                   .file = inputs.path_file.string(),
                   .place = fmt::format("t = {} s", static_cast<double>(out.ticks) * kTick),
                   .found = "a pose that is not finite",
                   .expected = "finite poses"});

    const auto& objects = session.state().objects;
    out.removed_mm3 = 0;
    for (const CutObject& object : objects)
      if (session.loadedIndexOf(object) == 0) out.removed_mm3 += internal::sumOf(object.removed_mm3);
    out.added_mm3 += tick.added_mm3;
    observers.tick({.sample = sample,
                    .output = tick,
                    .objects = objects,
                    .ticks = out.ticks,
                    .removed_mm3 = out.removed_mm3,
                    .added_mm3 = out.added_mm3});
  }
  session.finish();
  const Vec3d& end = inputs.path.poses.back().T_object_tool.translation;
  out.short_of_end_mm = std::max(hand->left(), (tick.T_world_tool.translation - end).norm());
  return out;
}

// ---- Summarise

// The field of the case in the bricks that differ from the loaded state.
BrickField changesOfCase(const Session& session) {
  const internal::Objects objects = internal::objectsOf(session, 0);
  if (!internal::isInPieces(objects)) return objects.front()->bricks().changedField();
  const std::vector<BrickField> fields = internal::fieldsOf(objects);
  std::vector<FieldPart> parts;
  for (const BrickField& field : fields) parts.push_back({.begin = &field});
  return joinedChanges(objects.front()->baked().phi0(), parts);
}

// The fields of the case and its neighbours in the bricks that changed. Error kEmpty: nothing of the case changed.
Expected<std::vector<BrickField>> changedFields(const Session& session, const CutScene& scene,
                                                const HapticCutOptions& options, const Simulated& simulated,
                                                const Bodies& bodies) {
  const bool is_adding = !options.add.empty();
  const bool only_rubs = options.is_reversed && !scene.model.tools.front().cuts_backwards;
  std::vector<BrickField> changed{changesOfCase(session)};
  for (std::size_t n = 1; n < scene.objects.size(); ++n)
    changed.push_back(session.state().objects[n].bricks().changedField());
  // A split changes nodes away from any surface.
  const bool is_in_pieces = internal::isInPieces(internal::objectsOf(session, 0));
  const bool is_cut =
      is_in_pieces ? simulated.removed_mm3 != 0 || simulated.added_mm3 != 0 : !changed.front().isEmpty();
  if (is_cut) return changed;

  const std::string nothing = fmt::format("tool {} {} nothing{}", scene.inputs.tool.id, is_adding ? "added" : "cut",
                                          scene.objects.size() > 1 ? " of the case that is to be cut" : "");
  if (only_rubs)
    return fail({.code = Error::Code::kEmpty,
                 .file = scene.inputs.path_file.string(),
                 .found = nothing,
                 .expected = "a tool that cuts in this direction",
                 .hint = "omit --reverse: in reverse this tool only rubs"});
  if (simulated.is_out_of_time)
    return fail({.code = Error::Code::kEmpty,
                 .file = scene.inputs.path_file.string(),
                 .found = fmt::format("{} within the {}", nothing, simulated.ended),
                 .expected = "a tool that reaches the case in that time",
                 .hint = "a longer --time-limit"});
  if (!simulated.is_complete)
    return fail({.code = Error::Code::kEmpty,
                 .file = scene.inputs.path_file.string(),
                 .found = fmt::format("{}: {}", nothing, simulated.ended),
                 .expected = "a hand that makes progress",
                 .hint = "a faster --spindle, another --drive, more --push, or more --patience"});
  return fail({.code = Error::Code::kEmpty,
               .file = scene.inputs.path_file.string(),
               .found = nothing,
               .expected = internal::throughBodies(bodies, scene.inputs.manifests.front().box),
               .hint = options.step.response == Response::kPenalty || !isPointed(scene.inputs.tool)
                           ? "check the path's frame and unit, the spindle and the force"
                           : "omit --response: with this one a thin point passes through without cutting. Or check the "
                             "path's frame and unit, the spindle and the force"});
}

// Planned volume of a body: the cutting part swept along the path, without resistance.
Expected<BrickField> planOf(const Bodies::Body& body, const CutScene& scene, const Progress& progress) {
  const CutPath whole = internal::pathInFrame(scene.inputs.path, body.T_world_body);
  const MergedPath merged = mergedFor(*scene.inputs.tool.cut, whole, body.begin->voxel());
  const CutPath& path = merged.path;
  SweepCutter cutter(*body.begin);
  for (std::size_t n = 0; n + 1 < path.poses.size(); ++n) {
    const double done = static_cast<double>(n) / static_cast<double>(path.poses.size());
    if (n % 16 == 0 && !report(progress, 0.9 + 0.02 * done, "comparing with the path")) return nothingWritten();
    if (path.cuts[n])
      cutter.advance(SweptTool(*scene.inputs.tool.cut, path.poses[n].T_object_tool, path.poses[n + 1].T_object_tool));
  }
  return cutter.cutField();
}

// The planned volume, and its removed part.
Expected<void> compareWithPath(const Session& session, const CutScene& scene, const Bodies& bodies,
                               const BrickField& changed, HapticSummary& summary, const Progress& progress) {
  const internal::Objects objects = internal::objectsOf(session, 0);
  internal::VolumeByNumber planned{};
  for (std::size_t n = 0; n < bodies.all.size(); ++n) {
    const BrickField& begin = *bodies.all[n].begin;
    KERF_TRY(plan, planOf(bodies.all[n], scene, progress));
    const auto of_body = internal::removedVolumes(begin, plan, internal::materialsOf(scene.object()));
    for (std::size_t m = 0; m < planned.size(); ++m) planned[m] += of_body[m];
    summary.reached_mm3 += internal::commonVolume(begin, plan, bodies.isInPieces() ? fieldOf(*objects[n]) : changed);
  }
  summary.planned_mm3 = internal::sumOf(planned);
  summary.planned_by_material = internal::byMaterial(planned, scene.materials);
  return {};
}

// Depth of the tip, or of the middle of the cutting part, in the case at the start of the path, mm; at most the field's
// band.
double depthAtStart(const CutScene& scene, const Bodies& bodies) {
  double deepest = 0;
  for (const Bodies::Body& body : bodies.all) {
    const Rigid3 start = body.T_world_body.inverse() * scene.inputs.path.poses.front().T_object_tool;
    for (const Vec3d& p : {Vec3d(Vec3d::Zero()), Vec3d(scene.inputs.tool.cut->bounds().center())}) {
      const Vec3d node = (start * p / body.begin->voxel()).array().round();
      deepest = std::max(deepest, -static_cast<double>(body.begin->at(node.cast<int>())));
    }
  }
  return deepest;
}

// @param tool  in the requested handpiece.
CutSettings recordOf(const HapticCutOptions& options, const Tool& tool) {
  CutSettings out;
  out.hand = nameOf(options.hand);
  out.response = rowOf(options.step.response).name;
  out.drive = describeDrive(tool);
  out.spindle = options.spindle;
  out.is_reversed = options.is_reversed;
  out.irrigation = options.irrigation;
  out.added = options.add;
  if (options.hand == HandKind::kForce) {
    out.push = options.force.force;
    out.feed_limit = options.force.feed_limit;
    out.patience = options.force.patience;
  }
  if (options.hand == HandKind::kDevice) out.device = options.device;
  return out;
}

HapticSummary summarise(const Session& session, const CutScene& scene, const Simulated& simulated,
                        const CutObservers& observers, const BrickField& changed) {
  HapticSummary out;
  out.ticks = simulated.ticks;
  out.seconds = static_cast<double>(simulated.ticks) * kTick;
  out.is_complete = simulated.is_complete;
  out.ended = simulated.ended;
  out.short_of_end_mm = simulated.short_of_end_mm;
  const StepSettings& settings = session.model().settings;
  if (settings.rendering == Rendering::kCoupled) out.coupling = settings.coupling.stiffness;

  out.initial_mm3 = internal::sumOf(scene.object().volumes());
  out.initial_by_material = internal::byMaterial(scene.object().volumes(), scene.materials);
  internal::VolumeByNumber removed{}, added{};
  for (const CutObject* const object : internal::objectsOf(session, 0)) {
    out.remaining_mm3 += internal::sumOf(object->bricks().countVolumes());
    for (std::size_t m = 0; m < removed.size(); ++m) {
      removed[m] += object->removed_mm3[m];
      added[m] += object->added_mm3[m];
    }
  }
  out.removed_mm3 = simulated.removed_mm3;
  out.removed_uncertainty_mm3 = volumeUncertainty(scene.object().voxel());
  out.added_mm3 = simulated.added_mm3;
  out.removed_by_material = internal::byMaterial(removed, scene.materials);
  out.added_by_material = internal::byMaterial(added, scene.materials);
  out.state_hash = fmt::format("{:016x}", session.hash());

  observers.addTo(out, session.state().objects);
  const internal::PieceCount count = internal::countPieces(scene.object().phi0(), changed);
  out.pieces = count.pieces;
  out.crumbs = count.crumbs;
  return out;
}

// ---- Write

RunManifest manifestOf(const CutScene& scene, const HapticSummary& summary) {
  const CutInputs& inputs = scene.inputs;
  RunManifest m;
  m.mode = kModeHaptic;
  m.case_path = inputs.paths.front();
  m.case_id = inputs.manifests.front().id;
  internal::addMotions(inputs.path, m);
  m.duration_s = summary.seconds;
  m.voxel_mm = scene.object().voxel();
  m.state_hash = summary.state_hash;
  for (std::size_t n = 1; n < scene.objects.size(); ++n) {
    // Rounding must not make a manifest that its reader rejects.
    const double removed = std::max(summary.beside[n - 1].removed_mm3, 0.0);
    m.beside.push_back({inputs.paths[n], inputs.manifests[n].id, scene.objects[n]->voxel(), removed});
    if (n >= scene.originals.size()) continue;
    RunManifest::Beside& other = m.beside.back();
    const RunManifest::Beside& before = inputs.before.beside[n - 1];
    other.name = before.name;
    other.has_begin = true;
    other.removed_mm3 += before.removed_mm3;
  }
  return m;
}

// Writes fields, summary and manifest; the observers have written their files.
Expected<void> writeRun(const fs::path& staging, const CutInputs& inputs, const std::vector<BrickField>& changed,
                        const MaterialBricks& added, HapticCut& cut) {
  std::vector<NamedField> fields{{"phi", &changed.front()}};
  for (std::size_t n = 1; n < changed.size(); ++n) fields.push_back({neighbourId(n), &changed[n]});
  KERF_CHECK(writeVdb(staging / internal::kRunField, fields, {{"case_id", cut.manifest.case_id}}, &added));

  KERF_TRY(summary, AtomicFile::create(staging / internal::kRunSummary));
  summary.stream() << toJson(cut.summary) << "\n";
  KERF_CHECK(summary.commit());
  return internal::finishRun(staging, inputs.tool, inputs.tool_file, inputs.path_file, cut.manifest);
}

// Speed and torque in the tool's file belong to its own handpiece.
Expected<void> takeHandpiece(Tool& tool, const std::string& name) {
  if (name.empty()) return {};
  const Handpiece* handpiece = findHandpiece(name);
  const auto refuse = [&](std::string expected) {
    return fail({.code = Error::Code::kBadValue,
                 .place = "--drive",
                 .found = fmt::format("\"{}\" for {}", name, tool.id),
                 .expected = std::move(expected),
                 .hint = "kerf tool info " + tool.id});
  };
  if (!handpiece) return refuse(fmt::format("one of {}", handpieceNames()));
  if (motionOf(tool) != ToolMotion::kSpin) return refuse("a rotating tool: the file of a saw sets its drive");
  if (handpiece->is_fast && !isFrictionGrip(tool))
    return refuse("a bur with a friction-grip shank: other shanks are not made for that speed");
  tool.drive.handpiece = handpiece;
  tool.drive.frequency_hz.reset();
  tool.drive.stall_load.reset();
  tool.drive.time_constant_s.reset();
  return {};
}

Expected<void> checkReverse(const Tool& tool, bool is_reversed) {
  if (!is_reversed || turnsBackwards(driveOf(tool).form)) return {};
  return fail({.code = Error::Code::kBadValue,
               .place = "--reverse",
               .found = fmt::format("{}, whose drive has no reverse: {}", tool.id, describeDrive(tool)),
               .expected = "a tool with a motor",
               .hint = isFrictionGrip(tool) ? "--drive electric" : "omit --reverse"});
}

}  // namespace

Expected<void> checkOptions(const HapticCutOptions& o) {
  struct Range {
    const char* name;
    double value, low, high;
    const char* unit;
  };
  const Range ranges[] = {
      {"--push", o.force.force, 0.01, o.step.coupling.force_limit, "N"},
      {"--feed-limit", o.force.feed_limit, 0.01, 1000, "mm/s"},
      {"--spindle", o.spindle, 0, 1, "of nominal"},
      {"--irrigation", o.irrigation, 0, 1, "of full irrigation"},
      {"--coupling", o.step.coupling.stiffness, 0.01, 100, "N/mm"},
      {"coupling damping", o.step.coupling.damping, 0, 1, "N s/mm"},
      {"--device-mass", o.device.mass_kg, 0.001, 10, "kg"},
      {"--device-damping", o.device.damping, 0, 1, "N s/mm"},
      {"--device-friction", o.device.friction, 0, 10, "N"},
      {"--encoder", o.device.encoder_mm, 0, 1, "mm"},
      {"--delay", static_cast<double>(o.device.delay_ticks), 0, 50, "ticks"},
      {"--hand-stiffness", o.device.hand_stiffness, 0, 100, "N/mm"},
      {"--hand-damping", o.device.hand_damping, 0, 1, "N s/mm"},
      {"--patience", o.force.patience, 0.001, 86400, "s"},
      {"coupling mass", o.step.coupling.mass_kg, 0.0001, 10, "kg"},
      {"coupling filter", o.step.coupling.filter_hz, 0.1, 1000, "Hz"},
      {"ramp", o.step.ramp_s, 0, 60, "s"},
      {"contact evaluations per tick", static_cast<double>(o.step.most_substeps), 1, 1000, ""},
      {"--time-limit", o.time_limit, 0.001, 86400, "s"},
  };
  for (const Range& r : ranges)
    if (!(r.value >= r.low && r.value <= r.high))
      return fail({.code = Error::Code::kBadValue,
                   .place = r.name,
                   .found = fmt::format("{} {}", r.value, r.unit),
                   .expected = fmt::format("{} to {} {}", r.low, r.high, r.unit)});

  if (o.hand == HandKind::kFeed && !rowOf(o.step.response).fits(Rendering::kRigid))
    return fail({.code = Error::Code::kBadValue,
                 .place = "--response",
                 .found = "another response, with a hand that follows its path",
                 .expected = "penalty: a tool that follows its path exactly cannot be held back",
                 .hint = "hand force or device"});
  return {};
}

Expected<HapticCut> cutCaseByHand(const fs::path& case_folder, const fs::path& tool_file, const fs::path& path_file,
                                  const fs::path& run_folder, const HapticCutOptions& options,
                                  const Progress& progress) {
  // Load.
  KERF_CHECK(checkOptions(options));
  KERF_TRY(inputs, internal::readInputs(case_folder, options.beside, tool_file, path_file, run_folder));
  KERF_CHECK(takeHandpiece(inputs.tool, options.drive));
  KERF_CHECK(checkReverse(inputs.tool, options.is_reversed));
  KERF_TRY(folder, AtomicFolder::create(run_folder, options.overwrite, kRunManifest));
  if (!report(progress, 0.0, "loading the case")) return nothingWritten();
  KERF_TRY(scene, internal::loadScene(std::move(inputs), settingsOf(options)));
  if (!report(progress, 0.03, "measuring distances")) return nothingWritten();
  KERF_TRY(observers, CutObservers::make(scene, options, folder.staging(), run_folder));

  // Simulate.
  Session session(scene.model, scene.objects, scene.start(), &observers.log());
  session.snapshotEvery(kSnapshotTicks);
  const internal::PiecesPutBack pieces = internal::putPiecesBack(session, scene.inputs.before.pieces);
  const Bodies bodies = internal::bodiesOf(session);
  KERF_CHECK(chooseMaterial(session, scene.materials, options.add));
  KERF_TRY(simulated, simulate(session, scene.inputs, options, observers, progress));
  KERF_CHECK(observers.close());

  // Summarise.
  KERF_TRY(changed, changedFields(session, scene, options, simulated, bodies));
  HapticCut out;
  out.summary = summarise(session, scene, simulated, observers, changed.front());
  out.summary.began_inside_mm = depthAtStart(scene, bodies);
  out.summary.settings = recordOf(options, scene.inputs.tool);
  out.manifest = manifestOf(scene, out.summary);
  out.manifest.missing_pieces = pieces.missing;
  out.manifest.added_before_mm3 = scene.added_before_mm3;
  if (bodies.isInPieces()) out.summary.findings.comes_out_at.reset();  // valid only for a case in one piece
  if (options.add.empty()) KERF_CHECK(compareWithPath(session, scene, bodies, changed.front(), out.summary, progress));
  if (options.hand == HandKind::kDevice)
    out.summary.coupling_text =
        describeStiffness(couplingFor(profileOf(options.device), options.step.coupling), options.step.coupling);
  out.left_region_unused = scene.inputs.manifests.front().region.has_value();

  // Write.
  if (!report(progress, 0.92, "writing")) return nothingWritten();
  if (scene.goesOn()) {  // the run stores all cuts and its initial field
    for (std::size_t n = 0; n < scene.originals.size(); ++n) {
      const FieldPart all{.begin = &scene.objects[n]->phi0(), .changed = &changed[n]};
      changed[n] = joinedChanges(scene.originals[n], {&all, 1});
    }
    if (bodies.isInPieces()) {
      const internal::Objects objects = internal::objectsOf(session, 0);
      const std::vector<BrickField> fields = internal::fieldsOf(objects);
      const std::vector<RunManifest::Piece> now = internal::piecesOf(objects, fields, pieces.labels);
      std::vector<FieldPart> parts;
      for (const BrickField& field : fields) parts.push_back({.begin = &field});
      KERF_TRY(left, internal::piecesLeft(scene, changed.front(), now, parts));
      out.manifest.pieces = std::move(left.pieces);
      out.manifest.pieces_cut_away = std::move(left.cut_away);
    }
    KERF_TRY(begin_sha256, internal::storeBegin(scene.inputs.from, folder.staging()));
    out.manifest.begin_sha256 = begin_sha256;
  }
  const MaterialBricks added = internal::addedMaterials(internal::objectsOf(session, 0), scene.added, scene.materials);
  KERF_CHECK(writeRun(folder.staging(), scene.inputs, changed, added, out));
  KERF_CHECK(folder.commit());
  report(progress, 1.0, "done");
  return out;
}

}  // namespace kerf
