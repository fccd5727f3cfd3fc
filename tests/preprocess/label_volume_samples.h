// Test helper: small label volumes as files with hand-written headers.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace kerf {

/// 4 x 3 x 2 labels, x fastest: label = x + 4 y + 12 z.
inline std::string countingLabels() {
  std::string s;
  for (int i = 0; i < 24; ++i) s.push_back(static_cast<char>(i));
  return s;
}

inline std::string nrrd(const std::string& fields, const std::string& values) {
  return "NRRD0004\n# a comment\n" + fields + "\n" + values;
}
inline const char* const kNrrdGrid = "type: unsigned char\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n";
inline const char* const kNrrdSpace =
    "space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.25,0) (0,0,2)\nspace origin: (1,2,3)\n";

inline std::string metaImage(const std::string& fields, const std::string& values) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\n" + fields +
         "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + values;
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

/// NIfTI-1, one file, uint8, with an sform: RAS, so that x and y change sign on the way to LPS.
inline std::string nifti(const std::string& values, float spacing_x = 0.5f) {
  std::string h(352, '\0');
  put<std::int32_t>(h, 0, 348);
  const std::int16_t dim[8] = {3, 4, 3, 2, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) put(h, 40 + 2 * i, dim[i]);
  put<std::int16_t>(h, 70, 2);
  put<std::int16_t>(h, 72, 8);  // uint8
  const float pixdim[8] = {1, spacing_x, 0.25f, 2, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) put(h, 76 + 4 * i, pixdim[i]);
  put<float>(h, 108, 352);
  put<float>(h, 112, 1);
  h[123] = 2;  // mm
  put<std::int16_t>(h, 252, 0);
  put<std::int16_t>(h, 254, 1);
  const float sform[12] = {-spacing_x, 0, 0, -1, 0, -0.25f, 0, -2, 0, 0, 2, 3};
  for (std::size_t i = 0; i < 12; ++i) put(h, 280 + 4 * i, sform[i]);
  std::memcpy(h.data() + 344, "n+1", 4);
  return h + values;
}

enum class Stream { kZlib, kGzip };

/// Compresses with header and checksum.
inline std::string compressed(const std::string& bytes, Stream kind) {
  z_stream z{};
  if (deflateInit2(&z, 9, Z_DEFLATED, kind == Stream::kGzip ? 31 : 15, 8, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  std::string out(deflateBound(&z, bytes.size()), '\0'), in = bytes;
  z.next_in = reinterpret_cast<unsigned char*>(in.data());
  z.avail_in = static_cast<unsigned>(in.size());
  z.next_out = reinterpret_cast<unsigned char*>(out.data());
  z.avail_out = static_cast<unsigned>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

/// One 4 x 3 slice of 8 bits as DICOM (explicit VR, little endian), at height z mm; or several frames in one file.
/// @param pixel_spacing, between_slices  decimal strings; empty: the file states none
inline std::string dicomSlice(const std::string& values, double z, const std::string& series = "1.2.3",
                              const std::string& pixel_spacing = "0.25\\0.5", int frames = 1,
                              const std::string& between_slices = "") {
  std::string body;
  const auto element = [](std::uint16_t group, std::uint16_t tag, const char* vr, std::string value) {
    if (value.size() % 2) value.push_back(std::strcmp(vr, "UI") == 0 || std::strcmp(vr, "OB") == 0 ? '\0' : ' ');
    std::string e(8, '\0');
    put(e, 0, group);
    put(e, 2, tag);
    e[4] = vr[0];
    e[5] = vr[1];
    if (std::strcmp(vr, "OB") == 0 || std::strcmp(vr, "OW") == 0) {
      e.resize(12);
      put(e, 8, static_cast<std::uint32_t>(value.size()));
    } else {
      put(e, 6, static_cast<std::uint16_t>(value.size()));
    }
    return e + value;
  };

  const auto word = [](std::uint16_t v) {
    std::string s(2, '\0');
    put(s, 0, v);
    return s;
  };

  const std::string instance = "1.2.3.4." + std::to_string(static_cast<int>(1000 + 10 * z));
  // CT; of several frames: a greyscale byte secondary capture
  const std::string kind = frames == 1 ? "1.2.840.10008.5.1.4.1.1.2" : "1.2.840.10008.5.1.4.1.1.7.2";
  std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", kind) +
                     element(2, 3, "UI", instance) + element(2, 0x10, "UI", "1.2.840.10008.1.2.1") +
                     element(2, 0x12, "UI", "1.2.3.9");
  std::string length(4, '\0');
  put(length, 0, static_cast<std::uint32_t>(meta.size()));

  body += std::string(128, '\0') + "DICM" + element(2, 0, "UL", length) + meta;
  body += element(8, 0x16, "UI", kind) + element(8, 0x18, "UI", instance) + element(8, 0x60, "CS", "CT") +
          (between_slices.empty() ? "" : element(0x18, 0x88, "DS", between_slices)) +
          element(0x20, 0xd, "UI", "1.2.3.1") + element(0x20, 0xe, "UI", series) +
          element(0x20, 0x32, "DS", "1\\2\\" + std::to_string(z)) + element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") +
          element(0x28, 2, "US", word(1)) + element(0x28, 4, "CS", "MONOCHROME2") +
          (frames == 1 ? "" : element(0x28, 8, "IS", std::to_string(frames))) + element(0x28, 0x10, "US", word(3)) +
          element(0x28, 0x11, "US", word(4)) + (pixel_spacing.empty() ? "" : element(0x28, 0x30, "DS", pixel_spacing)) +
          element(0x28, 0x100, "US", word(8)) + element(0x28, 0x101, "US", word(8)) +
          element(0x28, 0x102, "US", word(7)) + element(0x28, 0x103, "US", word(0)) +
          element(0x7fe0, 0x10, "OB", values);
  return body;
}

/// An 8-bit grey PNG. zlib makes its stream and checksums.
inline std::string greyPng(unsigned width, unsigned height, const std::string& values) {
  const auto big = [](unsigned long v) {
    std::string s;
    for (int shift = 24; shift >= 0; shift -= 8) s.push_back(static_cast<char>(v >> shift & 255));
    return s;
  };
  const auto chunk = [&](const std::string& kind, const std::string& data) {
    const std::string body = kind + data;
    return big(data.size()) + body +
           big(crc32(0, reinterpret_cast<const unsigned char*>(body.data()), static_cast<unsigned>(body.size())));
  };
  std::string rows;
  for (unsigned y = 0; y < height; ++y) rows += '\0' + values.substr(y * width, width);
  std::string packed(compressBound(rows.size()), '\0');
  unsigned long size = packed.size();
  compress(reinterpret_cast<unsigned char*>(packed.data()), &size, reinterpret_cast<const unsigned char*>(rows.data()),
           rows.size());
  packed.resize(size);
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", big(width) + big(height) + std::string("\x08\0\0\0\0", 5)) +
         chunk("IDAT", packed) + chunk("IEND", "");
}

}  // namespace kerf
