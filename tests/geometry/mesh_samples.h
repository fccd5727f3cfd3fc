// Small files in every format, built byte by byte, independent of Kerf's own writers.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace kerf::samples {

template <class T>
std::string bytes(T value, bool big = false) {
  std::string s(reinterpret_cast<const char*>(&value), sizeof value);
  if (big) s.assign(s.rbegin(), s.rend());
  return s;
}
static_assert(std::endian::native == std::endian::little);

inline constexpr float kCorner[4][3] = {{0, 0, 0}, {1.5f, 0, 0}, {0, 0.1f, 0}, {0, 0, -3e-5f}};
inline constexpr std::uint32_t kFace[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};

inline std::string binaryStl(const std::string& title = "a tetrahedron", std::uint32_t count = 4,
                             std::uint16_t attribute = 0) {
  std::string s = title;
  s.resize(80, ' ');
  s += bytes(count);
  for (const auto& face : kFace) {
    s += std::string(12, '\0');
    for (const std::uint32_t v : face)
      for (const float c : kCorner[v]) s += bytes(c);
    s += bytes(attribute);
  }
  return s;
}

inline std::string asciiStl(const std::string& eol = "\n") {
  std::string s = "Solid tooth 36" + eol;
  for (const auto& face : kFace) {
    s += "  FACET Normal nan 0 0" + eol + "outer loop" + eol;
    for (const std::uint32_t v : face) {
      constexpr const char* kText[4] = {"0 0 0", "+1.5 0 0", "0.0e0 0.1 0", "0 -0 -3E-5"};
      s += "\tvertex " + std::string(kText[v]) + eol;
    }
    s += "endloop" + eol + "endfacet" + eol;
  }
  return s + "ENDSOLID tooth 36" + eol;
}

// double positions, unknown properties and elements, one quad-free tetrahedron with colours on vertices and faces
inline std::string binaryPly(bool big, std::uint32_t vertices = 4, std::uint32_t faces = 4) {
  std::string s =
      "ply\nformat binary_" + std::string(big ? "big" : "little") +
      "_endian 1.0\ncomment units: mm\nobj_info none\nelement camera 1\nproperty list uchar short pose\n"
      "element vertex " +
      std::to_string(vertices) +
      "\nproperty float quality\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nelement face " +
      std::to_string(faces) +
      "\nproperty list uchar uint vertex_index\nproperty uchar red\nproperty uchar green\nproperty uchar "
      "blue\nproperty uchar alpha\nend_header\n";
  s += bytes<std::uint8_t>(2) + bytes<std::int16_t>(-5, big) + bytes<std::int16_t>(7, big);
  for (std::uint8_t v = 0; v < 4; ++v) {
    s += bytes(0.5f, big);
    for (const float c : kCorner[v]) s += bytes(static_cast<double>(c), big);
    s += {static_cast<char>(10 + v), 20, 30};
  }
  for (std::uint8_t f = 0; f < 4; ++f) {
    s += '\3';
    for (const std::uint32_t v : kFace[f]) s += bytes(v, big);
    s += {static_cast<char>(100 + f), 1, 2, static_cast<char>(200)};
  }
  return s;
}

inline std::string asciiPly() {
  return "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
         "property uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\nproperty uchar alpha\r\nelement face "
         "4\r\n"
         "property list uchar int vertex_indices\r\nend_header\r\n"
         "0 0 0 10 20 30 255\r\n1.5 0 0 11 20 30 255\r\n0 0.1 0 12 20 30 255\r\n0 0 -3e-5 13 20 30 254\r\n"
         "3 0 1 2\r\n3 0 3 1\r\n3 1 3 2\r\n3 0 2 3\r\n";
}

inline std::string obj() {
  return "# units = mm\nmtllib absent.mtl\nv 0 0 0 0 0 1\nvn 0 0 1\nv 1.5 0 0 0 1 0\nvt 0 0\nv 0 0.1 0 1 0 0\n"
         "v 0 0 -3e-5 1 1 1\nf 1//1 2//1 3//1\nf 1/1 4/1 \\\n2/1\nf 2 4 3\nf -4/1/1 -2/1/1 -1/1/1\n";
}

inline std::string off() {
  return "COFF # a comment\n4 4 0\n\n0 0 0 10 20 30 255\n1.5 0 0 11 20 30 255\n0 0.1 0 12 20 30 255\n"
         "0 0 -3e-5 13 20 30 255\n3 0 1 2 1 2 3\n3 0 3 1 4 5 6\n3 1 3 2\n3 0 2 3 0.5 1.0 0.0\n";
}

}  // namespace kerf::samples
