// SPDX-License-Identifier: Apache-2.0
#include "tests/support/model_difference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "pbdsurg/mesh/topology.h"

#include "lib/solver/sets/membrane_record.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "tests/support/inspect.h"

namespace pbdsurg::testing {
namespace {

struct Mismatch : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void require(bool holds, const char* what, Index id) {
  if (!holds) {
    throw Mismatch(std::string(what) + " (" + std::to_string(id) + ")");
  }
}

bool is_near(double actual, double expected, double share) {
  return std::abs(actual - expected) <= share * std::abs(expected);
}

float pick(const Stiffness& stiffness, const Solver& solver) {
  return solver.options().mode == ProjectionMode::fraction ? stiffness.fraction
                                                           : stiffness.compliance;
}

constexpr double kRounding = 1e-5;  // of single precision, edit by edit

Index index_of(std::size_t i) {
  return static_cast<Index>(i);
}

/// What follows from the live tetrahedra and triangles and nothing else.
struct Fresh {
  struct LiveEdge {
    Edge vertices;
    Index tets;  ///< around it
    const Body* body;
  };

  explicit Fresh(const LiveModel& model)
      : vertex_tets(model.points.size()), masses(model.particle_masses) {
    for (std::size_t t = 0; t < model.triangles.size(); ++t) {
      const Body& body = model.bodies[model.triangle_bodies[t]];
      const auto& [a, b, c] = model.triangles[t];
      const double area =
          (model.points[b] - model.points[a]).cross(model.points[c] - model.points[a]).norm() / 2;
      for (const Index v : model.triangles[t]) {
        masses[v] += model.triangle_alive[t]
                         ? double{body.material.density} * double{body.thickness} * area / 3
                         : 0;
      }
    }
    for (std::size_t t = 0; t < model.tets.size(); ++t) {
      if (!model.tet_alive[t]) {
        continue;
      }
      const Body& body = model.body_of_tet(index_of(t));
      const Tet& tet = model.tets[t];
      const double volume = tet_volume(model.points, tet);
      for (const Index v : tet) {
        ++vertex_tets[v];
        masses[v] += body.material.density * volume / 4;
      }
      for (const auto& [a, b] : kTetEdges) {
        edges.push_back({edge_between(tet[a], tet[b]), 1, &body});
      }
    }
    std::ranges::sort(edges, {}, &LiveEdge::vertices);
    std::size_t count = 0;
    for (const LiveEdge& edge : edges) {
      if (count > 0 && edges[count - 1].vertices == edge.vertices) {
        ++edges[count - 1].tets;
      } else {
        edges[count++] = edge;
      }
    }
    edges.resize(count);
  }

  [[nodiscard]] const LiveEdge* find(const Edge& vertices) const {
    const auto found = std::ranges::lower_bound(edges, vertices, {}, &LiveEdge::vertices);
    return found != edges.end() && found->vertices == vertices ? &*found : nullptr;
  }

