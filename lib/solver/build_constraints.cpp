// SPDX-License-Identifier: Apache-2.0
#include "solver/build_constraints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <vector>

#include "pbdsurg/coloring/color.h"

#include "solver/neo_hookean_record.h"
#include "solver/nested_domains.h"

namespace pbdsurg {
namespace {

// Colours the constraints listed, domain by domain, and gives each its group: the colours of a
// domain, then its overflow, then those of the next.
// @param group_of  [id_count] those not listed are left alone
// @return          how many groups there are
template <class Constraint>
Index group_by_color(PhaseKind kind, std::span<const ConstraintRecord<Constraint>> records,
                     std::span<const Index> ids, const NestedDomains& domains, SolverData& data,
                     std::vector<Index>& group_of) {
  constexpr std::size_t kArity = Constraint::kVertexCount;
  std::vector<NestedDomains::Domain> all_domains;
  std::vector<Index> first_of_level;
  for (Index level = 0; level < domains.level_count(); ++level) {
    first_of_level.push_back(static_cast<Index>(all_domains.size()));
    for (Index domain = 0; domain < domains.domain_count(level); ++domain) {
      all_domains.push_back({level, domain});
    }
  }
  std::vector<std::vector<Index>> ids_of_domain(all_domains.size());
  for (const Index id : ids) {
    const NestedDomains::Domain domain = domains.domain_of(records[id].places);
    ids_of_domain[first_of_level[domain.level] + domain.index].push_back(id);
  }
  Index group_count = 0;
  for (std::size_t d = 0; d < all_domains.size(); ++d) {
    std::vector<std::array<Index, kArity>> vertices;
    vertices.reserve(ids_of_domain[d].size());
    for (const Index id : ids_of_domain[d]) {
      vertices.push_back(records[id].places);
    }
    const Coloring coloring =
        color_constraints({std::span<const std::array<Index, kArity>>(vertices),
                           static_cast<Index>(data.particles.size())},
                          data.options.coloring);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Index color = coloring.color_of[i];
      group_of[ids_of_domain[d][i]] =
          group_count + (color == kOverflowColor ? coloring.color_count : color);
    }
    for (Index color = 0; color <= coloring.color_count; ++color) {
      data.constraint_phases.push_back({kind, group_count + color, color == coloring.color_count,
                                        all_domains[d].level, all_domains[d].index});
    }
    group_count += coloring.color_count + 1;
  }
  return group_count;
}

template <class Visit>
void for_each_edge(const Scene& scene, const SolverData& data, Visit visit) {
  std::size_t b = 0;  // edges are sorted, so their bodies ascend
  for (std::size_t e = 0; e < data.edges.size(); ++e) {
    const Edge& edge = data.edges[e];
    while (edge[0] >= data.bodies[b].first_vertex + data.bodies[b].vertex_count) {
      ++b;
    }
    const double length = (scene.positions()[edge[0]] - scene.positions()[edge[1]]).norm();
    visit(static_cast<Index>(e), length, data.bodies[b].material);
  }
}

void build_distances(const Scene& scene, const NestedDomains& domains, SolverData& data) {
  std::vector<ConstraintRecord<DistanceConstraint>> records;
  records.reserve(data.edges.size() + data.links.size());
  std::vector<Index> ids;
  for_each_edge(scene, data, [&](Index edge, double length, const Material& material) {
    records.push_back({data.places_of(data.edges[edge]),
                       {static_cast<float>(length),
                        stiffness_in(data.options.mode, material.stretch), material.damping}});
    if (material.model == ElasticModel::springs) {
      ids.push_back(edge);
    }
  });
  for (const Link& link : data.links) {
    ids.push_back(static_cast<Index>(records.size()));
    records.push_back({data.places_of(Edge{link.first, link.second}),
                       {link.rest_length, stiffness_in(data.options.mode, link.stiffness), 0}});
  }
  if (data.options.composition == PlanComposition::joint) {
    data.edge_owners =
        EdgeOwners(data.bodies, static_cast<Index>(data.edges.size()), data.tet_edges);
  }
  std::vector<Index> alone, owned;
  for (const Index id : ids) {
    (data.is_owned(id) ? owned : alone).push_back(id);
  }
  const std::span<const ConstraintRecord<DistanceConstraint>> view(records);
  std::vector<Index> group_of(records.size(), kInvalidIndex);
  data.first_joint_group =
      group_by_color(PhaseKind::distance, view, alone, domains, data, group_of);
  for (const Index edge : owned) {
    group_of[edge] = data.joint_group_of(edge);
  }
  const bool is_joint = data.options.composition == PlanComposition::joint;
  data.distances = ConstraintSlots<DistanceConstraint>(
      view, group_of, data.joint_group(is_joint ? data.volumes.group_count() : 0, 0));
}

void build_volumes(const Scene& scene, const NestedDomains& domains, SolverData& data) {
  std::vector<ConstraintRecord<VolumeConstraint>> records;
  records.reserve(data.tets.size());
  std::vector<Index> ids;
  for (const Body& body : data.bodies) {
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      const double volume = tet_volume(scene.positions(), data.tets[t]);
      records.push_back(
          {data.places_of(data.tets[t]),
           {static_cast<float>(volume), stiffness_in(data.options.mode, body.material.volume),
            body.material.damping}});
      if (has_volume_constraints(body)) {
        ids.push_back(t);
      }
    }
  }
  const std::span<const ConstraintRecord<VolumeConstraint>> view(records);
  std::vector<Index> group_of(records.size(), kInvalidIndex);
  const bool is_joint = data.options.composition == PlanComposition::joint;
  const Index group_count = group_by_color(is_joint ? PhaseKind::joint : PhaseKind::volume, view,
                                           ids, domains, data, group_of);
  data.volumes = ConstraintSlots<VolumeConstraint>(view, group_of, group_count);
}

