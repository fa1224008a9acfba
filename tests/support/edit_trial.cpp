// SPDX-License-Identifier: Apache-2.0
#include "support/edit_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/core/error.h"
#include "pbdsurg/core/random.h"

#include "solver/solver_data.h"
#include "support/meshes.h"
#include "support/solver_digest.h"

namespace pbdsurg::testing {
namespace {

constexpr double kEdge = 4e-3;      // m
constexpr float kTimeStep = 1e-3F;  // s
constexpr Stiffness kLink{0.5F, 1e-3F};

Index index_of(std::size_t i) {
  return static_cast<Index>(i);
}

// A box of which some tetrahedra were split around a vertex within, again and again: vertices have
// from three to many neighbours.
TetMesh make_irregular_mesh(int splits, std::uint64_t seed) {
  const TetMesh box = make_box({2, 1, 1}, 2 * kEdge, 0.1, seed);
  std::vector<Eigen::Vector3d> points(box.positions().begin(), box.positions().end());
  std::vector<Tet> tets(box.tets().begin(), box.tets().end());
  for (int i = 0; i < splits; ++i) {
    const std::size_t split = random_bits(seed, i) % tets.size();
    const Tet parent = tets[split];
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Index v : parent) {
      middle += points[v] / 4;
    }
    const Index added = index_of(points.size());
    points.push_back(middle);
    for (std::size_t corner = 0; corner < 4; ++corner) {
      Tet part = parent;
      part[corner] = added;
      if (corner == 0) {
        tets[split] = part;
      } else {
        tets.push_back(part);
      }
    }
  }
  return {std::move(points), std::move(tets)};
}

TetMesh make_small_organ() {
  OrganRecipe recipe = organ_recipe(Organ::liver);
  recipe.options.vertex_count = 90;
  return tetrahedralize(recipe.shape, recipe.options).mesh;
}

EditScene make_one_body(const char* name, TetMesh mesh) {
  Scene scene;
  scene.add_body(name, mesh, elastic_material(mesh, 1000, 20e3));
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  scene.fix_where(
      0, [&](const Eigen::Vector3d& x) { return x.x() < box.min().x() + 0.1 * box.sizes().x(); });
  return {name, std::move(scene), std::move(mesh)};
}

EditScene make_linked_bodies() {
  TetMesh block = make_box({2, 2, 2}, kEdge, 0.1);
  const TetMesh tube = make_box({3, 1, 1}, kEdge, 0.1, 2);
  Material soft = elastic_material(block, 1000, 20e3);
  soft.max_stretch = 1.2F;
  soft.damping = 1e-3F;
  Material walls = elastic_material(tube, 1000, 20e3);
  walls.has_volume_constraints = false;
  Scene scene;
  scene.add_body("block", block, soft);
  scene.add_body("tube", tube, walls);
  for (Index v = 0; v < tube.vertex_count(); ++v) {
    scene.add_link({v, block.vertex_count() + v, 1e-3F, kLink});
    scene.add_link({v + 3, block.vertex_count() + v, 2e-3F, kLink});
  }
  scene.fix_vertices(0, std::array<Index, 3>{0, 1, 2});
  return {"linked bodies", std::move(scene), std::move(block)};
}

EditScene make_solids() {
  TetMesh solid = make_box({2, 2, 1}, kEdge, 0.1, 3);
  const TetMesh block = make_box({2, 1, 1}, kEdge, 0.1, 4);
  Scene scene;
  scene.add_body("solid", solid, {.model = ElasticModel::neo_hookean, .max_stretch = 1.3F});
  scene.add_body("block", block, elastic_material(block, 1000, 20e3));
  const std::array<Eigen::Vector3d, 3> thread{
      {{0, 0, -kEdge}, {kEdge, 0, -kEdge}, {2 * kEdge, 0, -kEdge}}};
  const Index particles = scene.add_particles("thread", thread, 1e-5);
  for (Index i = 0; i < 3; ++i) {
    const Index particle = scene.body(particles).first_vertex + i;
    scene.add_link({2 * i, particle, 1e-3F, kLink});
    scene.add_link({particle, scene.body(1).first_vertex + i, 1e-3F, kLink});
  }
  scene.add_link({scene.body(particles).first_vertex, scene.body(particles).first_vertex + 1,
                  static_cast<float>(kEdge), kLink});
  return {"solids and a thread", std::move(scene), std::move(solid)};
}

template <class IsAlive>
std::vector<Index> find_all(std::size_t count, IsAlive is_alive) {
  std::vector<Index> found;
  for (Index id = 0; id < index_of(count); ++id) {
    if (is_alive(id)) {
      found.push_back(id);
    }
  }
  return found;
}

// Some of them, each once: those chosen last are left.
std::vector<Index> pick_some(std::vector<Index> ids, Index most, Choices& choices) {
  std::vector<Index> picked;
  for (Index wanted = choices.below(most) + 1; wanted > 0 && !ids.empty(); --wanted) {
    std::swap(ids[choices.below(index_of(ids.size()))], ids.back());
    picked.push_back(ids.back());
    ids.pop_back();
  }
  return picked;
}

}  // namespace

