// SPDX-License-Identifier: Apache-2.0
#include "support/live_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "pbdsurg/edit/live_boundary.h"

#include "solver/neo_hookean_record.h"
#include "solver/solver_data.h"

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

Index index_of(std::size_t i) {
  return static_cast<Index>(i);
}

/// What follows from the live tetrahedra and nothing else.
struct Fresh {
  struct LiveEdge {
    Edge vertices;
    Index tets;  ///< around it
    const Body* body;
  };

  Fresh(const Scene& scene, const Solver& solver, const std::vector<bool>& tet_alive)
      : vertex_tets(scene.vertex_count()), masses(scene.vertex_count()) {
    for (const Body& body : scene.bodies()) {
      for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
        masses[v] = body.tet_count == 0 ? scene.masses()[v] : 0;
      }
      for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
        body_of_tet.push_back(&body);
        if (!tet_alive[t]) {
          continue;
        }
        const Tet& tet = solver.tets()[t];
        const double volume = tet_volume(scene.positions(), scene.tets()[t]);
        for (const Index v : tet) {
          ++vertex_tets[v];
          masses[v] += body.material.density * volume / 4;
        }
        for (const auto& [a, b] : kTetEdges) {
          edges.push_back(
              {{std::min(tet[a], tet[b]), std::max(tet[a], tet[b])}, 1, body_of_tet[t]});
        }
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

  std::vector<const Body*> body_of_tet;  // [tet_count]
  std::vector<Index> vertex_tets;        // [vertex_count]
  std::vector<double> masses;            // [vertex_count] kg
  std::vector<LiveEdge> edges;           // sorted
};

void compare_topology(const Solver& solver, const Fresh& fresh,
                      const std::vector<bool>& tet_alive) {
  const SolverData& data = solver_data(solver);
  std::size_t live = 0;
  for (std::size_t e = 0; e < solver.edges().size(); ++e) {
    const Fresh::LiveEdge* edge = fresh.find(solver.edges()[e]);
    live += edge != nullptr;
    require(data.edge_tets[e] == (edge != nullptr ? edge->tets : 0), "tets around edge",
            index_of(e));
    require(solver.is_edge_alive(index_of(e)) == (edge != nullptr), "edge alive", index_of(e));
  }
  require(live == fresh.edges.size(), "live edges", index_of(live));
  for (std::size_t t = 0; t < tet_alive.size(); ++t) {
    require(solver.is_tet_alive(index_of(t)) == tet_alive[t], "tet alive", index_of(t));
    if (tet_alive[t]) {
      for (std::size_t e = 0; e < 6; ++e) {
        const Tet& tet = solver.tets()[t];
        const Index a = tet[kTetEdges[e][0]], b = tet[kTetEdges[e][1]];
        require(solver.edges()[solver.tet_edges(index_of(t))[e]] ==
                    Edge{std::min(a, b), std::max(a, b)},
                "edges of tet", index_of(t));
      }
    }
  }
}

void compare_masses(const Scene& scene, const Solver& solver, const Fresh& fresh) {
  const SolverData& data = solver_data(solver);
  const auto velocities = solver.velocities();
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const double mass = fresh.masses[v];
    const float w = data.particle(v).w;
    require(static_cast<Index>(data.vertex_tets[v].size()) == fresh.vertex_tets[v],
            "tets at vertex", v);
    require(solver.has_tissue(v) == (mass > 0), "tissue at vertex", v);
    require(mass > 0 ? is_near(data.vertex_masses[v], mass, 1e-9) : data.vertex_masses[v] == 0,
            "mass of vertex", v);
    if (mass > 0 && !scene.is_fixed(v)) {
      require(is_near(w, 1 / mass, 1e-6), "inverse mass of vertex", v);
    } else {
      require(w == 0 && velocities[v].isZero(0), "rest of a vertex that cannot move", v);
    }
  }
}