void build_neo_hookeans(const Scene& scene, const NestedDomains& domains, SolverData& data) {
  std::vector<ConstraintRecord<NeoHookeanConstraint>> records(data.tets.size());
  std::vector<Index> ids;
  for (const Body& body : data.bodies) {
    if (body.material.model != ElasticModel::neo_hookean) {
      continue;
    }
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      records[t] = make_neo_hookean(scene.positions(), data.tets[t], data.places_of(data.tets[t]),
                                    body.material);
      ids.push_back(t);
    }
  }
  const std::span<const ConstraintRecord<NeoHookeanConstraint>> view(records);
  std::vector<Index> group_of(records.size(), kInvalidIndex);
  const Index group_count =
      group_by_color(PhaseKind::neo_hookean, view, ids, domains, data, group_of);
  data.neo_hookeans = ConstraintSlots<NeoHookeanConstraint>(view, group_of, group_count);
}

void build_strain_limits(const Scene& scene, const NestedDomains& domains, SolverData& data) {
  std::vector<ConstraintRecord<StrainLimitConstraint>> records;
  std::vector<Index> ids;
  for_each_edge(scene, data, [&](Index edge, double length, const Material& material) {
    records.push_back(
        {data.places_of(data.edges[edge]), {static_cast<float>(material.max_stretch * length)}});
    if (std::isfinite(material.max_stretch)) {
      ids.push_back(edge);
    }
  });
  const std::span<const ConstraintRecord<StrainLimitConstraint>> view(records);
  std::vector<Index> group_of(records.size(), kInvalidIndex);
  const Index group_count =
      group_by_color(PhaseKind::strain_limit, view, ids, domains, data, group_of);
  data.strain_limits = ConstraintSlots<StrainLimitConstraint>(view, group_of, group_count);
}

}  // namespace

float stiffness_in(ProjectionMode mode, const Stiffness& stiffness) noexcept {
  return mode == ProjectionMode::fraction ? stiffness.fraction : stiffness.compliance;
}

void build_constraints(const Scene& scene, SolverData& data) {
  const NestedDomains domains = data.options.composition == PlanComposition::nested
                                    ? NestedDomains(scene.vertex_count())
                                    : NestedDomains();
  for (Index level = 0; level < domains.level_count(); ++level) {
    data.domain_counts.push_back(domains.domain_count(level));
  }
  build_volumes(scene, domains, data);
  build_distances(scene, domains, data);
  build_neo_hookeans(scene, domains, data);
  build_strain_limits(scene, domains, data);
  std::stable_sort(data.constraint_phases.begin(), data.constraint_phases.end(),
                   [](const Phase& a, const Phase& b) {
                     return std::tie(a.level, a.domain, a.kind) <
                            std::tie(b.level, b.domain, b.kind);
                   });
}

}  // namespace pbdsurg
