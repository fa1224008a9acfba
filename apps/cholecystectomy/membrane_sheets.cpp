// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/membrane_sheets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/base/random.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::Triangle;

constexpr auto kRow = static_cast<Index>(MembraneSheets::kLevels.size());

// All that follows is choice of display.
constexpr std::uint64_t kSeed = 11;
constexpr double kWebShare = 0.4;         // of the edges within the membrane
constexpr float kLeastLength = 0.2e-3F;   // m: shorter links count as so long at rest
constexpr float kSink = 0.3e-3F;          // m, that sheets reach into the organs
constexpr float kBlendReach = 0.45F;      // of its length, along which tissue becomes an organ's
constexpr float kFeather = 0.15F;         // of its length, along which it fades in at an organ
constexpr float kGlassiest = 0.1F;        // of A0 / A
constexpr float kMostCrumpled = 1.5F;     // of A0 / A
constexpr float kOpacityOfBurn = 0.4F;    // that a whole burn adds
constexpr float kWebFrom = 1e-3F;         // m, where the web begins to show
constexpr float kWebWhole = 3e-3F;        // m, where it shows in full
constexpr float kRibbonFrom = 1e-3F;      // m, where ribbons begin to show
constexpr float kRibbonWhole = 3e-3F;     // m, where they show in full
constexpr float kRibbonWidth = 0.4e-3F;   // m, half of it, in the middle
constexpr float kRibbonFlare = 2.5F;      // of that width, at the ends
constexpr float kRibbonAlpha = 0.2F;      // in the middle
constexpr float kRibbonEndAlpha = 0.25F;  // at the organs
constexpr std::array<float, 5> kRibbonLevels{0, 0.2F, 0.5F, 0.8F, 1};

float smooth_step(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

// 1 at an end, 0 from kBlendReach on.
float closeness(float place_from_end) {
  const float t = std::max(0.0F, 1 - place_from_end / kBlendReach);
  return t * t * (3 - 2 * t);
}

bool is_finite(const SheetLinkState& state) {
  return state.first.allFinite() && state.second.allFinite();
}

Eigen::Vector4f finite_layer(const Eigen::Vector4f& layer) {
  return layer.allFinite() ? layer : Eigen::Vector4f::Zero();
}

// Both layers, each by its cover and by how near it is.
Eigen::Vector4f burn_at(const SheetLinkState& now, float place) {
  const Eigen::Vector4f a = finite_layer(now.first_burn), b = finite_layer(now.second_burn);
  const float of_first = (1 - place) * a.w(), of_second = place * b.w();
  const float cover = of_first + of_second;
  Eigen::Vector4f layer = Eigen::Vector4f::Zero();
  if (cover > 0) {
    layer.head<3>() = (of_first * a.head<3>() + of_second * b.head<3>()) / cover;
    layer.w() = std::min(cover, 1.0F);
  }
  return layer;
}

float thinned(float alpha, float share_left) {
  return 1 - std::pow(1 - alpha, share_left);
}

// Of the strip between two links: the parallelogram of its middle lines.
float area_between(const Eigen::Vector3f& a_first, const Eigen::Vector3f& a_second,
                   const Eigen::Vector3f& b_first, const Eigen::Vector3f& b_second) {
  const Eigen::Vector3f across = (b_first + b_second - a_first - a_second) / 2;
  const Eigen::Vector3f along = (a_second + b_second - a_first - b_first) / 2;
  return across.cross(along).norm();
}

// Leaves out what has no area, and turns triangles so that their fronts are where normals point.
void add_triangle(Surface& surface, Index a, Index b, Index c) {
  const Eigen::Vector3f ab = surface.positions[b] - surface.positions[a];
  const Eigen::Vector3f ac = surface.positions[c] - surface.positions[a];
  const Eigen::Vector3f normal = ab.cross(ac);
  if (!(normal.norm() > 1e-5F * std::max(ab.squaredNorm(), ac.squaredNorm()))) {
    return;
  }
  const Eigen::Vector3f wanted = surface.normals[a] + surface.normals[b] + surface.normals[c];
  surface.triangles.push_back(normal.dot(wanted) < 0 ? Triangle{a, c, b} : Triangle{a, b, c});
}

// A web has no outside: its normals are all turned to one side, so that no two that meet cancel.
const Eigen::Vector3f kWebSide(0.36F, 0.48F, 0.80F);

void clear(Surface& surface) {
  surface.positions.clear();
  surface.rest_positions.clear();
  surface.normals.clear();
  surface.colors.clear();
  surface.triangles.clear();
}

}  // namespace

