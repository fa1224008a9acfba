// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/substep_rule.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/base/describe.h"
#include "lib/solver/coarse_choice.h"
#include "lib/solver/sets/stiff_links.h"
#include "lib/solver/solver_options.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

// Of the time in which a pressure wave crosses an edge, for one sweep and an accuracy of 2 %: where
// bars, blocks, a bath and a ball come to rest within it (`statics`).
constexpr double kVertexShare = 0.95;
constexpr double kProjectionShare = 0.3;
constexpr double kUsualAccuracy = 0.02;

// With a coarse correction between two sweeps. Near rest neither stiffness nor mesh counts: the
// modes find it in the first 60 substeps. Where these help little, as in a bar turned by a quarter,
// or in a small stiff body among soft ones, which have the softest modes, sweeps move tissue as if
// waves crossed an edge in a substep h. A drag that is critical for its true waves, in `crossing`,
// makes that creep: to rest in about (h / crossing)^2 crossings for each edge along the body. What
// has 0.2 s for that, however stiff it is, so takes h in proportion to sqrt(crossing).
constexpr int kCorrectedSweeps = 2;
constexpr double kCorrectedTime = 10e-3;         // s, times `crossing` is the square of a substep
constexpr double kCorrectedLongest = 1.0 / 300;  // s

// Of stiff links with a correction: sweeps for each substep of the longest that the softer of two
// bodies would need without it; or of that, for each sweep but one. Eighteen stitches of 2e-4 m/N
// between two strips of liver (examples/suture.cpp) shook with 2 sweeps in substeps of 0.6 to 2.5
// ms. They came to rest with 3 in 0.6 and 0.8 ms, 4 in 1.7 and 10 in 2.5; this gives 3, 3, 7
// and 10.
constexpr double kSweepsOfLinks = 3;
constexpr double kShareOfLinks = 0.45;

// Pa, of pressure waves: what changes of volume make stiff as a ratio nears 1/2.
// @param volume  m^3, of a tetrahedron in the mean
// @param edge    m, likewise
double wave_modulus(const Material& material, double volume, double edge) {
  if (material.model == ElasticModel::neo_hookean) {
    const double ratio = material.poissons_ratio;
    return material.youngs_modulus * (1 - ratio) / ((1 + ratio) * (1 - 2 * ratio));
  }
  // a lattice of springs has a modulus of about stiffness / edge, and a ratio of 1/4; rigid volumes
  // are kept one by one, without a wave
  const double lattice = 1.2 / (edge * double{material.stretch.compliance});
  const double compliance = material.has_volume_constraints ? material.volume.compliance : 0;
  return lattice + (compliance > 0 ? volume / compliance : 0);
}

// s, in which a wave of pressure crosses an edge.
// @param volume     m^3, of a tetrahedron, or a triangle of a sheet, in the mean
// @param stiffness  times that of the material
// @param fibre      Pa, of fibres, along which it runs
double crossing_time(const Body& body, float stiffness, float fibre, double volume) {
  const Material& material = body.material;
  if (is_sheet(body)) {  // in plane stress, of an equilateral one
    const double ratio = material.poissons_ratio;
    const double edge = std::sqrt(4 / std::numbers::sqrt3 * volume / double{body.thickness});
    const double modulus = double{stiffness} * double{material.youngs_modulus};
    return edge * std::sqrt(material.density * (1 - ratio * ratio) / modulus);
  }
  const double edge = std::cbrt(6 * std::numbers::sqrt2 * volume);  // of a regular one
  const double modulus = double{stiffness} * wave_modulus(material, volume, edge) + double{fibre};
  return edge * std::sqrt(material.density / modulus);
}

[[noreturn]] void refuse(const Body& body, const std::string& what, const SolverOptions& options) {
  std::ostringstream text;
  text << "body '" << body.name << "' " << what << ": more than " << kMostAutomatic
       << " in the longest step, " << options.longest_step
       << " s; a coarser mesh, softer material, shorter step or larger accuracy needs fewer, or "
       << "name substeps and iterations";
  throw InvalidArgument(text.str());
}

