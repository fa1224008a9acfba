// SPDX-License-Identifier: Apache-2.0
#include "solver/stage_plan.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>
#include <unordered_map>

#include "solver/vertex_changes.h"

namespace pbdsurg::cuda {
namespace {

constexpr Index kSerial = -2;  // in place of a record: that of a serial stage

DistanceRecord to_record(const ConstraintRecord<DistanceConstraint>& from) {
  return {{from.places[0], from.places[1]},
          from.parameters[DistanceConstraint::kRest],
          from.parameters[DistanceConstraint::kStiffness]};
}

VolumeRecord to_record(const ConstraintRecord<VolumeConstraint>& from) {
  return {{from.places[0], from.places[1], from.places[2], from.places[3]},
          from.parameters[VolumeConstraint::kRest],
          from.parameters[VolumeConstraint::kStiffness],
          from.parameters[VolumeConstraint::kDamping],
          0};
}

NeoHookeanRecord to_record(const ConstraintRecord<NeoHookeanConstraint>& from) {
  NeoHookeanRecord record{{from.places[0], from.places[1], from.places[2], from.places[3]}, {}};
  std::copy(from.parameters.begin(), from.parameters.end(), record.parameters);
  return record;
}

StrainLimitRecord to_record(const ConstraintRecord<StrainLimitConstraint>& from) {
  return {{from.places[0], from.places[1]}, from.parameters[StrainLimitConstraint::kLimit], 0};
}

// The volume of a tetrahedron of a joint plan and the edges that it owns.
JointRecord to_joint_record(const SolverData& data, Index tet) {
  const VolumeRecord volume = to_record(data.volumes.record(tet));
  JointRecord record{{volume.places[0], volume.places[1], volume.places[2], volume.places[3]},
                     volume.rest,
                     volume.stiffness,
                     volume.damping,
                     0,
                     {},
                     {}};
  for (std::size_t place = 0; place < 6; ++place) {
    const Index edge = data.tet_edges[tet][place];
    const Index distance = data.distance_ids.of_edge(edge);
    record.edge_rest[place] = kNotOwned;
    if (data.distances.is_alive(distance) && data.edge_owners[edge] == tet) {
      const DistanceRecord owned = to_record(data.distances.record(distance));
      record.edge_rest[place] = owned.rest;
      record.edge_stiffness[place] = owned.stiffness;
    }
  }
  return record;
}

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

void write_edge(Index joint, Index place, float rest, float stiffness,
                std::vector<WordChange>& words) {
  const auto write = [&](std::size_t offset, float value) {
    const std::size_t byte = sizeof(JointRecord) * static_cast<std::size_t>(joint) + offset +
                             sizeof(float) * static_cast<std::size_t>(place);
    std::uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    words.push_back({DeviceArray::joints, static_cast<std::uint32_t>(byte / sizeof bits), bits});
  };
  write(offsetof(JointRecord, edge_rest), rest);
  write(offsetof(JointRecord, edge_stiffness), stiffness);
}

}  // namespace

/// Makes stages of phases.
class StagePlan::Builder {
 public:
  Builder(const SolverData& data, StagePlan& plan, StageRecords& records)
      : data_(data), plan_(plan), records_(records) {}

  // The phases that one stage takes together, by the groups of their constraints.
  void add(PhaseKind kind, std::span<const Index> groups, bool serial) {
    switch (kind) {
      case PhaseKind::distance:
        add_stage(kind, collect(data_.distances, groups), serial);
        break;
      case PhaseKind::volume:
        add_stage(kind, collect(data_.volumes, groups), serial);
        break;
      case PhaseKind::joint:
        if (serial) {
          add_serial_joints(groups);
        } else {
          add_stage(kind, collect(data_.volumes, groups), serial);
        }
        break;
      case PhaseKind::neo_hookean:
        add_stage(kind, collect(data_.neo_hookeans, groups), serial);
        break;
      case PhaseKind::strain_limit:
        add_stage(kind, collect(data_.strain_limits, groups), serial);
        break;
      case PhaseKind::vertex:
      case PhaseKind::attachment:
      case PhaseKind::contact:
        break;  // not among a solver's constraints
    }
  }

