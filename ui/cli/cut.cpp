#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "geometry/tool/handpiece.h"
#include "geometry/tool/tool_file.h"
#include "sim/monitor/monitor.h"
#include "sim/object/baked_object.h"
#include "sim/run/cut/cut_remarks.h"
#include "sim/run/cut/geometry_cut.h"
#include "sim/run/cut/haptic_cut.h"
#include "sim/run/files/small_cut.h"
#include "sim/step/response.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct CutArguments {
  std::string case_folder, tool, path, output;
  CutOptions options;
  bool json = false;
  std::string hand;  // empty: geometry only
  std::string response = "penalty";
  HapticCutOptions haptic;
};

std::optional<HandKind> handKind(const std::string& name) {
  if (name == "feed") return HandKind::kFeed;
  if (name == "force") return HandKind::kForce;
  if (name == "device") return HandKind::kDevice;
  return std::nullopt;
}

std::vector<std::string> responseNames() {
  std::vector<std::string> names;
  for (const ResponseRow& row : kResponses) names.emplace_back(row.name);
  return names;
}

std::string handpieceHelp() {
  std::string text = "handpiece that drives the tool, instead of the one of its file or shank: ";
  const char* between = "";
  for (const Handpiece& row : handpieces())
    text += fmt::format("{}{} ({})", std::exchange(between, "; "), row.name, row.description);
  return text;
}

std::vector<std::string> handpiecesByName() {
  std::vector<std::string> names;
  for (const Handpiece& row : handpieces()) names.emplace_back(row.name);
  return names;
}

std::string responseHelp() {
  std::string text = "collision response that keeps the tool out of the tissue: ";
  const char* between = "";
  for (const ResponseRow& row : kResponses)
    text += fmt::format("{}{} ({})", std::exchange(between, ", "), row.name, row.description);
  return text + "; docs/how-it-works/step.md";
}

// An option for another virtual hand than the requested one: it would have no effect, so it is a user error.
std::optional<Error> misplaced(const CLI::App& command, const std::string& hand) {
  for (const CLI::App* group : command.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string& name = group->get_group();
    const bool fits = !hand.empty() && (name == "With --hand" || (name + " ").find(" " + hand + " ") != name.npos);
    if (fits || !name.starts_with("With --hand")) continue;
    for (const CLI::Option* option : group->get_options())
      if (option->count() > 0)
        return Error{.code = Error::Code::kBadValue,
                     .place = option->get_name(),
                     .found = "given with " + (hand.empty() ? "no --hand" : "--hand " + hand),
                     .expected = name.substr(5),
                     .hint = "kerf cut --help"};
  }
  return std::nullopt;
}

void tell(const std::vector<CutRemark>& remarks) {
  for (const CutRemark& remark : remarks)
    printText(stderr, "kerf: {}{}\n", remark.is_warning ? "WARNING: " : "", remark.text);
}

// ---- Against resistance

// Warns of cuts in neighbours, which the export of the object does not show.
void warnOfNeighbours(const CutArguments& a, const HapticSummary& s) {
  const std::size_t of_run = s.beside.size() - a.haptic.beside.size();  // neighbours of the continued run
  for (std::size_t n = 0; n < s.beside.size(); ++n) {
    const HapticSummary::Neighbour& other = s.beside[n];
    const std::string place = n < of_run ? other.case_path : a.haptic.beside[n - of_run].string();
    const std::string name = fmt::format("{} ({})", other.id, place);
    const auto least = s.least_distance_mm.find(other.id);
    const bool is_in = least != s.least_distance_mm.end() && least->second < 0;
    const std::string in = is_in ? fmt::format(", cutting part in it by {:.3f} mm", -least->second) : "";

    if (other.removed_mm3 > 0)
      printText(stderr, "kerf: {}: {:.4f} mm3 removed{}. Export its mesh: kerf export {} --beside {} -o FILE\n", name,
                other.removed_mm3, in, a.output, n + 1);
    else if (other.seconds_touched > 0 || is_in)
      printText(stderr, "kerf: {}: touched for {:.3f} s, nothing removed{}\n", name, other.seconds_touched, in);
    if (other.overlap_mm3 > 0.01 * std::min(other.initial_mm3, s.initial_mm3))
      printText(stderr, "kerf: {} overlaps the case by about {:.1f} mm3 before the cut: the tool touches both there\n",
                name, other.overlap_mm3);
  }
}

