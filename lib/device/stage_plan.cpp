// SPDX-License-Identifier: Apache-2.0
#include "lib/device/stage_plan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include "lib/device/vertex_changes.h"
#include "lib/solver/solver_options.h"

namespace pbdsurg::cuda {
namespace {

template <class Record>
void write_record(DeviceArray array, Index index, const Record& record,
                  std::vector<WordChange>& words) {
  constexpr std::size_t kWords = sizeof(Record) / sizeof(std::uint32_t);
  std::array<std::uint32_t, kWords> values;
  std::memcpy(values.data(), &record, sizeof record);
  for (std::size_t w = 0; w < kWords; ++w) {
    words.push_back({array, static_cast<std::uint32_t>(index * kWords + w), values[w]});
  }
}

// Of any type of record: its first place is its first word.
template <class Record>
void write_nothing(DeviceArray array, Index index, std::vector<WordChange>& words) {
  static_assert(offsetof(Record, places) == 0);
  constexpr std::size_t kWords = sizeof(Record) / sizeof(std::uint32_t);
  words.push_back({array, static_cast<std::uint32_t>(index * kWords),
                   static_cast<std::uint32_t>(kInvalidIndex)});
}

void write_edge(Index joint, std::size_t place, const OwnedEdge& edge,
                std::vector<WordChange>& words) {
  const auto write = [&](std::size_t offset, float value) {
    const std::size_t byte =
        sizeof(JointRecord) * static_cast<std::size_t>(joint) + offset + sizeof value * place;
    words.push_back({DeviceArray::joints, static_cast<std::uint32_t>(byte / sizeof value),
                     std::bit_cast<std::uint32_t>(value)});
  };
  write(offsetof(JointRecord, edge_rest), edge.rest);
  write(offsetof(JointRecord, edge_stiffness), edge.stiffness);
}

// Ids beyond are gone for good.
template <class Constraint>
Index id_count(const SolverData& data) {
  constexpr Element kElement = KindOf<Constraint>::kElement;
  if constexpr (kElement == Element::edge_or_link) {
    return data.sets.distance_ids.count();
  } else if constexpr (kElement == Element::edge) {
    return static_cast<Index>(data.tissue->edges().size());
  } else if constexpr (kElement == Element::link) {
    return static_cast<Index>(data.tissue->links().size());
  } else if constexpr (kElement == Element::hinge) {
    return static_cast<Index>(data.tissue->hinges().size());
  } else if constexpr (kElement == Element::triangle) {
    return static_cast<Index>(data.tissue->triangles().size());
  } else {
    static_assert(kElement == Element::tet);
    return static_cast<Index>(data.tissue->tets().size());
  }
}

template <class Constraint>
Index pool_in(const SolverData& data, const ConstraintSlots<Constraint>& slots,
              const std::vector<Index>& pools, Index id) {
  if (id >= id_count<Constraint>(data)) {
    return kGone;
  }
  if (!slots.is_alive(id)) {
    return kRemoved;
  }
  const Index group = slots.group_of(id);
  return group < static_cast<Index>(pools.size()) ? pools[group] : kNoPool;
}

}  // namespace

Index StagePlan::pool_of(const SolverData& data, const Changes::Constraint& change) const {
  const std::vector<Index>& pools = pools_[static_cast<std::size_t>(holder_of(change.kind))];
  Index pool = kGone;
  data.sets.visit_set(change.kind,
                      [&](const auto& slots) { pool = pool_in(data, slots, pools, change.id); });
  const bool is_owned =
      pool == kNoPool && change.kind == PhaseKind::distance && data.sets.is_owned(change.id);
  return is_owned ? kGone : pool;
}

// Stages of vertices come first.
bool StagePlan::set_colors(const VertexBlocks& blocks) {
  std::vector<Stage> colors;
  for (Index color = 0; color < blocks.color_count(); ++color) {
    const auto [first, count] = blocks.blocks(color);
    if (count > 0) {
      colors.push_back({PhaseKind::vertex, first, count});
    }
  }
  const auto is_alike = [](const Stage& a, const Stage& b) {
    return a.kind == b.kind && a.first == b.first && a.count == b.count;
  };
  const std::span<const Stage> before(stages_.data(), static_cast<std::size_t>(color_stages_));
  if (std::ranges::equal(colors, before, is_alike)) {
    return false;
  }
  const auto count = static_cast<Index>(colors.size());
  for (WaitingStage& waiting : waiting_stages_) {
    waiting.stage += count - color_stages_;
  }
  stages_.erase(stages_.begin(), stages_.begin() + color_stages_);
  stages_.insert(stages_.begin(), colors.begin(), colors.end());
  color_stages_ = count;
  return true;
}

void StagePlan::list_open_stages() {
  open_stages_.clear();
  auto waiting = waiting_stages_.begin();
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (waiting != waiting_stages_.end() && waiting->stage == static_cast<Index>(i)) {
      ++waiting;
    } else {
      open_stages_.push_back(stages_[i]);
    }
  }
}