  void add_tubes() {
    for_each_tube_tet(data_, [&](Index t) {
      if (data_.tet_alive[t]) {
        const Tet places = data_.places_of(data_.tets[t]);
        plan_.tubes_[t] = static_cast<Index>(records_.tubes.size());
        records_.tubes.push_back({{places[0], places[1], places[2], places[3]}});
      }
    });
  }

 private:
  template <class Constraint>
  static std::vector<Index> collect(const ConstraintSlots<Constraint>& slots,
                                    std::span<const Index> groups) {
    std::vector<Index> ids;
    for (const Index group : groups) {
      ids.insert(ids.end(), slots.ids(group).begin(), slots.ids(group).end());
    }
    return ids;
  }

  // All edges at one place of kTetEdges before those at the next, and volumes last.
  void add_serial_joints(std::span<const Index> groups) {
    for (Index place = 0; place < 6; ++place) {
      std::vector<Index> edge_groups;
      for (const Index group : groups) {
        edge_groups.push_back(data_.joint_group(group, place));
      }
      add(PhaseKind::distance, edge_groups, true);
    }
    add(PhaseKind::volume, groups, true);
  }

  void add_stage(PhaseKind kind, std::vector<Index> ids, bool serial) {
    if (ids.empty()) {
      return;
    }
    const Index first = record_count(kind);
    const auto first_level = static_cast<Index>(records_.level_ends.size());
    if (serial) {
      sort_by_level(kind, ids, first);
    } else {  // near constraints near each other: they share cache lines
      std::ranges::sort(
          ids, {}, [&](Index id) { return std::pair(std::ranges::min(places_of(kind, id)), id); });
    }
    for (const Index id : ids) {
      add_record(kind, id, serial);
    }
    plan_.stages_.push_back({kind, first, static_cast<Index>(ids.size()), first_level,
                             static_cast<Index>(records_.level_ends.size()) - first_level});
  }

  void sort_by_level(PhaseKind kind, std::vector<Index>& ids, Index first) {
    std::unordered_map<Index, Index> next_level;  // of a place
    std::vector<std::pair<Index, Index>> levels;  // level, id
    std::vector<Index> sizes;
    for (const Index id : ids) {
      const std::span<const Index> places = places_of(kind, id);
      Index level = 0;
      for (const Index place : places) {
        level = std::max(level, next_level[place]);
      }
      for (const Index place : places) {
        next_level[place] = level + 1;
      }
      levels.emplace_back(level, id);
      sizes.resize(std::max(sizes.size(), static_cast<std::size_t>(level) + 1));
      ++sizes[level];
    }
    std::ranges::stable_sort(levels, {}, &std::pair<Index, Index>::first);
    std::ranges::transform(levels, ids.begin(), &std::pair<Index, Index>::second);
    for (const Index size : sizes) {
      first += size;
      records_.level_ends.push_back(first);
    }
  }

  std::span<const Index> places_of(PhaseKind kind, Index id) {
    const auto keep = [&](const auto& record) {
      std::ranges::copy(record.places, places_.begin());
      return std::span<const Index>(places_).first(record.places.size());
    };
    switch (kind) {
      case PhaseKind::distance:
        return keep(data_.distances.record(id));
      case PhaseKind::neo_hookean:
        return keep(data_.neo_hookeans.record(id));
      case PhaseKind::strain_limit:
        return keep(data_.strain_limits.record(id));
      default:
        return keep(data_.volumes.record(id));
    }
  }

  [[nodiscard]] Index record_count(PhaseKind kind) const {
    switch (kind) {
      case PhaseKind::distance:
        return static_cast<Index>(records_.distances.size());
      case PhaseKind::neo_hookean:
        return static_cast<Index>(records_.neo_hookeans.size());
      case PhaseKind::strain_limit:
        return static_cast<Index>(records_.strain_limits.size());
      case PhaseKind::joint:
        return static_cast<Index>(records_.joints.size());
      default:
        return static_cast<Index>(records_.volumes.size());
    }
  }

