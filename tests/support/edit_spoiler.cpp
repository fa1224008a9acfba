// SPDX-License-Identifier: Apache-2.0
#include "tests/support/edit_spoiler.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <utility>

#include "tests/support/bad_ids.h"
#include "tests/support/body_spoiler.h"
#include "tests/support/cuts.h"
#include "tests/support/inspect.h"

namespace pbdsurg::testing {
namespace {

constexpr Stiffness kLink{0.5F, 1e-3F};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();

Index index_of(std::size_t i) {
  return static_cast<Index>(i);
}

// Each function says whether it found what it needs.
class Spoiler {
 public:
  Spoiler(const Solver& solver, Choices& choices, TopologyEdit& edit)
      : solver_(solver),
        data_(inspect(solver)),
        choices_(choices),
        edit_(edit),
        live_tets_(find_all(data_.tissue->tets().size(),
                            [&](Index t) { return data_.tissue->is_tet_alive(t); })),
        live_triangles_(find_all(data_.tissue->triangles().size(),
                                 [&](Index t) { return data_.tissue->is_triangle_alive(t); })),
        live_links_(find_all(data_.tissue->links().size(),
                             [&](Index l) { return data_.tissue->is_link_alive(l); })),
        tissue_(find_all(data_.particles.size(),
                         [&](Index v) { return !data_.tissue->tets_at(v).empty(); })) {}

  bool spoil() {
    switch (choices_.below(14)) {
      case 0:
        return spoil_removal();
      case 1:
        return spoil_rest_value();
      case 2:
        return spoil_new_vertex();
      case 3:
        return spoil_corner_move();
      case 4:
        return spoil_link_move();
      case 5:
      case 6:
        return spoil_new_tet();
      case 7:
        return spoil_new_link();
      case 8:
        return spoil_stiffness();
      case 9:
        return spoil_link_length();
      case 10:
        return spoil_fixing();
      case 11:
        return spoil_fibre();
      default:
        return spoil_bodies(solver_, choices_, edit_);
    }
  }

 private:
  bool spoil_removal() {
    if (!live_triangles_.empty() && choices_.below(2) == 0) {
      spoil_ids(choices_, edit_.remove_triangles, data_.tissue->triangles().size(), live_triangles_,
                [](Index t) { return t; });
    } else if (choices_.below(2) == 0) {
      spoil_ids(choices_, edit_.remove_tets, data_.tissue->tets().size(), live_tets_,
                [](Index t) { return t; });
    } else {
      spoil_ids(choices_, edit_.remove_links, data_.tissue->links().size(), live_links_,
                [](Index l) { return l; });
    }
    return true;
  }

  bool spoil_rest_value() {
    const float bad_value = choices_.one_of(std::array{0.0F, -1e-3F, kNan, kInfinite, -0.0F});
    const auto springs = find_all(data_.tissue->edges().size(), [&](Index e) {
      return data_.sets.of<DistanceConstraint>().is_alive(data_.sets.distance_ids.of_edge(e));
    });
    const auto volumes = find_all(data_.tissue->tets().size(), [&](Index t) {
      return data_.sets.of<VolumeConstraint>().is_alive(t) ||
             data_.sets.of<NeoHookeanConstraint>().is_alive(t);
    });
    if (!live_triangles_.empty() && choices_.below(3) == 0) {
      if (choices_.below(2) == 0) {
        edit_.rest_areas = {{choices_.one_of(live_triangles_), bad_value}};
      } else {
        spoil_ids(choices_, edit_.rest_areas, data_.tissue->triangles().size(), live_triangles_,
                  [](Index t) {
                    return RestAreaChange{t, 1e-6F};
                  });
      }
      return true;
    }
    switch (choices_.below(4)) {
      case 0:
        edit_.rest_lengths = {{choices_.below(index_of(data_.tissue->edges().size())), bad_value}};
        break;
      case 1:
        edit_.rest_volumes = {{choices_.below(index_of(data_.tissue->tets().size())), bad_value}};
        break;
      case 2:
        spoil_ids(choices_, edit_.rest_lengths, data_.tissue->edges().size(), springs, [](Index e) {
          return RestLengthChange{e, 1e-3F};
        });
        break;
      default:
        spoil_ids(choices_, edit_.rest_volumes, data_.tissue->tets().size(), volumes, [](Index t) {
          return RestVolumeChange{t, 1e-9F};
        });
    }
    return true;
  }