// The continued run; null: it began with a case.
nlohmann::json goesOn(const CutArguments& a) { return isRun(a.case_folder) ? nlohmann::json(a.case_folder) : nullptr; }

nlohmann::json cutJson(const CutArguments& a, const HapticCut& cut) {
  nlohmann::json j = nlohmann::json::parse(toJson(cut.summary));
  j["tool"] = cut.manifest.tool_id;
  j["hand"] = a.hand;
  j["response"] = a.response;
  j["voxel_mm"] = cut.manifest.voxel_mm;
  j["goes_on"] = goesOn(a);
  j["warnings"] = warningsOf(cut.manifest);
  return j;
}

// ": enamel 1.2000, dentin 0.3000"; with signs ": enamel +1.2000". A hardly touched tissue may have "lost" a little
// less than nothing, shares of voxels at its border: shown as 0.
std::string byMaterial(const std::map<std::string, double>& volumes, bool with_sign) {
  std::string out;
  for (const auto& [id, volume] : volumes) {
    out += out.empty() ? ": " : ", ";
    out += with_sign ? fmt::format("{} {:+.4f}", id, volume) : fmt::format("{} {:.4f}", id, std::max(0.0, volume));
  }
  return out;
}

void printVolumes(const HapticSummary& s, bool is_adding) {
  if (is_adding) {
    printText("added {:.4f} mm3{}\n", s.added_mm3, byMaterial(s.added_by_material, true));
    if (s.clipped > 0)
      printText(
          "{} of {} ticks were more than {:g} mm outside the object's box, or needed more air than fits: nothing was "
          "added there\n",
          s.clipped, s.ticks, kAirAround);
  }
  printText("removed {:.4f} mm3{}; {:.4f} of {:.4f} mm3 are left, in {}", s.removed_mm3,
            byMaterial(s.removed_by_material, false), s.remaining_mm3, s.initial_mm3, counted(s.pieces, "piece"));
  if (s.crumbs > 0) printText(" and {} below 0.1 mm3", counted(s.crumbs, "crumb"));
  printText("\n");
}

// Compares with the planned cut of the path.
void printPlan(const HapticSummary& s) {
  if (!(s.planned_mm3 > 0)) return;
  const Vec3d& at = s.farthest_off_at;
  printText("reached {:.0f} % of the {:.4f} mm3 that the path asks for{}\n", 100 * s.reached_mm3 / s.planned_mm3,
            s.planned_mm3, byMaterial(s.planned_by_material, false));
  printText("{:.4f} mm3 removed beside that; off the path by {:.2f} mm at most, at ({:.2f}, {:.2f}, {:.2f})\n",
            std::max(0.0, s.removed_mm3 - s.reached_mm3), s.farthest_off_mm, at[0], at[1], at[2]);
}

void printMonitored(const HapticSummary& s) {
  printText("{:.1f} C under the tool at most", s.hottest_c);
  if (s.bone_limit_s >= 0) printText(", 47 C in bone passed at {:.2f} s", s.bone_limit_s);
  if (s.pulp_limit_s >= 0) printText(", 5.5 K in the pulp passed at {:.2f} s", s.pulp_limit_s);
  for (const auto& [id, distance] : s.least_distance_mm) {
    const char* in = id.starts_with("beside") ? "touched, tool in it by" : "opened, tool in it by";
    printText("; {} {} {:.2f} mm", id, distance < 0 ? in : "no nearer than", std::abs(distance));
  }
  printText("\n");
}

// Empty if the tool is at the end of its path.
std::string shortOfEnd(const HapticSummary& s) {
  constexpr double kAtEnd = 0.02;  // mm
  return s.short_of_end_mm > kAtEnd ? fmt::format(", {:.2f} mm short of the path's end", s.short_of_end_mm)
                                    : std::string();
}

