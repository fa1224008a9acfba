// SPDX-License-Identifier: Apache-2.0
#include "viewer/shaders.h"

namespace cholecystectomy {

const char* const kSceneVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 rest;
layout(location = 3) in vec4 color;
layout(location = 4) in vec3 burn;
layout(location = 5) in int material;
uniform mat4 view_of_world;
uniform mat4 clip_of_view;
out vec3 v_position;
out vec3 v_normal;
out vec3 v_rest;
out vec4 v_color;
out vec3 v_burn;
out float v_depth;
flat out int v_material;
void main() {
  vec4 view_position = view_of_world * vec4(position, 1);
  gl_Position = clip_of_view * view_position;
  v_position = position;
  v_normal = normal;
  v_rest = rest;
  v_color = color;
  v_burn = burn;
  v_depth = -view_position.z;
  v_material = material;
}
)";

const char* const kScreenVertexShader = R"(#version 330 core
out vec2 v_place;  // 0..1 over the picture
void main() {
  v_place = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2 * v_place - 1, 0, 1);
}
)";

const char* const kEmptyFragmentShader = R"(#version 330 core
void main() {}
)";

const char* const kGeometryFragmentShader = R"(#version 330 core
in vec3 v_normal;
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
const char* const kOcclusionFragmentShader = R"(#version 330 core
in vec2 v_place;
uniform sampler2D geometry;
uniform vec2 tangent;
uniform float radius;  // m
out float visibility;
const int kSamples = 14;
const float kGoldenAngle = 2.39996323;
vec3 position_at(vec2 place, float depth) {
  return vec3((2 * place - 1) * tangent * depth, -depth);
}
void main() {
  vec4 here = texture(geometry, v_place);
  visibility = 1;
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
  visibility = max(0, 1 - 2.6 * sum / float(kSamples));
}
)";

const char* const kOcclusionBlurFragmentShader = R"(#version 330 core
in vec2 v_place;
uniform sampler2D geometry;
uniform sampler2D occlusion;
out float visibility;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 last = textureSize(occlusion, 0) - 1;
  float depth = texelFetch(geometry, pixel, 0).w;
  float sum = 0;
  float weights = 0;
  // 4 x 4 pixels, the period of the turned samples
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      ivec2 other = clamp(pixel + ivec2(x, y), ivec2(0), last);
      float difference = abs(texelFetch(geometry, other, 0).w - depth);
      float weight = max(0.001, 1 - difference / (0.03 * max(depth, 1e-6)));
      sum += weight * texelFetch(occlusion, other, 0).r;
      weights += weight;
    }
  }
  visibility = sum / weights;
}
)";

// Tissue: a wet film (GGX: Walter, Marschner, Li, Torrance 2007) over wrapped diffuse light whose
// red reaches farther into the shade, as light that travels under skin does. All detail comes from
// solid noise at the rest position, so it sticks to tissue and is there on cut faces. The gradient
// of that noise is taken as if rest and world axes agreed: a turned organ has turned bumps, which
// nobody can see.
const char* const kTissueFragmentShader = R"(#version 330 core
in vec3 v_position;
in vec3 v_normal;
in vec3 v_rest;
in vec4 v_color;
in vec3 v_burn;
in float v_depth;
flat in int v_material;
uniform samplerBuffer materials;
uniform sampler3D gradient_noise;
uniform sampler3D cell_noise;
uniform sampler2D geometry;
uniform sampler2D occlusion;
uniform sampler2DShadow shadow_map;
uniform mat4 clip_of_world_from_light;
uniform vec3 eye;
uniform vec3 light;
uniform vec3 forward;
uniform float reference_distance;
uniform float brightness;
uniform vec2 picture_size;
out vec4 radiance;

const float kPi = 3.14159265;
const vec3 kCavity = vec3(0.30, 0.105, 0.075);  // light that other tissue sends back

vec4 gradient_at(vec3 p) { return 2 * texture(gradient_noise, p / 8) - 1; }
vec4 cell_at(vec3 p) { return 2 * texture(cell_noise, p / 8) - 1; }

