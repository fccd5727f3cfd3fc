// The goals of `kerf-bench`, scene by scene. Only the scene table includes this.
//
// A goal: name of the number (each {} matches any text), unit, at most / at least / exactly, limit. If two rows match a
// number, the first applies.
#pragma once

#include "bench/verdict.h"

namespace kerf::cli::goals {

using enum Sense;

// A whole mandible at 0.05 mm: docs/results/README.md.
inline constexpr Goal kOpenGoals[] = {
    {"processor time, p50", "s", kAtMost, 5},
    {"most memory", "GB", kAtMost, 1.2},
};
inline constexpr Goal kCutBurGoals[] = {
    {"a fluted mesh of it: time over the bur's", "", kAtMost, 2},
    {"  removal off by", "%", kAtMost, 1},
};
inline constexpr Goal kExportGoals[] = {
    {"processor time, p50", "s", kAtMost, 1.2, Weight::kAim},
};
inline constexpr Goal kPointsGoals[] = {
    {"50k nodes, p99", "ms", kAtMost, 0.5},
    {"200k nodes, p99", "ms", kAtMost, 0.5},
    {"200k nodes, p99, each one's least of {} runs", "ms", kAtMost, 0.5},
};
inline constexpr Goal kTickBurGoals[] = {
    {"ticks that lacked room", "", kAtMost, 0},
    {"p99.9", "ms", kAtMost, 0.8},
    {"carve to mesh ready, p95", "ms", kAtMost, 15},
    {"carve to mesh ready, max", "ms", kAtMost, 33},
};
inline constexpr Goal kTickSawGoals[] = {
    {"ticks that lacked room", "", kAtMost, 0},
    {"p99.9", "ms", kAtMost, 0.8},
};
inline constexpr Goal kTickFineGoals[] = {
    {"{}: ticks that lacked room", "", kAtMost, 0},
    {"blade: p99.9", "ms", kAtMost, 0.8},
    {"blade: p99.9, each tick's least of {} runs", "ms", kAtMost, 0.8},
    {"ball: p99.9, each tick's least of {} runs", "ms", kAtMost, 0.8, Weight::kAim},
    // All 47 000 nodes and 620 bricks change in every tick: docs/results/README.md.
    {"ball: p99.9", "ms", kAtMost, 0.8, Weight::kAim},
};
inline constexpr Goal kTickSizesGoals[] = {
    {"{} bricks: over the smallest", "", kAtMost, 1.25},
};
inline constexpr Goal kRealtimeGoals[] = {
    {"ticks that lacked room", "", kAtMost, 0}, {"records lost", "", kAtMost, 0},
    {"of them not meshed", "", kAtMost, 0},     {"chunks unlike those of the final field", "", kAtMost, 0},
    {"replay differs", "", kAtMost, 0},         {"removed a second", "mm3/s", kAtLeast, 0.05},
};

inline constexpr Goal kInvarianceGoals[] = {
    {"jump of force per ms, eroding, at {} mm", "N", kAtMost, 0.05},
    {"jump of torque about the tip per ms, eroding, at {} mm", "N mm", kAtMost, 1},
    {"force over three voxels", "%", kAtMost, 5},
    {"removal over three voxels", "%", kAtMost, 5},
    {"removal against mu N v / u_s", "%", kAtMost, 5},
    {"force over 24 attitudes", "%", kAtMost, 3},
    {"removal over 24 attitudes", "%", kAtMost, 3},
    {"jump of force per ms, sliding {} mm/s at {} N", "N", kAtMost, 0.02},
    {"jump of torque about the tip per ms, sliding {} mm/s", "N mm", kAtMost, 1},
    {"in air, still, 5 s: force", "N", kAtMost, 0.01},
    {"in air, at 3 mm/s: force", "N", kAtMost, 0.01},
    {"in air, to and fro, 5 mm at 1 Hz: force", "N", kAtMost, 0.01},
    {"  ticks with contact ({})", "", kAtMost, 0},
};
inline constexpr Goal kSharpGoals[] = {
    // Edges and points miss their goals: docs/results/README.md has the reasons.
    {"over voxels: force pressed, 805-014", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force pressed, 837-012", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force pressed, 847-012", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force pressed, 862-016", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force pressed, 859-012", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force pressed, drill-20", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force pressed, disc-22", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force pressed, most of all", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, 805-014", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, 837-012", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, 847-012", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, 862-016", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, 859-012", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, saw-reciprocating-25", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, saw-sagittal-10", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, saw-piezo-050", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, disc-22", "%", kAtMost, 5, Weight::kAim},
    {"over voxels: force cutting, most of all", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.05 mm: force pressed, 805-014", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force pressed, 837-012", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force pressed, 847-012", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force pressed, 862-016", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force pressed, 859-012", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force pressed, drill-20", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force pressed, disc-22", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force pressed, most of all", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force cutting, disc-22", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.05 mm: force cutting, most of all", "%", kAtMost, 3, Weight::kAim},
    {"24 at 0.1 mm: force pressed, 805-014", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force pressed, 837-012", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force pressed, 847-012", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force pressed, 862-016", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force pressed, 859-012", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force pressed, drill-20", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force pressed, disc-22", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force pressed, most of all", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force cutting, 805-014", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force cutting, 862-016", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force cutting, disc-22", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: force cutting, most of all", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: removal, 862-016", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: removal, 859-012", "%", kAtMost, 5, Weight::kAim},
    {"24 at 0.1 mm: removal, most of all", "%", kAtMost, 5, Weight::kAim},
    // All others.
    {"over voxels: force {}", "%", kAtMost, 5},
    {"24 at 0.05 mm: force {}", "%", kAtMost, 3},
    {"24 at 0.1 mm: force {}", "%", kAtMost, 5},
    {"{}: removal, {}", "%", kAtMost, 5},
};
inline constexpr Goal kSharpRackGoals[] = {
    {"0.1 and 0.05 mm: {}, p90", "%", kAtMost, 5},
    {"{} attitudes at 0.05 mm: {}, p90", "%", kAtMost, 3},
    {"{} attitudes at 0.1 mm: {}, p90", "%", kAtMost, 5},
    {"0.1 and 0.05 mm: {}, most of all", "%", kAtMost, 5, Weight::kAim},
    {"{} attitudes at 0.05 mm: {}, most of all", "%", kAtMost, 3, Weight::kAim},
    {"{} attitudes at 0.1 mm: {}, most of all", "%", kAtMost, 5, Weight::kAim},
};
inline constexpr Goal kForcesGoals[] = {
    {"  spread of the rate in {}", "%", kAtMost, 3},
    {"  against {} as configured", "%", kAtMost, 10},
    {"  against mu v / u_s", "%", kAtMost, 5},
    {"  1 - R^2", "", kAtMost, 0.02},
    {"saw: pairs of 54 where force does not grow with density and feed, fall with strokes", "", kAtMost, 0},
    {"saw: jump of force per ms", "N", kAtMost, 0.05},
    {"saw: jump of torque about the tip per ms", "N mm", kAtMost, 1},
    {"saw: thrust against the law's reference, 27 runs, mean error", "%", kAtMost, 10},
    {"  out of 1.4 to 1.8 by", "", kAtMost, 0},
};
inline constexpr Goal kDrivesGoals[] = {
    // A ball that plunges straight cuts with its slow pole. Pressing it hardly brakes the drive.
    {"  turbine, 801-014: {}: out of {} to {} by", "mm3/s", kAtMost, 0, Weight::kAim},
    {"  turbine, 801-014: {}: out of {} to {} by", "N", kAtMost, 0, Weight::kAim},
    {"turbine, 801-014: dentin at 1 N", "mm3/s", kAtLeast, 0.3, Weight::kAim},
    // The widest tools brake the drive by the longest lever.
    {"  turbine, 856-021: {}: out of {} to {} by", "N", kAtMost, 0, Weight::kAim},
    {"  {}: out of {} to {} by", "mm3/s", kAtMost, 0},
    {"  {}: out of {} to {} by", "N", kAtMost, 0},
    {"  {}: out of {} to {} by", "s", kAtMost, 0},
    {"turbine, {}: dentin at 1 N", "mm3/s", kAtLeast, 0.3},
    {"turbine, {}: most power", "W", kAtMost, 13},
    {"turbine, {}: stops in, cutting at 1 N", "s", kAtMost, 1.5},
    {"turbine-brake, {}: stops in, {}", "s", kAtMost, 1},
    {"electric, {}: speed lost at 1 N", "%", kAtMost, 5},
};
inline constexpr Goal kDrillSitesGoals[] = {
    {"  {}: out of {} to {} by", "mm/s", kAtMost, 0},
    // Faster: 20 N drive them at the greatest feed per turn through all of the spongy bone.
    {"  2.0 mm, 20 N: site of 10 mm: out of 4 to 8 by", "s", kAtMost, 0, Weight::kAim},
    {"  2.8 mm at once, 20 N: site of 10 mm: out of 4 to 8 by", "s", kAtMost, 0, Weight::kAim},
    // Slower: four drills in sequence; 12 N hardly press the wide drills beyond rubbing.
    {"  2.0 to 4.2 mm in turn, 8 N: site of 10 mm: out of 4 to 8 by", "s", kAtMost, 0, Weight::kAim},
    {"  2.0 to 4.2 mm in turn, 12 N: site of 10 mm: out of 4 to 8 by", "s", kAtMost, 0, Weight::kAim},
    {"  3.5 mm at once, 12 N: site of 10 mm: out of 4 to 8 by", "s", kAtMost, 0, Weight::kAim},
    {"  4.2 mm at once, 12 N: site of 10 mm: out of 4 to 8 by", "s", kAtMost, 0, Weight::kAim},
    {"  {}: out of {} to {} by", "s", kAtMost, 0},
    {"  {}: out of {} to {} by", "", kAtMost, 0},
    {"thrust against the law, the worst of 16", "%", kAtMost, 10},
};
inline constexpr Goal kSawGoals[] = {
    {"  pushes the wrong way ({} mm)", "", kAtMost, 0},
    {"  kerf widened by the flanks ({} mm)", "um", kAtMost, 1},
    // Half a voxel, but not below 25 um.
    {"kerf width, worst of 12 attitudes, 0.1 mm voxels", "um", kAtMost, 50},
    {"kerf width, worst of 12 attitudes, 0.05 mm voxels", "um", kAtMost, 25},
    {"plane of the wall, worst of 12 ({} mm)", "degrees", kAtMost, 0.1},
};
inline constexpr Goal kHeatGoals[] = {
    {"  out of {} to {} by", "K", kAtMost, 0},
    {"signs that are wrong, of {}", "", kAtMost, 0},
    {"saw: area off kerf x 10 mm by", "%", kAtMost, 10},
    {"responses, one wet cavity: {}", "%", kAtMost, 10},
};

// Only the default response has goals.
inline constexpr Goal kResponseGoals[] = {
    {"penalty coupled: jump of force per ms, flat", "N", kAtMost, 0.02},
    {"penalty coupled: jump of force per ms, ball", "N", kAtMost, 0.02},
    {"penalty coupled: 1 N/mm: devices given energy, of {}", "", kAtMost, 0},
    {"penalty coupled: 2 N/mm: devices given energy, of {}", "", kAtMost, 0},
    {"penalty coupled: 1 N/mm: devices that tremble by 5 um", "", kAtMost, 0},
    {"penalty coupled: 1 N/mm, no friction: energy given, most", "mJ", kAtMost, 0.1},
    {"penalty coupled: jump of force per ms, cutting", "N", kAtMost, 0.05},
    {"penalty coupled: removal less mu N v / u_s", "%", kAtMost, 5},
};

inline constexpr Goal kSinkGoals[] = {
    {"tools", "", kAtLeast, 100},
    {"force at the end over the spring's, least", "", kAtLeast, 0.75},
    {"cutting: runs that removed enough to judge", "", kAtLeast, 400},
    {"too deep in the solid", "", kAtMost, 0},
    {"walls passed, of {}", "", kAtMost, 0},
    {"too deep in the solid, 1 m/s", "", kAtMost, 0, Weight::kAim},
    {"walls passed, 1 m/s", "", kAtMost, 0, Weight::kAim},
    // The maximum occurs for a flame, where its core takes over.
    {"force falls with depth by, most", "N", kAtMost, 0.05},
    // Tips thinner than three voxels, spikes of a mesh: docs/results/README.md.
    {"cutting: removal over what the work pays for, least", "", kAtLeast, 0.75, Weight::kAim},
    {"cutting: runs that removed less than 0.95 of that", "", kAtMost, 0, Weight::kAim},
    {"cutting: removal over what the work pays for, most", "", kAtMost, 1.15, Weight::kAim},
    {"cutting: removal, 0.1 mm against 0.05 mm voxels", "%", kAtMost, 5, Weight::kAim},
};
inline constexpr Goal kTunnellingGoals[] = {
    {"{}: passed, of {}", "", kAtMost, 0},
    {"{}: contacts missed", "", kAtMost, 0},
    {"{}: driven through without a hole", "", kAtMost, 0},
};
inline constexpr Goal kLedgerGoals[] = {
    {"{}: removed, off the mesh", "%", kAtMost, 1},
    {"{}: as loaded, off the mesh", "%", kAtMost, 1},
    {"{}: removed + left against loaded", "", kAtMost, 1e-12},
    {"{}: filling added", "mm3", kAtLeast, 0.5},
    {"{}: filling left", "mm3", kAtMost, 0},
    {"{}: filling added less removed", "mm3", kAtMost, 0},
};
inline constexpr Goal kPiecesGoals[] = {
    {"cases counted wrong", "", kAtMost, 0},
    {"lists whose volumes do not sum to the whole, to the bit", "", kAtMost, 0},
    {"removed + left against before", "", kAtMost, 1e-6},
    {"last bridge to list, {}, max", "ms", kAtMost, 50},
};
inline constexpr Goal kSplitGoals[] = {
    {"splits that are missing or too many", "", kAtMost, 0},
    {"most of them", "ticks", kAtMost, 50},
    {"ticks that lacked room", "", kAtMost, 0},
    {"records lost", "", kAtMost, 0},
    {"replay differs", "", kAtMost, 0},
};

inline constexpr Goal kPassivityGoals[] = {
    {"K 0.33 N/mm, friction 0.05 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0},
    {"K 0.7 N/mm, friction 0.05 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0},
    {"K 1 N/mm, friction 0.05 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0},
    {"K 0.33 N/mm, friction 0.05 N: trembling", "um", kAtMost, 5},
    {"K 0.7 N/mm, friction 0.05 N: trembling", "um", kAtMost, 5},
    {"K 1 N/mm, friction 0.05 N: trembling", "um", kAtMost, 5},
    // A device without friction trembles by its encoder steps with any coupling.
    {"K 0.33 N/mm, friction 0 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0.1},
    {"K 0.7 N/mm, friction 0 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0.1},
    {"K 1 N/mm, friction 0 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0.1},
};
inline constexpr Goal kPassivityLargeGoals[] = {
    {"K within the bounds of the literature: given energy", "", kAtMost, 0},
    {"K within the bounds of the literature: trembling, most", "um", kAtMost, 5},
    {"K up to twice these bounds: most energy", "mJ", kAtMost, 0.1},
};
inline constexpr Goal kEdgesGoals[] = {
    {"slides", "", kAtLeast, 2352},
    // A tool that falls into a groove hits its floor or its far wall: an impact, not a release.
    {"groove 1 mm wide: slides with more than 0.05 N beyond that", "", kAtMost, 0, Weight::kAim},
    {"{}: slides with more than 0.05 N beyond that", "", kAtMost, 0},
};
inline constexpr Goal kDevicesGoals[] = {
    {"{}: runaways", "", kAtMost, 0},
    {"wall, friction down to 0: trembling, most", "um", kAtMost, 50},
    {"wall, friction down to 0: most energy given", "mJ", kAtMost, 0.05},
    {"wall: trembling, most", "um", kAtMost, 5},
    {"wall: given more than 1e-4 mJ", "%", kAtMost, 1},
    {"wall: most energy given", "mJ", kAtMost, 0.01},
    {"wall: force at rest over an ideal device's, as stiff as wanted, p50", "", kAtLeast, 0.95},
    {"blade pushed sideways in its kerf: trembling, most", "um", kAtMost, 20},
    {"blade pushed sideways in its kerf: most energy given", "mJ", kAtMost, 0.01},
    {"blade turned in its kerf: trembling, most", "mrad", kAtMost, 0.5},
    {"saw cutting: ripple, most", "um", kAtMost, 20},
    // The limit of ideal devices. Encoder steps cause the ripple: docs/results/README.md.
    {"bur cutting enamel: rippling by more than 20 um above 15 Hz", "%", kAtMost, 0, Weight::kAim},
    {"whole stack: energy given, at the end", "mJ", kAtMost, 0.01},
    {"whole stack: age of a force at the motors, p99", "ms", kAtMost, 4,
     Weight::kAim},  // real time: depends on the machine
    {"whole stack: age of a force at the motors, p99.9", "ms", kAtMost, 10, Weight::kAim},
};
inline constexpr Goal kWindowMemoryGoals[] = {
    {"strokes", "", kAtLeast, 2},
    {"in memory, most over what it was when opened", "MB", kAtMost, 500},
    {"heap in use, grown by half way", "MB", kAtMost, 400},
    {"heap in use, grown since then", "MB", kAtMost, 400},
};
inline constexpr Goal kWindowSessionGoals[] = {
    {"frame while opening, longest", "ms", kAtMost, 100, Weight::kAim},  // real time: depends on the machine
    {"frame while exporting, longest", "ms", kAtMost, 100, Weight::kAim},
    {"carve to picture, p95", "frames", kAtMost, 2},
    {"haptic loop, mean", "Hz", kAtLeast, 995},
};

}  // namespace kerf::cli::goals