  std::vector<Index> vertex_tets;  // [vertex_count]
  std::vector<double> masses;      // [vertex_count] kg
  std::vector<LiveEdge> edges;     // sorted
};

void compare_bodies(const Solver& solver, const Fresh& fresh, const LiveModel& model) {
  require(solver.tissue().bodies().size() == model.bodies.size(), "bodies",
          index_of(solver.tissue().bodies().size()));
  std::vector<bool> is_alive(model.bodies.size());
  for (Index v = 0; v < model.vertex_count(); ++v) {
    const Index body = model.vertex_bodies[v];
    require(solver.tissue().body_of_vertex(v) == body, "body of vertex", v);
    is_alive[body] = is_alive[body] || fresh.masses[v] > 0;
  }
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Index b = index_of(i);
    const Body& actual = solver.tissue().body(b);
    const Body& expected = model.bodies[i];
    require(actual.name == expected.name, "name of body", b);
    require(actual.first_vertex == expected.first_vertex &&
                actual.vertex_count == expected.vertex_count &&
                actual.first_tet == expected.first_tet && actual.tet_count == expected.tet_count &&
                actual.first_triangle == expected.first_triangle &&
                actual.triangle_count == expected.triangle_count,
            "ids of body", b);
    require(solver.tissue().is_body_alive(b) == is_alive[i], "body alive", b);
  }
}

void compare_topology(const Solver& solver, const Fresh& fresh, const LiveModel& model) {
  const SolverData& data = inspect(solver);
  require(solver.vertex_count() == model.vertex_count(), "vertices", solver.vertex_count());
  require(solver.tissue().tets().size() == model.tets.size(), "tets",
          index_of(solver.tissue().tets().size()));
  require(solver.tissue().links().size() == model.links.size(), "links",
          index_of(solver.tissue().links().size()));
  std::size_t live = 0;
  for (std::size_t e = 0; e < solver.tissue().edges().size(); ++e) {
    const Fresh::LiveEdge* edge = fresh.find(solver.tissue().edges()[e]);
    live += edge != nullptr;
    require(data.tissue->edge_tets()[e] == (edge != nullptr ? edge->tets : 0), "tets around edge",
            index_of(e));
    require(solver.tissue().is_edge_alive(index_of(e)) == (edge != nullptr), "edge alive",
            index_of(e));
  }
  require(live == fresh.edges.size(), "live edges", index_of(live));
  for (std::size_t t = 0; t < model.tets.size(); ++t) {
    require(solver.tissue().is_tet_alive(index_of(t)) == model.tet_alive[t], "tet alive",
            index_of(t));
    if (model.tet_alive[t]) {
      require(solver.tissue().tets()[t] == model.tets[t], "vertices of tet", index_of(t));
      require(data.tissue->body_of_tet(index_of(t)) == model.tet_bodies[t], "body of tet",
              index_of(t));
      for (std::size_t e = 0; e < 6; ++e) {
        const Tet& tet = solver.tissue().tets()[t];
        const Index a = tet[kTetEdges[e][0]], b = tet[kTetEdges[e][1]];
        require(solver.tissue().edges()[solver.tissue().tet_edges(index_of(t))[e]] ==
                    Edge{std::min(a, b), std::max(a, b)},
                "edges of tet", index_of(t));
      }
    }
  }
}

void compare_masses(const LiveModel& model, const Solver& solver, const Fresh& fresh) {
  const SolverData& data = inspect(solver);
  const auto velocities = solver.velocities();
  for (Index v = 0; v < model.vertex_count(); ++v) {
    const double mass = fresh.masses[v];
    const float w = data.particle(v).w;
    require(static_cast<Index>(data.tissue->tets_at(v).size()) == fresh.vertex_tets[v],
            "tets at vertex", v);
    require(solver.tissue().has_tissue(v) == (mass > 0), "tissue at vertex", v);
    require(solver.tissue().is_fixed(v) == model.is_fixed[v], "whether fixed is vertex", v);
    require(
        mass > 0 ? is_near(data.tissue->masses()[v], mass, 1e-9) : data.tissue->masses()[v] == 0,
        "mass of vertex", v);
    if (mass > 0 && !model.is_fixed[v]) {
      require(is_near(w, 1 / mass, 1e-6), "inverse mass of vertex", v);
    } else {
      require(w == 0 && velocities[v].isZero(0), "rest of a vertex that cannot move", v);
    }
  }
}

// Of new edges, lengths come of differences between the squares of those around (length_between()).
// A short edge among long ones keeps fewer digits than a float has.
class Lengths {
 public:
  template <class Map>
  explicit Lengths(const Map& lengths) {
    for (const auto& [edge, length] : lengths) {
      longest_ = std::max(longest_, static_cast<double>(length));
    }
  }

  [[nodiscard]] bool are_near(double a, double b) const {
    constexpr double kLost = 1e-6;
    return is_near(a, b, kRounding) || std::abs(a * a - b * b) <= kLost * longest_ * longest_;
  }