void StagePlan::note_owner(const SolverData& data, Index distance) {
  if (distance >= static_cast<Index>(owners_.size())) {
    owners_.resize(static_cast<std::size_t>(distance) + 1, kInvalidIndex);
  }
  Index owner = kInvalidIndex;
  if (data.sets.of<DistanceConstraint>().is_alive(distance) && data.sets.is_owned(distance)) {
    owner = data.sets.edge_owners[data.sets.distance_ids.edge_of(distance)];
  }
  for (const Index tet : {owners_[distance], owner}) {
    if (tet != kInvalidIndex) {
      touched_edges_.push_back({tet, data.sets.distance_ids.edge_of(distance)});
    }
  }
  owners_[distance] = owner;
}

// Of each record touched, what its holder is after all changes: so words listed twice are alike.
void StagePlan::write_records(const SolverData& data, std::vector<WordChange>& words) const {
  const auto& volumes = data.sets.of<VolumeConstraint>();
  for (const RecordTable::Record& record : table_.touched()) {
    const auto& [array, index] = record;
    const Index id = table_.holder_of(record);
    const bool has_holder = id != kInvalidIndex;
    if (array == DeviceArray::joints) {
      if (has_holder && volumes.is_alive(id)) {
        write_record(array, index, to_joint_record(data, id), words);
      } else {
        write_nothing<JointRecord>(array, index, words);
      }
    } else if (array == DeviceArray::tubes) {
      if (has_holder && is_tube(data, id)) {
        write_record(array, index, to_tube_record(data, id), words);
      } else {
        write_nothing<TubeRecord>(array, index, words);
      }
    }
    data.sets.for_each_set([&, array = array, index = index]<class Constraint>(
                               const ConstraintSlots<Constraint>& slots) {
      if (array != array_of(KindOf<Constraint>::kPhase)) {
        return;
      }
      if (!has_holder || !slots.is_alive(id)) {
        write_nothing<Record<Constraint>>(array, index, words);
        return;
      }
      const auto now = slots.record(id);
      write_record(array, index, to_record<Constraint>(now), words);
      if constexpr (std::is_same_v<Constraint, DistanceConstraint>) {
        words.push_back(
            {DeviceArray::distance_damping, static_cast<std::uint32_t>(index),
             std::bit_cast<std::uint32_t>(now.parameters[DistanceConstraint::kDamping])});
      }
    });
  }
}

void StagePlan::write_edges(const SolverData& data, std::vector<WordChange>& words) const {
  const auto tet_edges = data.tissue->tet_edges();
  const auto& volumes = data.sets.of<VolumeConstraint>();
  for (const auto& [tet, edge] : touched_edges_) {
    const auto& edges = tet_edges[tet];
    const auto place = std::ranges::find(edges, edge) - edges.begin();
    if (place < 6 && volumes.is_alive(tet)) {  // else its record is written as a whole
      write_edge(table_.record_of(Holder::volume, tet), static_cast<std::size_t>(place),
                 owned_edge(data, tet, edge), words);
    }
  }
}

bool StagePlan::follow(const SolverData& data, const Changes& changes,
                       std::vector<WordChange>& words) {
  if (data.sets.has_damping != is_damped_ || changes.rows_anew) {
    return false;
  }
  table_.forget_touched();
  touched_edges_.clear();
  const auto tet_count = static_cast<Index>(data.tissue->tets().size());
  const auto tube_pool = [&](Index tet) {
    if (is_tube(data, tet)) {
      return tube_pool_;
    }
    return tet < tet_count ? kRemoved : kGone;
  };
  for (const Changes::Constraint& change : changes.constraints) {
    if (change.kind != PhaseKind::vertex &&
        !table_.leave(holder_of(change.kind), change.id, pool_of(data, change))) {
      return false;
    }
  }
  for (const Index tet : changes.tets) {
    if (!table_.leave(Holder::tube, tet, tube_pool(tet))) {
      return false;
    }
  }
  for (const Changes::Constraint& change : changes.constraints) {
    if (change.kind == PhaseKind::vertex) {
      continue;
    }
    if (!table_.join(holder_of(change.kind), change.id, pool_of(data, change))) {
      return false;
    }
    if (change.kind == PhaseKind::distance) {
      note_owner(data, change.id);
    }
  }
  for (const Index tet : changes.tets) {
    if (!table_.join(Holder::tube, tet, tube_pool(tet))) {
      return false;
    }
  }
  const auto is_in_use = [&](const WaitingStage& waiting) {
    return table_.free_count(waiting.pool) < stages_[waiting.stage].count;
  };
  const bool have_opened = std::erase_if(waiting_stages_, is_in_use) > 0;
  const bool have_moved = !changes.blocks.empty() && set_colors(data.vertex_blocks);
  if (have_opened || have_moved) {
    list_open_stages();
    ++revision_;
  }
  follow_rows(data, changes, words);
  write_records(data, words);
  write_edges(data, words);
  return true;
}

}  // namespace pbdsurg::cuda