void printCut(const CutArguments& a, const HapticCut& cut) {
  const HapticSummary& s = cut.summary;
  const bool is_default = findResponse(a.response)->response == StepSettings{}.response;
  const std::string response = is_default ? "" : " by " + a.response;
  printText("cut with {} held by a {} hand{} for {:.2f} s, {:.2f} s of it in contact, voxels {} mm; ended: {}{}\n",
            cut.manifest.tool_id, a.hand, response, s.seconds, s.seconds_in_contact, cut.manifest.voxel_mm, s.ended,
            shortOfEnd(s));
  if (!s.coupling_text.empty()) printText("the device can hold a coupling of {}\n", s.coupling_text);
  printVolumes(s, !a.haptic.add.empty());
  printPlan(s);
  printText("force on the tool {:.2f} N mean, {:.2f} N at most; normal load {:.2f} N; to the hand {:.2f} N at most\n",
            s.mean_contact_force, s.peak_contact_force, s.mean_normal_load, s.peak_hand_force);
  printText("drive {:.1f} mJ into the tissue, speed down to {:.0f} % of nominal", s.work, 100 * s.least_speed);
  if (s.stalled_s > 0.05)
    printText("; it stalled for {:.2f} s: too {} for this drive{}", s.stalled_s,
              a.hand == "feed" ? "fast a feed" : "heavy a hand",
              a.haptic.spindle < 1 ? fmt::format(" at {:g} of its speed", a.haptic.spindle) : "");
  printText("\n");
  printMonitored(s);

  if (s.too_fast > 0)
    printText("{} of {} ticks were too fast for one contact evaluation per voxel: use a slower feed\n", s.too_fast,
              s.ticks);
  if (s.out_of_bricks > 0)
    printText("{} of {} ticks ran out of reserved bricks: their cuts came later, or not at all\n", s.out_of_bricks,
              s.ticks);
  printText("state {}\nrun written: {}\n", s.state_hash, a.output);
}

int runByHand(const CutArguments& a, const std::filesystem::path& tool) {
  HapticCutOptions options = a.haptic;
  options.hand = *handKind(a.hand);
  options.step.response = findResponse(a.response)->response;  // one of responseNames(), as checked on parsing
  options.overwrite = a.options.overwrite;
  if (const auto fine = checkOptions(options); !fine) return complainOfUsage(fine.error());
  const auto cut = [&] {
    TerminalProgress progress;
    return cutCaseByHand(a.case_folder, tool, a.path, a.output, options, progress.callback());
  }();
  if (!cut) return complain(cut.error());

  if (const auto used = readTool(tool)) tell(remarksOf(*cut, options, *used));
  warnOfNeighbours(a, cut->summary);
  if (a.json)
    printJson(cutJson(a, *cut));
  else
    printCut(a, *cut);
  return kOk;
}

// ---- Geometry only

// Reports short motions that were merged and swept as longer ones. Empty if there are none.
std::string mergedLine(const RunManifest& m) {
  if (m.merged_motions == 0) return {};
  return fmt::format("{} short motions were merged: {} were swept, each within {:.2g} mm of the path\n",
                     m.merged_motions, m.swept_motions, m.merge_tolerance_mm);
}

// Reference of the volumes after continuing a run.
std::string earlierLine(const RunManifest& m) {
  if (!m.begin_sha256.empty()) return "since the run that this one continues:\n";
  if (m.earlier.empty()) return {};
  return fmt::format("with {} along other paths before it:\n", counted(m.earlier.size(), "cut"));
}

// The sweep also cuts neighbours of a continued run.
void tellOfNeighbours(const CutArguments& a, const RunManifest& m) {
  for (std::size_t n = 0; n < m.beside.size(); ++n) {
    const RunManifest::Beside& other = m.beside[n];
    if (other.removed_now_mm3 <= kUnchanged) continue;
    printText(stderr, "kerf: {} ({}): {:.4f} mm3 removed. Export its mesh: kerf export {} --beside {} -o FILE\n",
              neighbourId(n + 1), other.case_path, other.removed_now_mm3, a.output, n + 1);
  }
}