  bool spoil_stiffness() {
    const float bad_value =
        choices_.one_of(std::array{0.0F, -1.0F, 5e-4F, 1001.0F, kNan, kInfinite});
    if (!live_triangles_.empty() && choices_.below(2) == 0) {
      if (choices_.below(2) == 0) {
        edit_.triangle_stiffnesses = {{choices_.one_of(live_triangles_), bad_value}};
      } else {
        spoil_ids(choices_, edit_.triangle_stiffnesses, data_.tissue->triangles().size(),
                  live_triangles_, [](Index t) {
                    return TriangleStiffnessChange{t, 2};
                  });
      }
      return true;
    }
    const auto springs = find_all(data_.tissue->tets().size(), [&](Index t) {
      const Body& body = data_.tissue->body(data_.tissue->body_of_tet(t));
      return data_.tissue->is_tet_alive(t) && body.material.model == ElasticModel::springs;
    });
    const Index what = choices_.below(3);
    if (what == 0 && !springs.empty()) {
      edit_.stiffnesses = {{choices_.one_of(springs), 2}};
    } else if (what == 1 || live_tets_.empty()) {
      edit_.stiffnesses = {{choices_.below(index_of(data_.tissue->tets().size())), bad_value}};
    } else {
      spoil_ids(choices_, edit_.stiffnesses, data_.tissue->tets().size(), live_tets_, [](Index t) {
        return StiffnessChange{t, 2};
      });
    }
    return true;
  }

  bool spoil_fibre() {
    const Eigen::Vector3f along(0, 1, 0);
    const std::array<Fibre, 5> bad{{{along, -1.0F},
                                    {along, kNan},
                                    {along, kInfinite},
                                    {2 * along, 1.0F},
                                    {{kNan, 0, 0}, 1.0F}}};
    const auto springs = find_all(data_.tissue->tets().size(), [&](Index t) {
      const Body& body = data_.tissue->body(data_.tissue->body_of_tet(t));
      return data_.tissue->is_tet_alive(t) && body.material.model == ElasticModel::springs;
    });
    const Index what = choices_.below(3);
    if (what == 0 && !springs.empty()) {
      edit_.fibres = {{choices_.one_of(springs), {along, 1}}};
    } else if (what == 1 || live_tets_.empty()) {
      edit_.fibres = {
          {choices_.below(index_of(data_.tissue->tets().size())), choices_.one_of(bad)}};
    } else {
      spoil_ids(choices_, edit_.fibres, data_.tissue->tets().size(), live_tets_, [](Index t) {
        return FibreChange{t, {}};
      });
    }
    return true;
  }

  bool spoil_link_length() {
    if (live_links_.empty() || choices_.below(2) == 0) {
      const float bad_value = choices_.one_of(std::array{-1e-3F, kNan, kInfinite});
      edit_.link_lengths = {{choices_.below(1 + index_of(live_links_.size())), bad_value}};
    } else {
      spoil_ids(choices_, edit_.link_lengths, data_.tissue->links().size(), live_links_,
                [](Index l) {
                  return LinkLengthChange{l, 1e-3F};
                });
    }
    return true;
  }

  // A vertex that is not there, is named twice, or is as it shall be already.
  bool spoil_fixing() {
    std::vector<Index>& list = choices_.below(2) == 0 ? edit_.fix_vertices : edit_.unfix_vertices;
    const bool is_to_be_fixed = &list == &edit_.fix_vertices;
    const auto those = find_all(data_.particles.size(), [&](Index v) {
      return data_.tissue->has_tissue(v) && data_.tissue->is_fixed(v) == is_to_be_fixed;
    });
    const Index what = choices_.below(3);
    if (what == 0 || those.empty()) {
      list.push_back(bad_id(solver_.vertex_count(), choices_));
    } else {
      list.push_back(choices_.one_of(those));
      if (what == 1) {  // in both lists
        (is_to_be_fixed ? edit_.unfix_vertices : edit_.fix_vertices).push_back(list.back());
      }
    }
    return true;
  }

  // What is there already keeps its id, and what is added is used, so that this is all that is bad.
  bool spoil_new_vertex() {
    if (live_tets_.empty()) {
      return false;
    }
    const Index place = add_part();
    NewVertex& vertex = edit_.new_vertices[place];
    switch (choices_.below(4)) {
      case 0:
        (choices_.below(2) == 0 ? vertex.first : vertex.second) =
            bad_id(solver_.vertex_count(), choices_);
        return true;
      case 1: {
        const auto bare = find_all(data_.particles.size(),
                                   [&](Index v) { return data_.tissue->tets_at(v).empty(); });
        if (bare.empty()) {
          return false;
        }
        vertex.second = choices_.one_of(bare);
        return true;
      }
      case 2: {
        const Index body = data_.tissue->body_of_vertex(vertex.first);
        std::vector<Index> others = tissue_;
        std::erase_if(others, [&](Index v) { return data_.tissue->body_of_vertex(v) == body; });
        if (others.empty()) {
          return false;
        }
        vertex.second = choices_.one_of(others);
        return true;
      }
      default:
        vertex.share = choices_.one_of(std::array{-0.1F, 1.1F, kNan, kInfinite});
        return true;
    }
  }