 private:
  double longest_ = 0;  // m
};

void compare_distances(const LiveModel& model, const Solver& solver, const Fresh& fresh) {
  const SolverData& data = inspect(solver);
  const Lengths rest_lengths(model.rest_lengths), limits(model.limits);
  const auto expect = [&](Index id, const Edge& vertices, float rest, float stiffness,
                          float damping, const char* what) {
    const auto [places, parameters] = data.sets.of<DistanceConstraint>().record(id);
    require(places == data.places_of(vertices) && rest_lengths.are_near(parameters[0], rest) &&
                parameters[1] == stiffness && parameters[2] == damping,
            what, id);
  };
  for (std::size_t e = 0; e < solver.tissue().edges().size(); ++e) {
    const Fresh::LiveEdge* edge = fresh.find(solver.tissue().edges()[e]);
    const bool is_spring = edge != nullptr && edge->body->material.model == ElasticModel::springs;
    const bool is_limited = edge != nullptr && std::isfinite(edge->body->material.max_stretch);
    const Index id = index_of(e);
    const Index distance = data.sets.distance_ids.of_edge(id);
    require(data.sets.of<DistanceConstraint>().is_alive(distance) == is_spring, "distance of edge",
            id);
    require(data.sets.of<StrainLimitConstraint>().is_alive(id) == is_limited,
            "strain limit of edge", id);
    if (is_spring) {
      const Material& material = edge->body->material;
      expect(distance, edge->vertices, model.rest_lengths.at(edge->vertices),
             pick(material.stretch, solver), material.damping, "distance of edge");
    }
    if (is_limited) {
      const auto limit = data.sets.of<StrainLimitConstraint>().record(id);
      require(limit.places == data.places_of(edge->vertices) &&
                  limits.are_near(limit.parameters[StrainLimitConstraint::kLimit],
                                  model.limits.at(edge->vertices)),
              "strain limit of edge", id);
    }
  }
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    const Link& link = model.links[l];
    const Index id = data.sets.distance_ids.of_link(index_of(l));
    const bool is_alive =
        model.link_alive[l] && fresh.masses[link.first] > 0 && fresh.masses[link.second] > 0;
    require(solver.tissue().is_link_alive(index_of(l)) == is_alive, "link alive", index_of(l));
    if (is_alive) {
      require(solver.tissue().links()[l].first == link.first &&
                  solver.tissue().links()[l].second == link.second,
              "ends of link", index_of(l));
      require(solver.tissue().links()[l].rest_length == link.rest_length, "length of link",
              index_of(l));
      expect(id, {link.first, link.second}, link.rest_length, pick(link.stiffness, solver), 0,
             "distance of link");
    }
    const auto& stiff = data.sets.of<StiffLinkConstraint>();
    const bool is_stiff = stiff.is_alive(index_of(l));
    const bool is_rigid =
        solver.options().method == SolverMethod::vertex_block && link.stiffness.compliance == 0;
    require(is_stiff ? is_alive : !(is_alive && is_rigid), "stiff link", index_of(l));
    if (is_stiff) {
      const auto [places, parameters] = stiff.record(index_of(l));
      require(places == data.places_of(Edge{link.first, link.second}) &&
                  parameters[StiffLinkConstraint::kRest] == link.rest_length &&
                  parameters[StiffLinkConstraint::kStiffness] == link.stiffness.compliance,
              "stiff link", index_of(l));
    }
  }
}

// Of a hinge, times that of its rigidity.
double hinge_factor(const LiveModel& model, const Hinge& hinge) {
  double sum = 0;
  int count = 0;
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    const auto has = [&](Index v) { return std::ranges::count(model.triangles[t], v) > 0; };
    const auto& v = hinge.vertices;
    if (model.triangle_alive[t] && has(v[0]) && has(v[1]) && (has(v[2]) || has(v[3]))) {
      sum += model.sheet_stiffnesses[t];
      ++count;
    }
  }
  return count == 0 ? 1 : sum / count;
}