nlohmann::json jsonOfNeighbours(const RunManifest& m) {
  nlohmann::json out = nlohmann::json::array();
  for (std::size_t n = 0; n < m.beside.size(); ++n)
    out.push_back({{"id", neighbourId(n + 1)},
                   {"case_path", m.beside[n].case_path},
                   {"removed_mm3", m.beside[n].removed_now_mm3},
                   {"removed_in_all_mm3", m.beside[n].removed_mm3}});
  return out;
}

int runGeometry(const CutArguments& a, const std::filesystem::path& tool) {
  const auto m = [&] {
    TerminalProgress progress;
    return cutCase(a.case_folder, tool, a.path, a.output, a.options, progress.callback());
  }();
  if (!m) return complain(m.error());

  if (const auto used = readTool(tool)) tell(remarksOf(*m, *used));
  tellOfNeighbours(a, *m);
  double removed = 0;
  for (const auto& [id, volume] : m->removed_by_material) removed += volume;
  const auto& out_at = m->findings.comes_out_at;
  if (a.json)
    printJson(nlohmann::json{
        {"tool", m->tool_id},
        {"removed_mm3", removed},
        {"removed_by_material_mm3", m->removed_by_material},
        {"thinner_than_voxels_mm3", m->thin_mm3},
        {"segments", m->segments},
        {"path_length_mm", m->path_length_mm},
        {"earlier_cuts", m->earlier.size()},
        {"goes_on", goesOn(a)},
        {"beside", jsonOfNeighbours(*m)},
        {"warnings", warningsOf(*m)},
        {"duration_s", m->duration_s},
        {"voxel_mm", m->voxel_mm},
        {"beyond_region_mm", m->beyond_region_mm},
        {"merged_motions", m->merged_motions},
        {"swept_motions", m->swept_motions},
        {"strokes", m->findings.strokes},
        {"idle_strokes", m->findings.idle},
        {"comes_out_at_mm", out_at ? nlohmann::json{out_at->x(), out_at->y(), out_at->z()} : nlohmann::json()},
        {"state_hash", m->state_hash}});
  else
    printText(
        "cut with {} along {:.2f} mm in {} motions, voxels {} mm; state {}\n{}{}removed {:.4f} mm3{}\nrun written: "
        "{}\n",
        m->tool_id, m->path_length_mm, m->segments, m->voxel_mm, m->state_hash, mergedLine(*m), earlierLine(*m),
        removed, byMaterial(m->removed_by_material, false), a.output);
  return kOk;
}

int runCut(const CutArguments& a) {
  const auto tool = findToolFile(a.tool, defaultToolFolders());
  if (!tool) return complain(tool.error());
  return a.hand.empty() ? runGeometry(a, *tool) : runByHand(a, *tool);
}

// ---- Options

constexpr const char* kFooter =
    "Without --hand: geometry only; the cutting part removes its swept volume.\n"
    "With --hand: a virtual hand holds the tool against resistance, in steps of 1 ms. Tissues differ, force decides\n"
    "how fast the tool cuts, neck, shank and flanks collide. The run then also holds forces.csv and summary.json.\n"
    "With a RUN: continues an ended run, with its pieces and neighbours at their last positions.\n"
    "With --beside: the tool also touches the neighbours, at their scan positions.\n"
    "Examples:\n"
    "  kerf cut molar.case --tool round-014 --path cavity.toml -o molar.run\n"
    "  kerf cut molar.case --tool round-014 --path cavity.toml --hand force --push 1.5 -o molar.run\n"
    "  kerf cut 36.case --tool 856-016 --path crown.toml --hand force --beside 35.case --beside 37.case -o 36.run";

