// GLSL 3.30 sources of the live renderer. View frame: x right, y up, z to the viewer, mm.
//
// The parts are joined to programs by live_renderer.cpp: version, #defines, kLight, then one of the others. Light is
// computed with a gamma of 2, so that a square and a root take the place of powers.
#pragma once

namespace kerf::live_shaders {

// The whole light of a surface: hemisphere, key and fill light, a clear coat, tone map, gamma.
inline constexpr const char* kLight = R"(
uniform vec3 key_light;   // unit, view frame
uniform vec3 key_half;    // unit, between the key light and the viewer
uniform vec3 fill_light;  // unit

// A soft shoulder keeps shape in the brightest parts and leaves the colour alone elsewhere.
vec3 toned(vec3 c) {
  vec3 over = max(c - 0.6, 0.0);
  return sqrt(min(c, 0.6) + over / (1.0 + over * 2.5));
}

// n: unit. color: gamma encoded. gloss: 0 matte, 1 wet. open: share of the light from around.
vec3 lit(vec3 n, vec3 color, float gloss, float open) {
  vec3 albedo = color * color;
  // What is thrown back and forth in a crevice keeps it from turning grey: bright tissue fills it with its own colour.
  vec3 crevice = vec3(open) / (1.0 - 0.5 * albedo * (1.0 - open));

  float up = 0.5 + 0.5 * n.y;
  vec3 light = mix(vec3(0.20, 0.172, 0.148), vec3(0.375, 0.372, 0.37), up) * crevice;
  // Light enters tissue and comes out beside: red the farthest, so the edge of the shade is soft and warm.
  const vec3 wrap = vec3(0.32, 0.25, 0.20);
  vec3 key = max((dot(n, key_light) + wrap) / (1.0 + wrap), 0.0);
  light += vec3(0.80, 0.74, 0.655) * key * mix(vec3(1.0), crevice, 0.75);
  light += vec3(0.15, 0.142, 0.13) * max(dot(n, fill_light), 0.0) * crevice;

  // Clear coat of enamel, F0 = ((1.63 - 1) / 2.63)^2, under a key light and a bright ceiling.
  float grazing = 1.0 - clamp(n.z, 0.0, 1.0);
  float grazing2 = grazing * grazing;
  float fresnel = 0.057 + 0.6 * grazing2 * grazing2;
  float d = dot(n, key_half);
  d = d * d * -0.985 + 1.0;
  float ceiling = clamp(2.0 * n.z * n.y - 0.1, 0.0, 1.0);
  float coat = gloss * open * (0.0045 / (d * d + 0.0006) * 0.085 + fresnel * ceiling * 0.9);
  vec3 rim = vec3(0.10, 0.11, 0.12) * grazing2 * grazing * up * open;
  return toned(albedo * light + coat + rim);
}
)";

// Interpolation of values across a triangle. In parallel projection both ways agree, and the plain one is cheaper. In
// perspective it is wrong: a gradient bends, and a triangle that goes past the eye is wrong everywhere.
inline constexpr const char* kAcross = R"(
#ifdef PERSPECTIVE
#define ACROSS
#else
#define ACROSS noperspective
#endif
)";

inline constexpr const char* kTissueVertex = R"(
layout(location = 0) in vec3 position;  // object frame, mm
layout(location = 1) in vec4 normal;    // object frame, unit; w: occlusion
layout(location = 2) in vec4 color;     // gamma encoded; a: gloss
uniform mat4 to_clip;
uniform mat3 to_view;
invariant gl_Position;  // the programs of two neighbouring pages leave no crack between them
#ifdef BY_PIXEL
ACROSS out vec4 view_normal;     // w: occlusion
ACROSS out vec4 surface_color;
#else
ACROSS out vec3 shown;
#endif
#ifdef GHOST
ACROSS out float opacity;
#endif
#ifdef TOOL
uniform mat4 to_tool;
ACROSS out vec4 tool_point;      // tool's approach frame, mm; w: cosine to the tool
#endif
#ifdef SECTION
uniform vec4 section;                   // object frame: normal, offset; positive is taken away
#endif
void main() {
  gl_Position = to_clip * vec4(position, 1.0);
#ifdef BY_PIXEL
  view_normal = vec4(to_view * normal.xyz, normal.w);
  surface_color = color;
#else
  shown = lit(to_view * normal.xyz, color.rgb, color.a, normal.w);
#endif
#ifdef GHOST
  // Like glass: clearest where it faces the viewer.
  float grazing = 1.0 - abs((to_view * normal.xyz).z);
  opacity = 0.16 + 0.6 * grazing * grazing;
#endif
#ifdef TOOL
  tool_point = vec4((to_tool * vec4(position, 1.0)).xyz, (mat3(to_tool) * normal.xyz).z);
#endif
#ifdef SECTION
  gl_ClipDistance[0] = -dot(section, vec4(position, 1.0));
#endif
}
)";