void compare_hinges(const LiveModel& model, const Solver& solver) {
  const Tissue& tissue = solver.tissue();
  require(tissue.hinges().size() == model.hinges.size(), "hinges",
          index_of(tissue.hinges().size()));
  std::vector<std::vector<Index>> at(model.points.size());  // [vertex]
  for (std::size_t h = 0; h < model.hinges.size(); ++h) {
    require(tissue.hinges()[h].vertices == model.hinges[h].vertices &&
                tissue.hinges()[h].rigidity == model.hinges[h].rigidity,
            "hinge", index_of(h));
    require(tissue.is_hinge_alive(index_of(h)) == model.hinge_alive[h], "hinge alive", index_of(h));
    for (const Index v : model.hinges[h].vertices) {
      if (model.hinge_alive[h]) {
        at[v].push_back(index_of(h));
      }
    }
    const auto& bendings = inspect(solver).sets.of<BendingConstraint>();
    require(bendings.is_alive(index_of(h)) == model.hinge_alive[h], "bending alive", index_of(h));
    if (model.hinge_alive[h]) {
      const Hinge& hinge = model.hinges[h];
      Vec3<double> x[4];
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d& point = model.points[hinge.vertices[k]];
        x[k] = {point.x(), point.y(), point.z()};
      }
      const HingeAtRest rest = hinge_at_rest(x, hinge.rigidity);
      const auto record = bendings.record(index_of(h));
      const Body& body = model.bodies[model.vertex_bodies[hinge.vertices[0]]];
      require(record.places == inspect(solver).places_of(hinge.vertices) &&
                  std::abs(record.parameters[BendingConstraint::kRest] - rest.turn) < kRounding &&
                  is_near(record.parameters[BendingConstraint::kStiffness],
                          1 / (hinge_factor(model, hinge) * rest.stiffness), kRounding) &&
                  record.parameters[BendingConstraint::kDamping] == body.material.damping,
              "bending of hinge", index_of(h));
    }
  }
  for (Index v = 0; v < model.vertex_count(); ++v) {
    require(std::ranges::equal(tissue.hinges_at(v), at[v]), "hinges at vertex", v);
  }
}

// Of a tetrahedron whose rest shape grew evenly, by a share of its volume.
void compare_fibres(const LiveModel& model, const Solver& solver, Index t, double share) {
  const SolverData& data = inspect(solver);
  const auto& set = data.sets.of<FibreConstraint>();
  const Fibre& fibre = model.fibres[t];
  const bool has_any = model.tet_alive[t] && fibre.stiffness > 0;
  require(set.is_alive(t) == has_any, "fibres of tet", t);
  require(solver.tissue().fibre(t).stiffness == fibre.stiffness &&
              solver.tissue().fibre(t).direction == fibre.direction,
          "fibre of tissue", t);
  if (!has_any) {
    return;
  }
  const auto record = set.record(t);
  require(record.places == data.places_of(model.tets[t]), "vertices of fibres", t);
  Eigen::Matrix3d sides;
  for (int k = 0; k < 3; ++k) {
    sides.col(k) = model.points[model.tets[t][k + 1]] - model.points[model.tets[t][0]];
  }
  const Eigen::Vector3d shares =
      sides.inverse() * fibre.direction.cast<double>() / std::cbrt(share);
  const Eigen::Vector3f found(record.parameters[0], record.parameters[1], record.parameters[2]);
  require((found.cast<double>() - shares).norm() <= 1e-3 * sides.inverse().norm(),
          "shares of fibres", t);
  const double stiffness = double{fibre.stiffness} * sides.determinant() / 6 * share;
  require(std::abs(record.parameters[FibreConstraint::kStiffness] - stiffness) <= 1e-3 * stiffness,
          "stiffness of fibres", t);
  if (data.options.method == SolverMethod::vertex_block) {
    const VertexTet& tet = data.vertex_blocks.tet(t);
    require(std::ranges::equal(tet.fibre_shares, std::span(record.parameters).first(3)) &&
                tet.fibre_stiffness == record.parameters[FibreConstraint::kStiffness],
            "fibres of vertex blocks", t);
  }
}