void compare_distances(const Solver& solver, const Fresh& fresh,
                       const std::vector<float>& rest_lengths,
                       const std::vector<bool>& link_alive) {
  const SolverData& data = solver_data(solver);
  const auto expect = [&](Index id, const Edge& vertices,
                          const std::array<float, DistanceConstraint::kParameterCount>& parameters,
                          const char* what) {
    const auto record = data.distances.record(id);
    require(record.places == data.places_of(vertices) && record.parameters == parameters, what, id);
  };
  for (std::size_t e = 0; e < solver.edges().size(); ++e) {
    const Fresh::LiveEdge* edge = fresh.find(solver.edges()[e]);
    const bool is_spring = edge != nullptr && edge->body->material.model == ElasticModel::springs;
    const bool is_limited = edge != nullptr && std::isfinite(edge->body->material.max_stretch);
    const Index id = index_of(e);
    require(data.distances.is_alive(id) == is_spring, "distance of edge", id);
    require(data.strain_limits.is_alive(id) == is_limited, "strain limit of edge", id);
    if (is_spring) {
      const Material& material = edge->body->material;
      expect(id, edge->vertices,
             {rest_lengths[e], pick(material.stretch, solver), material.damping},
             "distance of edge");
      require(solver.rest_length(id) == rest_lengths[e], "rest length of edge", id);
    }
    if (is_limited) {
      const auto limit = data.strain_limits.record(id);
      require(limit.places == data.places_of(edge->vertices) &&
                  is_near(limit.parameters[StrainLimitConstraint::kLimit],
                          double{edge->body->material.max_stretch} * rest_lengths[e], 1e-5),
              "strain limit of edge", id);
    }
  }
  for (std::size_t l = 0; l < link_alive.size(); ++l) {
    const Link& link = solver.links()[l];
    const Index id = data.distance_ids.of_link(index_of(l));
    const bool is_alive =
        link_alive[l] && solver.has_tissue(link.first) && solver.has_tissue(link.second);
    require(solver.is_link_alive(index_of(l)) == is_alive, "link alive", index_of(l));
    if (is_alive) {
      expect(id, {link.first, link.second}, {link.rest_length, pick(link.stiffness, solver), 0},
             "distance of link");
    }
  }
}