// s, the longest substep that comes to rest with `times` as many sweeps, of a body that needs
// `limit`.
double with_sweeps(double limit, double friction_time, double times) {
  limit *= std::sqrt(times);
  // h^2 + tau h = limit^2, without a difference of near numbers
  const double half = 0.5 * friction_time;
  return limit * limit / (half + std::sqrt(half * half + limit * limit));
}

// Of substeps or sweeps: a step of so many exactly needs no more of them.
int whole(double number) {
  constexpr double kRounding = 1e-4;
  constexpr double kMost = 1e6;
  return static_cast<int>(std::clamp(std::ceil(number - kRounding), 1.0, kMost));
}

struct BodyVolume {
  double volume = 0;    // m^3
  Index count = 0;      // of tetrahedra, or triangles of a sheet
  float stiffness = 1;  // of the stiffest of them, times that of the material
  float fibre = 0;      // Pa, of the stiffest fibres

  // One more of them.
  void add(double volume_of_it, float stiffness_of_it) {
    volume += volume_of_it;
    stiffness = count == 0 ? stiffness_of_it : std::max(stiffness, stiffness_of_it);
    ++count;
  }
};

// s, a substep of one sweep, or of kCorrectedSweeps with a correction.
// @param crossing      s, of a wave
// @param is_corrected  whether a coarse correction moves the body
double limit_of(double crossing, const SolverOptions& options, bool is_corrected) {
  const double looser = std::sqrt(double{options.accuracy} / kUsualAccuracy);
  if (is_corrected) {
    return looser * std::min(std::sqrt(kCorrectedTime * crossing), kCorrectedLongest);
  }
  const bool by_vertices = options.method == SolverMethod::vertex_block;
  return looser * (by_vertices ? kVertexShare : kProjectionShare) * crossing;
}

// For the bodies of a scene or of tissue.
// @param is_corrected  whether a coarse correction moves them
// @param volume_of     of the live tetrahedra of a body: BodyVolume(std::size_t)
template <class VolumeOf>
SubstepRule rule_of(std::span<const Body> bodies, const SolverOptions& options, bool is_corrected,
                    const VolumeOf& volume_of) {
  const bool has_substeps = options.substeps != kAutomatic;
  const bool has_sweeps = options.iterations != kAutomatic;
  if ((has_substeps && has_sweeps) || is_explicit(options)) {  // see StableSubstep for the latter
    return {};
  }
  const int least = least_sweeps(options);
  const double given = has_sweeps ? options.iterations : least;
  double shortest = options.longest_step, friction = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto [volume, count, stiffness, fibre] = volume_of(b);
    if (count == 0) {
      continue;
    }
    const Body& body = bodies[b];
    const bool has_modes = is_corrected && !is_sheet(body);
    double limit =
        limit_of(crossing_time(body, stiffness, fibre, volume / count), options, has_modes);
    if (!(limit > 0)) {
      throw InvalidArgument("body '" + body.name +
                            "' has springs of compliance 0: no substep is short enough for them; "
                            "give a compliance, or name substeps and iterations");
    }
    if (has_modes) {  // whatever friction there is
      limit = with_sweeps(limit, 0, given / kCorrectedSweeps);
    } else if (has_sweeps) {
      limit = with_sweeps(limit, body.material.damping, given);
    } else {
      friction = std::max(friction, body.material.damping / (limit * limit));
      limit *= std::sqrt(given);
    }
    shortest = std::min(shortest, limit);
    const double longest = double{options.longest_step};
    const double h = has_substeps ? longest / options.substeps : std::min(limit, longest);
    if (!has_substeps && longest > kMostAutomatic * limit) {
      refuse(body, "needs substeps of " + describe(limit) + " s or less", options);
    }
    const double sweeps = least * h * h / (limit * limit) + h * friction;
    if (!has_sweeps && sweeps > kMostAutomatic) {
      refuse(body, "needs " + describe(std::ceil(sweeps)) + " sweeps of a substep", options);
    }
  }
  return {static_cast<float>(shortest), static_cast<float>(friction)};
}