void compare_tets(const LiveModel& model, const Solver& solver) {
  const SolverData& data = inspect(solver);
  for (std::size_t i = 0; i < model.tets.size(); ++i) {
    const Index t = index_of(i);
    const Body& body = model.body_of_tet(t);
    const Material& material = body.material;
    const bool is_solid = model.tet_alive[i] && material.model == ElasticModel::neo_hookean;
    const bool has_volume = model.tet_alive[i] && has_volume_constraints(body);
    require(data.sets.of<VolumeConstraint>().is_alive(t) == has_volume, "volume of tet", t);
    require(data.sets.of<NeoHookeanConstraint>().is_alive(t) == is_solid, "neo-hookean of tet", t);
    const double share = model.rest_volumes[i] / tet_volume(model.points, model.tets[i]);
    compare_fibres(model, solver, t, share);
    if (!model.tet_alive[i]) {
      continue;
    }
    const Tet places = data.places_of(model.tets[i]);
    if (has_volume) {
      const auto record = data.sets.of<VolumeConstraint>().record(t);
      require(record.places == places &&
                  is_near(record.parameters[VolumeConstraint::kRest], model.rest_volumes[i],
                          kRounding) &&
                  record.parameters[1] == pick(material.volume, solver) &&
                  record.parameters[2] == material.damping,
              "volume of tet", t);
    }
    if (is_solid) {
      const auto record = data.sets.of<NeoHookeanConstraint>().record(t);
      auto expected =
          make_neo_hookean(model.points, model.tets[i], places, material, model.stiffnesses[i]);
      require(solver.tissue().stiffness(t) == model.stiffnesses[i], "stiffness of tet", t);
      for (int p = 0; p < 9; ++p) {
        expected.parameters[NeoHookeanConstraint::kInverseShape + p] /=
            static_cast<float>(std::cbrt(share));
      }
      expected.parameters[NeoHookeanConstraint::kStiffness] *= static_cast<float>(share);
      require(record.places == places, "vertices of neo-hookean", t);
      const auto largest_shape = [](const auto& parameters) {
        return *std::max_element(parameters.begin() + NeoHookeanConstraint::kInverseShape,
                                 parameters.begin() + NeoHookeanConstraint::kInverseShape + 9);
      };
      const double size = std::abs(largest_shape(expected.parameters));
      for (int p = 0; p < NeoHookeanConstraint::kParameterCount; ++p) {
        const bool is_shape =
            p >= NeoHookeanConstraint::kInverseShape && p < NeoHookeanConstraint::kInverseShape + 9;
        const double error = std::abs(record.parameters[p] - expected.parameters[p]);
        require(error <= 1e-4 * (is_shape ? size : std::abs(expected.parameters[p])),
                "parameters of neo-hookean", t);
      }
    }
  }
}

void compare_sheets(const LiveModel& model, const Solver& solver) {
  const SolverData& data = inspect(solver);
  const Tissue& tissue = solver.tissue();
  require(tissue.triangles().size() == model.triangles.size(), "triangles",
          index_of(tissue.triangles().size()));
  std::vector<std::vector<Index>> at(model.points.size());  // [vertex]
  for (std::size_t i = 0; i < model.triangles.size(); ++i) {
    const Index t = index_of(i);
    require(tissue.is_triangle_alive(t) == model.triangle_alive[i], "triangle alive", t);
    require(tissue.body_of_triangle(t) == model.triangle_bodies[i], "body of triangle", t);
    const auto& membranes = data.sets.of<MembraneConstraint>();
    require(membranes.is_alive(t) == model.triangle_alive[i], "membrane alive", t);
    if (!model.triangle_alive[i]) {
      continue;
    }
    require(tissue.triangles()[i] == model.triangles[i], "vertices of triangle", t);
    for (const Index v : model.triangles[i]) {
      at[v].push_back(t);
    }
    const auto record = membranes.record(t);
    const auto expected =
        make_membrane(model.points, model.triangles[i], data.places_of(model.triangles[i]),
                      model.bodies[model.triangle_bodies[i]], model.sheet_stiffnesses[i]);
    require(tissue.triangle_stiffness(t) == model.sheet_stiffnesses[i], "stiffness of triangle", t);
    require(record.places == expected.places, "vertices of membrane", t);
    const double share = model.rest_areas[i] / rest_area(expected);
    require(is_near(solver.rest_area(t), model.rest_areas[i], 1e-4), "rest area of triangle", t);
    const double size = std::abs(
        *std::max_element(expected.parameters.begin() + MembraneConstraint::kInverseShape,
                          expected.parameters.begin() + MembraneConstraint::kInverseShape + 4));
    for (int p = 0; p < MembraneConstraint::kParameterCount; ++p) {
      const bool is_shape =
          p >= MembraneConstraint::kInverseShape && p < MembraneConstraint::kInverseShape + 4;
      const bool is_stiffness = p == MembraneConstraint::kStiffness;
      const double scale = is_shape ? 1 / std::sqrt(share) : is_stiffness ? share : 1;
      const double value = scale * expected.parameters[p];
      require(std::abs(record.parameters[p] - value) <= 1e-4 * (is_shape ? size : std::abs(value)),
              "parameters of membrane", t);
    }
  }
  for (Index v = 0; v < model.vertex_count(); ++v) {
    require(std::ranges::equal(tissue.triangles_at(v), at[v]), "triangles at vertex", v);
  }
}