void compare_tets(const Scene& scene, const Solver& solver, const Fresh& fresh,
                  const std::vector<bool>& tet_alive, const std::vector<float>& rest_volumes) {
  const SolverData& data = solver_data(solver);
  for (std::size_t i = 0; i < tet_alive.size(); ++i) {
    const Index t = index_of(i);
    const Body& body = *fresh.body_of_tet[i];
    const Material& material = body.material;
    const bool is_solid = tet_alive[i] && material.model == ElasticModel::neo_hookean;
    const bool has_volume = tet_alive[i] && has_volume_constraints(body);
    require(data.volumes.is_alive(t) == has_volume, "volume of tet", t);
    require(data.neo_hookeans.is_alive(t) == is_solid, "neo-hookean of tet", t);
    const Tet places = data.places_of(solver.tets()[i]);
    if (has_volume) {
      const auto record = data.volumes.record(t);
      require(record.places == places &&
                  record.parameters[VolumeConstraint::kRest] == rest_volumes[i] &&
                  record.parameters[1] == pick(material.volume, solver) &&
                  record.parameters[2] == material.damping,
              "volume of tet", t);
    }
    if (is_solid) {
      const auto record = data.neo_hookeans.record(t);
      auto expected = make_neo_hookean(scene.positions(), scene.tets()[i], places, material);
      const double share = rest_volumes[i] / tet_volume(scene.positions(), scene.tets()[i]);
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
  std::vector<bool> distances(static_cast<std::size_t>(data.distances.group_count()));
  std::vector<bool> volumes(static_cast<std::size_t>(data.volumes.group_count()));
  std::vector<bool> neo_hookeans(static_cast<std::size_t>(data.neo_hookeans.group_count()));
  std::vector<bool> strain_limits(static_cast<std::size_t>(data.strain_limits.group_count()));
  std::map<std::pair<Index, Index>, Index> domain_of;  // of (level, place)
  const auto claim = [&](const auto& slots, Index group, const Phase& phase) {
    if (data.domain_counts.size() > 1) {
      for (const Index id : slots.ids(group)) {
        for (const Index place : slots.record(id).places) {
          require(domain_of.try_emplace({phase.level, place}, phase.domain).first->second ==
                      phase.domain,
                  "domains that share a place", place);
        }
      }
    }
  };
  for (const Phase& phase : data.constraint_phases) {
    const auto color = static_cast<std::size_t>(phase.color);
    switch (phase.kind) {
      case PhaseKind::distance:
        distances[color] = phase.serial;
        claim(data.distances, phase.color, phase);
        break;
      case PhaseKind::joint:
        for (Index place = 0; place < 6; ++place) {
          distances[data.joint_group(phase.color, place)] = phase.serial;
        }
        [[fallthrough]];
      case PhaseKind::volume:
        volumes[color] = phase.serial;
        claim(data.volumes, phase.color, phase);
        break;
      case PhaseKind::neo_hookean:
        neo_hookeans[color] = phase.serial;
        claim(data.neo_hookeans, phase.color, phase);
        break;
      case PhaseKind::strain_limit:
        strain_limits[color] = phase.serial;
        claim(data.strain_limits, phase.color, phase);
        break;
      default:
        require(false, "kind of a constraint's phase", static_cast<Index>(phase.kind));
    }
  }
  compare_groups(data.distances, data, distances, "group of distances");
  compare_groups(data.volumes, data, volumes, "group of volumes");
  compare_groups(data.neo_hookeans, data, neo_hookeans, "group of neo-hookeans");
  compare_groups(data.strain_limits, data, strain_limits, "group of strain limits");
}

void compare_plan(const SolverData& data) {
  if (data.options.method == SolverMethod::vertex_block) {
    return;
  }
  std::size_t next = 0;
  for (const Phase& phase : data.constraint_phases) {
    if (data.constraint_count(phase) > 0) {
      require(next < data.plan.phases.size() && data.plan.phases[next].kind == phase.kind &&
                  data.plan.phases[next].color == phase.color,
              "phase", index_of(next));
      ++next;
    }
  }
  require(next == data.plan.phases.size(), "phases", index_of(next));
}

void compare_owners(const Solver& solver, const Fresh& fresh) {
  const SolverData& data = solver_data(solver);
  const bool is_joint = data.options.composition == PlanComposition::joint;
  for (std::size_t i = 0; i < data.edges.size(); ++i) {
    const Index e = index_of(i);
    if (!data.distances.is_alive(e)) {
      continue;
    }
    const Index owner = data.edge_owners[e];
    if (!is_joint || !has_volume_constraints(*fresh.find(data.edges[i])->body)) {
      require(owner == kInvalidIndex && data.distances.group_of(e) < data.first_joint_group,
              "owner of edge", e);
      continue;
    }
    require(owner != kInvalidIndex && data.tet_alive[owner], "owner of edge", e);
    const auto& edges = data.tet_edges[owner];
    const auto place = std::ranges::find(edges, e) - edges.begin();
    require(
        place < 6 && data.distances.group_of(e) ==
                         data.joint_group(data.volumes.group_of(owner), static_cast<Index>(place)),
        "group of an owned edge", e);
  }
}

// A triangle from its smallest vertex on, which keeps its winding.
Triangle from_smallest(Triangle triangle) {
  std::ranges::rotate(triangle, std::ranges::min_element(triangle));
  return triangle;
}

// Sorted, with the tetrahedron that each bounds.
using Surface = std::vector<std::pair<Triangle, Index>>;

Surface find_surface(const Solver& solver, const std::vector<bool>& tet_alive, Index body) {
  struct Face {
    Triangle sorted;
    Triangle vertices;
    Index tet;
  };
  const Body& where = solver.body(body);
  std::vector<Face> faces;
  for (Index t = where.first_tet; t < where.first_tet + where.tet_count; ++t) {
    if (tet_alive[t]) {
      const Tet& tet = solver.tets()[t];
      for (const auto& [a, b, c] : kTetTriangles) {
        const Triangle triangle{tet[a], tet[b], tet[c]};
        faces.push_back({triangle, from_smallest(triangle), t});
        std::ranges::sort(faces.back().sorted);
      }
    }
  }
  std::ranges::sort(faces, {}, &Face::sorted);
  Surface surface;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + 1 < faces.size() && faces[i].sorted == faces[i + 1].sorted) {
      ++i;  // within
    } else {
      surface.emplace_back(faces[i].vertices, faces[i].tet);
    }
  }
  std::ranges::sort(surface);
  return surface;
}

void compare_surface(const Solver& solver, const std::vector<bool>& tet_alive, Index body) {
  Surface actual;
  for (const BoundaryTriangle& triangle : find_live_boundary(solver, body)) {
    actual.emplace_back(from_smallest(triangle.vertices), triangle.tet);
  }
  std::ranges::sort(actual);
  require(actual == find_surface(solver, tet_alive, body), "surface of body", body);
}

}  // namespace

LiveModel::LiveModel(const Scene& scene, const Solver& solver)
    : scene_(&scene),
      tet_alive_(scene.tets().size(), true),
      link_alive_(scene.links().size(), true) {
  for (const auto& [a, b] : solver.edges()) {
    rest_lengths_.push_back(
        static_cast<float>((scene.positions()[a] - scene.positions()[b]).norm()));
  }
  for (const Tet& tet : scene.tets()) {
    rest_volumes_.push_back(static_cast<float>(tet_volume(scene.positions(), tet)));
  }
}

