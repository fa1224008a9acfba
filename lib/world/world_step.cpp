// SPDX-License-Identifier: Apache-2.0
// A step of a world, in the order that world.h states.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <exception>
#include <string>
#include <utility>

#include "lib/world/edit_merge.h"
#include "lib/world/world_data.h"

namespace pbdsurg {
namespace {

// Where a tool's electrode will be, as far as that is known before the step.
Electrode placed(const Electrode& electrode, const Solver& solver, ToolId tool) {
  const ToolPose pose =
      Eigen::Translation3f(solver.tool_displacement(tool)) * solver.tool_target(tool);
  return {pose * electrode.tip, pose * electrode.heel};
}

class Stopwatch {
 public:
  /// s since the last call, or since it was made
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

void World::Data::heat(double dt, Frame& frame, std::vector<EditRequest>& requests) {
  for (const auto& burner : burners) {
    EditRequest request{EditSource::heat, {}, static_cast<Index>(frame.cauteries.size())};
    frame.cauteries.push_back(
        burner->cautery.heat(*solver, placed(burner->setup.electrode, *solver, burner->setup.tool),
                             burner->settings, dt, request.edit));
    requests.push_back(std::move(request));
  }
}

std::vector<EditRequest> World::Data::collect(double dt, Frame& frame) {
  std::vector<EditRequest> requests;
  heat(dt, frame, requests);
  TopologyEdit named;
  for (const EditRequest& request : requests) {
    merge(named, request.edit, tissue->vertex_count());
  }
  const auto heat_links = static_cast<std::ptrdiff_t>(named.remove_links.size());
  strands.find_parting(*solver, blades, named);
  requests.push_back({EditSource::strands, {}});
  requests.back().edit.remove_links.assign(named.remove_links.begin() + heat_links,
                                           named.remove_links.end());
  collect_program(frame, requests);
  std::erase_if(requests, [](const EditRequest& request) { return is_empty(request.edit); });
  return requests;
}

void World::Data::collect_program(Frame& frame, std::vector<EditRequest>& requests) {
  for (ProgramEdit& asked : std::exchange(edits, {})) {
    if (asked.version == tissue->version()) {
      requests.push_back({EditSource::program, std::move(asked.edit)});
    } else {
      frame.refused.push_back({EditSource::program, "the edit was made for topology version " +
                                                        std::to_string(asked.version) +
                                                        "; the tissue is at version " +
                                                        std::to_string(tissue->version())});
    }
  }
  EditRequest removal{EditSource::program, {}};
  for (const BodyId body : std::exchange(leaving, {})) {
    try {
      removal.edit.remove_bodies.push_back(bodies.in_tissue(body));
    } catch (const InvalidArgument& refusal) {
      frame.refused.push_back({EditSource::program, refusal.what()});
    }
  }
  std::ranges::sort(removal.edit.remove_bodies);
  removal.edit.remove_bodies.erase(
      std::unique(removal.edit.remove_bodies.begin(), removal.edit.remove_bodies.end()),
      removal.edit.remove_bodies.end());
  requests.push_back(std::move(removal));
  requests.push_back({EditSource::program, {.new_bodies = std::exchange(new_bodies, {})}});
}

const TissueChange& World::Data::apply(const TopologyEdit& edit, Frame& frame) {
  const TissueChange& change = tissue->apply(edit);
  frame.removed_tets += static_cast<Index>(change.removed_tets.size());
  frame.removed_triangles += static_cast<Index>(change.removed_triangles.size());
  frame.removed_links += static_cast<Index>(change.removed_links.size());
  return change;
}

void World::Data::commit(const EditRequest& request, Frame& frame) {
  if (request.burner != kInvalidIndex) {
    burners[request.burner]->cautery.commit(frame.cauteries[request.burner]);
  }
}

// @return  whether one edit could do it; else nothing has changed
bool World::Data::apply_all(const std::vector<EditRequest>& requests, Frame& frame) {
  TopologyEdit merged;
  for (const EditRequest& request : requests) {
    if (!merge(merged, request.edit, tissue->vertex_count())) {
      return false;
    }
  }
  try {
    apply(merged, frame);
  } catch (const std::exception&) {
    return false;  // of whom, apply_each() finds out
  }
  for (const EditRequest& request : requests) {
    commit(request, frame);
  }
  return true;
}

// One after another, so that a bad request stops no other.
void World::Data::apply_each(std::vector<EditRequest>& requests, std::span<const BladeSweep> swept,
                             Frame& frame) {
  EarlierEdits earlier(*tissue);
  for (EditRequest& request : requests) {
    if (request.source == EditSource::strands) {  // they forget causes with each edit
      request.edit = {};
      strands.find_parting(*solver, swept, request.edit);
    } else {
      earlier.adapt(request.edit, *tissue);
    }
    if (is_empty(request.edit)) {
      commit(request, frame);
      continue;
    }
    try {
      earlier.note(apply(request.edit, frame));
      commit(request, frame);
    } catch (const std::exception& refusal) {
      frame.refused.push_back({request.source, refusal.what()});
    }
  }
}

void World::Data::change(std::vector<EditRequest>& requests, std::span<const BladeSweep> swept,
                         Frame& frame) {
  const std::size_t events = strands.events().size();
  if (!requests.empty() && !apply_all(requests, frame)) {
    apply_each(requests, swept, frame);
  }
  bodies.stop_waiting();
  frame.parted_strands = static_cast<Index>(strands.events().size() - events);
}

Frame World::step(double dt) {
  Data& data = *data_;
  data.make_solver();
  data.solver->check_step(static_cast<float>(dt));
  Frame frame;
  Stopwatch watch;
  std::vector<EditRequest> requests = data.collect(dt, frame);
  frame.times.heat = watch.lap();
  data.change(requests, std::exchange(data.blades, {}), frame);
  frame.times.edit = watch.lap();
  frame.report = data.solver->step(static_cast<float>(dt));
  frame.lost_grips = data.solver->lost_grips();
  frame.times.step = watch.lap();
  data.refresh();
  frame.times.readback = watch.lap();
  return frame;
}

}  // namespace pbdsurg