float ambient_visibility() {
  // joined by depth, so that the half-size map does not bleed over edges
  vec2 texel = gl_FragCoord.xy * 0.5 - 0.5;
  ivec2 base = ivec2(floor(texel));
  vec2 part = texel - vec2(base);
  ivec2 last = textureSize(occlusion, 0) - 1;
  float sum = 0;
  float weights = 0;
  for (int i = 0; i < 4; ++i) {
    ivec2 bit = ivec2(i & 1, i >> 1);
    ivec2 at = clamp(base + bit, ivec2(0), last);
    vec2 near = mix(1 - part, part, vec2(bit));
    float difference = abs(texelFetch(geometry, at, 0).w - v_depth);
    float weight = (near.x * near.y + 0.01) * max(0.002, 1 - difference / (0.02 * v_depth));
    sum += weight * texelFetch(occlusion, at, 0).r;
    weights += weight;
  }
  return sum / weights;
}

float light_visibility(vec3 n) {
  vec3 at = v_position + n * 0.006 * reference_distance;
  vec4 clip = clip_of_world_from_light * vec4(at, 1);
  vec3 place = clip.xyz / clip.w * 0.5 + 0.5;
  if (any(lessThan(place, vec3(0))) || any(greaterThan(place, vec3(1)))) {
    return 1.0;
  }
  float sum = 0;
  float texel = 1.3 / float(textureSize(shadow_map, 0).x);
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      sum += texture(shadow_map, vec3(place.xy + texel * vec2(x, y), place.z - 0.0004));
    }
  }
  return sum / 9;
}

float ggx(float ndh, float alpha) {
  float a2 = alpha * alpha;
  float d = ndh * ndh * (a2 - 1) + 1;
  return a2 / (kPi * d * d);
}

float smith(float ndv, float ndl, float alpha) {
  float k = alpha / 2;
  return 1 / ((ndv * (1 - k) + k) * (ndl * (1 - k) + k));  // G / (ndv ndl)
}

float schlick(float f0, float cosine) { return f0 + (1 - f0) * pow(1 - cosine, 5); }

vec3 add_bump(vec3 n, vec3 gradient) {
  return normalize(n - (gradient - n * dot(n, gradient)));
}

vec4 shade_smoke(vec3 incoming) {
  float r = length(v_rest.xy);
  float body = smoothstep(1.0, 0.15, r);
  float wisp = 0.5 + 0.7 * gradient_at(vec3(v_rest.xy * 1.1, v_rest.z * 1.7)).w +
               0.35 * gradient_at(vec3(v_rest.xy * 2.7, v_rest.z * 2.3 + 4)).w;
  float behind = texture(geometry, gl_FragCoord.xy / picture_size).w;
  float soft = behind > 0 ? clamp((behind - v_depth) / max(v_burn.x, 1e-6) + 0.2, 0, 1) : 1;
  return vec4(0.55 * v_color.rgb * incoming, v_color.a * body * soft * clamp(wisp, 0.0, 1.0));
}

vec3 shade_tool(vec3 n, vec3 v, vec3 l, vec3 incoming, float shade, float ambient, bool steel) {
  vec4 brushed = gradient_at(v_rest / 0.0012);
  n = add_bump(n, 0.03 * brushed.xyz);
  float ndl = max(dot(n, l), 0);
  float ndv = max(dot(n, v), 0.02);
  vec3 h = normalize(l + v);
  float alpha = steel ? 0.10 : 0.16;
  float f0 = steel ? 0.55 : 0.04;
  float spec = min(4.0, ggx(max(dot(n, h), 0), alpha) * smith(ndv, max(ndl, 0.02), alpha) / 4);
  // what a rod mirrors: the lit scope behind the eye, red tissue at the sides
  float back = max(dot(reflect(-v, n), v), 0);
  vec3 mirrored = mix(kCavity * 0.9, vec3(0.62, 0.62, 0.64), smoothstep(0.15, 0.9, back * back));
  vec3 base = steel ? mirrored * (0.55 + 0.45 * ambient) : vec3(0.022, 0.022, 0.026);
  float lit = steel ? 0.35 + 0.65 * ndl : 0.25 + 0.75 * ndl;
  vec3 edge = schlick(f0, ndv) * kCavity * ambient * (steel ? 0.35 : 0.9);
  return incoming * (base * lit * mix(0.35, 1.0, shade) + edge +
                     vec3(schlick(f0, max(dot(v, h), 0)) * spec * ndl * shade));
}

