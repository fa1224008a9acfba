// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Plans of random constraints, and random edits of them.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"

#include "lib/device/cluster_shapes.h"
#include "lib/device/stage_plan.h"
#include "tests/support/toy_sweep.h"

namespace pbdsurg::cuda::testing {

/// Stages of random constraints between near vertices, with spare records, and edits of them; where
/// there are spare records, stages of nothing else, too.
class RandomPlan {
 public:
  RandomPlan(Index place_count, Index per_stage, Index spare, std::uint64_t seed)
      : place_count_(place_count), seed_(seed) {
    for (const auto& [kind, count] :
         {std::pair(PhaseKind::distance, per_stage), std::pair(PhaseKind::distance, per_stage),
          std::pair(PhaseKind::distance, per_stage), std::pair(PhaseKind::distance, 0),
          std::pair(PhaseKind::strain_limit, per_stage), std::pair(PhaseKind::volume, per_stage),
          std::pair(PhaseKind::volume, per_stage), std::pair(PhaseKind::volume, 0),
          std::pair(PhaseKind::neo_hookean, per_stage), std::pair(PhaseKind::bending, per_stage),
          std::pair(PhaseKind::membrane, per_stage), std::pair(PhaseKind::fibre, per_stage)}) {
      if (count + spare == 0) {
        continue;
      }
      visit_kind(records, kind, [&, count = count, kind = kind](auto& all) {
        const auto first = static_cast<Index>(all.size());
        stages.push_back({kind, first, count + spare});
        all.resize(all.size() + static_cast<std::size_t>(count + spare));
        records.distance_damping.resize(records.of<DistanceConstraint>().size(), 0);
        for (Index i = 0; i < count + spare; ++i) {
          std::ranges::fill(all[first + i].places, kInvalidIndex);
          if (i < count) {
            place(stages.back(), first + i, 3);
          }
        }
      });
    }
  }

  std::vector<Stage> stages;
  StageRecords records;

  [[nodiscard]] Index place_count() const { return place_count_; }

  /// Some edits of all kinds.
  /// @return  changes of words, in any order
  std::vector<WordChange> edit(int count) {
    StageRecords before = records;
    if (below(3) == 0) {
      place_count_ += 1 + below(4);
    }
    if (below(6) == 0) {  // an undo
      const Index gone = place_count_ - below(3);
      for (const Stage& stage : stages) {
        for (Index i = stage.first; i < stage.first + stage.count; ++i) {
          if (is_alive(stage, i) &&
              std::ranges::any_of(places(stage, i), [&](Index place) { return place >= gone; })) {
            remove(stage, i);
          }
        }
      }
      place_count_ = gone;
    }
    for (int e = 0; e < count; ++e) {
      const Stage& stage =
          stages[static_cast<std::size_t>(below(static_cast<Index>(stages.size())))];
      const Index i = stage.first + below(stage.count);
      if (!is_alive(stage, i)) {
        if (below(2) == 0) {
          come_back(stage, i);
        } else {
          place(stage, i, below(2) == 0 ? 0 : 3);  // at new vertices, or anywhere
        }
      } else {
        switch (below(4)) {
          case 0:
            remove(stage, i);
            break;
          case 1:
            place(stage, i, 3);
            break;
          case 2:
            move_corner(stage, i);
            break;
          default:
            set_parameters(stage, i);
            break;
        }
      }
    }
    return shuffled(changes_since(before));
  }

 private:
  Index below(Index end) {
    return static_cast<Index>(random_unit(seed_, ++draw_) * static_cast<double>(end));
  }

  std::span<Index> places(const Stage& stage, Index i) { return places_of(records, stage.kind, i); }
  bool is_alive(const Stage& stage, Index i) { return places(stage, i)[0] >= 0; }

  bool is_free(const Stage& stage, Index place) {
    for (Index i = stage.first; i < stage.first + stage.count; ++i) {
      if (is_alive(stage, i) && std::ranges::count(places(stage, i), place) > 0) {
        return false;
      }
    }
    return true;
  }

