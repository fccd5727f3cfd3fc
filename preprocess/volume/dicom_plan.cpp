// planDicom(): the slices or frames of one DICOM series.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "preprocess/volume/volume_plan.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

struct Slice {
  fs::path path;
  VolumeHeader header;
  double height = 0;  // mm, along the normal of the slices
};

Vec3d column(const VolumeHeader& h, std::size_t a) { return {h.direction[a], h.direction[3 + a], h.direction[6 + a]}; }
Vec3d originOf(const VolumeHeader& h) { return {h.origin[0], h.origin[1], h.origin[2]}; }

// Every DICOM file of the folder, all of one series.
Expected<std::vector<Slice>> readSlices(const fs::path& folder, const std::vector<fs::path>& files,
                                        const Progress& progress) {
  std::vector<Slice> slices;
  std::set<std::string> series;
  for (const fs::path& f : files) {
    if (!report(progress, 0.2 * static_cast<double>(slices.size()) / static_cast<double>(files.size()),
                "reading headers"))
      return cancelled(folder.string());
    if (!isDicom(f)) continue;
    KERF_TRY(h, readVolumeHeader(f, VolumeFormat::kDicom));
    KERF_CHECK(requireOneValue(f, h));
    series.insert(h.series);
    slices.push_back({f, h, 0});
  }

  if (slices.empty())
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .found = "no slices" + textOfSliceFolders(folder),
                 .expected = "a DICOM series, or .png, .tif or .bmp slices",
                 .hint = "the folder that holds the slices themselves"});
  if (series.size() > 1) {
    std::string uids;
    for (const std::string& s : series) uids += (uids.empty() ? "" : ", ") + s;
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .found = fmt::format("{} series: {}", series.size(), uids.substr(0, 400)),
                 .expected = "one",
                 .hint = "move the series you want into a folder of its own"});
  }

  const Slice& first = slices.front();
  if (first.header.size.size() != 3)
    return fail({.code = Error::Code::kUnsupported,
                 .file = first.path.string(),
                 .found = fmt::format("{} axes", first.header.size.size()),
                 .expected = "a slice"});
  return slices;
}

bool areAlike(const VolumeHeader& h, const VolumeHeader& first) {
  const auto differ = [](double a, double b) { return std::abs(a - b) > 1e-3 * b; };
  return !(h.size != first.size || h.size[2] != 1 || h.type != first.type ||
           h.states_pixel_spacing != first.states_pixel_spacing || (column(h, 0) - column(first, 0)).norm() > 1e-3 ||
           (column(h, 1) - column(first, 1)).norm() > 1e-3 || differ(h.spacing[0], first.spacing[0]) ||
           differ(h.spacing[1], first.spacing[1]));
}

// Sorts slices by height. They must be alike and evenly spaced.
Expected<void> stackSlices(std::vector<Slice>& slices) {
  const VolumeHeader first = slices.front().header;
  const Vec3d up = column(first, 0).cross(column(first, 1)).normalized();
  for (Slice& s : slices) {
    if (!areAlike(s.header, first))
      return fail({.code = Error::Code::kUnsupported,
                   .file = s.path.string(),
                   .found = "a slice of another size, spacing or orientation",
                   .expected = "the same in all slices",
                   .hint = "leave scout images and other series out of the folder"});
    s.height = up.dot(originOf(s.header));
  }

  std::sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) {
    return a.height != b.height ? a.height < b.height : a.path < b.path;
  });

  // The lower median of the gaps above zero: a missing slice widens one gap, not the step.
  const auto last = slices.size() - 1;
  std::vector<double> gaps, steps;
  for (std::size_t i = 0; i < last; ++i) gaps.push_back(slices[i + 1].height - slices[i].height);
  std::copy_if(gaps.begin(), gaps.end(), std::back_inserter(steps), [](double gap) { return gap > 1e-4; });
  std::sort(steps.begin(), steps.end());
  const double step = steps.empty() ? 0 : steps[(steps.size() - 1) / 2];
  for (std::size_t i = 0; i < last; ++i) {
    // Positions are decimal strings, rounded: 2 % of a step is far above that and far below a missing slice.
    if (std::abs(gaps[i] - step) <= 0.02 * step + 1e-3 && gaps[i] > 1e-4) continue;
    const double missing = step > 1e-4 ? std::round(gaps[i] / step) - 1 : 0;
    const bool is_whole = missing >= 1 && std::abs(gaps[i] - (missing + 1) * step) <= 0.02 * step + 1e-3;
    return fail({.code = Error::Code::kBadValue,
                 .file = slices[i + 1].path.string(),
                 .found = fmt::format("{:.4g} mm above {}", gaps[i], slices[i].path.filename().string()) +
                          (is_whole ? fmt::format(": {:.0f} missing between them", missing) : std::string()),
                 .expected = fmt::format("evenly spaced slices, {:.4g} mm apart", step),
                 .hint = "export the series again: a slice is missing or duplicate"});
  }
  return {};
}

