// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/shaders.h"

namespace cholecystectomy {

const char* const kSceneVertexShader = R"(layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 rest;
layout(location = 3) in vec4 color;
layout(location = 4) in vec4 burn;
layout(location = 5) in float wetness;
layout(location = 6) in int material;
uniform mat4 view_of_world;
uniform mat4 clip_of_view;
out vec3 v_position;
out vec3 v_normal;
out vec3 v_rest;
out vec4 v_color;
out vec4 v_burn;
out float v_wetness;
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
  v_wetness = wetness;
  v_depth = -view_position.z;
  v_material = material;
}
)";

// Curved point-normal triangles: Vlachos, Peters, Boyd, Mitchell 2001, "Curved PN triangles". A
// point on an edge is computed from the edge's two ends alone, in the order of their ids, by the
// same instructions for both triangles that share it: no hole can open between them.
const char* const kSkinVertexShader = R"(layout(location = 0) in uvec4 point;  // see Lattice
uniform samplerBuffer positions;       // xyz, 1 where finite
uniform samplerBuffer normals;         // xyz, how much around the vertex is inside
uniform isamplerBuffer slots;          // corners; 0 nothing, 1 skin, 2 inner
uniform int first_slot;
uniform int subdivision;
uniform mat4 view_of_world;
uniform mat4 clip_of_view;
invariant gl_Position;
#ifndef DEPTH_ONLY
uniform samplerBuffer rest_positions;
uniform samplerBuffer burns;
uniform samplerBuffer colors;
uniform samplerBuffer wetnesses;
uniform bool has_burns;
uniform bool has_colors;
uniform bool has_wetness;
uniform float figure;
out vec3 v_position;
out vec3 v_normal;
out vec3 v_rest;
out vec4 v_color;
out vec4 v_burn;
out float v_wetness;
out float v_depth;
out float v_inner;  // 0 skin .. 1 inside
#endif

// How much an edge may bend: not at all where its ends face apart, or one does not know its normal.
float bend(vec3 n0, vec3 n1) { return smoothstep(0.05, 0.5, dot(n0, n1)); }

// The control point near p0. It leaves the edge by at most an eighth of its length, so that sharp
// normals fold nothing over.
vec3 control(vec3 p0, vec3 n0, vec3 p1, float bending) {
  vec3 edge = p1 - p0;
  float most = 0.36 * length(edge);
  return (2 * p0 + p1 - bending * clamp(dot(edge, n0), -most, most) * n0) / 3;
}

vec3 on_edge(vec3 p0, vec3 n0, float u, vec3 p1, vec3 n1, float v) {
  float bending = bend(n0, n1);
  return u * u * u * p0 + 3 * u * u * v * control(p0, n0, p1, bending) +
         3 * u * v * v * control(p1, n1, p0, bending) + v * v * v * p1;
}

vec3 inside(vec3 p0, vec3 n0, vec3 p1, vec3 n1, vec3 p2, vec3 n2, vec3 s) {
  float bend01 = bend(n0, n1);
  float bend12 = bend(n1, n2);
  float bend20 = bend(n2, n0);
  vec3 c01 = control(p0, n0, p1, bend01);
  vec3 c10 = control(p1, n1, p0, bend01);
  vec3 c12 = control(p1, n1, p2, bend12);
  vec3 c21 = control(p2, n2, p1, bend12);
  vec3 c20 = control(p2, n2, p0, bend20);
  vec3 c02 = control(p0, n0, p2, bend20);
  vec3 middle = (c01 + c10 + c12 + c21 + c20 + c02) / 4 - (p0 + p1 + p2) / 6;
  return s.x * s.x * s.x * p0 + s.y * s.y * s.y * p1 + s.z * s.z * s.z * p2 +
         3 * (s.x * s.y * (s.x * c01 + s.y * c10) + s.y * s.z * (s.y * c12 + s.z * c21) +
              s.z * s.x * (s.z * c20 + s.x * c02)) +
         6 * s.x * s.y * s.z * middle;
}

