// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/shaders.h"

namespace cholecystectomy {

const char* const kScreenVertexShader = R"(out vec2 v_place;  // 0..1 over the picture
void main() {
  v_place = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2 * v_place - 1, 0, 1);
}
)";

const char* const kEmptyFragmentShader = R"(void main() {}
)";

const char* const kGeometryFragmentShader = R"(in vec3 v_normal;
in float v_depth;
uniform mat4 view_of_world;
out vec4 normal_and_depth;
void main() {
  vec3 n = mat3(view_of_world) * v_normal;
  normal_and_depth = vec4((gl_FrontFacing ? n : -n) / max(length(n), 1e-6), v_depth);
}
)";

// Ambient obscurance: McGuire, Osman, Bukowski, Hennessy 2011, "The Alchemy screen-space ambient
// obscurance algorithm", equation 10.
const char* const kOcclusionFragmentShader = R"(in vec2 v_place;
uniform sampler2D geometry;
uniform vec2 tangent;
uniform float radius;  // m
out vec2 visibility_and_depth;
const int kSamples = 14;
const float kGoldenAngle = 2.39996323;
vec3 position_at(vec2 place, float depth) {
  return vec3((2 * place - 1) * tangent * depth, -depth);
}
void main() {
  vec4 here = texture(geometry, v_place);
  visibility_and_depth = vec2(1, here.w);
  if (here.w <= 0) {
    return;
  }
  vec3 center = position_at(v_place, here.w);
  vec2 reach = min(vec2(0.12), radius / (2 * tangent * here.w));
  ivec2 pixel = ivec2(gl_FragCoord.xy) & 3;
  float turn = 6.2831853 * float((pixel.x * 4 + pixel.y * 7 + pixel.x * pixel.y * 3) & 15) / 16;
  float sum = 0;
  for (int i = 0; i < kSamples; ++i) {
    float along = (float(i) + 0.5) / float(kSamples);
    float angle = turn + float(i) * kGoldenAngle;
    vec2 place = v_place + reach * along * vec2(cos(angle), sin(angle));
    float depth = texture(geometry, place).w;
    if (depth <= 0) {
      continue;
    }
    vec3 offset = position_at(place, depth) - center;
    float squared = dot(offset, offset);
    float fade = max(0, 1 - squared / (radius * radius));
    sum += fade * max(0, dot(offset, here.xyz) - 0.012 * radius - 0.004 * here.w) /
           (sqrt(squared) + 0.02 * radius);
  }
  visibility_and_depth.x = max(0, 1 - 2.6 * sum / float(kSamples));
}
)";

const char* const kOcclusionBlurFragmentShader = R"(uniform sampler2D occlusion;
out vec2 visibility_and_depth;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 last = textureSize(occlusion, 0) - 1;
  float depth = texelFetch(occlusion, pixel, 0).y;
  if (depth <= 0) {
    visibility_and_depth = vec2(1, depth);
    return;
  }
  float scale = 1 / (0.03 * depth);
  float sum = 0;
  float weights = 0;
  // 4 x 4 pixels, the period of the turned samples
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      vec2 other = texelFetch(occlusion, clamp(pixel + ivec2(x, y), ivec2(0), last), 0).xy;
      float weight = max(0.001, 1 - abs(other.y - depth) * scale);
      sum += weight * other.x;
      weights += weight;
    }
  }
  visibility_and_depth = vec2(sum / weights, depth);
}
)";

const char* const kGlowFragmentShader = R"(in vec2 v_place;
uniform sampler2D source;
uniform vec2 stride;      // from one sample to the next, of the picture
uniform float threshold;  // only what is brighter glows
out vec4 glow;
void main() {
  vec3 sum = vec3(0);
  float weights = 0;
  for (int i = -4; i <= 4; ++i) {
    float weight = exp(-float(i * i) / 8);
    sum += weight * max(texture(source, v_place + float(i) * stride).rgb - threshold, 0);
    weights += weight;
  }
  glow = vec4(sum / weights, 1);
}
)";

const char* const kScopeFragmentShader = R"(in vec2 v_place;
uniform sampler2D scene;
#ifdef GLOW
uniform sampler2D glow;
#endif
uniform float aspect;
uniform float tangent;  // of half the vertical field of view
uniform float figure;
out vec4 pixel;
// Narkowicz 2016, "ACES filmic tone mapping curve"
vec3 expose(vec3 x) { return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1); }
vec3 srgb(vec3 x) {
  return mix(12.92 * x, 1.055 * pow(x, vec3(1 / 2.4)) - 0.055, step(vec3(0.0031308), x));
}
#ifdef DETAIL
vec3 encode(vec3 x) { return srgb(x); }
#else
vec3 encode(vec3 x) {  // by square roots, within half a step of 8 bits
  vec3 root = sqrt(x);
  vec3 fourth = sqrt(root);
  return clamp(0.662002687 * root + 0.684122060 * fourth - 0.323583601 * sqrt(fourth) -
                   0.0225411470 * x, 0, 1);
}
#endif
void main() {
  vec2 from_center = (v_place - 0.5) * vec2(aspect, 1);
  float r = length(from_center) / 0.60;  // the mask's radius, in heights of the picture
  if (r >= 1 && figure < 0.5) {
    pixel = vec4(0, 0, 0, 1);
    return;
  }
  vec3 light = texelFetch(scene, ivec2(gl_FragCoord.xy), 0).rgb;
  if (figure > 0.5) {
    pixel = vec4(srgb(clamp(light, 0, 1)), 1);
    return;
  }
#ifdef GLOW
  light += 0.10 * texture(glow, v_place).rgb;
#endif
  float off_axis = 2 * tangent * length(from_center);
  float cosine_squared = 1 / (1 + off_axis * off_axis);
  light *= cosine_squared * cosine_squared;  // a lens dims by the fourth power of the cosine
  light = mix(vec3(dot(light, vec3(0.2126, 0.7152, 0.0722))), light, 0.86);
  float mask = 1 - smoothstep(0.975, 1.0, r);
  pixel = vec4(encode(expose(light)) * mask, 1);
}
)";

}  // namespace cholecystectomy