// Tetrahedra or triangles that a body came with, also those that have gone since.
BodyVolume volume_as_it_came(const Tissue& tissue, const Body& body) {
  BodyVolume whole{0, body.tet_count};
  for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
    whole.volume += tissue.tet_mass(t) / body.material.density;
  }
  for (Index t = body.first_triangle; t < body.first_triangle + body.triangle_count; ++t) {
    whole.volume += tissue.triangle_mass(t) / body.material.density;
    ++whole.count;
  }
  return whole;
}

}  // namespace

int least_sweeps(const SolverOptions& options) noexcept {
  return has_coarse_correction(options) ? kCorrectedSweeps : 1;
}

SubstepRule substep_rule(const Tissue& tissue, const SolverOptions& options) {
  std::vector<BodyVolume> volumes(tissue.bodies().size());
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (tissue.is_tet_alive(t)) {
      BodyVolume& body = volumes[tissue.body_of_tet(t)];
      body.add(tet_volume(tissue.rest_positions(), tissue.tets()[t]), tissue.stiffness(t));
      body.fibre = std::max(body.fibre, tissue.fibre(t).stiffness);
    }
  }
  for (Index t = 0; t < static_cast<Index>(tissue.triangles().size()); ++t) {
    if (tissue.is_triangle_alive(t)) {
      const Index b = tissue.body_of_triangle(t);
      volumes[b].add(tissue.triangle_mass(t) / tissue.bodies()[b].material.density,
                     tissue.triangle_stiffness(t));
    }
  }
  const bool is_corrected = has_coarse_correction(options) && has_node_for_each_piece(tissue);
  const SubstepRule rule =
      rule_of(tissue.bodies(), options, is_corrected, [&](std::size_t b) { return volumes[b]; });
  return both(rule, stiff_link_rule(tissue, options));
}

SubstepRule stiff_link_rule(const Tissue& tissue, const SolverOptions& options) {
  SubstepRule rule{options.longest_step, 0};
  if (!has_coarse_correction(options) ||
      (options.substeps != kAutomatic && options.iterations != kAutomatic)) {
    return rule;
  }
  std::vector<double> limits(tissue.bodies().size(), -1);  // s, of bodies without a correction
  const auto limit_at = [&](Index vertex) {
    const Index b = tissue.body_of_vertex(vertex);
    const Body& body = tissue.bodies()[b];
    if (limits[b] < 0 && (body.tet_count > 0 || is_sheet(body))) {
      const BodyVolume whole = volume_as_it_came(tissue, body);
      limits[b] = limit_of(crossing_time(body, 1, 0, whole.volume / whole.count), options, false);
    }
    return limits[b];
  };
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    if (!tissue.is_link_alive(l) || !stiff_link_numbers(tissue, l, options)) {
      continue;
    }
    const Link& link = tissue.links()[l];
    const double softer = std::max(limit_at(link.first), limit_at(link.second));
    if (softer > 0 && options.iterations == kAutomatic) {
      rule.friction = std::max(rule.friction, static_cast<float>(kSweepsOfLinks / softer));
    } else if (softer > 0) {
      const double limit = kShareOfLinks * (options.iterations - 1) * softer;
      rule.longest = std::min(rule.longest, static_cast<float>(limit));
    }
  }
  return rule;
}

SubstepRule substep_rule(const Scene& new_bodies, const SolverOptions& options) {
  return rule_of(new_bodies.bodies(), options, false, [&](std::size_t b) {
    const Body& body = new_bodies.bodies()[b];
    BodyVolume sum;
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      sum.add(tet_volume(new_bodies.positions(), new_bodies.tets()[t]),
              new_bodies.stiffnesses()[t]);
      sum.fibre = std::max(sum.fibre, new_bodies.fibres()[t].stiffness);
    }
    for (Index t = body.first_triangle; t < body.first_triangle + body.triangle_count; ++t) {
      sum.add(body.thickness * triangle_area(new_bodies.positions(), new_bodies.triangles()[t]),
              new_bodies.triangle_stiffnesses()[t]);
    }
    return sum;
  });
}

