// GLSL 3.30 sources of the renderer. View frame: x right, y up, z to the viewer, mm.
#pragma once

namespace kerf::shaders {

inline constexpr const char* kSurfaceVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 color;
uniform mat3 rotation;     // world -> view
uniform vec3 shift;        // added after the rotation, mm
uniform vec3 half_extent;  // of the view volume, mm
out vec3 view_normal;
out vec3 surface_color;
void main() {
  view_normal = rotation * normal;
  surface_color = color.rgb;
  vec3 p = (rotation * position + shift) / half_extent;
  gl_Position = vec4(p.xy, -p.z, 1.0);
}
)";

// Colours stay sRGB in the 8-bit target. Alpha: 1 outside, 0.5 on the back of a triangle.
inline constexpr const char* kSurfaceFragment = R"(#version 330 core
in vec3 view_normal;
in vec3 surface_color;
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 normal;
void main() {
  vec3 n = normalize(view_normal);
  color = vec4(surface_color, gl_FrontFacing ? 1.0 : 0.5);
  normal = vec4(gl_FrontFacing ? n : -n, 1.0);
}
)";

// One triangle over the whole target.
inline constexpr const char* kScreenVertex = R"(#version 330 core
void main() {
  vec2 p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * p - 1.0, 0.0, 1.0);
}
)";

// After McGuire et al., "The Alchemy screen-space ambient obscurance algorithm", HPG 2011, with weights by angle; the
// pattern turns over a 4 x 4 tile, which the shading pass averages away. Second channel: a march towards the key light.
inline constexpr const char* kOcclusionFragment = R"(#version 330 core
uniform sampler2D depth_map;
uniform sampler2D normal_map;
uniform float mm_per_point;
uniform float half_depth;   // mm
uniform float reach;        // mm, of the occlusion
uniform float shadow_reach; // mm
uniform vec3 key_light;
uniform int samples;
out vec4 result;

vec3 at(ivec2 p) {
  p = clamp(p, ivec2(0), textureSize(depth_map, 0) - 1);
  float z = texelFetch(depth_map, p, 0).r;
  return vec3((vec2(p) + 0.5) * mm_per_point, (1.0 - 2.0 * z) * half_depth);
}
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  result = vec4(1.0);
  if (texelFetch(depth_map, pixel, 0).r >= 1.0 || samples == 0) return;
  const int bayer[16] = int[16](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);
  float tile = (float(bayer[(pixel.y & 3) * 4 + (pixel.x & 3)]) + 0.5) / 16.0;
  vec3 p = at(pixel), n = texelFetch(normal_map, pixel, 0).xyz;
  float most = min(reach / mm_per_point, 400.0), sum = 0.0;
  for (int i = 0; i < samples; ++i) {
    float u = (float(i) + tile) / float(samples);
    float angle = 2.39996323 * float(i) + 6.2831853 * tile;
    vec3 v = at(pixel + ivec2(round((1.0 + most * u * sqrt(u)) * vec2(cos(angle), sin(angle))))) - p;
    float d = length(v) + 1e-6;
    sum += max(0.0, dot(v, n) / d - 0.12) * max(0.0, 1.0 - d / (1.6 * reach));
  }
  result.r = clamp(1.0 - 2.5 * sum / float(samples), 0.0, 1.0);

  float lit = 1.0, bias = 1.5 * mm_per_point;
  vec3 start = p + n * (2.0 * mm_per_point + 0.01 * shadow_reach);
  for (int i = 0; i < samples; ++i) {
    vec3 q = start + key_light * (shadow_reach * (float(i) + tile) / float(samples));
    float above = at(ivec2(floor(q.xy / mm_per_point))).z - q.z;
    float sure = 1.0 - smoothstep(0.1, 0.4, above / shadow_reach);  // what hangs far in front need not be a thick solid
    if (above > bias) lit = min(lit, 1.0 - sure * (1.0 - (float(i) + tile) / float(samples)));
  }
  result.g = lit;
}
)";

inline constexpr const char* kShadeFragment = R"(#version 330 core
uniform sampler2D depth_map;
uniform sampler2D normal_map;
uniform sampler2D color_map;
uniform sampler2D occlusion_map;
uniform sampler2D ground_map;
uniform mat3 rotation;      // world -> view
uniform vec2 points;        // size of the target
uniform float mm_per_point;
uniform float half_depth;
uniform float reach;
uniform vec3 key_light;
uniform vec4 ground;        // world: centre x, y of the map; z of the plane; side of the map, relative to the target; mm
uniform int flags;          // 1: ground shadow, 2: transparent
out vec4 result;