// The header of the volume that sorted slices make. They may be shifted against each other (a tilted gantry): the third
// axis runs from slice to slice.
VolumeHeader stackedHeader(const std::vector<Slice>& slices) {
  VolumeHeader whole = slices.front().header;
  const Vec3d rise =
      (originOf(slices.back().header) - originOf(slices.front().header)) / static_cast<double>(slices.size() - 1);
  whole.size[2] = slices.size();
  whole.spacing[2] = rise.norm();
  for (std::size_t row = 0; row < 3; ++row)
    whole.direction[3 * row + 2] = rise[static_cast<Eigen::Index>(row)] / rise.norm();
  return whole;
}

// Spacing of the series. @param header  of any of its files.
void findSpacing(const VolumeHeader& header, VolumePlan& plan) {
  const bool frames = plan.files.size() == 1;  // otherwise the positions of the slices give their spacing
  const bool pixel = header.states_pixel_spacing, frame = !frames || header.states_frame_spacing;
  const Vec3d& spacing = plan.grid.spacing;
  if (!pixel || !frame) {
    if (pixel) plan.known_spacing.head<2>() = spacing.head<2>();
    if (frame) plan.known_spacing[2] = spacing[2];
    plan.unusable = pixel   ? "no spacing between the frames"
                    : frame ? "no pixel spacing"
                            : "no spacing, neither of pixels nor between the frames";
    if (frame) plan.unusable += fmt::format(" ({:.6g} mm along z)", spacing[2]);
    if (pixel) plan.unusable += fmt::format(" ({:.6g} and {:.6g} mm along x and y)", spacing[0], spacing[1]);
  } else if ((spacing.array() > 1e-6).all() && (spacing.array() < 1e6).all()) {
    plan.stated_spacing = spacing;
  } else {
    plan.unusable = "a spacing of " + textOf(spacing);
  }
}

}  // namespace

Expected<VolumePlan> planDicom(const fs::path& folder, const std::vector<fs::path>& files, const Progress& progress) {
  KERF_TRY(slices, readSlices(folder, files, progress));
  VolumePlan plan;
  plan.format = VolumeFormat::kDicom;

  if (slices.size() == 1) {
    const Slice& only = slices.front();
    if (only.header.size[2] <= 1)
      return fail({.code = Error::Code::kEmpty,
                   .file = folder.string(),
                   .found = "one slice",
                   .expected = "two or more",
                   .hint = "export the whole series"});
    plan.files = {only.path};  // all frames in one file
    plan.header = only.header;
    KERF_CHECK(setGrid(only.path, only.header, plan));
  } else {
    KERF_CHECK(stackSlices(slices));
    plan.header = slices.front().header;
    plan.header.size.resize(2);
    KERF_CHECK(setGrid(folder, stackedHeader(slices), plan));
    for (const Slice& s : slices) plan.files.push_back(s.path);
  }
  findSpacing(slices.front().header, plan);
  return plan;
}

}  // namespace kerf::internal
