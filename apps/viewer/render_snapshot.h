// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One moment of a scene, as plain data for a renderer. Lengths are metres, colours are sRGB in
/// [0, 1]. A snapshot owns its arrays, so that it can cross threads.

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/look.h"

namespace cholecystectomy {

/// A triangle mesh of one kind of tissue. Both sides are lit; counter-clockwise is outside.
///
/// A triangle with a corner that is not finite is not drawn. An optional array is empty or has one
/// entry per vertex.
struct Surface {
  std::string name;
  std::vector<Eigen::Vector3f> positions;    ///< [vertex_count] m
  std::vector<pbdsurg::Triangle> triangles;  ///< [triangle_count] vertex ids
  pbdsurg::TissueLook look;
  std::vector<Eigen::Vector3f> normals;  ///< optional, of any length: else those of the triangles
  std::vector<Eigen::Vector3f> rest_positions;  ///< optional m: where the tissue's texture sticks
  std::vector<Eigen::Vector4f> burn;            ///< optional rgb and cover: a dull layer over the
                                                ///< tissue, which hides that share of its colour
  std::vector<float> wetness;                   ///< optional 0..1: a film of fluid, shines
  std::vector<Eigen::Vector4f> colors;          ///< optional rgba: replaces colour and opacity
  std::vector<std::uint8_t> is_inner;  ///< optional [triangle_count] 1 where a cut or a burn has
                                       ///< bared the inside: drawn with inner_look, whose
                                       ///< rim fades over the triangles beside it
  pbdsurg::TissueLook inner_look;
  bool casts_shadow = true;  ///< a backdrop need not: nothing lies behind it
};

/// What changed of a surface, for who keeps one. Runs replace what was there, and may reach beyond
/// the end, which then moves.
struct SurfaceChange {
  struct Triangles {
    pbdsurg::Index first = 0;
    std::vector<pbdsurg::Triangle> values;  ///< a triangle that names a vertex twice is not drawn
    std::vector<std::uint8_t> is_inner;     ///< [values.size()] as in Surface
  };
  struct Burns {
    pbdsurg::Index first = 0;
    std::vector<Eigen::Vector4f> values;
  };
  std::vector<Eigen::Vector3f> positions;  ///< [vertex_count] m, of all vertices; empty: as before
  std::vector<Eigen::Vector3f> new_rest_positions;  ///< m, of vertices that were added at the end
  std::vector<Triangles> triangles;
  std::vector<Burns> burns;
};

enum class ToolFinish { steel, insulation };

/// A rod swept along a polyline, closed by round caps. Points that are not finite are left out.
struct ToolPart {
  std::vector<Eigen::Vector3f> points;  ///< [point_count] m
  std::vector<float> radii;             ///< [point_count] m
  ToolFinish finish = ToolFinish::steel;
};

struct Tool {
  std::string name;
  std::vector<ToolPart> parts;
};

/// A straight fibre between two organs.
struct Strand {
  Eigen::Vector3f from;   ///< m
  Eigen::Vector3f to;     ///< m
  Eigen::Vector4f color;  ///< rgba
  float thickness;        ///< m
};

struct SmokePuff {
  Eigen::Vector3f center;  ///< m
  float radius;            ///< m
  float opacity;           ///< 0..1 in its middle
};

/// The laparoscope: an eye with a light beside it.
struct Camera {
  Eigen::Vector3f eye{0, 0, 0.1f};      ///< m
  Eigen::Vector3f target{0, 0, 0};      ///< m
  Eigen::Vector3f up{0, 1, 0};          ///< any length, not along the view
  float vertical_field_of_view = 1.1f;  ///< rad

  /// Where the light leaves the scope, in camera axes (right, up, back). m
  Eigen::Vector3f light_offset{0.003f, 0.006f, 0};

  /// 1 exposes tissue at the target's distance well.
  float brightness = 1;
};

enum class Style {
  scope,   ///< through a laparoscope
  figure,  ///< on white, without gloss, texture or shadows, so that colours are read as given
};

/// All that is drawn anew for each picture.
struct SceneView {
  std::vector<Tool> tools;
  std::vector<Surface> sheets;  ///< small and translucent, as membranes are
  std::vector<Strand> strands;
  std::vector<SmokePuff> smoke;
  float haze = 0;  ///< 0..1, share of the light that smoke in the cavity takes at the target
  Camera camera;
  Style style = Style::scope;  ///< a figure is meant for surfaces with colours, and strands
};

/// A whole moment.
struct RenderSnapshot : SceneView {
  std::vector<Surface> surfaces;
};

}  // namespace cholecystectomy