// Blocks are full but for the last, whose idle lanes repeat it, and no two constraints of a group
// that is projected at once share a vertex.
// @param is_serial  [group_count]
// @param domains    [group_count] level and domain
template <class Constraint>
void compare_groups(const ConstraintSlots<Constraint>& slots, const SolverData& data,
                    const std::vector<bool>& is_serial, const char* what) {
  std::vector<Index> seen(data.particles.size(), kInvalidIndex);  // group that last used a place
  for (Index group = 0; group < slots.group_count(); ++group) {
    const auto ids = slots.ids(group);
    const auto blocks = slots.blocks(group);
    require(blocks.size() == (ids.size() + kBlockLanes - 1) / kBlockLanes, what, group);
    for (const Index id : ids) {
      require(slots.group_of(id) == group, what, id);
      for (const Index place : slots.record(id).places) {
        require(is_serial[group] || seen[place] != group, what, id);
        seen[place] = group;
      }
    }
    for (std::size_t lane = ids.size(); lane < blocks.size() * kBlockLanes; ++lane) {
      const std::size_t last = (ids.size() - 1) % kBlockLanes;
      for (const auto& corner : blocks.back().corners) {
        require(corner[lane % kBlockLanes] == corner[last], what, group);
      }
      for (const auto& parameter : blocks.back().parameters) {
        require(parameter[lane % kBlockLanes] == parameter[last], what, group);
      }
    }
  }
}

void compare_colors(const SolverData& data) {
  std::map<PhaseKind, std::vector<bool>> is_serial;  // of the groups of a kind of constraint
  data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
    is_serial[KindOf<Constraint>::kPhase].resize(static_cast<std::size_t>(slots.group_count()));
  });
  std::map<std::pair<Index, Index>, Index> domain_of;  // of (level, place)
  const auto claim = [&](const auto& slots, Index group, const Phase& phase) {
    if (data.sets.domain_counts.size() > 1) {
      for (const Index id : slots.ids(group)) {
        for (const Index place : slots.record(id).places) {
          require(domain_of.try_emplace({phase.level, place}, phase.domain).first->second ==
                      phase.domain,
                  "domains that share a place", place);
        }
      }
    }
  };
  for (const Phase& phase : data.sets.phases) {
    const auto color = static_cast<std::size_t>(phase.color);
    if (phase.kind == PhaseKind::joint) {
      for (Index place = 0; place < 6; ++place) {
        is_serial[PhaseKind::distance][data.sets.joint_group(phase.color, place)] = phase.serial;
      }
    }
    bool is_elastic = false;
    data.sets.visit_set(phase.kind,
                        [&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
                          is_elastic = true;
                          is_serial[KindOf<Constraint>::kPhase][color] = phase.serial;
                          claim(slots, phase.color, phase);
                        });
    require(is_elastic, "kind of a constraint's phase", static_cast<Index>(phase.kind));
  }
  data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
    compare_groups(slots, data, is_serial[KindOf<Constraint>::kPhase], "group of constraints");
  });
}

