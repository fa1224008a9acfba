// SPDX-License-Identifier: Apache-2.0
// How a plan of stages is made; stage_plan.cpp has how it follows edits.
#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "lib/device/stage_plan.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/room_to_grow.h"

namespace pbdsurg::cuda {
namespace {

// Groups by what one stage takes together: a level, a kind and the phase's number within them.
using GroupsOfStages = std::map<std::tuple<Index, PhaseKind, Index>, std::vector<Index>>;

// What is serial comes last of its kind, whatever the number of colours.
constexpr Index kSerialOrdinal = std::numeric_limits<Index>::max();

// Records of a stage, where edits are expected at all.
constexpr Index kFewestSpare = 32;

// What nobody projects is for the report alone: one stage of a kind has room for all groups.
GroupsOfStages join_groups(const SolverData& data, const GroupsOfStages& groups) {
  GroupsOfStages joined;
  for (const auto& [key, groups_of_stage] : groups) {
    const PhaseKind kind = std::get<PhaseKind>(key);
    auto& all = joined[is_after_vertices(kind) ? key : std::tuple(data.sets.last_level(), kind, 0)];
    all.insert(all.end(), groups_of_stage.begin(), groups_of_stage.end());
  }
  return joined;
}

// Those that there are, and those that edits would open next, behind all others of their kind.
GroupsOfStages find_groups(const SolverData& data) {
  GroupsOfStages groups;
  std::map<PhaseKind, Index> next_ordinal;  // of the last level
  Index ordinal = 0;
  const Phase* before = nullptr;
  for (const Phase& phase : data.sets.phases) {
    if (before == nullptr || std::tie(phase.level, phase.domain, phase.kind) !=
                                 std::tie(before->level, before->domain, before->kind)) {
      ordinal = 0;
    }
    groups[{phase.level, phase.kind, phase.serial ? kSerialOrdinal : ordinal++}].push_back(
        phase.color);
    if (phase.level == data.sets.last_level()) {
      next_ordinal[phase.kind] = ordinal;
    }
    before = &phase;
  }
  const auto add_next = [&](PhaseKind kind, Index group_count) {
    for (Index i = 0; i < kWaitingGroups; ++i) {
      groups[{data.sets.last_level(), kind, next_ordinal[kind] + i}].push_back(group_count + i);
    }
  };
  data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
    add_next(KindOf<Constraint>::kPhase, slots.group_count());
  });
  return moves_vertices(data.options) ? join_groups(data, groups) : groups;
}

}  // namespace

/// Makes stages of phases.
class StagePlan::Builder {
 public:
  Builder(const SolverData& data, bool has_grown, StagePlan& plan, StageRecords& records)
      : data_(data), has_grown_(has_grown), plan_(plan), records_(records) {}

  void add_stages() {
    const GroupsOfStages groups = find_groups(data_);
    for (const auto& [key, groups_of_stage] : groups) {
      const auto [level, kind, ordinal] = key;
      make_pools(kind);
      const Index count = count_constraints(kind, groups_of_stage);
      if (is_joinable(level, ordinal) && count > 0) {
        Joinable& joinable = joinable_[static_cast<std::size_t>(holder_of(kind))];
        ++joinable.stages;
        joinable.constraints += count;
      }
    }
    for (const auto& [key, groups_of_stage] : groups) {
      const auto [level, kind, ordinal] = key;
      if (ordinal != kSerialOrdinal) {
        add_parallel(kind, groups_of_stage, is_joinable(level, ordinal));
      } else if (kind == PhaseKind::joint) {
        add_serial_joints(groups_of_stage);
      } else {
        add_serial(kind, groups_of_stage);
      }
    }
  }

  void add_tubes() {
    plan_.tube_pool_ = plan_.table_.add_pool(DeviceArray::tubes);
    for_each_tube_tet(*data_.tissue, [&](Index t) {
      if (data_.tissue->is_tet_alive(t)) {
        const auto record = static_cast<Index>(records_.tubes.size());
        plan_.table_.add(plan_.tube_pool_, Holder::tube, t, record);
        records_.tubes.push_back(to_tube_record(data_, t));
      }
    });
    const auto count = static_cast<Index>(records_.tubes.size());
    joinable_[static_cast<std::size_t>(Holder::tube)] = {count > 0 ? 1 : 0, count};
    add_spare(plan_.tube_pool_, spare_count(Holder::tube), records_.tubes);
  }