Index Choices::below(Index count) {
  unsigned bits = 0;
  for (const unsigned shift : {8U, 0U}) {
    bits |= (is_spent() ? 0U : bytes_[next_]) << shift;
    ++next_;
  }
  return static_cast<Index>(bits % static_cast<unsigned>(count));
}

std::vector<std::uint8_t> random_bytes(std::uint64_t seed, std::size_t count) {
  std::vector<std::uint8_t> bytes(count);
  for (std::size_t i = 0; i < count; ++i) {
    bytes[i] = static_cast<std::uint8_t>(random_bits(seed, i) >> 56);
  }
  return bytes;
}

const std::vector<EditScene>& edit_scenes() {
  static const std::vector<EditScene> scenes = [] {
    std::vector<EditScene> all;
    all.push_back(make_one_body("lattice", make_box({3, 2, 2}, kEdge, 0.1)));
    all.push_back(make_one_body("irregular", make_irregular_mesh(20, 7)));
    all.push_back(make_one_body("organ", make_small_organ()));
    all.push_back(make_linked_bodies());
    all.push_back(make_solids());
    return all;
  }();
  return scenes;
}

std::vector<SolverOptions> edit_options(const EditScene& scene) {
  const SolverOptions base{.substeps = 2, .damping = 1, .backend = BackendKind::serial};
  std::vector<SolverOptions> all(7, base);
  all[1].composition = PlanComposition::joint;
  all[1].coloring.balance = true;
  all[2].composition = PlanComposition::nested;
  all[2].coloring = {.algorithm = ColoringAlgorithm::random_disc};
  all[3].coloring = {.max_colors = 5};
  all[4].composition = PlanComposition::joint;
  all[4].coloring = {.max_colors = 5};
  all[5].method = SolverMethod::vertex_block;
  all[6].composition = PlanComposition::joint;
  all[6].mode = ProjectionMode::fraction;
  for (const std::size_t separate : {0, 3}) {
    all[separate].composition = PlanComposition::separate;
  }
  const bool has_solid = std::ranges::any_of(scene.scene.bodies(), [](const Body& body) {
    return body.material.model == ElasticModel::neo_hookean;
  });
  if (has_solid) {  // whose energy fractions do not follow
    all.pop_back();
  }
  return all;
}

EditTrial::EditTrial(const EditScene& scene, const SolverOptions& options)
    : scene_(&scene),
      solver_(scene.scene, options),
      heat_(solver_, std::array{ThermalBody{0, &scene.first_mesh, kLiver}}),
      pieces_(solver_),
      model_(scene.scene, solver_) {
  for (Index body = 0; body < index_of(solver_.bodies().size()); ++body) {
    surfaces_.emplace_back(solver_, body);
  }
}

std::vector<EditParticipant*> EditTrial::participants() {
  std::vector<EditParticipant*> all{&heat_, &pieces_};
  for (LiveSurface& surface : surfaces_) {
    all.push_back(&surface);
  }
  return all;
}

void EditTrial::edit(const TopologyEdit& change) {
  apply_edit(solver_, change, participants());
  model_.apply(change);
}

std::string EditTrial::edit_and_undo(Choices& choices) {
  const TopologyEdit edit = make_edit(choices);
  const std::uint64_t before = digest_of(solver_data(solver_));
  const EditResult result = apply_edit(solver_, edit, participants());
  const bool steps = choices.below(4) == 0;
  std::string wrong = steps ? step() : "";
  undo_edit(solver_, edit, result, participants());
  if (wrong.empty() && !steps && digest_of(solver_data(solver_)) != before) {
    wrong = "undo leaves something changed";
  }
  return wrong;
}