  void add_record(PhaseKind kind, Index id, bool serial) {
    const Index record = serial ? kSerial : record_count(kind);
    switch (kind) {
      case PhaseKind::distance: {
        const auto distance = data_.distances.record(id);
        plan_.distances_[id] = {DeviceArray::distances, record};
        records_.distances.push_back(to_record(distance));
        records_.distance_damping.push_back(distance.parameters[DistanceConstraint::kDamping]);
        break;
      }
      case PhaseKind::neo_hookean:
        plan_.neo_hookeans_[id] = {DeviceArray::neo_hookeans, record};
        records_.neo_hookeans.push_back(to_record(data_.neo_hookeans.record(id)));
        break;
      case PhaseKind::strain_limit:
        plan_.strain_limits_[id] = {DeviceArray::strain_limits, record};
        records_.strain_limits.push_back(to_record(data_.strain_limits.record(id)));
        break;
      case PhaseKind::joint:
        plan_.volumes_[id] = {DeviceArray::joints, record};
        records_.joints.push_back(to_joint_record(data_, id));
        for (const Index edge : data_.tet_edges[id]) {
          const Index distance = data_.distance_ids.of_edge(edge);
          if (data_.distances.is_alive(distance) && data_.edge_owners[edge] == id) {
            plan_.distances_[distance] = plan_.joint_location(data_, edge);
          }
        }
        break;
      default:
        plan_.volumes_[id] = {DeviceArray::volumes, record};
        records_.volumes.push_back(to_record(data_.volumes.record(id)));
        break;
    }
  }