// misplaced() reads the names of these groups to find their hands.
void addOptionsOfAnyHand(CLI::App& command, HapticCutOptions& haptic) {
  auto* group = command.add_option_group("With --hand");
  group->add_option("--drive", haptic.drive, handpieceHelp())->check(CLI::IsMember(handpiecesByName()));
  group->add_option("--spindle", haptic.spindle, "spindle speed, 0 to 1 of the tool's nominal speed")
      ->capture_default_str();
  group->add_flag("--reverse", haptic.is_reversed,
                  "reverse the drive of a motor: diamonds still cut, blades and drills only rub");
  group->add_option("--irrigation", haptic.irrigation, "irrigation, 0 (dry) to 1")->capture_default_str();
  group->add_option("--add", haptic.add,
                    "add this material along the path instead of cutting: a material id such as composite; with "
                    "several pieces, to the largest");
  group
      ->add_option("--beside", haptic.beside,
                   "a neighbour, such as the adjacent tooth: a case in the same scan frame. The tool collides with it "
                   "and cuts it, and the run records the distance to it; repeat for several")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  group->add_flag("--sound", haptic.with_sound, "also write sound.wav, the sound of the tool");
  group->add_option("--time-limit", haptic.time_limit, "longest simulated time, s")->capture_default_str();
}

void addOptionsOfOneHand(CLI::App& command, CutArguments& a) {
  auto* coupled = command.add_option_group("With --hand force or device");
  coupled->add_option("--response", a.response, responseHelp())
      ->check(CLI::IsMember(responseNames()))
      ->capture_default_str();

  auto* force = command.add_option_group("With --hand force");
  force->add_option("--push", a.haptic.force.force, "force on the tool, 0.01 to 8 N")->capture_default_str();
  force->add_option("--feed-limit", a.haptic.force.feed_limit, "highest speed, mm/s")->capture_default_str();
  force->add_option("--patience", a.haptic.force.patience, "longest time without progress, s")->capture_default_str();

  DeviceHand::Options& d = a.haptic.device;
  auto* device = command.add_option_group("With --hand device");
  device
      ->add_option("--coupling", a.haptic.step.coupling.stiffness,
                   "stiffness of the virtual coupling, N/mm; Kerf lowers it if the device cannot hold it")
      ->capture_default_str();
  device->add_option("--device-mass", d.mass_kg, "kg")->capture_default_str();
  device->add_option("--device-damping", d.damping, "N s/mm")->capture_default_str();
  device->add_option("--device-friction", d.friction, "N")->capture_default_str();
  device->add_option("--encoder", d.encoder_mm, "resolution, mm")->capture_default_str();
  device->add_option("--delay", d.delay_ticks, "ticks from sample to force")->capture_default_str();
  device->add_option("--hand-stiffness", d.hand_stiffness, "N/mm; loose 0.3, firm 2")->capture_default_str();
  device->add_option("--hand-damping", d.hand_damping, "N s/mm")->capture_default_str();
}

}  // namespace

void addCut(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<CutArguments>();
  command.footer(kFooter);
  command
      .add_option("CASE", a->case_folder,
                  "case folder, or an ended run: the new run continues it and holds the cuts of both")
      ->type_name("CASE|RUN")
      ->required();
  command.add_option("--tool", a->tool, "tool id (kerf tool list) or a tool's TOML file")->required();
  command
      .add_option("--path", a->path,
                  "CSV of poses (t,x,y,z,qw,qx,qy,qz) or TOML of strokes; see docs/reference/path-files.md")
      ->required();
  command.add_option("-o,--output", a->output, "run folder to write")->required();
  addOverwrite(command, a->options.overwrite, "replace an existing run");

  CLI::Option* hand =
      command
          .add_option("--hand", a->hand,
                      "virtual hand that holds the tool against resistance: feed (follows the path in its time), force "
                      "(pushes along it), device (a simulated force-feedback device)")
          ->check(CLI::IsMember({"feed", "force", "device"}));
  command
      .add_flag_callback(
          "--haptic", [a] { a->hand = "device"; }, "the same as --hand device")
      ->excludes(hand);
  addOptionsOfAnyHand(command, a->haptic);
  addOptionsOfOneHand(command, *a);
  addCasePlaces(command);
  command.add_flag("--json", a->json, "print the summary as JSON on standard output");

  command.callback([a, &command, &exit_code] {
    const auto wrong = misplaced(command, a->hand);
    exit_code = wrong ? complainOfUsage(*wrong) : runCut(*a);
  });
}

}  // namespace kerf::cli