struct MembraneSheets::SheetStyle {
  float alpha;      // of tissue at rest, in the middle
  float end_alpha;  // at the organs
  float waist;      // depth, of the length
  int rounds;       // of smoothing along it
  bool is_web;      // shows where the gap is open; sheets meet at all angles
};

MembraneSheets::MembraneSheets(std::span<const SheetLink> links, std::span<const Triangle> membrane,
                               const Eigen::Vector3f& color)
    : links_(links.begin(), links.end()),
      triangles_(membrane.begin(), membrane.end()),
      color_(color),
      is_alive_(links.size(), 0),
      is_lonely_(links.size(), 0),
      row_of_(links.size(), pbdsurg::kInvalidIndex) {
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (!links[l].first.allFinite() || !links[l].second.allFinite()) {
      throw pbdsurg::InvalidArgument("link " + std::to_string(l) + " of a sheet is not finite");
    }
  }
  // pairs of links with the place of the edge in its triangle, sorted so that equal pairs meet
  std::vector<std::pair<std::array<Index, 2>, std::size_t>> sides;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      if (a < 0 || a >= static_cast<Index>(links.size())) {
        throw pbdsurg::InvalidArgument(
            "triangle " + std::to_string(t) + " of a membrane refers to link " + std::to_string(a) +
            "; ids must be in [0, " + std::to_string(links.size()) + ")");
      }
      sides.push_back({{std::min(a, b), std::max(a, b)}, 3 * t + k});
    }
  }
  std::sort(sides.begin(), sides.end());
  edges_of_triangle_.resize(triangles_.size());
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const auto& [pair, place] = sides[i];
    if (i == 0 || pair != sides[i - 1].first) {
      const bool is_web = pbdsurg::random_unit(kSeed, static_cast<std::uint64_t>(pair[0]),
                                               static_cast<std::uint64_t>(pair[1])) < kWebShare;
      edges_.push_back({pair, is_web, 0, {}});
    }
    edges_of_triangle_[place / 3][place % 3] = static_cast<Index>(edges_.size()) - 1;
  }
  pbdsurg::TissueLook look;
  look.color = look.mottle = color;
  look.gloss = 0.25F;
  look.opacity = 0.01F;  // where a renderer extrapolates alpha below zero
  look.detail_size = 0.002F;
  look.relief = 0.1F;
  constexpr std::array<const char*, 3> kNames{"membrane", "membrane_web", "connective_tissue"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    surfaces_[i].name = kNames[i];
    surfaces_[i].look = look;
  }
}

void MembraneSheets::update(std::span<const SheetLinkState> states) {
  if (states.size() != links_.size()) {
    throw pbdsurg::InvalidArgument("sheets of " + std::to_string(links_.size()) +
                                   " links were given " + std::to_string(states.size()) +
                                   " states");
  }
  note_living(states);
  if (!is_sorted_) {
    sort_edges();
  }
  constexpr SheetStyle kCurtain{0.32F, 0.6F, 0.14F, 6, false};
  constexpr SheetStyle kWeb{0.09F, 0.1F, 0.05F, 2, true};
  shape(border_, kCurtain, states, surfaces_[0]);
  shape(inner_, kWeb, states, surfaces_[1]);
  shape_ribbons(states);
}

void MembraneSheets::note_living(std::span<const SheetLinkState> states) {
  for (std::size_t l = 0; l < states.size(); ++l) {
    const std::uint8_t alive = states[l].is_alive && is_finite(states[l]) ? 1 : 0;
    is_sorted_ = is_sorted_ && alive == is_alive_[l];
    is_alive_[l] = alive;
  }
}

