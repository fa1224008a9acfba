// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/build_constraints.h"

#include <algorithm>
#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "pbdsurg/coloring/color.h"

#include "lib/solver/sets/nested_domains.h"

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
      data.sets.phases.push_back({kind, group_count + color, color == coloring.color_count,
                                  all_domains[d].level, all_domains[d].index});
    }
    group_count += coloring.color_count + 1;
  }
  return group_count;
}

// Constraints of those elements that have numbers for them.
// @param elements    [count] edges, tetrahedra, triangles or hinges
// @param numbers_of  std::optional<Numbers<Constraint>>(element)
template <class Constraint, class Element, class NumbersOf>
ConstraintSlots<Constraint> build_slots(PhaseKind kind, const std::vector<Element>& elements,
                                        const NestedDomains& domains, SolverData& data,
                                        NumbersOf numbers_of) {
  const Tissue& tissue = *data.tissue;
  std::vector<ConstraintRecord<Constraint>> records(elements.size());
  std::vector<Index> ids;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (const auto numbers = numbers_of(elements[i])) {
      if constexpr (KindOf<Constraint>::kElement == pbdsurg::Element::edge) {
        records[i] = {data.places_of(tissue.edges()[i]), *numbers};
      } else if constexpr (KindOf<Constraint>::kElement == pbdsurg::Element::hinge) {
        records[i] = {data.places_of(tissue.hinges()[i].vertices), *numbers};
      } else if constexpr (KindOf<Constraint>::kElement == pbdsurg::Element::triangle) {
        records[i] = {data.places_of(tissue.triangles()[i]), *numbers};
      } else {
        static_assert(KindOf<Constraint>::kElement == pbdsurg::Element::tet);
        records[i] = {data.places_of(tissue.tets()[i]), *numbers};
      }
      ids.push_back(static_cast<Index>(i));
    }
  }
  const std::span<const ConstraintRecord<Constraint>> view(records);
  std::vector<Index> group_of(records.size(), kInvalidIndex);
  const Index group_count = group_by_color(kind, view, ids, domains, data, group_of);
  return {view, group_of, group_count};
}

void build_volumes(const ConstraintNumbers& numbers, const NestedDomains& domains,
                   SolverData& data) {
  const bool is_joint = data.options.composition == PlanComposition::joint;
  data.sets.of<VolumeConstraint>() = build_slots<VolumeConstraint>(
      is_joint ? PhaseKind::joint : PhaseKind::volume, numbers.tets, domains, data,
      [](const TetNumbers& tet) { return tet.volume; });
}

void build_distances(const ConstraintNumbers& numbers, const NestedDomains& domains,
                     SolverData& data) {
  const Tissue& tissue = *data.tissue;
  std::vector<ConstraintRecord<DistanceConstraint>> records;
  records.reserve(tissue.edges().size() + tissue.links().size());
  std::vector<Index> ids;
  for (std::size_t e = 0; e < tissue.edges().size(); ++e) {
    const auto& distance = numbers.edges[e].distance;
    if (distance) {
      ids.push_back(static_cast<Index>(e));
    }
    records.push_back(
        {data.places_of(tissue.edges()[e]), distance.value_or(Numbers<DistanceConstraint>{})});
  }
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    const Link& link = tissue.links()[l];
    if (tissue.is_link_alive(l)) {
      ids.push_back(static_cast<Index>(records.size()));
    }
    records.push_back(
        {data.places_of(Edge{link.first, link.second}), link_numbers(link, data.options.mode)});
  }
  if (data.options.composition == PlanComposition::joint) {
    data.sets.edge_owners =
        EdgeOwners(tissue.bodies(), static_cast<Index>(tissue.edges().size()), tissue.tet_edges());
  }
  std::vector<Index> alone, owned;
  for (const Index id : ids) {
    (data.sets.is_owned(id) ? owned : alone).push_back(id);
  }
  const std::span<const ConstraintRecord<DistanceConstraint>> view(records);
  std::vector<Index> group_of(records.size(), kInvalidIndex);
  data.sets.first_joint_group =
      group_by_color(PhaseKind::distance, view, alone, domains, data, group_of);
  for (const Index edge : owned) {
    group_of[edge] = data.sets.joint_group_of(edge, tissue.tet_edges());
  }
  const bool is_joint = data.options.composition == PlanComposition::joint;
  data.sets.of<DistanceConstraint>() = ConstraintSlots<DistanceConstraint>(
      view, group_of,
      data.sets.joint_group(is_joint ? data.sets.of<VolumeConstraint>().group_count() : 0, 0));
}