std::string EditTrial::try_bad_edit(Choices& choices) {
  TopologyEdit edit = make_edit(choices);
  spoil(choices, edit);
  const std::uint64_t before = digest_of(solver_data(solver_));
  try {
    apply_edit(solver_, edit, participants());
    return "a bad edit was accepted";
  } catch (const InvalidArgument&) {
    return digest_of(solver_data(solver_)) == before
               ? ""
               : "a bad edit was refused, but something changed";
  }
}

std::string EditTrial::step() {
  const StepReport report = solver_.step(kTimeStep);
  return report.non_finite_vertices == 0
             ? ""
             : "vertex " + std::to_string(report.first_non_finite) + " is not finite";
}

std::string EditTrial::difference() const {
  std::string wrong = model_.difference(solver_);
  if (wrong.empty()) {
    wrong = model_.difference(heat_, {0, &scene_->first_mesh, kLiver});
  }
  for (std::size_t body = 0; body < surfaces_.size() && wrong.empty(); ++body) {
    wrong = model_.difference(surfaces_[body], solver_, index_of(body));
  }
  return wrong.empty() ? model_.difference(pieces_, solver_) : wrong;
}

TopologyEdit EditTrial::make_edit(Choices& choices) const {
  TopologyEdit edit;
  for (Index parts = choices.below(2); parts >= 0; --parts) {
    if (choices.below(3) < 2) {
      add_removals(choices, edit);
    } else {
      add_rest_values(choices, edit);
    }
  }
  return edit;
}

// Of one kind that the edit does not have yet.
void EditTrial::add_removals(Choices& choices, TopologyEdit& edit) const {
  const auto tet_alive = [&](Index t) { return solver_.is_tet_alive(t); };
  const auto link_alive = [&](Index l) { return solver_.is_link_alive(l); };
  const std::vector<Index> tets = find_all(solver_.tets().size(), tet_alive);
  switch (choices.below(4)) {
    case 0:
    case 1:
      edit.remove_tets = pick_some(tets, 6, choices);
      break;
    case 2:  // all around a vertex
      if (!tets.empty()) {
        const Index near = tets[choices.below(index_of(tets.size()))];
        const Index vertex = solver_.tets()[near][choices.below(4)];
        edit.remove_tets = tets;
        std::erase_if(edit.remove_tets, [&](Index t) {
          return std::ranges::find(solver_.tets()[t], vertex) == solver_.tets()[t].end();
        });
      }
      break;
    default:
      edit.remove_links = pick_some(find_all(solver_.links().size(), link_alive), 3, choices);
  }
}

void EditTrial::add_rest_values(Choices& choices, TopologyEdit& edit) const {
  const SolverData& data = solver_data(solver_);
  const auto factor = [&] { return 0.8F + 0.1F * static_cast<float>(choices.below(5)); };
  if (choices.below(2) == 0) {
    const auto is_spring = [&](Index e) { return data.distances.is_alive(e); };
    edit.rest_lengths.clear();
    for (const Index e : pick_some(find_all(data.edges.size(), is_spring), 5, choices)) {
      edit.rest_lengths.push_back({e, factor() * solver_.rest_length(e)});
    }
  } else {
    const auto has_volume = [&](Index t) {
      return data.volumes.is_alive(t) || data.neo_hookeans.is_alive(t);
    };
    edit.rest_volumes.clear();
    for (const Index t : pick_some(find_all(data.tets.size(), has_volume), 5, choices)) {
      edit.rest_volumes.push_back({t, factor() * solver_.rest_volume(t)});
    }
  }
}