void compare_plan(const SolverData& data) {
  if (data.options.method == SolverMethod::vertex_block) {
    return;
  }
  std::size_t next = 0;
  for (const Phase& phase : data.sets.phases) {
    if (data.sets.constraint_count(phase) > 0) {
      require(next < data.plan.phases.size() && data.plan.phases[next].kind == phase.kind &&
                  data.plan.phases[next].color == phase.color,
              "phase", index_of(next));
      ++next;
    }
  }
  next += static_cast<std::size_t>(data.custom.count());
  require(next <= data.plan.phases.size(), "phases", index_of(next));
  for (; next < data.plan.phases.size(); ++next) {
    const PhaseKind kind = data.plan.phases[next].kind;
    require(kind == PhaseKind::body_contact || kind == PhaseKind::grip ||
                kind == PhaseKind::attachment || kind == PhaseKind::contact,
            "phase of what touches", index_of(next));
  }
}

// Of a joint plan: edges that are as they were have an owner; those that edits made, and those
// whose owner they took, may be on their own.
void compare_owners(const LiveModel& model, const Solver& solver, const Fresh& fresh) {
  const SolverData& data = inspect(solver);
  const bool is_joint = data.options.composition == PlanComposition::joint;
  std::vector<bool> has_phase(
      static_cast<std::size_t>(data.sets.of<DistanceConstraint>().group_count()));
  for (const Phase& phase : data.sets.phases) {
    if (phase.kind == PhaseKind::distance) {
      has_phase[phase.color] = true;
    }
  }
  for (std::size_t i = 0; i < data.tissue->edges().size(); ++i) {
    const Index e = index_of(i);
    const Index distance = data.sets.distance_ids.of_edge(e);
    if (!data.sets.of<DistanceConstraint>().is_alive(distance)) {
      continue;
    }
    const Index owner = data.sets.edge_owners[e];
    const bool may_be_alone = !is_joint || model.has_grown ||
                              !has_volume_constraints(*fresh.find(data.tissue->edges()[i])->body);
    if (owner == kInvalidIndex) {
      require(may_be_alone && has_phase[data.sets.of<DistanceConstraint>().group_of(distance)],
              "owner of edge", e);
      continue;
    }
    require(is_joint && data.tissue->is_tet_alive(owner), "owner of edge", e);
    const auto& edges = data.tissue->tet_edges()[owner];
    const auto place = std::ranges::find(edges, e) - edges.begin();
    require(place < 6 && data.sets.of<DistanceConstraint>().group_of(distance) ==
                             data.sets.joint_group(data.sets.of<VolumeConstraint>().group_of(owner),
                                                   static_cast<Index>(place)),
            "group of an owned edge", e);
  }
}

}  // namespace

namespace {

void compare_loads(const LiveModel& model, const Solver& solver) {
  const std::vector<Eigen::Vector3f> forces = solver.forces();
  for (std::size_t v = 0; v < model.points.size(); ++v) {
    require(forces.empty() ? model.forces[v].isZero(0) : forces[v] == model.forces[v],
            "the force of vertex", index_of(v));
  }
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    require(solver.gravity(index_of(b)) == model.gravities[b], "gravity of body", index_of(b));
  }
}

}  // namespace

std::string difference(const LiveModel& model, const Solver& solver) {
  try {
    const Fresh fresh(model);
    compare_bodies(solver, fresh, model);
    compare_topology(solver, fresh, model);
    compare_masses(model, solver, fresh);
    compare_distances(model, solver, fresh);
    compare_tets(model, solver);
    compare_sheets(model, solver);
    compare_hinges(model, solver);
    compare_owners(model, solver, fresh);
    compare_colors(inspect(solver));
    compare_plan(inspect(solver));
    compare_loads(model, solver);
    return {};
  } catch (const Mismatch& mismatch) {
    return mismatch.what();
  }
}

}  // namespace pbdsurg::testing