void main() {
  vec4 color = texelFetch(materials, 4 * v_material);
  vec3 mottle = texelFetch(materials, 4 * v_material + 1).rgb;
  vec4 surface = texelFetch(materials, 4 * v_material + 2);
  vec2 pattern = texelFetch(materials, 4 * v_material + 3).xy;
  int kind = int(surface.w + 0.5);

  vec3 to_light = light - v_position;
  float distance = length(to_light);
  vec3 l = to_light / distance;
  vec3 v = normalize(eye - v_position);
  // inverse square, held back near the scope as the camera's own exposure control does
  float reach = distance / reference_distance;
  float cone = pow(max(dot(-l, forward), 0), 2.0);
  vec3 incoming = brightness * vec3(1.0, 0.965, 0.92) * 1.25 / (reach * reach + 0.25) *
                  mix(0.35, 1.0, cone);

  if (kind == 3) {
    radiance = shade_smoke(incoming);
    return;
  }
  vec3 n = v_normal / max(length(v_normal), 1e-6);
  n = gl_FrontFacing ? n : -n;
  float ambient = ambient_visibility();
  float shade = light_visibility(n);
  if (kind != 0) {
    radiance = vec4(min(shade_tool(n, v, l, incoming, shade, ambient, kind == 1), vec3(6)), 1);
    return;
  }

  // --- detail -----------------------------------------------------------------------------------
  vec3 p = v_rest / surface.y;
  vec4 fine = gradient_at(p * 2.9 + 0.37);
  vec4 medium = gradient_at(p);
  vec4 coarse = gradient_at(p * 0.21 + 0.71);
  float relief = surface.z;
  vec3 bump = relief * (0.55 * medium.xyz + 0.35 * fine.xyz);
  float opacity = color.a;
  vec3 albedo = mix(color.rgb, mottle, smoothstep(-0.35, 0.55, coarse.w + 0.35 * medium.w));
  if (v_color.a >= 0) {
    albedo = v_color.rgb * (1 + 0.18 * medium.w);
    opacity = v_color.a;
  }
  float crease = 0;
  if (pattern.x > 0) {
    vec4 cell = cell_at(p * 0.8 + 0.22 * medium.xyz);
    bump += pattern.x * 0.75 * cell.xyz;
    crease = pattern.x * (1 - smoothstep(0.0, 0.30, 0.5 * cell.w + 0.5));
    albedo = mix(albedo, mottle * vec3(0.85, 0.62, 0.45), 0.65 * crease);
    albedo *= 1 + 0.18 * pattern.x * fine.w;
  }
  if (pattern.y > 0) {
    vec3 q = p * 0.30 + 0.16 * medium.xyz;
    float trunk = abs(gradient_at(q).w);
    float twig = abs(gradient_at(q * 2.3 + 3.1).w);
    float line = (1 - smoothstep(0.015, 0.055, trunk)) * smoothstep(-0.25, 0.1, coarse.w) +
                 0.55 * (1 - smoothstep(0.02, 0.07, twig)) * smoothstep(0.0, 0.3, medium.w + coarse.w);
    albedo = mix(albedo, vec3(0.42, 0.055, 0.045), min(1.0, line) * pattern.y * 0.8);
  }

  // --- burn: pale, then tan, brown and black ------------------------------------------------------
  float grain = 0.6 * fine.w + 0.5 * medium.w;
  float coagulation = v_burn.x <= 0 ? 0 : smoothstep(0.05, 0.55, v_burn.x * (1 + 0.5 * grain));
  float charring = v_burn.y <= 0 ? 0 : clamp(v_burn.y * (1.15 + 0.7 * grain), 0, 1);
  albedo = mix(albedo, vec3(0.80, 0.72, 0.58) * (1 + 0.12 * grain), 0.92 * coagulation);
  albedo = mix(albedo, vec3(0.36, 0.19, 0.075), smoothstep(0.04, 0.28, charring));
  albedo = mix(albedo, vec3(0.075, 0.030, 0.014), smoothstep(0.22, 0.52, charring));
  albedo = mix(albedo, vec3(0.010, 0.008, 0.007), smoothstep(0.45, 0.80, charring));
  opacity = max(opacity, max(0.85 * coagulation, smoothstep(0.05, 0.4, charring)) *
                             step(0.02, opacity));
  float dry = max(0.45 * coagulation, smoothstep(0.05, 0.45, charring));
  bump += (0.35 * coagulation + 0.9 * charring) * (0.4 * medium.xyz + 0.45 * fine.xyz);

  float wet = v_burn.z;
  float gloss = max(surface.x * (1 - dry), wet * 0.98);
  albedo *= mix(1.0, 0.72, wet);
  vec3 bumped = add_bump(n, bump);

  // --- light ----------------------------------------------------------------------------------
  float ndl = dot(bumped, l);
  vec3 wrap = vec3(0.42, 0.17, 0.13) * (1 - 0.8 * charring);
  vec3 diffuse = clamp((ndl + wrap) / (1 + wrap), 0, 1);
  vec3 shadow = mix(vec3(0.22, 0.085, 0.065), vec3(1), shade);
  vec3 hollow = pow(vec3(ambient), vec3(0.75, 1.15, 1.25));  // red survives in folds
  vec3 lit = albedo * (diffuse * shadow * mix(vec3(0.25), vec3(1), hollow) * (1 - 0.35 * crease) +
                       0.35 * kCavity * hollow);

  vec3 film_normal = add_bump(n, bump * mix(0.7, 0.35, wet) + 0.05 * fine.xyz);
  vec3 h = normalize(l + v);
  float ndh = max(dot(film_normal, h), 0);
  float ndv = max(dot(film_normal, v), 0.04);
  float film_ndl = max(dot(film_normal, l), 0);
  float sharp = mix(0.26, 0.035, gloss);
  float f0 = 0.030;
  float fresnel = schlick(f0, max(dot(v, h), 0));
  float highlight = fresnel * film_ndl / 4 *
                    (0.55 * ggx(ndh, sharp) * smith(ndv, max(film_ndl, 0.04), sharp) +
                     0.45 * ggx(ndh, 0.22) * smith(ndv, max(film_ndl, 0.04), 0.22));
  highlight *= gloss * mix(0.15, 1.0, shade);
  float rim = schlick(f0, ndv) * gloss * ambient * 0.55;
  vec3 shine = vec3(highlight) + rim * kCavity;
  vec3 total = incoming * (lit + shine / max(opacity, 0.25));
  radiance = vec4(min(total, vec3(6)), clamp(opacity + min(highlight, 1.0) * step(0.02, opacity), 0, 1));
}
)";

const char* const kGlowFragmentShader = R"(#version 330 core
in vec2 v_place;
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

const char* const kScopeFragmentShader = R"(#version 330 core
in vec2 v_place;
uniform sampler2D scene;
uniform sampler2D glow;
uniform float aspect;
out vec4 pixel;
// Narkowicz 2016, "ACES filmic tone mapping curve"
vec3 expose(vec3 x) { return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1); }
vec3 srgb(vec3 x) {
  return mix(12.92 * x, 1.055 * pow(x, vec3(1 / 2.4)) - 0.055, step(vec3(0.0031308), x));
}
void main() {
  vec2 from_center = (v_place - 0.5) * vec2(aspect, 1);
  float r = length(from_center) / 0.60;  // the mask's radius, in heights of the picture
  vec3 light = texture(scene, v_place).rgb + 0.10 * texture(glow, v_place).rgb;
  light *= 1 - 0.55 * r * r;
  float mask = 1 - smoothstep(0.975, 1.0, r);
  pixel = vec4(srgb(expose(light)) * mask, 1);
}
)";

}  // namespace cholecystectomy