 private:
  // Stages that have constraints and take more, and how many they have.
  struct Joinable {
    Index stages = 0;
    Index constraints = 0;
  };

  // Calls visit(slots, records) with the constraints of a kind.
  template <class Visit>
  void visit_kind(PhaseKind kind, Visit visit) {
    data_.sets.visit_set(kind, [&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
      if constexpr (std::is_same_v<Constraint, VolumeConstraint>) {
        if (kind == PhaseKind::joint) {
          return visit(slots, records_.joints);
        }
      }
      visit(slots, records_.of<Constraint>());
    });
  }

  std::vector<Index>& pools(PhaseKind kind) {
    return plan_.pools_[static_cast<std::size_t>(holder_of(kind))];
  }

  // Whether new constraints may join.
  [[nodiscard]] bool is_joinable(Index level, Index ordinal) const {
    return level == data_.sets.last_level() && ordinal != kSerialOrdinal;
  }

  void make_pools(PhaseKind kind) {
    visit_kind(kind, [&](const auto& slots, const auto&) {
      pools(kind).resize(static_cast<std::size_t>(slots.group_count() + kWaitingGroups), kNoPool);
    });
  }

  Index count_constraints(PhaseKind kind, std::span<const Index> groups) {
    std::size_t count = 0;
    visit_kind(kind,
               [&](const auto& slots, const auto&) { count = collect(slots, groups).size(); });
    return static_cast<Index>(count);
  }

  template <class Constraint>
  static std::vector<Index> collect(const ConstraintSlots<Constraint>& slots,
                                    std::span<const Index> groups) {
    std::vector<Index> ids;
    for (const Index group : groups) {
      if (group < slots.group_count()) {
        ids.insert(ids.end(), slots.ids(group).begin(), slots.ids(group).end());
      }
    }
    return ids;
  }

  // Spare records of a stage that constraints may join. They join the first that is free at their
  // vertices, so some stages get several times their share.
  [[nodiscard]] Index spare_count(Holder holder) const {
    const auto [stages, constraints] = joinable_[static_cast<std::size_t>(holder)];
    if (stages == 0 && holder != Holder::distance) {
      return 0;
    }
    constexpr Index kShares = 4;
    const Index expected = expected_growth(holder, constraints);
    return std::min(expected, kFewestSpare + kShares * (expected / std::max<Index>(1, stages)));
  }

  [[nodiscard]] Index expected_growth(Holder holder, Index constraints) const {
    constexpr Index kFewest = 256, kPart = 16;
    const SpareRoom& spare = data_.options.spare;
    Index asked = spare.tets;
    if (holder == Holder::distance) {
      asked = spare.edges + spare.links;
    } else if (holder == Holder::strain_limit) {
      asked = spare.edges;
    } else if (holder == Holder::stiff_link) {
      asked = spare.links;
    } else if (holder == Holder::bending || holder == Holder::membrane) {
      asked = 0;  // come with bodies alone
    }
    return has_grown_ ? std::max(asked, kFewest + constraints / kPart) : asked;
  }

  template <class Record>
  void add_spare(Index pool, Index count, std::vector<Record>& records) {
    plan_.table_.add_free(pool, static_cast<Index>(records.size()), count);
    records.resize(records.size() + static_cast<std::size_t>(count), no_record<Record>());
  }

  void add_parallel(PhaseKind kind, std::span<const Index> groups, bool is_joinable) {
    visit_kind(kind, [&](const auto& slots, auto& records) {
      std::vector<Index> ids = collect(slots, groups);
      const auto count = static_cast<Index>(ids.size());
      Index spare = is_joinable ? spare_count(holder_of(kind)) : 0;
      if (count == 0) {
        Index& waiting = waiting_counts_[kind];
        if (spare == 0 || waiting == kWaitingGroups) {
          return;
        }
        spare = std::max(spare >> waiting, std::min(spare, kFewestSpare));
        ++waiting;
      }
      // near constraints near each other: they share cache lines
      std::ranges::sort(ids, {}, [&](Index id) {
        return std::pair(std::ranges::min(slots.record(id).places), id);
      });
      const auto first = static_cast<Index>(records.size());
      const Index pool = plan_.table_.add_pool(array_of(kind));
      if (count == 0) {
        plan_.waiting_stages_.push_back({static_cast<Index>(plan_.stages_.size()), pool});
      }
      for (const Index group : groups) {
        pools(kind)[group] = pool;
      }
      for (const Index id : ids) {
        plan_.table_.add(pool, holder_of(kind), id, static_cast<Index>(records.size()));
        add_record(kind, id);
      }
      add_spare(pool, spare, records);
      records_.distance_damping.resize(records_.of<DistanceConstraint>().size());
      plan_.stages_.push_back({kind, first, count + spare, 0, 0, spare});
    });
  }