void MembraneSheets::sort_edges() {
  is_lonely_ = is_alive_;
  for (MembraneEdge& edge : edges_) {
    edge.living_triangles = 0;
  }
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& triangle = triangles_[t];
    if (std::all_of(triangle.begin(), triangle.end(), [&](Index l) { return is_alive_[l] != 0; })) {
      for (std::size_t k = 0; k < 3; ++k) {
        MembraneEdge& edge = edges_[edges_of_triangle_[t][k]];
        ++edge.living_triangles;
        edge.last = {triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]};
        is_lonely_[triangle[k]] = 0;
      }
    }
  }
  collect(border_, true);
  collect(inner_, false);
  is_sorted_ = true;
}

void MembraneSheets::collect(Sheet& sheet, bool is_border) {
  sheet.edges.clear();
  sheet.opposite.clear();
  sheet.links.clear();
  std::fill(row_of_.begin(), row_of_.end(), pbdsurg::kInvalidIndex);
  for (const MembraneEdge& edge : edges_) {
    const bool is_wanted =
        is_border ? edge.living_triangles == 1 : edge.living_triangles > 1 && edge.is_web;
    if (!is_wanted) {
      continue;
    }
    std::array<Index, 2> rows{};
    for (std::size_t k = 0; k < 2; ++k) {
      Index& row = row_of_[edge.last[k]];
      if (row == pbdsurg::kInvalidIndex) {
        row = static_cast<Index>(sheet.links.size());
        sheet.links.push_back(edge.last[k]);
      }
      rows[k] = row;
    }
    sheet.edges.push_back(rows);
    sheet.opposite.push_back(edge.last[2]);
  }
}

// Each round moves values towards the mean of their neighbours, and part of the way back, so that
// the rim of a small hole does not shrink to a point: Taubin 1995, "A signal processing approach to
// fair surface design".
void MembraneSheets::smooth(const Sheet& sheet, int rounds, std::vector<Eigen::Vector3f>& values) {
  for (int pass = 0; pass < 2 * rounds; ++pass) {
    const float way = pass % 2 == 0 ? 0.5F : -0.35F;
    sums_.assign(values.size(), Eigen::Vector3f::Zero());
    counts_.assign(values.size(), 0);
    for (const auto& [a, b] : sheet.edges) {
      sums_[a] += values[b];
      sums_[b] += values[a];
      ++counts_[a];
      ++counts_[b];
    }
    for (std::size_t row = 0; row < values.size(); ++row) {
      values[row] += way * (sums_[row] / static_cast<float>(counts_[row]) - values[row]);
    }
  }
}

// Links end in vertices: where a mesh is coarser, many in one, and a border of triangles is jagged.
// Spread along the edges, they hang on a line.
void MembraneSheets::find_ends(const Sheet& sheet, int rounds,
                               std::span<const SheetLinkState> states) {
  first_ends_.clear();
  second_ends_.clear();
  for (const Index link : sheet.links) {
    first_ends_.push_back(states[link].first);
    second_ends_.push_back(states[link].second);
  }
  smooth(sheet, rounds, first_ends_);
  smooth(sheet, rounds, second_ends_);
}

// Towards the inside of the membrane, across the link.
void MembraneSheets::find_waists(const Sheet& sheet, int rounds,
                                 std::span<const SheetLinkState> states) {
  waists_.assign(sheet.links.size(), Eigen::Vector3f::Zero());
  const auto middle = [&](Index link) -> Eigen::Vector3f {
    return (states[link].first + states[link].second) / 2;
  };
  for (std::size_t e = 0; e < sheet.edges.size(); ++e) {
    const auto [a, b] = sheet.edges[e];
    const Eigen::Vector3f inwards =
        middle(sheet.opposite[e]) - (middle(sheet.links[a]) + middle(sheet.links[b])) / 2;
    waists_[a] += inwards;
    waists_[b] += inwards;
  }
  smooth(sheet, rounds, waists_);
  for (std::size_t row = 0; row < waists_.size(); ++row) {
    const Eigen::Vector3f along = (second_ends_[row] - first_ends_[row]).stableNormalized();
    const float length = waists_[row].norm();
    waists_[row] -= waists_[row].dot(along) * along;
    // along the link: no direction is inwards
    waists_[row] = waists_[row].norm() > 0.05F * length ? Eigen::Vector3f(waists_[row].normalized())
                                                        : Eigen::Vector3f::Zero();
  }
}