  bool spoil_triangle_move() {
    if (choices_.below(4) == 0) {
      spoil_ids(choices_, edit_.triangle_moves, data_.tissue->triangles().size(), live_triangles_,
                [](Index t) {
                  return TriangleMove{t, 0, 0};
                });
      return true;
    }
    const Index triangle = choices_.one_of(live_triangles_);
    const Triangle& corners = solver_.tissue().triangles()[triangle];
    const Index from = corners[choices_.below(3)];
    const TriangleMove good{triangle, from, add_copy(from)};
    edit_.triangle_moves.push_back(good);
    TriangleMove& move = edit_.triangle_moves.back();
    switch (choices_.below(4)) {
      case 0:
        edit_.remove_triangles.push_back(triangle);
        return true;
      case 1:
        move.from = bad_id(solver_.vertex_count(), choices_);
        return true;
      case 2:
        edit_.new_vertices.push_back({from, corners[from == corners[0] ? 1 : 0], 0.5F});
        ++move.to;
        return true;
      default:
        edit_.triangle_moves.insert(edit_.triangle_moves.begin(), good);
        return true;
    }
  }

  bool spoil_corner_move() {
    if (!live_triangles_.empty() && choices_.below(2) == 0) {
      return spoil_triangle_move();
    }
    if (live_tets_.empty()) {
      return false;
    }
    if (choices_.below(4) == 0) {
      const std::size_t count = data_.tissue->tets().size();
      spoil_ids(choices_, edit_.corner_moves, count, live_tets_, [](Index t) {
        return CornerMove{t, 0, 0};
      });
      return true;
    }
    const CornerMove good = add_move();
    CornerMove& move = edit_.corner_moves.back();
    switch (choices_.below(4)) {
      case 0:
        edit_.remove_tets.push_back(move.tet);
        return true;
      case 1:
        move.from = choices_.below(2) == 0 ? bad_id(solver_.vertex_count(), choices_)
                                           : choices_.one_of(tissue_);
        return !has_corner(solver_.tissue().tets()[move.tet], move.from);
      case 2:
        move.to = bad_copy(move.to, good.from);
        return true;
      default:
        edit_.corner_moves.insert(edit_.corner_moves.begin(), good);
        return true;
    }
  }

  bool spoil_link_move() {
    const std::size_t count = data_.tissue->links().size();
    if (choices_.below(4) == 0) {
      spoil_ids(choices_, edit_.link_moves, count, live_links_, [](Index l) {
        return LinkMove{l, 0, 0};
      });
      return true;
    }
    std::vector<Index> links = live_links_;
    std::erase_if(links, [&](Index l) {
      return data_.tissue->tets_at(data_.tissue->links()[l].first).empty();
    });
    if (links.empty()) {
      return false;
    }
    const Index link = choices_.one_of(links);
    const Index from = data_.tissue->links()[link].first;
    const LinkMove good{link, from, add_copy(from)};
    edit_.link_moves.push_back(good);
    LinkMove& move = edit_.link_moves.back();
    switch (choices_.below(4)) {
      case 0:
        edit_.remove_links.push_back(link);
        return true;
      case 1:
        move.from = choices_.one_of(tissue_);
        return move.from != from && move.from != data_.tissue->links()[link].second;
      case 2:
        move.to = bad_copy(move.to, from);
        return true;
      default:
        edit_.link_moves.insert(edit_.link_moves.begin(), good);
        return true;
    }
  }

  bool spoil_new_tet() {
    if (live_tets_.empty()) {
      return false;
    }
    add_part();
    NewTet& tet = edit_.new_tets.back();
    const auto end = solver_.vertex_count() + index_of(edit_.new_vertices.size());
    switch (choices_.below(9)) {
      case 0: {
        const auto dead = find_all(data_.tissue->tets().size(),
                                   [&](Index t) { return !data_.tissue->is_tet_alive(t); });
        tet.parent = dead.empty() || choices_.below(2) == 0
                         ? bad_id(index_of(data_.tissue->tets().size()), choices_)
                         : choices_.one_of(dead);
        return true;
      }
      case 1:
        edit_.remove_tets.push_back(tet.parent);
        return true;
      case 2: {
        const Index from = solver_.tissue().tets()[tet.parent][choices_.below(4)];
        edit_.new_vertices.push_back({from, from, 0});
        edit_.corner_moves.push_back({tet.parent, from, end});
        return true;
      }
      case 3:
        tet.vertices[choices_.below(4)] = bad_id(end, choices_);
        return true;
      case 4: {
        std::vector<Index> others = tissue_;
        std::erase_if(others,
                      [&](Index v) { return has_corner(solver_.tissue().tets()[tet.parent], v); });
        if (others.empty()) {
          return false;
        }
        tet.vertices[choices_.below(4)] = choices_.one_of(others);
        return true;
      }
      case 5:  // inside out
        std::swap(tet.vertices[1], tet.vertices[2]);
        return true;
      case 6:  // flat
        tet.vertices[1] = tet.vertices[2];
        return true;
      case 7:  // too little
        edit_.new_tets.pop_back();
        return true;
      default:  // too much
        edit_.new_tets.push_back(tet);
        return true;
    }
  }