void main() {
  ivec4 slot = texelFetch(slots, first_slot + int(point.w));
  vec4 p0 = texelFetch(positions, slot.x);
  vec4 p1 = texelFetch(positions, slot.y);
  vec4 p2 = texelFetch(positions, slot.z);
  vec4 m0 = texelFetch(normals, slot.x);
  vec4 m1 = texelFetch(normals, slot.y);
  vec4 m2 = texelFetch(normals, slot.z);
  vec3 n0 = m0.xyz;
  vec3 n1 = m1.xyz;
  vec3 n2 = m2.xyz;
  // exactly one at a corner, whatever the division gives
  vec3 steps = vec3(point.xyz);
  float all_steps = float(subdivision);
  vec3 s = mix(steps / all_steps, vec3(1), equal(steps, vec3(all_steps)));
  vec3 position;
  if (subdivision > 2 && point.x > 0u && point.y > 0u && point.z > 0u) {
    position = inside(p0.xyz, n0, p1.xyz, n1, p2.xyz, n2, s);
  } else {
    bool first = point.z == 0u;
    bool second = !first && point.x == 0u;
    ivec2 ids = first ? slot.xy : second ? slot.yz : slot.zx;
    vec2 shares = first ? s.xy : second ? s.yz : s.zx;
    vec3 pa = first ? p0.xyz : second ? p1.xyz : p2.xyz;
    vec3 pb = first ? p1.xyz : second ? p2.xyz : p0.xyz;
    vec3 na = first ? n0 : second ? n1 : n2;
    vec3 nb = first ? n1 : second ? n2 : n0;
    bool swap = ids.x > ids.y;
    position = on_edge(swap ? pb : pa, swap ? nb : na, swap ? shares.y : shares.x,
                       swap ? pa : pb, swap ? na : nb, swap ? shares.x : shares.y);
  }
  vec4 view_position = view_of_world * vec4(position, 1);
  gl_Position = clip_of_view * view_position;
  if (slot.w == 0 || p0.w * p1.w * p2.w == 0) {
    gl_Position = vec4(2, 2, 2, 1);  // all points of the triangle: nothing
  }
#ifndef DEPTH_ONLY
  v_position = position;
  v_depth = -view_position.z;
  v_inner = dot(s, vec3(m0.w, m1.w, m2.w));
  v_normal = s.x * n0 + s.y * n1 + s.z * n2;
  if (figure < 0.5) {
    // A rim is sharp, and what is torn or burnt open is rugged, though its shape has one normal.
    vec3 face = cross(p1.xyz - p0.xyz, p2.xyz - p0.xyz);
    face /= max(length(face), 1e-20);
    vec3 n = v_normal / max(length(v_normal), 1e-6);
    float crease = 1 - smoothstep(0.1, 0.6, dot(n, face));
    v_normal = mix(n, face, slot.w == 2 ? max(crease, 0.15) : crease);
  }
  v_rest = s.x * texelFetch(rest_positions, slot.x).xyz +
           s.y * texelFetch(rest_positions, slot.y).xyz +
           s.z * texelFetch(rest_positions, slot.z).xyz;
  v_burn = vec4(0);
  if (has_burns) {
    v_burn = s.x * texelFetch(burns, slot.x) + s.y * texelFetch(burns, slot.y) +
             s.z * texelFetch(burns, slot.z);
  }
  v_color = vec4(0, 0, 0, -1);
  if (has_colors) {
    v_color = s.x * texelFetch(colors, slot.x) + s.y * texelFetch(colors, slot.y) +
              s.z * texelFetch(colors, slot.z);
  }
  v_wetness = 0;
  if (has_wetness) {
    v_wetness = s.x * texelFetch(wetnesses, slot.x).x + s.y * texelFetch(wetnesses, slot.y).x +
                s.z * texelFetch(wetnesses, slot.z).x;
  }
#endif
}
)";

// A ring around the round picture, before everything: what it hides is not shaded. A strip of
// kMaskPoints vertices.
const char* const kMaskVertexShader = R"(uniform float aspect;
void main() {
  float angle = float(gl_VertexID >> 1) * 6.2831853 / 48;
  float radius = (gl_VertexID & 1) == 0 ? 1.2 * 1.0022 : 8;  // the polygon lies around the circle
  gl_Position = vec4(radius * vec2(cos(angle) / aspect, sin(angle)), -1, 1);
}
)";

}  // namespace cholecystectomy