SubstepRule substep_rule(const Tissue& tissue, const TopologyEdit& edit,
                         const SolverOptions& options) {
  const bool changes_none =
      edit.stiffnesses.empty() && edit.triangle_stiffnesses.empty() && edit.fibres.empty();
  std::vector<BodyVolume> bodies(changes_none ? 0 : tissue.bodies().size());
  for (const StiffnessChange& change : edit.stiffnesses) {
    BodyVolume& body = bodies[tissue.body_of_tet(change.tet)];
    body.stiffness = std::max(body.stiffness, change.factor);
    body.fibre = std::max(body.fibre, tissue.fibre(change.tet).stiffness);
  }
  for (const TriangleStiffnessChange& change : edit.triangle_stiffnesses) {
    BodyVolume& body = bodies[tissue.body_of_triangle(change.triangle)];
    body.stiffness = std::max(body.stiffness, change.factor);
  }
  for (const FibreChange& change : edit.fibres) {
    BodyVolume& body = bodies[tissue.body_of_tet(change.tet)];
    body.stiffness = std::max(body.stiffness, tissue.stiffness(change.tet));
    body.fibre = std::max(body.fibre, change.fibre.stiffness);
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = tissue.bodies()[b];
    if (bodies[b].stiffness > 1 || bodies[b].fibre > 0) {
      const BodyVolume whole = volume_as_it_came(tissue, body);
      bodies[b].volume = whole.volume;
      bodies[b].count = whole.count;
    }
  }
  const bool is_corrected = has_coarse_correction(options);
  return rule_of(tissue.bodies().first(bodies.size()), options, is_corrected,
                 [&](std::size_t b) { return bodies[b]; });
}

SubstepRule both(const SubstepRule& a, const SubstepRule& b) noexcept {
  return {std::min(a.longest, b.longest), std::max(a.friction, b.friction)};
}

SubstepRule hastened(const SubstepRule& rule, double haste) noexcept {
  return {static_cast<float>(rule.longest / std::sqrt(haste)),
          static_cast<float>(rule.friction * haste)};
}

void check_explicit_step(float dt, const SubstepRule& rule, const SolverOptions& options) {
  constexpr float kRounding = 1e-4F;
  const int substeps = divide_step(dt, rule, options).substeps;
  if (dt / static_cast<float>(substeps) > (1 + kRounding) * rule.longest) {
    std::ostringstream text;
    text << "dt is " << dt << " s in " << substeps << " substeps; explicit steps are stable up to "
         << rule.longest
         << " s a substep as tissue is stretched and moves now, and take as many as they need "
         << "where substeps are automatic";
    throw InvalidArgument(text.str());
  }
}

StepPart whole_step(float dt, const StepDivision& division) noexcept {
  StepPart step;
  step.division = division;
  step.h = dt / static_cast<float>(division.substeps);
  step.per_step = division.substeps;
  return step;
}

StepPart first_part(const StepPart& step, int most) noexcept {
  StepPart part = step;
  if (step.division.substeps - most > most / 2) {
    part.division.substeps = most;
  }
  part.after = step.division.substeps - part.division.substeps;
  return part;
}

StepPart part_after(const StepPart& part, float dt, double longest, int most) noexcept {
  StepPart next = part;
  next.past_h = part.h;
  next.start = part.start + part.division.substeps / part.per_step;
  next.before = part.before + part.division.substeps;
  const double left = part.after / part.per_step;  // of the step
  const double time = left * double{dt};
  next.division.substeps = std::max(part.after, whole(time / longest));
  if (next.division.substeps > part.after) {
    next.h = static_cast<float>(time / next.division.substeps);
    next.per_step = next.division.substeps / left;
  }
  return first_part(next, most);
}

StepDivision divide_step(float dt, const SubstepRule& rule, const SolverOptions& options,
                         int least_substeps) noexcept {
  StepDivision division{options.substeps, options.iterations};
  if (options.substeps == kAutomatic) {
    division.substeps = std::max(least_substeps, whole(double{dt} / double{rule.longest}));
  }
  if (is_explicit(options)) {
    division.sweeps = 1;
  } else if (options.iterations == kAutomatic) {
    const double h = double{dt} / division.substeps, share = h / double{rule.longest};
    const int least = least_sweeps(options);
    division.sweeps = std::max(least, whole(least * share * share + h * double{rule.friction}));
  }
  return division;
}

}  // namespace pbdsurg