void LiveModel::apply(const TopologyEdit& edit) {
  for (const RestLengthChange& change : edit.rest_lengths) {
    rest_lengths_[change.edge] = change.rest_length;
  }
  for (const RestVolumeChange& change : edit.rest_volumes) {
    rest_volumes_[change.tet] = change.rest_volume;
  }
  for (const Index t : edit.remove_tets) {
    tet_alive_[t] = false;
  }
  for (const Index l : edit.remove_links) {
    link_alive_[l] = false;
  }
}

std::string LiveModel::difference(const Solver& solver) const {
  try {
    const Fresh fresh(*scene_, solver, tet_alive_);
    compare_topology(solver, fresh, tet_alive_);
    compare_masses(*scene_, solver, fresh);
    compare_distances(solver, fresh, rest_lengths_, link_alive_);
    compare_tets(*scene_, solver, fresh, tet_alive_, rest_volumes_);
    compare_owners(solver, fresh);
    compare_colors(solver_data(solver));
    compare_plan(solver_data(solver));
    for (std::size_t body = 0; body < solver.bodies().size(); ++body) {
      compare_surface(solver, tet_alive_, index_of(body));
    }
    return {};
  } catch (const Mismatch& mismatch) {
    return mismatch.what();
  }
}

std::string LiveModel::difference(const HeatField& field, const ThermalBody& body) const {
  constexpr double kTimeStep = 0.02;  // s
  constexpr double kPower = 0.05;     // W
  const Body& where = scene_->body(body.body);
  // in the scene's numbering of vertices
  std::vector<Eigen::Vector3d> points(field.mesh().rest_positions().begin(),
                                      field.mesh().rest_positions().end());
  std::vector<Tet> live;
  for (Index t = 0; t < where.tet_count; ++t) {
    if (tet_alive_[where.first_tet + t]) {
      live.push_back(body.mesh->tets()[t]);
      for (Index& v : live.back()) {
        v += where.first_vertex;
      }
    }
  }
  const Index first = live.empty() ? 0 : live.front()[0], last = live.empty() ? 0 : live.back()[3];
  HeatField expected(TetMesh(std::move(points), std::move(live)), body.tissue);
  HeatField actual = field;
  const std::vector<HeatSource> sources{{first, kPower}, {last, kPower}};
  for (int i = 0; i < 3; ++i) {
    expected.step(kTimeStep, sources);
    actual.step(kTimeStep, sources);
  }
  for (Index v = 0; v < actual.mesh().vertex_count(); ++v) {
    if (actual.capacity(v) != expected.capacity(v) ||
        actual.temperatures()[v] != expected.temperatures()[v]) {
      return "temperature at vertex (" + std::to_string(v) + ")";
    }
  }
  return actual.ledger().in == expected.ledger().in ? "" : "heat delivered";
}

std::string LiveModel::difference(const LiveSurface& surface, const Solver& solver,
                                  Index body) const {
  Surface actual;
  for (std::size_t slot = 0; slot < surface.triangles().size(); ++slot) {
    if (surface.origins()[slot].tet != kInvalidIndex) {
      actual.emplace_back(from_smallest(surface.triangles()[slot]), surface.origins()[slot].tet);
    } else if (surface.triangles()[slot] != LiveSurface::kEmptyTriangle) {
      return "triangle in an empty slot (" + std::to_string(slot) + ")";
    }
  }
  std::ranges::sort(actual);
  return actual == find_surface(solver, tet_alive_, body)
             ? ""
             : "live surface of body (" + std::to_string(body) + ")";
}

std::string LiveModel::difference(const LivePieces& pieces, const Solver& solver) const {
  std::vector<Tet> live;
  std::vector<Index> ids;
  for (std::size_t t = 0; t < tet_alive_.size(); ++t) {
    if (tet_alive_[t]) {
      live.push_back(solver.tets()[t]);
      ids.push_back(index_of(t));
    } else if (pieces.piece_of(index_of(t)) != kInvalidIndex) {
      return "piece of a tet that is gone (" + std::to_string(t) + ")";
    }
  }
  const Components components = find_components(solver.vertex_count(), live);
  std::map<Index, Index> piece_of, component_of, counts;
  for (std::size_t i = 0; i < live.size(); ++i) {
    const Index component = components.of_vertex[live[i][0]];
    const Index piece = pieces.piece_of(ids[i]);
    if (piece_of.try_emplace(component, piece).first->second != piece ||
        component_of.try_emplace(piece, component).first->second != component) {
      return "piece of tet (" + std::to_string(ids[i]) + ")";
    }
    ++counts[piece];
  }
  for (Index piece = 0; piece < pieces.count(); ++piece) {
    if (pieces.tet_count(piece) != counts[piece]) {
      return "tetrahedra of piece (" + std::to_string(piece) + ")";
    }
  }
  return {};
}

}  // namespace pbdsurg::testing
