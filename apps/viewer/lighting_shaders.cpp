// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/shaders.h"

namespace cholecystectomy {

const char* const kLightingFunctions = R"(in vec3 v_position;
in vec3 v_normal;
in vec3 v_rest;
in vec4 v_color;
in vec4 v_burn;
in float v_wetness;
in float v_depth;
#ifdef SKIN
in float v_inner;
#else
flat in int v_material;
#endif
uniform sampler3D gradient_noise;
#ifdef OCCLUSION
uniform sampler2D occlusion;  // visibility, depth
#endif
#ifdef SHADOWS
uniform sampler2DShadow shadow_map;
uniform mat4 clip_of_world_from_light;
#endif
uniform vec3 eye;
uniform vec3 light;
uniform vec3 forward;
uniform float reference_distance;
uniform float brightness;
uniform float haze_density;  // 1 / m
uniform vec3 haze_light;     // what smoke in the cavity sends back of the lamp
out vec4 radiance;

const vec3 kCavity = vec3(0.30, 0.115, 0.085);  // light that other tissue sends back

vec4 noise_at(vec3 p) { return 2 * texture(gradient_noise, p / 8) - 1; }

// Inverse square, held back near the scope as the camera's own exposure control does.
vec3 incoming_light(vec3 to_light) {
  float distance = length(to_light);
  float reach = distance / reference_distance;
  float cone = max(dot(-to_light, forward) / distance, 0);
  return brightness * vec3(1.0, 0.965, 0.92) * 1.45 / (reach * reach + 0.25) *
         mix(0.35, 1.0, cone * cone);
}

// Joined by depth, so that the half-size map does not bleed over edges.
float ambient_visibility() {
#ifdef OCCLUSION
  vec2 texel = gl_FragCoord.xy * 0.5 - 0.5;
  ivec2 base = ivec2(floor(texel));
  vec2 part = texel - vec2(base);
  ivec2 last = textureSize(occlusion, 0) - 1;
  float sum = 0;
  float weights = 0;
  for (int i = 0; i < 4; ++i) {
    ivec2 bit = ivec2(i & 1, i >> 1);
    vec2 near = mix(1 - part, part, vec2(bit));
    vec2 there = texelFetch(occlusion, clamp(base + bit, ivec2(0), last), 0).xy;
    float difference = abs(there.y - v_depth);
    float weight = (near.x * near.y + 0.01) * max(0.002, 1 - difference / (0.02 * v_depth));
    sum += weight * there.x;
    weights += weight;
  }
  return sum / weights;
#else
  return 1.0;
#endif
}

float light_visibility(vec3 n) {
#ifdef SHADOWS
  vec4 clip = clip_of_world_from_light * vec4(v_position + n * 0.006 * reference_distance, 1);
  vec3 place = clip.xyz / clip.w * 0.5 + 0.5;
  bool outside = any(lessThan(place, vec3(0))) || any(greaterThan(place, vec3(1)));
#ifdef DETAIL
  float texel = 0.9 / float(textureSize(shadow_map, 0).x);
  float depth = place.z - 0.0004;
  float sum = texture(shadow_map, vec3(place.xy + texel * vec2(-0.5, -1.5), depth)) +
              texture(shadow_map, vec3(place.xy + texel * vec2(1.5, -0.5), depth)) +
              texture(shadow_map, vec3(place.xy + texel * vec2(0.5, 1.5), depth)) +
              texture(shadow_map, vec3(place.xy + texel * vec2(-1.5, 0.5), depth));
  float lit = sum / 4;
#else
  float lit = texture(shadow_map, vec3(place.xy, place.z - 0.0004));
#endif
  return outside ? 1.0 : lit;
#else
  return 1.0;
#endif
}

// Walter, Marschner, Li, Torrance 2007, "Microfacet models for refraction", times pi: diffuse
// light is written as albedo times irradiance, without its 1 / pi, too.
float ggx(float ndh, float alpha) {
  float a2 = alpha * alpha;
  float d = ndh * ndh * (a2 - 1) + 1;
  return a2 / (d * d);
}

// Masking and shadowing, divided by the two cosines.
float smith(float ndv, float ndl, float alpha) {
  float k = alpha / 2;
  return 1 / ((ndv * (1 - k) + k) * (ndl * (1 - k) + k));
}

float schlick(float f0, float cosine) {
  float x = 1 - cosine;
  return f0 + (1 - f0) * x * x * x * x * x;
}

vec3 facing_normal() {
  vec3 n = v_normal / max(length(v_normal), 1e-6);
  return gl_FrontFacing ? n : -n;
}

vec3 add_bump(vec3 n, vec3 gradient) { return normalize(n - (gradient - n * dot(n, gradient))); }

vec3 through_haze(vec3 value) {
  return haze_density > 0 ? mix(haze_light, value, exp(-haze_density * v_depth)) : value;
}

// Keeps one glint from whitening all samples of a pixel.
vec3 limited(vec3 value) { return min(value, vec3(6)); }
)";

