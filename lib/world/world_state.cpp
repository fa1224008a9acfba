// SPDX-License-Identifier: Apache-2.0
// Worlds at a moment: recorded, saved, and made again.
#include "pbdsurg/world/world_state.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "lib/tissue/compact.h"
#include "lib/world/edit_journal.h"
#include "lib/world/world_state_data.h"

namespace pbdsurg {

void EditJournal::follow(const Tissue&, const TissueChange& change) noexcept {
  if (!was_renumbered_) {
    edits_.push_back(std::make_shared<const TopologyEdit>(change.edit));
  }
}

void EditJournal::undo(const Tissue&, const TissueChange&) noexcept {
  if (!was_renumbered_) {
    edits_.pop_back();
  }
}

void EditJournal::renumber(const Tissue&, const Renumbering&) noexcept {
  edits_.clear();
  was_renumbered_ = true;
}

namespace {

template <class Value>
std::size_t bytes_of(std::span<const Value> values) noexcept {
  return values.size_bytes();
}

std::size_t bytes_of(const HeatSnapshot& heat) noexcept {
  return 6 * heat.temperatures.size() * sizeof(double) +
         (heat.held.size() + heat.active.size() + heat.pending.size()) * sizeof(Index);
}

std::size_t bytes_in(const auto&... lists) noexcept {
  return (... + (lists.size() * sizeof(lists[0])));
}

std::size_t bytes_of(const Scene& scene) noexcept {
  return bytes_in(scene.bodies(), scene.positions(), scene.masses(), scene.tets(),
                  scene.triangles(), scene.links(), scene.hinges());
}

std::size_t bytes_of(const TopologyEdit& edit) noexcept {
  return sizeof(edit) + bytes_of(edit.new_bodies) +
         bytes_in(edit.remove_tets, edit.remove_triangles, edit.remove_links, edit.remove_bodies,
                  edit.rest_lengths, edit.rest_volumes, edit.rest_areas, edit.stiffnesses,
                  edit.triangle_stiffnesses, edit.fibres, edit.link_lengths, edit.fix_vertices,
                  edit.unfix_vertices, edit.new_vertices, edit.corner_moves, edit.triangle_moves,
                  edit.link_moves, edit.new_tets, edit.new_links);
}

std::size_t bytes_of(const EditJournal::Edits& edits) noexcept {
  std::size_t bytes = 0;
  for (const auto& edit : edits) {
    bytes += bytes_of(*edit);
  }
  return bytes;
}

}  // namespace

std::size_t WorldState::edit_count() const noexcept {
  return data_ == nullptr ? 0 : data_->edits.size();
}

std::size_t WorldState::memory_bytes() const noexcept {
  if (data_ == nullptr) {
    return 0;
  }
  std::size_t bytes = data_->edits.size() * sizeof(data_->edits[0]) +
                      bytes_of(data_->strands.strands()) + bytes_of(data_->strands.events()) +
                      pbdsurg::memory_bytes(data_->motion);
  for (const BurnerState& burner : data_->burners) {
    bytes += bytes_of(burner.cautery.heat) + burner.cautery.link_doses.size() * sizeof(double) +
             burner.cautery.due.size() * sizeof(DueElement);
  }
  return bytes;
}

std::size_t WorldState::shared_bytes() const noexcept {
  if (data_ == nullptr) {
    return 0;
  }
  return data_->origin->bytes + bytes_of(data_->edits);
}

std::shared_ptr<const World::Origin> World::Origin::of(const Executor& executor,
                                                       const Solver& solver,
                                                       std::shared_ptr<const Scene> scene,
                                                       EditJournal::Edits edits_of_scene) {
  SolverOptions options = solver.options();
  options.executor = executor;
  std::unique_ptr<TissueData> tissue = copy_of(tissue_data(solver.tissue()));
  SolverCopy copy(solver);
  const std::size_t bytes = solver.tissue().memory_bytes() + copy.memory_bytes() +
                            (scene == nullptr ? 0 : bytes_of(*scene)) + bytes_of(edits_of_scene);
  return std::make_shared<const Origin>(Origin{std::move(options), std::move(tissue),
                                               std::move(copy), bytes, std::move(scene),
                                               std::move(edits_of_scene)});
}

void World::record() {
  Data& data = *data_;
  data.make_solver();
  std::shared_ptr<const Scene> scene;
  EditJournal::Edits edits_of_scene;
  if (data.tissue->version() == 0) {
    scene = std::make_shared<const Scene>(scene_of(tissue_data(*data.tissue)));
  } else if (data.journal != nullptr && !data.journal->was_renumbered()) {
    scene = data.origin->scene;
    edits_of_scene = data.origin->edits_of_scene;
    const EditJournal::Edits& since = data.journal->edits();
    edits_of_scene.insert(edits_of_scene.end(), since.begin(), since.end());
  }
  std::shared_ptr<const Origin> origin =
      Origin::of(data.options.executor, *data.solver, std::move(scene), std::move(edits_of_scene));
  std::vector<std::vector<ThermalBody>> burnt;  // [burner] a compaction may have come
  for (const auto& burner : data.burners) {
    std::vector<ThermalBody>& bodies = burnt.emplace_back();
    for (const BodyId body : burner->setup.bodies) {
      // of one that has gone, vertices may still take part in heat
      const Index in_tissue = data.bodies.last_in_tissue(body);
      if (in_tissue != kInvalidIndex) {
        bodies.push_back({in_tissue, data.bodies.record(body).heat});
      }
    }
  }
  for (const auto& burner : data.burners) {  // as in worlds that are made of it
    burner->cautery.restore(burner->cautery.snapshot());
  }
  auto journal = std::make_unique<EditJournal>();
  data.tissue->add_follower(*journal);
  // nothing is left to fail
  data.origin = std::move(origin);
  data.journal = std::move(journal);
  for (std::size_t i = 0; i < burnt.size(); ++i) {
    data.burners[i]->setup.since_record = {0, std::move(burnt[i])};
  }
}

WorldState World::save() const {
  const Data& data = *data_;
  if (data.origin == nullptr) {
    throw InvalidArgument("a world is saved from record() on");
  }
  if (data.journal->was_renumbered()) {
    throw InvalidArgument("a compaction came since record(); call that again before save()");
  }
  WorldState state;
  auto made = std::make_shared<WorldState::Data>();
  made->origin = data.origin;
  made->edits = data.journal->edits();
  made->strands = data.strands;
  made->bodies = data.bodies;
  made->bodies.stop_waiting();  // for what a step was asked for
  for (const auto& burner : data.burners) {
    made->burners.push_back({burner->setup, burner->settings, burner->cautery.snapshot()});
  }
  made->motion = motion_of(*data.solver);
  state.data_ = std::move(made);
  return state;
}

World::World(const WorldState& state) {
  if (state.data_ == nullptr) {
    throw InvalidArgument("the state is of no world");
  }
  const WorldState::Data& saved = *state.data_;
  auto made = std::make_unique<Data>(saved.origin->options);
  made->tissue = make_tissue(copy_of(*saved.origin->tissue));
  made->solver = std::make_unique<Solver>(saved.origin->solver.make(*made->tissue));
  // burners come when they came, so that surfaces have the same slots
  auto burner = saved.burners.begin();
  const auto add_burners = [&](std::size_t edit_count) {
    for (; burner != saved.burners.end() && burner->setup.since_record.edits_before <= edit_count;
         ++burner) {
      made->add_burner(burner->setup);
    }
  };
  for (std::size_t i = 0; i < saved.edits.size(); ++i) {
    add_burners(i);
    made->tissue->apply(*saved.edits[i]);
  }
  add_burners(saved.edits.size());
  set_motion(*made->solver, saved.motion);
  for (std::size_t i = 0; i < saved.burners.size(); ++i) {
    CauterySnapshot cautery = saved.burners[i].cautery;
    cautery.heat.tissue = made->tissue->identified_version();
    made->burners[i]->cautery.restore(cautery);
    made->burners[i]->settings = saved.burners[i].settings;
  }
  made->strands = saved.strands;
  made->bodies = saved.bodies;
  made->follow_tissue();
  made->origin = saved.origin;
  made->journal = std::make_unique<EditJournal>(saved.edits);
  made->tissue->add_follower(*made->journal);
  data_ = std::move(made);
}

}  // namespace pbdsurg