inline constexpr const char* kTissueFragment = R"(
#ifdef BY_PIXEL
ACROSS in vec4 view_normal;
ACROSS in vec4 surface_color;
#else
ACROSS in vec3 shown;
#endif
#ifdef GHOST
ACROSS in float opacity;
#endif
#ifdef TOOL
ACROSS in vec4 tool_point;
uniform vec4 footprint;           // approach frame: middle, half extents, mm
uniform vec4 shadow;              // strength; its reach below the tip, mm; 1: round; pixels per mm
uniform vec2 tool_height;         // approach frame: lowest, highest, mm
#endif
#ifdef TINT
uniform sampler3D tool_distance;  // mm
uniform vec3 table_low, table_scale;
uniform float contact;            // mm
uniform vec3 tint;
#endif
#ifdef SECTION
uniform vec3 section_color;
uniform int has_tissues;
uniform sampler2D section_tissues;      // of the plane: colours times their alpha
uniform vec3 section_across, section_up, section_weight;  // of a pixel (x, y, 1): where it is in that picture
#endif
out vec4 result;
void main() {
#ifdef SECTION
  if (!gl_FrontFacing) {  // the inside of a solid: what is seen is the section through it
    vec3 pixel = vec3(gl_FragCoord.xy, 1.0);
    vec4 tissue = has_tissues == 0 ? vec4(0.0) : texture(section_tissues, vec2(dot(section_across, pixel), dot(section_up, pixel)) / dot(section_weight, pixel));
    result = vec4(tissue.a > 0.02 ? tissue.rgb / tissue.a : section_color, 1.0);
    return;
  }
#endif
#ifdef BY_PIXEL
  vec3 c = lit(normalize(view_normal.xyz), surface_color.rgb, surface_color.a, view_normal.w);
#else
  vec3 c = shown;
#endif
#ifdef TOOL
  // Hard-edged, one pixel soft; only on what faces the tool and lies below its widest part.
  vec2 q = abs(tool_point.xy - footprint.xy) - footprint.zw;
  float inside = shadow.z > 0.5 ? footprint.z - length(tool_point.xy - footprint.xy) : -max(q.x, q.y);
  float below = tool_height.x - tool_point.z;
  float dark = clamp(inside * shadow.w + 0.5, 0.0, 1.0) * clamp(tool_point.w * 6.0, 0.0, 1.0);
  dark *= clamp(1.0 - below / shadow.y, 0.0, 1.0) * step(tool_point.z, tool_height.y);
  c *= 1.0 - shadow.x * dark;
#endif
#ifdef TINT
  float d = texture(tool_distance, (tool_point.xyz - table_low) * table_scale).r;
  c = mix(c, tint, 0.6 * (1.0 - smoothstep(0.8 * contact, contact, d)));
#endif
#ifdef GHOST
  result = vec4(c, opacity);
#else
  result = vec4(c, 1.0);
#endif
}
)";

// Steel: little colour of its own, mostly reflections of the studio.
inline constexpr const char* kToolVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 normal;
layout(location = 2) in vec4 color;
uniform mat4 to_clip;
uniform mat3 to_view;
out vec3 view_normal;
out vec3 surface_color;
void main() {
  gl_Position = to_clip * vec4(position, 1.0);
  view_normal = to_view * normal.xyz;
  surface_color = color.rgb;
}
)";
inline constexpr const char* kToolFragment = R"(
in vec3 view_normal;
in vec3 surface_color;
uniform float alpha;
out vec4 result;
void main() {
  vec3 n = normalize(view_normal);
  vec3 r = vec3(2.0 * n.z * n.xy, 2.0 * n.z * n.z - 1.0);
  vec3 base = surface_color * surface_color;
  // Light boxes left and right, a bright ceiling, a dark floor: what a polished shank shows.
  float left = smoothstep(-0.95, -0.45, r.x) * (1.0 - smoothstep(-0.40, 0.10, r.x));
  float right = smoothstep(0.45, 0.75, r.x) * (1.0 - smoothstep(0.80, 0.98, r.x));
  float above = smoothstep(-0.3, 0.9, r.y);
  float room = 0.10 + 1.05 * left + 0.45 * right + 0.75 * above;
  float d = max(dot(n, key_half), 0.0);
  d *= d;
  d *= d;
  d *= d;
  d *= d;
  float edge = 1.0 - clamp(n.z, 0.0, 1.0);
  vec3 c = base * (0.12 + 1.1 * room) + 0.4 * d * d * d + 0.10 * edge * edge * edge;
  result = vec4(toned(c), alpha);
}
)";

// Coordinates of the picture, a colour each: the background, the line along the tool's axis.
inline constexpr const char* kFlatVertex = R"(
layout(location = 0) in vec2 position;
layout(location = 1) in vec4 color;
uniform vec3 depth;  // of clip space: along x, along y, in the middle
noperspective out vec4 shown;
void main() {
  gl_Position = vec4(position, dot(depth, vec3(position, 1.0)), 1.0);
  shown = color;
}
)";
// Half a step of noise, so that a slow gradient shows no bands.
inline constexpr const char* kFlatFragment = R"(
noperspective in vec4 shown;
uniform float noise;
out vec4 result;
void main() {
  float n = fract(dot(gl_FragCoord.xy, vec2(0.75487767, 0.56984029)));
  result = shown + noise * (n - 0.5);
}
)";

// The mean of factor x factor points, in linear light.
inline constexpr const char* kReduceVertex = R"(
void main() {
  vec2 p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * p - 1.0, 0.0, 1.0);
}
)";
inline constexpr const char* kReduceFragment = R"(
uniform sampler2D points;
uniform int factor;
out vec4 result;
void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * factor;
  vec3 sum = vec3(0.0);
  for (int y = 0; y < factor; ++y)
    for (int x = 0; x < factor; ++x) {
      vec3 c = texelFetch(points, first + ivec2(x, y), 0).rgb;
      sum += c * c;
    }
  result = vec4(sqrt(sum / float(factor * factor)), 1.0);
}
)";

}  // namespace kerf::live_shaders