void MembraneSheets::find_thinning(const Sheet& sheet, std::span<const SheetLinkState> states) {
  areas_.assign(sheet.links.size(), Eigen::Vector2f::Zero());
  for (const auto& [row_a, row_b] : sheet.edges) {
    const Index a = sheet.links[row_a], b = sheet.links[row_b];
    const SheetLink &rest_a = links_[a], &rest_b = links_[b];
    const float width = (rest_b.first + rest_b.second - rest_a.first - rest_a.second).norm() / 2;
    const Eigen::Vector2f area(
        std::max(area_between(rest_a.first, rest_a.second, rest_b.first, rest_b.second),
                 kLeastLength * width),
        area_between(states[a].first, states[a].second, states[b].first, states[b].second));
    areas_[row_a] += area;
    areas_[row_b] += area;
  }
}

Eigen::Vector4f MembraneSheets::color_at(const SheetLink& rest, const SheetLinkState& now,
                                         float place, float alpha, float end_alpha) const {
  const float first = closeness(place), second = closeness(1 - place);
  Eigen::Vector3f color =
      (1 - first - second) * color_ + first * rest.first_color + second * rest.second_color;
  alpha += (first + second) * (end_alpha - alpha);
  alpha *= smooth_step(0, kFeather, std::min(place, 1 - place));
  const Eigen::Vector4f burn = burn_at(now, place);
  color += burn.w() * (burn.head<3>() - color);
  alpha += kOpacityOfBurn * burn.w() * alpha * (1 - alpha);
  return {color.x(), color.y(), color.z(), alpha};
}

void MembraneSheets::shape(const Sheet& sheet, const SheetStyle& style,
                           std::span<const SheetLinkState> states, Surface& surface) {
  clear(surface);
  find_ends(sheet, style.rounds, states);
  find_waists(sheet, style.rounds, states);
  find_thinning(sheet, states);
  for (std::size_t row = 0; row < sheet.links.size(); ++row) {
    const Index link = sheet.links[row];
    const SheetLink& rest = links_[link];
    const SheetLinkState& now = states[link];
    const Eigen::Vector3f along = second_ends_[row] - first_ends_[row];
    const Eigen::Vector3f beyond = kSink * along.stableNormalized();
    const float length = (now.second - now.first).norm();
    const float rest_length = std::max((rest.second - rest.first).norm(), kLeastLength);
    // a gap is open where links are long and longer than at rest: slanting ones are always long
    const float shown = style.is_web ? smooth_step(kWebFrom, kWebWhole, length) *
                                           smooth_step(1.05F, 1.3F, length / rest_length)
                                     : 1;
    const auto [area_at_rest, area] = std::pair(areas_[row].x(), areas_[row].y());
    const float share_left =
        std::clamp(area > 0 ? area_at_rest / area : kMostCrumpled, kGlassiest, kMostCrumpled);
    // fibres: no two links are as dense
    const float density = static_cast<float>(
        0.6 + 0.8 * pbdsurg::random_unit(kSeed, static_cast<std::uint64_t>(link)));
    const float alpha = thinned(style.alpha, density * share_left);
    for (const float place : kLevels) {
      const float depth = style.waist * 4 * place * (1 - place) * along.norm();
      surface.positions.push_back(first_ends_[row] + place * along + (2 * place - 1) * beyond +
                                  depth * waists_[row]);
      surface.rest_positions.push_back(rest.first + place * (rest.second - rest.first));
      surface.colors.push_back(color_at(rest, now, place, alpha, style.end_alpha));
      surface.colors.back().w() *= shown;
      surface.normals.push_back(Eigen::Vector3f::Zero());
    }
  }
  const auto is_shown = [&](Index row) { return surface.colors[row * kRow + kRow / 2].w() > 0; };
  for (const auto& [a, b] : sheet.edges) {
    for (Index k = 0; k + 1 < kRow; ++k) {
      const std::array<Index, 4> cell{a * kRow + k, a * kRow + k + 1, b * kRow + k,
                                      b * kRow + k + 1};
      const auto corner = [&](std::size_t i) { return surface.positions[cell[i]]; };
      const Eigen::Vector3f normal = (corner(1) + corner(3) - corner(0) - corner(2))
                                         .cross(corner(2) + corner(3) - corner(0) - corner(1));
      const bool is_turned = style.is_web && normal.dot(kWebSide) < 0;
      for (const Index v : cell) {
        surface.normals[v] += is_turned ? Eigen::Vector3f(-normal) : normal;
      }
    }
  }
  for (Eigen::Vector3f& normal : surface.normals) {
    normal.stableNormalize();
  }
  for (const auto& [a, b] : sheet.edges) {
    if (is_shown(a) || is_shown(b)) {
      for (Index k = 0; k + 1 < kRow; ++k) {
        const Index i = a * kRow + k, j = b * kRow + k;
        add_triangle(surface, i, j, j + 1);
        add_triangle(surface, i, j + 1, i + 1);
      }
    }
  }
}