  const SolverData& data_;
  StagePlan& plan_;
  StageRecords& records_;
  std::array<Index, 4> places_{};
};

StagePlan::StagePlan(const SolverData& data, StageRecords& records)
    : distances_(static_cast<std::size_t>(data.distance_ids.count())),
      volumes_(data.tets.size()),
      neo_hookeans_(data.tets.size()),
      strain_limits_(data.edges.size()),
      tubes_(data.tets.size(), kInvalidIndex) {
  // What is serial comes last of its kind, whatever the number of colours.
  constexpr Index kSerialOrdinal = std::numeric_limits<Index>::max();
  std::map<std::tuple<Index, PhaseKind, Index>, std::vector<Index>> groups;
  Index ordinal = 0;
  const Phase* before = nullptr;
  for (const Phase& phase : data.constraint_phases) {
    if (before == nullptr || std::tie(phase.level, phase.domain, phase.kind) !=
                                 std::tie(before->level, before->domain, before->kind)) {
      ordinal = 0;
    }
    groups[{phase.level, phase.kind, phase.serial ? kSerialOrdinal : ordinal++}].push_back(
        phase.color);
    before = &phase;
  }
  Builder builder(data, *this, records);
  for (const auto& [key, groups_of_stage] : groups) {
    builder.add(std::get<PhaseKind>(key), groups_of_stage, std::get<2>(key) == kSerialOrdinal);
  }
  builder.add_tubes();
  if (data.options.method == SolverMethod::vertex_block) {
    std::erase_if(stages_,
                  [](const Stage& stage) { return stage.kind != PhaseKind::strain_limit; });
    std::vector<Stage> colors;
    const VertexBlocks& blocks = data.vertex_method.blocks;
    for (Index color = 0; color < blocks.color_count(); ++color) {
      const auto [first, count] = blocks.blocks(color);
      if (count > 0) {
        colors.push_back({PhaseKind::vertex, first, count});
      }
    }
    stages_.insert(stages_.begin(), colors.begin(), colors.end());
  }
}

StagePlan::Location StagePlan::joint_location(const SolverData& data, Index edge) const {
  const Index owner = data.edge_owners[edge];
  const auto& edges = data.tet_edges[owner];
  const auto place = std::ranges::find(edges, edge) - edges.begin();
  return {DeviceArray::joints, volumes_[owner].record, static_cast<Index>(place)};
}

bool StagePlan::follow_distance(const SolverData& data, Index id, std::vector<WordChange>& words) {
  Location& location = distances_[id];
  const bool is_alive = data.distances.is_alive(id);
  const bool is_joint = is_alive && data.is_owned(id);
  const Location next = is_joint ? joint_location(data, data.distance_ids.edge_of(id)) : location;
  if (location.record == kSerial || next.record == kSerial ||
      (is_alive && next.record == kInvalidIndex)) {
    return false;
  }
  const bool moves = !is_alive || next.record != location.record || next.place != location.place;
  if (location.record != kInvalidIndex && moves) {
    if (location.array == DeviceArray::joints) {
      write_edge(location.record, location.place, kNotOwned, 0, words);
    } else {
      write_nothing<DistanceRecord>(location.array, location.record, words);
    }
  }
  if (is_alive) {
    location = next;
    const DistanceRecord record = to_record(data.distances.record(id));
    if (is_joint) {
      write_edge(next.record, next.place, record.rest, record.stiffness, words);
    } else {
      write_record(next.array, next.record, record, words);
    }
  }
  return true;
}

bool StagePlan::follow_volume(const SolverData& data, Index id, std::vector<WordChange>& words) {
  const Location& location = volumes_[id];
  const bool is_alive = data.volumes.is_alive(id);
  if (location.record == kSerial) {
    return false;
  }
  if (location.record == kInvalidIndex) {
    return !is_alive;
  }
  if (location.array == DeviceArray::joints) {
    if (is_alive) {
      write_record(location.array, location.record, to_joint_record(data, id), words);
    } else {
      write_nothing<JointRecord>(location.array, location.record, words);
    }
  } else if (is_alive) {
    write_record(location.array, location.record, to_record(data.volumes.record(id)), words);
  } else {
    write_nothing<VolumeRecord>(location.array, location.record, words);
  }
  return true;
}

bool StagePlan::follow(const SolverData& data, const Changes& changes,
                       std::vector<WordChange>& words) {
  if (changes.grown) {
    return false;
  }
  const auto follow_simple = [&](auto& locations, const auto& slots, Index id) {
    using Record = decltype(to_record(slots.record(id)));
    const Location& location = locations[id];
    const bool is_alive = slots.is_alive(id);
    if (location.record == kSerial || (is_alive && location.record == kInvalidIndex)) {
      return false;
    }
    if (is_alive) {
      write_record(location.array, location.record, to_record(slots.record(id)), words);
    } else if (location.record != kInvalidIndex) {
      write_nothing<Record>(location.array, location.record, words);
    }
    return true;
  };
  const auto follow_one = [&](const Changes::Constraint& change) {
    switch (change.kind) {
      case PhaseKind::distance:
        return follow_distance(data, change.id, words);
      case PhaseKind::volume:
      case PhaseKind::joint:
        return follow_volume(data, change.id, words);
      case PhaseKind::neo_hookean:
        return follow_simple(neo_hookeans_, data.neo_hookeans, change.id);
      case PhaseKind::strain_limit:
        return follow_simple(strain_limits_, data.strain_limits, change.id);
      case PhaseKind::vertex:
        follow_vertex(data.vertex_method.blocks, change.id, words);
        break;
      case PhaseKind::attachment:
      case PhaseKind::contact:
        break;
    }
    return true;
  };
  for (const Changes::Constraint& change : changes.constraints) {
    if (!follow_one(change)) {
      return false;
    }
  }
  for (const Index tet : changes.tets) {
    if (tubes_[tet] != kInvalidIndex && data.tet_alive[tet]) {
      const Tet places = data.places_of(data.tets[tet]);
      write_record(DeviceArray::tubes, tubes_[tet],
                   TubeRecord{{places[0], places[1], places[2], places[3]}}, words);
    } else if (tubes_[tet] != kInvalidIndex) {
      write_nothing<TubeRecord>(DeviceArray::tubes, tubes_[tet], words);
    } else if (data.tet_alive[tet] && !data.volumes.is_alive(tet) &&
               !data.neo_hookeans.is_alive(tet)) {
      return false;
    }
  }
  return true;
}

}  // namespace pbdsurg::cuda