  bool spoil_new_link() {
    if (tissue_.empty()) {
      return false;
    }
    const Index end = solver_.vertex_count() + index_of(edit_.new_vertices.size()) +
                      edit_.new_bodies.vertex_count();
    const Index vertex = choices_.one_of(tissue_);
    Link link{tissue_.front() == vertex ? tissue_.back() : tissue_.front(), vertex, 1e-3F, kLink};
    switch (choices_.below(7)) {
      case 0:
        link.first = link.second;
        break;
      case 1:
        (choices_.below(2) == 0 ? link.first : link.second) = bad_id(end, choices_);
        break;
      case 2:
        link.rest_length = choices_.one_of(std::array{-1e-3F, kNan, kInfinite});
        break;
      case 3:
        link.stiffness.fraction = choices_.one_of(std::array{-0.5F, 1.5F, kNan});
        break;
      case 4:
        link.stiffness.compliance = choices_.one_of(std::array{-1e-3F, kNan, kInfinite});
        break;
      case 5: {
        const auto gone = find_all(data_.particles.size(),
                                   [&](Index v) { return !solver_.tissue().has_tissue(v); });
        if (gone.empty()) {
          return false;
        }
        link.second = choices_.one_of(gone);
        break;
      }
      default:  // where tissue goes with the edit
        edit_ = {};
        std::ranges::copy(data_.tissue->tets_at(vertex), std::back_inserter(edit_.remove_tets));
    }
    edit_.new_links.push_back(link);
    return true;
  }

  // Something else than a new copy of a vertex. @param to  a good one, the last of the edit
  Index bad_copy(Index to, Index from) {
    switch (choices_.below(3)) {
      case 0:
        return from;
      case 1:
        return bad_id(to + 1, choices_);
      default:
        edit_.new_vertices.push_back({choices_.one_of(tissue_), from, 0.5F});
        return to + 1;
    }
  }

  Index add_copy(Index vertex) {
    edit_.new_vertices.push_back({vertex, vertex, 0});
    return solver_.vertex_count() + index_of(edit_.new_vertices.size()) - 1;
  }

  // A good move, unless the edit has taken the tetrahedron for something else.
  CornerMove add_move() {
    const Index tet = choices_.one_of(live_tets_);
    const Index from = solver_.tissue().tets()[tet][choices_.below(4)];
    edit_.corner_moves.push_back({tet, from, add_copy(from)});
    return edit_.corner_moves.back();
  }

  // Two new tetrahedra for one, and the vertex between them, in an edit without others.
  // @return  the vertex's place in the edit
  Index add_part() {
    edit_.corner_moves.clear();
    edit_.new_tets.clear();
    edit_.new_vertices.clear();
    edit_.link_moves.clear();
    edit_.remove_tets.clear();
    edit_.new_links.clear();
    const Index t = choices_.one_of(live_tets_);
    const Tet& parent = solver_.tissue().tets()[t];
    edit_.new_vertices.push_back({parent[0], parent[1], 0.5F});
    for (const Index gone : {parent[0], parent[1]}) {
      edit_.new_tets.push_back({t, parent});
      std::ranges::replace(edit_.new_tets.back().vertices, gone, solver_.vertex_count());
    }
    return 0;
  }

  const Solver& solver_;
  const SolverData& data_;
  Choices& choices_;
  TopologyEdit& edit_;
  std::vector<Index> live_tets_, live_triangles_, live_links_, tissue_;
};

}  // namespace

void spoil(const Solver& solver, Choices& choices, TopologyEdit& edit) {
  if (choices.below(16) == 0) {  // a vertex that nothing uses
    const auto has_tissue = [&](Index v) { return !solver.tissue().tets_at(v).empty(); };
    const auto vertices = find_all(static_cast<std::size_t>(solver.vertex_count()), has_tissue);
    if (!vertices.empty()) {
      const Index vertex = choices.one_of(vertices);
      edit.new_vertices.push_back({vertex, vertex, 0});
      return;
    }
  }
  if (!Spoiler(solver, choices, edit).spoil()) {
    edit.remove_tets.push_back(-1);
  }
}

}  // namespace pbdsurg::testing