void MembraneSheets::shape_ribbons(std::span<const SheetLinkState> states) {
  clear(surfaces_[2]);
  for (std::size_t l = 0; l < links_.size(); ++l) {
    if (is_lonely_[l] != 0 && (states[l].second - states[l].first).norm() > kRibbonFrom) {
      add_ribbon(links_[l], states[l]);
    }
  }
}

// Two crossed bands, so that it shows from all sides, with edges that fade out.
void MembraneSheets::add_ribbon(const SheetLink& rest, const SheetLinkState& now) {
  Surface& surface = surfaces_[2];
  const Eigen::Vector3f along = now.second - now.first;
  const float length = along.norm();
  const Eigen::Vector3f direction = along / length;
  Eigen::Index least = 0;
  direction.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3f u = direction.cross(Eigen::Vector3f::Unit(least)).normalized();
  const Eigen::Vector3f v = direction.cross(u);
  const float rest_length = std::max((rest.second - rest.first).norm(), kLeastLength);
  const float share_left = std::clamp(rest_length / length, kGlassiest, kMostCrumpled);
  const float shown = smooth_step(kRibbonFrom, kRibbonWhole, length);
  const float alpha = shown * thinned(kRibbonAlpha, share_left);
  for (const auto& [side, front] : {std::pair(u, v), std::pair(v, u)}) {
    const auto base = static_cast<Index>(surface.positions.size());
    for (const float place : kRibbonLevels) {
      const float end = 2 * place - 1;
      const float width = kRibbonWidth * (1 + (kRibbonFlare - 1) * end * end * end * end);
      const Eigen::Vector4f color = color_at(rest, now, place, alpha, shown * kRibbonEndAlpha);
      for (const float across : {-1.0F, 0.0F, 1.0F}) {
        surface.positions.push_back(now.first + place * along + end * kSink * direction +
                                    across * width * side);
        surface.rest_positions.push_back(rest.first + place * (rest.second - rest.first));
        surface.normals.push_back((front + across * side).normalized());
        surface.colors.push_back(color);
        surface.colors.back().w() *= 1 - std::abs(across);
      }
    }
    for (Index k = 0; k + 1 < static_cast<Index>(kRibbonLevels.size()); ++k) {
      for (Index half = 0; half < 2; ++half) {
        const Index i = base + 3 * k + half;
        add_triangle(surface, i, i + 1, i + 4);
        add_triangle(surface, i, i + 4, i + 3);
      }
    }
  }
}

}  // namespace cholecystectomy
