#include "preprocess/volume/volume_names.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string>

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

std::string lowerCase(std::string s) {
  for (char& c : s)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return s;
}

// Runs of digits compare as numbers: slice-2 before slice-10.
bool naturalLess(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const auto run = [&](const std::string& s, std::size_t& at) {
        while (at < s.size() && s[at] == '0') ++at;
        const std::size_t first = at;
        while (at < s.size() && digit(s[at])) ++at;
        return s.substr(first, at - first);
      };
      const std::string x = run(a, i), y = run(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  const std::size_t left_a = a.size() - i, left_b = b.size() - j;
  return left_a != left_b ? left_a < left_b : a < b;
}

}  // namespace

std::optional<VolumeFormat> fileFormat(const fs::path& path) {
  const std::string name = lowerCase(path.filename().string());
  if (name.ends_with(".nrrd")) return VolumeFormat::kNrrd;
  if (name.ends_with(".nii") || name.ends_with(".nii.gz")) return VolumeFormat::kNifti;
  if (name.ends_with(".mha") || name.ends_with(".mhd")) return VolumeFormat::kMetaImage;
  return {};
}

std::optional<VolumeFormat> sliceFormat(const fs::path& path) {
  const std::string name = lowerCase(path.filename().string());
  if (name.ends_with(".png")) return VolumeFormat::kPng;
  if (name.ends_with(".tif") || name.ends_with(".tiff")) return VolumeFormat::kTiff;
  if (name.ends_with(".bmp")) return VolumeFormat::kBmp;
  return {};
}

const char* nameOf(VolumeFormat format) {
  switch (format) {
    case VolumeFormat::kNrrd:
      return "NRRD";
    case VolumeFormat::kNifti:
      return "NIfTI";
    case VolumeFormat::kMetaImage:
      return "MetaImage";
    case VolumeFormat::kDicom:
      return "DICOM";
    case VolumeFormat::kPng:
      return "PNG slices";
    case VolumeFormat::kTiff:
      return "TIFF slices";
    case VolumeFormat::kBmp:
      return "BMP slices";
  }
  return "";
}

Expected<std::vector<fs::path>> filesOf(const fs::path& folder) {
  std::error_code ec;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    std::error_code ignored;
    if (it->is_regular_file(ignored) && it->path().filename().string()[0] != '.') files.push_back(it->path());
  }
  if (ec)
    return fail({.code = Error::Code::kUnreadable,
                 .file = folder.string(),
                 .found = ec.message(),
                 .expected = "a readable folder"});
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return naturalLess(a.filename().string(), b.filename().string());
  });
  return files;
}

bool hasDicomMark(const fs::path& path) {
  std::array<char, 132> head{};
  std::error_code failed;  // files without a size, as in /proc, may block for ever
  if (const auto bytes = fs::file_size(path, failed); failed || bytes < head.size()) return false;
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  return std::memcmp(head.data() + 128, "DICM", 4) == 0;
}

}  // namespace kerf::internal