  void add_serial(PhaseKind kind, std::span<const Index> groups) {
    visit_kind(kind, [&](const auto& slots, const auto& records) {
      for (const Index group : groups) {
        pools(kind)[group] = kSerialPool;
      }
      std::vector<Index> ids = collect(slots, groups);
      if (ids.empty()) {
        return;
      }
      const auto first = static_cast<Index>(records.size());
      const auto first_level = static_cast<Index>(records_.level_ends.size());
      sort_by_level(slots, ids, first);
      for (const Index id : ids) {
        plan_.table_.add_serial(holder_of(kind), id);
        add_record(kind, id);
      }
      plan_.stages_.push_back({kind, first, static_cast<Index>(ids.size()), first_level,
                               static_cast<Index>(records_.level_ends.size()) - first_level});
    });
  }

  // All edges at one place of kTetEdges before those at the next, and volumes last.
  void add_serial_joints(std::span<const Index> groups) {
    for (Index place = 0; place < 6; ++place) {
      std::vector<Index> edge_groups;
      for (const Index group : groups) {
        edge_groups.push_back(data_.sets.joint_group(group, place));
      }
      add_serial(PhaseKind::distance, edge_groups);
    }
    add_serial(PhaseKind::volume, groups);
  }

  template <class Constraint>
  void sort_by_level(const ConstraintSlots<Constraint>& slots, std::vector<Index>& ids,
                     Index first) {
    std::unordered_map<Index, Index> next_level;  // of a place
    std::vector<std::pair<Index, Index>> levels;  // level, id
    std::vector<Index> sizes;
    for (const Index id : ids) {
      const auto places = slots.record(id).places;
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

  void add_record(PhaseKind kind, Index id) {
    if (kind == PhaseKind::joint) {
      records_.joints.push_back(to_joint_record(data_, id));
      note_owned(id);
      return;
    }
    data_.sets.visit_set(kind, [&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
      const auto record = slots.record(id);
      records_.of<Constraint>().push_back(to_record<Constraint>(record));
      if constexpr (std::is_same_v<Constraint, DistanceConstraint>) {
        records_.distance_damping.push_back(record.parameters[DistanceConstraint::kDamping]);
      }
    });
  }

  void note_owned(Index tet) {
    for (const Index edge : data_.tissue->tet_edges()[tet]) {
      const Index distance = data_.sets.distance_ids.of_edge(edge);
      if (data_.sets.of<DistanceConstraint>().is_alive(distance) &&
          data_.sets.edge_owners[edge] == tet) {
        plan_.owners_[distance] = tet;
      }
    }
  }

  const SolverData& data_;
  bool has_grown_;
  StagePlan& plan_;
  StageRecords& records_;
  std::array<Joinable, kHolderCount> joinable_{};
  std::map<PhaseKind, Index> waiting_counts_;
};

StagePlan::StagePlan(const SolverData& data, StageRecords& records, bool has_grown)
    : is_damped_(data.sets.has_damping),
      owners_(static_cast<std::size_t>(data.sets.distance_ids.count()), kInvalidIndex) {
  Builder builder(data, has_grown, *this, records);
  builder.add_stages();
  builder.add_tubes();
  if (moves_vertices(data.options)) {
    keep_stages_after_vertices();
    set_colors(data.vertex_blocks);
  }
  open_stages_.reserve(stages_.size());
  list_open_stages();
}

void StagePlan::keep_stages_after_vertices() {
  std::vector<Stage> kept;
  std::vector<WaitingStage> waiting;
  auto next = waiting_stages_.begin();
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const bool waits = next != waiting_stages_.end() && next->stage == static_cast<Index>(i);
    if (is_after_vertices(stages_[i].kind)) {
      if (waits) {
        waiting.push_back({static_cast<Index>(kept.size()), next->pool});
      }
      kept.push_back(stages_[i]);
    }
    next += waits ? 1 : 0;
  }
  stages_ = std::move(kept);
  waiting_stages_ = std::move(waiting);
}

}  // namespace pbdsurg::cuda