// Puts one thing that must be refused in some place of the edit.
void EditTrial::spoil(Choices& choices, TopologyEdit& edit) const {
  const SolverData& data = solver_data(solver_);
  const auto insert = [&](auto& list, auto bad) {
    const Index place = choices.below(index_of(list.size()) + 1);
    list.insert(list.begin() + place, bad);
  };
  // out of range, dead, or twice in the list; `id_of` an entry
  const auto bad_id = [&](auto& list, std::size_t count, auto is_alive, auto id_of, auto entry_of) {
    const std::vector<Index> dead = find_all(count, [&](Index id) { return !is_alive(id); });
    switch (choices.below(5)) {
      case 0:
        return index_of(count) + choices.below(3);
      case 1:
        return -1 - choices.below(3);
      case 2:
        return std::numeric_limits<Index>::max() - choices.below(2);
      case 3:
        if (!dead.empty()) {
          return dead[choices.below(index_of(dead.size()))];
        }
        [[fallthrough]];
      default:
        if (list.empty()) {
          const std::vector<Index> live = find_all(count, is_alive);
          if (live.empty()) {
            return index_of(count);
          }
          list.push_back(entry_of(live[choices.below(index_of(live.size()))]));
        }
        return id_of(list[choices.below(index_of(list.size()))]);
    }
  };
  const auto bad_value = [&] {
    constexpr std::array kBad{0.0F, -1e-3F, std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity(), -0.0F};
    return kBad[choices.below(index_of(kBad.size()))];
  };
  const auto same = [](Index id) { return id; };
  const auto tet_alive = [&](Index t) { return solver_.is_tet_alive(t); };
  const auto is_spring = [&](Index e) { return data.distances.is_alive(e); };
  const auto has_volume = [&](Index t) {
    return data.volumes.is_alive(t) || data.neo_hookeans.is_alive(t);
  };
  const std::size_t edges = data.edges.size(), tets = data.tets.size();
  switch (choices.below(6)) {
    case 0:
      insert(edit.remove_tets, bad_id(edit.remove_tets, tets, tet_alive, same, same));
      break;
    case 1:
      insert(edit.remove_links, bad_id(
                                    edit.remove_links, data.links.size(),
                                    [&](Index l) { return solver_.is_link_alive(l); }, same, same));
      break;
    case 2:
      insert(edit.rest_lengths,
             RestLengthChange{bad_id(
                                  edit.rest_lengths, edges, is_spring,
                                  [](const RestLengthChange& change) { return change.edge; },
                                  [](Index e) {
                                    return RestLengthChange{e, 1e-3F};
                                  }),
                              1e-3F});
      break;
    case 3:
      insert(edit.rest_volumes,
             RestVolumeChange{bad_id(
                                  edit.rest_volumes, tets, has_volume,
                                  [](const RestVolumeChange& change) { return change.tet; },
                                  [](Index t) {
                                    return RestVolumeChange{t, 1e-9F};
                                  }),
                              1e-9F});
      break;
    case 4:
      edit.rest_lengths.clear();
      edit.rest_lengths.push_back({choices.below(index_of(edges)), bad_value()});
      break;
    default:
      edit.rest_volumes.clear();
      edit.rest_volumes.push_back({choices.below(index_of(tets)), bad_value()});
  }
}

std::string run_edit_trial(std::span<const std::uint8_t> bytes) {
  Choices choices(bytes);
  const EditScene& scene = edit_scenes()[choices.below(index_of(edit_scenes().size()))];
  std::vector<SolverOptions> options = edit_options(scene);
  const Index option = choices.below(index_of(options.size()));
  if (choices.below(16) == 0) {
    options[option].backend = BackendKind::threaded;
    options[option].threads = 2;
  }
  EditTrial trial(scene, options[option]);
  std::string wrong;
  while (wrong.empty() && !choices.is_spent()) {
    switch (choices.below(10)) {
      case 0:
        wrong = trial.try_bad_edit(choices);
        break;
      case 2:
      case 3:
        wrong = trial.edit_and_undo(choices);
        break;
      case 1:
        wrong = trial.step();
        break;
      default:
        trial.edit(choices);
    }
  }
  for (int i = 0; i < 2 && wrong.empty(); ++i) {
    wrong = trial.step();
  }
  if (wrong.empty()) {
    wrong = trial.difference();
  }
  return wrong.empty() ? wrong : scene.name + ", options " + std::to_string(option) + ": " + wrong;
}

std::vector<std::uint8_t> bytes_of_trial(std::uint64_t seed) {
  constexpr std::size_t kFewest = 16, kMost = 128;
  return random_bytes(seed, kFewest + random_bits(seed, kMost) % (kMost - kFewest));
}

}  // namespace pbdsurg::testing