// A wet film over wrapped diffuse light whose red reaches farther into the shade, as light that
// travels under skin does. All detail comes from solid noise at the rest position, so it sticks to
// tissue and is there on cut faces. Its gradient is used as if rest and world axes agreed: a turned
// organ has turned bumps, which nobody can see.
const char* const kTissueFragmentShader = R"(
#ifdef SKIN
uniform vec4 skin_look[4];
uniform vec4 inner_look[4];
float detail_size() { return v_inner < 0.5 ? skin_look[2].y : inner_look[2].y; }
// The rim of what is open is torn by the noise, else it would show the triangles.
float inside(float noise) { return smoothstep(0.3, 0.7, v_inner + 0.25 * noise); }
vec4 look(int part, float inside) { return mix(skin_look[part], inner_look[part], inside); }
#else
uniform samplerBuffer materials;
float detail_size() { return texelFetch(materials, 4 * v_material + 2).y; }
float inside(float noise) { return 0.0; }
vec4 look(int part, float inside) { return texelFetch(materials, 4 * v_material + part); }
#endif
uniform sampler3D cell_noise;
uniform float figure;  // 1 for colours as given
void main() {
  if (figure > 0.5) {
    float facing = max(dot(facing_normal(), normalize(light - v_position)), 0);
    radiance = vec4(v_color.rgb * ambient_visibility() * mix(0.5, 1.0, facing), v_color.a);
    return;
  }
  vec3 to_light = light - v_position;
  vec3 l = normalize(to_light);
  vec3 v = normalize(eye - v_position);
  vec3 incoming = incoming_light(to_light);
  vec3 n = facing_normal();
  float ambient = ambient_visibility();
  float shade = light_visibility(n);

  // --- detail -----------------------------------------------------------------------------------
  vec3 p = v_rest / detail_size();
  vec4 fine = noise_at(p);
  float open = inside(fine.w);
  vec4 color = look(0, open);
  vec3 mottle = look(1, open).rgb;
  vec3 surface = look(2, open).xyz;  // gloss, detail size, relief
  vec2 pattern = look(3, open).xy;   // lobules, vessels
#ifdef DETAIL
  vec4 coarse = noise_at(p * 0.24 + 0.10 * fine.xyz + 0.71);
  vec4 cell = 2 * texture(cell_noise, (p * 0.6 + 0.15 * fine.xyz + 0.4 * coarse.xyz) / 8) - 1;
#else
  vec4 coarse = noise_at(p * 0.24 + 0.71);
  vec4 cell = vec4(0, 0, 0, 1);
  if (pattern.x > 0) {
    cell = 2 * texture(cell_noise, (p * 0.6 + 0.4 * coarse.xyz) / 8) - 1;
  }
#endif
  vec3 bump = surface.z * fine.xyz;
  float opacity = color.a;
  vec3 albedo = mix(color.rgb, mottle, smoothstep(-0.4, 0.5, coarse.w + 0.5 * fine.w));
  if (v_color.a >= 0) {
    albedo = v_color.rgb * (1 + 0.18 * fine.w);
    opacity = v_color.a;
  }
  // fat: domes with soft furrows between them
  bump += pattern.x * 0.62 * cell.xyz;
  float furrow = pattern.x * (1 - smoothstep(0.0, 0.45, 0.5 * cell.w + 0.5));
  albedo *= 1 - furrow * vec3(0.10, 0.24, 0.42);
  // vessels: lines of even width along a level of the noise, value over slope, on part of the surface
  if (pattern.y > 0) {
    float trunk = (1 - smoothstep(0.02, 0.06, abs(coarse.w - 0.16) / (length(coarse.xyz) + 0.1))) *
                  smoothstep(-0.25, 0.05, fine.y + coarse.y);
    float twig = (1 - smoothstep(0.04, 0.11, abs(fine.w - 0.1) / (length(fine.xyz) + 0.1))) *
                 smoothstep(0.0, 0.2, coarse.z);
    albedo = mix(albedo, vec3(0.40, 0.065, 0.055), min(1.0, trunk + 0.45 * twig) * pattern.y * 0.7);
  }

  // --- burn: a layer with a grained edge; the darker it is, the rougher and the less it lets through
  float dry = 0;
  float charring = 0;
  float dull = 0;  // no film lies on char
  if (v_burn.a > 0) {
    float grain = fine.w;
    float burnt = clamp(v_burn.a * (1 + 0.5 * grain), 0, 1);
    vec3 crust = v_burn.rgb / max(v_burn.a, 1e-4);
    charring = burnt * clamp(1 - 2 * dot(crust, vec3(0.2126, 0.7152, 0.0722)), 0, 1);
    albedo = mix(albedo, crust * (1 + 0.15 * grain), burnt);
    opacity = max(opacity, burnt * step(0.02, opacity));  // what is gone stays gone
    dull = smoothstep(0.1, 0.5, charring);
    dry = max(0.45 * burnt, dull);
    bump += (0.28 * burnt + 0.44 * charring) * fine.xyz;
  }

  float wet = v_wetness * (1 - dull);
  float gloss = max(surface.x * (1 - dry), 0.98 * wet);
  albedo *= mix(1.0, 0.72, wet);

  // --- light ----------------------------------------------------------------------------------
  vec3 bumped = add_bump(n, bump);
  float ndl = dot(bumped, l);
  vec3 wrap = vec3(0.42, 0.17, 0.13) * (1 - 0.8 * charring);
  vec3 diffuse = clamp((ndl + wrap) / (1 + wrap), 0, 1);
  vec3 shadow = mix(vec3(0.20, 0.095, 0.08), vec3(1), shade);
  vec3 hollow = ambient * mix(vec3(1.18, 0.88, 0.84), vec3(1), ambient);  // red survives in folds
  vec3 lit = albedo * (diffuse * shadow * mix(vec3(0.25), vec3(1), hollow) +
                       0.35 * kCavity * hollow);

#ifdef DETAIL
  vec3 film = add_bump(n, bump * mix(0.75, 0.45, wet));
#else
  vec3 film = bumped;
#endif
  vec3 h = normalize(l + v);
  float ndh = max(dot(film, h), 0);
  float ndv = max(dot(film, v), 0.04);
  float film_ndl = max(dot(film, l), 0.04);
  float sharp = mix(0.30, 0.055, gloss);
#ifdef DETAIL
  float fresnel = schlick(0.035, max(dot(v, h), 0));
  float lobes = 0.9 * ggx(ndh, sharp) * smith(ndv, film_ndl, sharp) +
                1.1 * ggx(ndh, 0.26) * smith(ndv, film_ndl, 0.26);
#else  // the lamp is close to the eye
  float fresnel = 0.035;
  float lobes = (0.9 * ggx(ndh, sharp) + 1.1 * ggx(ndh, 0.26)) / (film_ndl * film_ndl + 0.1);
#endif
  float highlight = fresnel * film_ndl / 4 * lobes * gloss * mix(0.12, 1.0, shade);
  vec3 shine = highlight + schlick(0.035, ndv) * gloss * ambient * 0.5 * kCavity;
  float alpha = clamp(opacity + min(highlight, 1.0) * step(0.02, opacity), 0, 1);
  // the film reflects in full even where the tissue under it is glassy
  radiance = vec4(through_haze(limited(incoming * (lit + shine / max(alpha, 0.2)))), alpha);
}
)";