// @param numbers  [link_count] of those that are stiff
void build_stiff_links(std::span<const StiffLinkNumbers> numbers, const NestedDomains& domains,
                       SolverData& data) {
  const std::span<const Link> links = data.tissue->links();
  std::vector<ConstraintRecord<StiffLinkConstraint>> records(links.size());
  std::vector<Index> ids;
  for (std::size_t l = 0; l < links.size(); ++l) {
    if (numbers[l]) {
      records[l] = {data.places_of(Edge{links[l].first, links[l].second}), *numbers[l]};
      ids.push_back(static_cast<Index>(l));
    }
  }
  if (ids.empty()) {
    return;
  }
  const std::span<const ConstraintRecord<StiffLinkConstraint>> view(records);
  std::vector<Index> group_of(records.size(), kInvalidIndex);
  const Index group_count =
      group_by_color(PhaseKind::stiff_link, view, ids, domains, data, group_of);
  data.sets.of<StiffLinkConstraint>() = {view, group_of, group_count};
}

}  // namespace

void build_constraints(const ConstraintNumbers& numbers, SolverData& data) {
  data.sets.distance_ids = DistanceIds(static_cast<Index>(data.tissue->edges().size()),
                                       static_cast<Index>(data.tissue->links().size()));
  const NestedDomains domains = data.options.composition == PlanComposition::nested
                                    ? NestedDomains(static_cast<Index>(data.particles.size()))
                                    : NestedDomains();
  for (Index level = 0; level < domains.level_count(); ++level) {
    data.sets.domain_counts.push_back(domains.domain_count(level));
  }
  build_volumes(numbers, domains, data);
  build_distances(numbers, domains, data);
  data.sets.of<NeoHookeanConstraint>() =
      build_slots<NeoHookeanConstraint>(PhaseKind::neo_hookean, numbers.tets, domains, data,
                                        [](const TetNumbers& tet) { return tet.neo_hookean; });
  const auto has_fibre = [](const TetNumbers& tet) { return tet.fibre.has_value(); };
  if (std::ranges::any_of(numbers.tets, has_fibre)) {
    data.sets.of<FibreConstraint>() =
        build_slots<FibreConstraint>(PhaseKind::fibre, numbers.tets, domains, data,
                                     [](const TetNumbers& tet) { return tet.fibre; });
  }
  data.sets.of<StrainLimitConstraint>() =
      build_slots<StrainLimitConstraint>(PhaseKind::strain_limit, numbers.edges, domains, data,
                                         [](const EdgeNumbers& edge) { return edge.limit; });
  if (!numbers.triangles.empty()) {
    data.sets.of<MembraneConstraint>() =
        build_slots<MembraneConstraint>(PhaseKind::membrane, numbers.triangles, domains, data,
                                        [](const TriangleNumbers& triangle) { return triangle; });
  }
  if (!numbers.hinges.empty()) {
    data.sets.of<BendingConstraint>() =
        build_slots<BendingConstraint>(PhaseKind::bending, numbers.hinges, domains, data,
                                       [](const HingeNumbers& hinge) { return hinge; });
  }
  build_stiff_links(numbers.stiff_links, domains, data);
  std::stable_sort(
      data.sets.phases.begin(), data.sets.phases.end(), [](const Phase& a, const Phase& b) {
        return std::tie(a.level, a.domain, a.kind) < std::tie(b.level, b.domain, b.kind);
      });
}

}  // namespace pbdsurg