  // A new constraint: near some vertex, or some of the last; it may find no free vertices.
  void place(const Stage& stage, Index i, Index anywhere) {
    std::vector<Index> chosen(places(stage, i).begin(), places(stage, i).end());
    const bool was_alive = is_alive(stage, i);
    if (was_alive) {
      remove(stage, i);
    }
    const std::size_t size = chosen.size();
    std::vector<Index> found;
    const Index base = anywhere > 0 ? below(place_count_) : place_count_ - 4;
    for (int tries = 0; tries < 30 && found.size() < size; ++tries) {
      const Index candidate = (base + below(40)) % place_count_;
      if (is_free(stage, candidate) && std::ranges::count(found, candidate) == 0) {
        found.push_back(candidate);
      }
    }
    if (found.size() == size) {
      write(stage, i, found);
      set_parameters(stage, i);
    } else if (was_alive) {
      write(stage, i, chosen);
    }
  }

  void move_corner(const Stage& stage, Index i) {
    std::vector<Index> moved(places(stage, i).begin(), places(stage, i).end());
    const Index to = below(2) == 0 ? place_count_ - 1 : below(place_count_);
    if (is_free(stage, to)) {
      moved[static_cast<std::size_t>(below(static_cast<Index>(moved.size())))] = to;
      write(stage, i, moved);
    }
  }

  void remove(const Stage& stage, Index i) {
    removed_[key(stage, i)] = {places(stage, i).begin(), places(stage, i).end()};
    places(stage, i)[0] = kInvalidIndex;
  }

  void come_back(const Stage& stage, Index i) {
    const auto found = removed_.find(key(stage, i));
    if (found != removed_.end() && std::ranges::all_of(found->second, [&](Index place) {
          return place < place_count_ && is_free(stage, place);
        })) {
      write(stage, i, found->second);
    }
  }

  void write(const Stage& stage, Index i, const std::vector<Index>& to) {
    std::ranges::copy(to, places(stage, i).begin());
  }

  void set_parameters(const Stage& stage, Index i) {
    const auto random = [&] { return static_cast<float>(1 + below(1000)); };
    visit_kind(records, stage.kind, [&](auto& all) {
      const std::size_t start = sizeof all[i].places / 4;
      const auto count = static_cast<std::size_t>(shape_of(stage.kind)->parameter_count);
      auto* const number = reinterpret_cast<std::uint32_t*>(&all[i]);
      for (std::size_t p = start; p < start + count; ++p) {
        number[p] = std::bit_cast<std::uint32_t>(random());
      }
    });
    if (stage.kind == PhaseKind::distance) {
      records.distance_damping[i] = random();
    }
  }

  static std::pair<PhaseKind, Index> key(const Stage& stage, Index i) { return {stage.kind, i}; }

  // As the backend tells them: one word of what is no more, the whole record of all else.
  std::vector<WordChange> changes_since(StageRecords& before) {
    std::vector<WordChange> changes;
    for (const Stage& stage : stages) {
      const ClusterShape& shape = *shape_of(stage.kind);
      for (Index i = stage.first; i < stage.first + stage.count; ++i) {
        const auto now = numbers_of(records, stage.kind, i);
        const auto then = numbers_of(before, stage.kind, i);
        const std::size_t count = static_cast<Index>(now[0]) < 0 ? 1 : now.size();
        for (std::size_t w = 0; w < count && now != then; ++w) {
          changes.push_back(
              {shape.array,
               static_cast<std::uint32_t>(i * shape.record_size) + static_cast<std::uint32_t>(w),
               now[w]});
        }
        if (stage.kind == PhaseKind::distance &&
            records.distance_damping[i] != before.distance_damping[i]) {
          changes.push_back({DeviceArray::distance_damping, static_cast<std::uint32_t>(i),
                             std::bit_cast<std::uint32_t>(records.distance_damping[i])});
        }
      }
    }
    return changes;
  }

  std::vector<WordChange> shuffled(std::vector<WordChange> changes) {
    for (std::size_t i = changes.size(); i > 1; --i) {
      std::swap(changes[i - 1], changes[static_cast<std::size_t>(below(static_cast<Index>(i)))]);
    }
    changes.push_back({DeviceArray::tubes, 0, 1});  // of no sweep
    return changes;
  }

  Index place_count_;
  std::uint64_t seed_;
  std::uint64_t draw_ = 0;
  std::map<std::pair<PhaseKind, Index>, std::vector<Index>> removed_;
};

}  // namespace pbdsurg::cuda::testing