const char* const kToolFragmentShader = R"(
uniform samplerBuffer materials;
void main() {
  bool steel = texelFetch(materials, 4 * v_material + 2).w < 0.5;
  vec3 to_light = light - v_position;
  vec3 l = normalize(to_light);
  vec3 v = normalize(eye - v_position);
  vec3 normal = facing_normal();
  float ambient = ambient_visibility();
  float shade = light_visibility(normal);
  vec3 n = add_bump(normal, 0.025 * noise_at(v_rest / 0.0012).xyz);
  float ndl = max(dot(n, l), 0);
  float ndv = max(dot(n, v), 0.02);
  vec3 h = normalize(l + v);
  float alpha = steel ? 0.11 : 0.20;
  float f0 = steel ? 0.55 : 0.04;
  float mirror = min(4.0, ggx(max(dot(n, h), 0), alpha) * smith(ndv, max(ndl, 0.02), alpha) / 4);
  // what a rod mirrors: the lit end of the scope, red tissue at the sides
  float back = max(dot(reflect(-v, n), v), 0);
  vec3 mirrored = mix(vec3(0.17, 0.105, 0.095), vec3(0.50, 0.50, 0.52), smoothstep(0.05, 0.9, back));
  vec3 base = steel ? mirrored * mix(0.5, 1.0, ambient) : vec3(0.018, 0.018, 0.022);
  vec3 edge = (schlick(f0, ndv) - f0) * kCavity * ambient * (steel ? 0.25 : 0.16);
  vec3 lit = base * mix(0.3, 1.0, ndl) * mix(0.35, 1.0, shade) + edge +
             schlick(f0, max(dot(v, h), 0)) * mirror * ndl * shade;
  radiance = vec4(through_haze(limited(incoming_light(to_light) * lit)), 1);
}
)";

const char* const kSmokeFragmentShader = R"(
#ifdef OCCLUSION
uniform sampler2D geometry;  // depth of what is opaque in its last component
uniform vec2 picture_size;
#endif
void main() {
  float body = smoothstep(1.0, 0.15, length(v_rest.xy));
  float wisp = 0.5 + 0.8 * noise_at(vec3(v_rest.xy * 1.1, v_rest.z * 1.7)).w;
  float soft = 1;
#ifdef OCCLUSION
  float behind = texture(geometry, gl_FragCoord.xy / picture_size).w;
  soft = behind > 0 ? clamp((behind - v_depth) / max(v_wetness, 1e-9) + 0.2, 0, 1) : 1;
#endif
  vec3 lit = limited(0.5 * v_color.rgb * incoming_light(light - v_position));
  radiance = vec4(through_haze(lit), v_color.a * body * soft * clamp(wisp, 0.0, 1.0));
}
)";

}  // namespace cholecystectomy