vec3 linear(vec3 c) { return pow(c, vec3(2.2)); }

vec4 background(vec2 p) {
  if ((flags & 2) != 0) return vec4(0.0);
  vec2 q = (p - 0.5 * points) / points.y;
  vec3 c = linear(mix(vec3(0.968, 0.972, 0.976), vec3(0.83, 0.846, 0.862), clamp(dot(q, q) * 1.1, 0.0, 1.0)));
  vec3 backwards = transpose(rotation) * vec3(0.0, 0.0, 1.0);
  if ((flags & 1) != 0 && backwards.z > 0.02) {
    vec3 w = transpose(rotation) * vec3((p - 0.5 * points) * mm_per_point, 0.0);
    w += backwards * ((ground.z - w.z) / backwards.z);
    vec2 uv = (w.xy - ground.xy) / ground.w + 0.5;
    c *= 1.0 - 0.55 * smoothstep(0.02, 0.3, backwards.z) * texture(ground_map, uv).r;
  }
  return vec4(c, 1.0);
}
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(depth_map, pixel, 0).r;
  if (depth >= 1.0) {
    result = background(gl_FragCoord.xy);
    return;
  }
  vec2 shadow = vec2(0.0);
  float weight = 0.0;
  ivec2 last = textureSize(depth_map, 0) - 1;
  for (int y = -2; y < 2; ++y)
    for (int x = -2; x < 2; ++x) {
      ivec2 q = clamp(pixel + ivec2(x, y), ivec2(0), last);
      float far = abs(texelFetch(depth_map, q, 0).r - depth) * 2.0 * half_depth;
      float w = far < 0.25 * reach + 6.0 * mm_per_point ? 1.0 : 1e-4;
      shadow += w * texelFetch(occlusion_map, q, 0).rg;
      weight += w;
    }
  shadow /= weight;

  vec3 n = normalize(texelFetch(normal_map, pixel, 0).xyz);
  vec4 color = texelFetch(color_map, pixel, 0);
  vec3 albedo = linear(color.rgb);
  if (color.a < 0.75) albedo = mix(albedo, vec3(0.16, 0.19, 0.24), 0.75);  // the inside of an open surface

  vec3 crevice = pow(vec3(shadow.r), vec3(0.9, 1.0, 1.08));  // light that bounces in a crevice turns warm
  float lit = smoothstep(0.0, 1.0, shadow.g);
  vec3 light = mix(vec3(0.27, 0.25, 0.24), vec3(0.45, 0.46, 0.49), 0.5 + 0.5 * n.y) * crevice;
  float key = max(0.0, (dot(n, key_light) + 0.15) / 1.15);
  light += vec3(0.80, 0.77, 0.73) * key * mix(0.35, 1.0, lit) * mix(vec3(1.0), crevice, 0.5);
  light += vec3(0.16, 0.18, 0.21) * max(0.0, dot(n, normalize(vec3(0.85, 0.05, 0.5)))) * crevice;
  vec3 c = albedo * light;
  float glance = pow(1.0 - clamp(n.z, 0.0, 1.0), 3.0);
  c += vec3(0.20, 0.21, 0.22) * glance * (0.5 + 0.5 * n.y) * crevice;
  vec3 halfway = normalize(key_light + vec3(0.0, 0.0, 1.0));
  c += vec3(0.16) * pow(max(0.0, dot(n, halfway)), 42.0) * lit * crevice;
  vec3 over = max(c - 0.65, 0.0);  // a soft shoulder keeps shape in the brightest parts
  result = vec4(min(c, 0.65) + over / (1.0 + over / 0.35), 1.0);
}
)";

// Averages in linear light; alpha comes out straight, not premultiplied.
inline constexpr const char* kReduceFragment = R"(#version 330 core
uniform sampler2D shaded_map;
uniform int factor;
out vec4 result;
void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * factor;
  vec4 sum = vec4(0.0);
  for (int y = 0; y < factor; ++y)
    for (int x = 0; x < factor; ++x) {
      vec4 c = texelFetch(shaded_map, first + ivec2(x, y), 0);
      sum += vec4(min(c.rgb, 1.0) * c.a, c.a);
    }
  float alpha = sum.a / float(factor * factor);
  vec3 c = sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
  result = vec4(pow(c, vec3(1.0 / 2.2)), alpha);
}
)";

}  // namespace kerf::shaders
