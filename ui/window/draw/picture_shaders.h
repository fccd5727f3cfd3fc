// GLSL 3.30 sources of the two passes of MeshPicture. View frame: x right, y up, z to the viewer, mm. Parallel
// projection. Light is computed with a gamma of 2, as in live_shaders.h.
#pragma once

namespace kerf::picture_shaders {

// After McGuire et al., "The Alchemy screen-space ambient obscurance algorithm", HPG 2011, with weights by angle; the
// pattern turns over a 4 x 4 tile, which the finish pass averages away. Second channel: a march towards the key light.
inline constexpr const char* kOcclusion = R"(
uniform sampler2D depth_map;
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
// Along one side of the picture: to the neighbour on the same surface.
vec3 along(ivec2 p, ivec2 step) {
  vec3 to = at(p + step) - at(p), from = at(p) - at(p - step);
  return abs(to.z) < abs(from.z) ? to : from;
}
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  result = vec4(1.0);
  if (texelFetch(depth_map, pixel, 0).r >= 0.9999 || samples == 0) return;
  const int bayer[16] = int[16](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);
  float tile = (float(bayer[(pixel.y & 3) * 4 + (pixel.x & 3)]) + 0.5) / 16.0;
  vec3 p = at(pixel), n = normalize(cross(along(pixel, ivec2(1, 0)), along(pixel, ivec2(0, 1))));
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
  result.g = mix(1.0, lit, smoothstep(-0.1, 0.6, dot(n, key_light)));  // a side that is turned away is dark already
}
)";

// Mean of factor x factor points in linear light; alpha comes out straight, not premultiplied.
inline constexpr const char* kFinish = R"(
uniform sampler2D depth_map;
uniform sampler2D color_map;
uniform sampler2D occlusion_map;
uniform sampler2D ground_map;
uniform mat3 rotation;      // world -> view
uniform vec2 points;        // size of the maps
uniform float mm_per_point;
uniform float half_depth;
uniform float reach;
uniform vec4 ground;        // world: centre x, y of the map; z of the plane; side of the map, relative to the target; mm
uniform int flags;          // 1: ground shadow, 2: transparent
uniform int factor;
out vec4 result;

vec4 background(vec2 p) {
  if ((flags & 2) != 0) return vec4(0.0);
  vec2 q = (p - 0.5 * points) / points.y;
  vec3 c = mix(vec3(0.968, 0.972, 0.976), vec3(0.83, 0.846, 0.862), clamp(dot(q, q) * 1.1, 0.0, 1.0));
  c *= c;
  vec3 backwards = transpose(rotation) * vec3(0.0, 0.0, 1.0);
  if ((flags & 1) != 0 && backwards.z > 0.02) {
    vec3 w = transpose(rotation) * vec3((p - 0.5 * points) * mm_per_point, 0.0);
    w += backwards * ((ground.z - w.z) / backwards.z);
    vec2 uv = (w.xy - ground.xy) / ground.w + 0.5;
    c *= 1.0 - 0.55 * smoothstep(0.02, 0.3, backwards.z) * texture(ground_map, uv).r;
  }
  return vec4(c, 1.0);
}
vec4 shown(ivec2 point) {
  float depth = texelFetch(depth_map, point, 0).r;
  if (depth >= 0.9999) return background(vec2(point) + 0.5);
  vec2 shadow = vec2(0.0);
  float weight = 0.0;
  for (int y = -2; y < 2; ++y)
    for (int x = -2; x < 2; ++x) {
      ivec2 q = clamp(point + ivec2(x, y), ivec2(0), ivec2(points) - 1);
      float far = abs(texelFetch(depth_map, q, 0).r - depth) * 2.0 * half_depth;
      float w = far < 0.25 * reach + 6.0 * mm_per_point ? 1.0 : 1e-4;
      shadow += w * texelFetch(occlusion_map, q, 0).rg;
      weight += w;
    }
  shadow /= weight;
  vec3 c = texelFetch(color_map, point, 0).rgb;
  vec3 crevice = pow(vec3(shadow.r), vec3(0.9, 1.0, 1.08));  // light that bounces in a crevice turns warm
  return vec4(c * c * crevice * mix(0.55, 1.0, smoothstep(0.0, 1.0, shadow.g)), 1.0);
}
void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * factor;
  vec4 sum = vec4(0.0);
  for (int y = 0; y < factor; ++y)
    for (int x = 0; x < factor; ++x) {
      vec4 c = shown(first + ivec2(x, y));
      sum += vec4(c.rgb * c.a, c.a);
    }
  vec3 c = sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
  result = vec4(sqrt(c), sum.a / float(factor * factor));
}
)";

}  // namespace kerf::picture_shaders
