// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fake_device.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <set>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/base/executor_state.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/program/solver_device.h"
#include "lib/solver/state/room_to_grow.h"
#include "tests/support/inspect.h"

namespace pbdsurg::testing {
namespace {

class DeviceOfTest final : public Device, public SolverDevice {
 public:
  explicit DeviceOfTest(MakeBackend make) : make_(std::move(make)) {}

  [[nodiscard]] const std::string& name() const noexcept override { return name_; }
  [[nodiscard]] std::unique_ptr<Backend> make_backend(const SolverData& data) override {
    return make_(data);
  }

 private:
  std::string name_ = "the test's device";
  MakeBackend make_;
};

// Topology as far as a step reads it, which edits of the live tissue do not reach.
std::unique_ptr<Tissue> copy_for_step(const Tissue& tissue) {
  const TissueData& live = inspect(tissue);
  auto copy = std::make_unique<TissueData>();
  copy->bodies = live.bodies;
  copy->later_tet_bodies = live.later_tet_bodies;
  copy->tets = live.tets;
  copy->tet_alive = live.tet_alive;
  return make_tissue(std::move(copy));
}

// What a device keeps to itself is not to be read.
void spoil(SolverData& data) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto spoil_particles = [](std::vector<Particle>& particles) {
    for (Particle& p : particles) {
      p = {kNan, kNan, kNan, p.w};
    }
  };
  for (Index i = 0; i < data.copy_count(); ++i) {
    CopyState& copy = data.copy(i);
    spoil_particles(copy.particles);
    std::ranges::fill(copy.velocities, Velocity{kNan, kNan, kNan, kNan});
    std::ranges::fill(copy.carries, Carry{kNan, kNan, kNan, kNan});
    std::ranges::fill(copy.ways, Way{kNan, kNan, kNan, kNan});
    std::ranges::fill(copy.velocities_before, Velocity{kNan, kNan, kNan, kNan});
    std::ranges::fill(copy.watched_positions, Eigen::Vector3f::Constant(kNan));
    for (ToolState& tool : copy.tools) {
      tool.force.setConstant(kNan);
      tool.torque.setConstant(kNan);
    }
  }
}

// All of two blocks but how many rows they have; of idle lanes nothing.
bool same_frame(const VertexBlock& a, const VertexBlock& b) {
  return a.lane_count == b.lane_count && a.is_damped == b.is_damped &&
         a.has_angles == b.has_angles && a.pulls.first == b.pulls.first &&
         a.springs.first == b.springs.first && a.volumes.first == b.volumes.first &&
         a.hinges.first == b.hinges.first && a.triangles.first == b.triangles.first &&
         a.fibres.first == b.fibres.first &&
         std::equal(a.corners, a.corners + a.lane_count, b.corners);
}

bool same_counts(const VertexBlock& a, const VertexBlock& b) {
  return a.pulls.count == b.pulls.count && a.springs.count == b.springs.count &&
         a.volumes.count == b.volumes.count && a.hinges.count == b.hinges.count &&
         a.triangles.count == b.triangles.count && a.fibres.count == b.fibres.count;
}

// Whether one lane of rows has the same numbers.
template <class Row>
bool same_lane(std::span<const Row> a, std::span<const Row> b, RowRange range, Index lane) {
  constexpr std::size_t kNumber = sizeof(float), kKind = kBlockLanes * kNumber;
  bool are_same = static_cast<std::size_t>(range.first + range.count) <= a.size();
  for (Index i = range.first; are_same && i < range.first + range.count; ++i) {
    const auto* const first = reinterpret_cast<const std::byte*>(&a[i]);
    const auto* const second = reinterpret_cast<const std::byte*>(&b[i]);
    for (std::size_t kind = 0; are_same && kind < sizeof(Row); kind += kKind) {
      const std::size_t at = kind + static_cast<std::size_t>(lane) * kNumber;
      are_same = std::memcmp(first + at, second + at, kNumber) == 0;
    }
  }
  return are_same;
}

}  // namespace

FakeDevice::FakeDevice(const SolverData& data, int device)
    : number(device),
      state_(data.copy_count(),
             data.particles.size() + static_cast<std::size_t>(data.options.spare.vertices),
             has_displacements(data.options), has_past(data.options)) {
  blocks_ = data.vertex_blocks;
  take_all(data);
}

Backend::Maker FakeDevice::maker() const {
  return [device = number](const SolverData& data) {
    return std::make_unique<FakeDevice>(data, device);
  };
}

void FakeDevice::follow_edit(SolverData& data) noexcept {
  followed_ = {data.changes.constraints.size(), data.changes.tets.size()};
}

void FakeDevice::start_step(SolverData& data) {
  if (followed_ != std::pair(data.changes.constraints.size(), data.changes.tets.size())) {
    throw Error("of some changes this was not told when they were made");
  }
  followed_ = {};
  take_over(data);
  own_.gravity = data.gravity;
  static_cast<PieceLists&>(own_.free_pieces) = data.free_pieces;
  own_.contact_firmness = data.contact_firmness;
  const bool met_before = !own_.contact_bodies.empty();
  own_.contact_bodies = data.contact_bodies;
  if (own_.contact_bodies.empty() == met_before) {
    own_.rebuild_plan();
  }
  own_.reserve_touches();
  own_.coarse_space = data.coarse_space;
  for (Index i = 0; i < data.copy_count(); ++i) {
    own_.copy(i).past_substep = data.copy(i).past_substep;
    own_.copy(i).factors = data.copy(i).factors;
    if (own_.contact_bodies.empty()) {
      own_.copy(i).touches = {};
    }
    own_.copy(i).touches.remembered = data.copy(i).touches.remembered;
    for (std::size_t t = 0; t < own_.tools.size(); ++t) {
      own_.copy(i).tools[t].pose = data.copy(i).tools[t].pose;
      own_.copy(i).tools[t].target = data.copy(i).tools[t].target;
      own_.copy(i).tools[t].joints = data.copy(i).tools[t].joints;
      own_.copy(i).tools[t].remembered = data.copy(i).tools[t].remembered;
      own_.copy(i).tools[t].grip = data.copy(i).tools[t].grip;
    }
  }
  own_.part = data.part;
  is_running_ = true;
  spoil(data);
}

// The work is done as late as can be.
StepReport FakeDevice::finish_step(SolverState& data) {
  if (data.changes.watched || data.changes.state != std::vector<bool>(data.changes.state.size()) ||
      data.particles.size() != vertex_count_ || data.tools.size() != own_.tools.size()) {
    throw Error("somebody changed what must stay while a step runs");
  }
  for (Index i = 0; i < own_.copy_count(); ++i) {
    state_.give(i, own_.copy(i), vertex_count_);
  }
  serial_->start_step(own_);
  const StepReport report = serial_->finish_step(own_);
  for (Index i = 0; i < own_.copy_count(); ++i) {
    state_.take(i, own_.copy(i), vertex_count_);
  }
  is_running_ = false;
  answer();
  for (Index i = 0; i < data.copy_count(); ++i) {
    CopyState& copy = data.copy(i);
    for (std::size_t t = 0; t < copy.tools.size(); ++t) {
      ToolState& tool = copy.tools[t];
      const ToolState& own = own_.copy(i).tools[t];
      tool.pose = own.pose;
      tool.joints = own.joints;
      tool.force = own.force;
      tool.torque = own.torque;
      tool.surface_contacts = own.surface_contacts;
      tool.remembered = own.remembered;
      tool.grip = own.grip;
    }
    copy.touches.contacts = own_.copy(i).touches.contacts;
    copy.touches.remembered = own_.copy(i).touches.remembered;
    copy.last_report = own_.copy(i).last_report;
    read_positions(data, i, watched_, copy.watched_positions);
  }
  return report;
}

void FakeDevice::fetch_state(SolverState& data, Index index) {
  ++fetch_count;
  CopyState& copy = data.copy(index);
  const std::size_t count = std::min(vertex_count_, copy.particles.size());
  for (Index place = 0; place < static_cast<Index>(count); ++place) {
    copy.set_motion(place, state_.motion(index, place));
  }
}

void FakeDevice::read_positions(const SolverState& /*data*/, Index copy,
                                std::span<const Index> places, std::span<Eigen::Vector3f> out) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const VertexMotion motion = motion_of(copy, places[i]);
    out[i] = {motion.x, motion.y, motion.z};
  }
}

void FakeDevice::ask_for_motion(std::span<const Index> places) {
  asked_.assign(places.begin(), places.end());
  asked_count += places.size();
  if (!is_running_) {
    answer();
  }
}

void FakeDevice::collect_motion(Index copy, std::span<VertexMotion> out) {
  std::ranges::copy(motion_[copy], out.begin());
}

VertexMotion FakeDevice::motion_of(Index copy, Index place) const {
  if (static_cast<std::size_t>(place) >= vertex_count_) {
    throw Error("place " + std::to_string(place) + " was in no step");
  }
  return state_.motion(copy, place);
}

void FakeDevice::answer() {
  motion_.resize(static_cast<std::size_t>(own_.copy_count()));
  for (Index i = 0; i < own_.copy_count() && !asked_.empty(); ++i) {
    motion_[i].clear();
    for (const Index place : asked_) {
      motion_[i].push_back(motion_of(i, place));
    }
  }
  asked_.clear();
}

// All but the state and what tools do.
void FakeDevice::take_all(const SolverData& data) {
  distances_ = {data.sets.of<DistanceConstraint>(),
                static_cast<std::size_t>(data.sets.distance_ids.count())};
  volumes_ = {data.sets.of<VolumeConstraint>(), data.tissue->tets().size()};
  neo_hookeans_ = {data.sets.of<NeoHookeanConstraint>(), data.tissue->tets().size()};
  fibres_ = {data.sets.of<FibreConstraint>(), data.tissue->tets().size()};
  membranes_ = {data.sets.of<MembraneConstraint>(), data.tissue->triangles().size()};
  strain_limits_ = {data.sets.of<StrainLimitConstraint>(), data.tissue->edges().size()};
  bendings_ = {data.sets.of<BendingConstraint>(), data.tissue->hinges().size()};
  stiff_links_ = {data.sets.of<StiffLinkConstraint>(), data.tissue->links().size()};
  own_.others.resize(data.others.size());
  own_.options = data.options;
  own_.gravity = data.gravity;
  own_.own_tissue = copy_for_step(*data.tissue);
  own_.tissue = own_.own_tissue.get();
  own_.place_of_vertex = data.place_of_vertex;
  own_.sets.domain_counts = data.sets.domain_counts;
  own_.sets.first_joint_group = data.sets.first_joint_group;
  own_.sets.phases = data.sets.phases;
  own_.sets.has_damping = data.sets.has_damping;
  own_.vertex_blocks = data.vertex_blocks;
  for (const Phase& phase : data.sets.phases) {
    if (!phase.serial) {
      continue;
    }
    switch (phase.kind) {
      case PhaseKind::distance:
        distances_.set_serial(phase.color);
        break;
      case PhaseKind::joint:
        for (Index place = 0; place < 6; ++place) {
          distances_.set_serial(data.sets.joint_group(phase.color, place));
        }
        volumes_.set_serial(phase.color);
        break;
      case PhaseKind::volume:
        volumes_.set_serial(phase.color);
        break;
      case PhaseKind::neo_hookean:
        neo_hookeans_.set_serial(phase.color);
        break;
      case PhaseKind::fibre:
        fibres_.set_serial(phase.color);
        break;
      case PhaseKind::membrane:
        membranes_.set_serial(phase.color);
        break;
      case PhaseKind::strain_limit:
        strain_limits_.set_serial(phase.color);
        break;
      case PhaseKind::bending:
        bendings_.set_serial(phase.color);
        break;
      case PhaseKind::stiff_link:
        stiff_links_.set_serial(phase.color);
        break;
      case PhaseKind::vertex:
      case PhaseKind::attachment:
      case PhaseKind::grip:
      case PhaseKind::contact:
      case PhaseKind::body_contact:
      case PhaseKind::custom:
        break;  // not among a solver's constraints
    }
  }
  own_.sets.of<DistanceConstraint>() = distances_.make_slots();
  own_.sets.of<VolumeConstraint>() = volumes_.make_slots();
  own_.sets.of<NeoHookeanConstraint>() = neo_hookeans_.make_slots();
  own_.sets.of<FibreConstraint>() = fibres_.make_slots();
  own_.sets.of<MembraneConstraint>() = membranes_.make_slots();
  own_.sets.of<StrainLimitConstraint>() = strain_limits_.make_slots();
  own_.sets.of<BendingConstraint>() = bendings_.make_slots();
  own_.sets.of<StiffLinkConstraint>() = stiff_links_.make_slots();
}

template <class Constraint>
void FakeDevice::refresh(DeviceRecords<Constraint>& records, const SolverData& data) {
  records.refresh(data.sets.of<Constraint>(), own_.sets.of<Constraint>());
}

void FakeDevice::take_over(const SolverData& data) {
  take_over_blocks(data.vertex_blocks, data.changes);
  if (data.changes.grown) {
    take_all(data);
    own_.rebuild_plan();
  }
  const Changes& changes = data.changes;
  take_over_state(data);
  for (Index i = 0; i < data.copy_count() && changes.tools; ++i) {
    own_.copy(i).tools = data.copy(i).tools;
    own_.copy(i).attachment_colors = data.copy(i).attachment_colors;
  }
  for (const Index tet : changes.tets) {
    if (!changes.grown) {  // else all are there, and some that are named may be gone
      inspect(*own_.own_tissue).tet_alive.set(tet, inspect(*data.tissue).tet_alive[tet]);
    }
  }
  for (const auto& [kind, id] : changes.constraints) {
    if (changes.grown) {
      break;  // all are there
    }
    switch (kind) {
      case PhaseKind::distance:
        distances_.take_over(data.sets.of<DistanceConstraint>(), id);
        break;
      case PhaseKind::volume:
        volumes_.take_over(data.sets.of<VolumeConstraint>(), id);
        break;
      case PhaseKind::neo_hookean:
        neo_hookeans_.take_over(data.sets.of<NeoHookeanConstraint>(), id);
        break;
      case PhaseKind::fibre:
        fibres_.take_over(data.sets.of<FibreConstraint>(), id);
        break;
      case PhaseKind::membrane:
        membranes_.take_over(data.sets.of<MembraneConstraint>(), id);
        break;
      case PhaseKind::strain_limit:
        strain_limits_.take_over(data.sets.of<StrainLimitConstraint>(), id);
        break;
      case PhaseKind::bending:
        bendings_.take_over(data.sets.of<BendingConstraint>(), id);
        break;
      case PhaseKind::stiff_link:
        stiff_links_.take_over(data.sets.of<StiffLinkConstraint>(), id);
        break;
      case PhaseKind::joint:
      case PhaseKind::attachment:
      case PhaseKind::grip:
      case PhaseKind::contact:
      case PhaseKind::body_contact:
      case PhaseKind::custom:
        throw Error("a change of no constraint");
      case PhaseKind::vertex:
        break;  // see take_over_blocks()
    }
  }
  refresh(distances_, data);
  refresh(volumes_, data);
  refresh(neo_hookeans_, data);
  refresh(fibres_, data);
  refresh(membranes_, data);
  refresh(strain_limits_, data);
  refresh(bendings_, data);
  refresh(stiff_links_, data);
  if (changes.watched) {
    watched_ = data.watched_places;
  }
  if (changes.any()) {
    own_.rebuild_plan();
  }
}

void FakeDevice::take_over_state(const SolverData& data) {
  const Changes& changes = data.changes;
  const std::size_t count = data.particles.size();
  if (count > state_.capacity()) {
    DeviceState larger(data.copy_count(), room_to_grow(count), has_displacements(data.options),
                       has_past(data.options));
    for (Index i = 0; i < data.copy_count(); ++i) {
      state_.give(i, own_.copy(i), vertex_count_);
      larger.take(i, own_.copy(i), vertex_count_);
    }
    state_ = std::move(larger);
    ++remade_count;
  }
  for (Index i = 0; i < data.copy_count(); ++i) {
    for (const Index place : changes.vertices) {
      state_.set_inverse_mass(i, place, data.particles[place].w);
    }
    if (changes.state[i]) {
      state_.take(i, data.copy(i), count);
    }
    for (const Index v : changes.moved) {
      state_.take_place(i, data.copy(i), data.place_of_vertex[v]);
    }
    take_over_forces(data, i);
  }
  if (changes.gravities) {
    own_.gravities = data.gravities;
  } else if (!own_.gravities.empty()) {
    own_.gravities.resize(count);
    for (const Index v : changes.moved) {
      const Index place = data.place_of_vertex[v];
      own_.gravities[place] = data.gravities[place];
    }
  }
  vertex_count_ = count;
}

// All, once there are any; then those that are named.
void FakeDevice::take_over_forces(const SolverData& data, Index copy) {
  const std::vector<Load>& forces = data.copy(copy).forces;
  std::vector<Load>& own = own_.copy(copy).forces;
  if (own.empty()) {
    own = forces;
    return;
  }
  own.resize(data.particles.size());
  const auto take = [&](Index place) { own[place] = forces.empty() ? Load{} : forces[place]; };
  for (const Index v : data.changes.moved) {
    take(data.place_of_vertex[v]);
  }
  for (const Changes::Force& force : data.changes.forces) {
    if (force.copy == copy) {
      take(force.place);
    }
  }
}

// Rows cannot be written one by one, so all are copied once no others differ than were named.
void FakeDevice::take_over_blocks(const VertexBlocks& blocks, const Changes& changes) {
  if (!changes.rows_anew) {
    check_blocks(blocks, changes);
  }
  const bool names_any =
      std::ranges::count(changes.constraints, PhaseKind::vertex, &Changes::Constraint::kind) > 0;
  if (changes.rows_anew || names_any || !changes.blocks.empty()) {
    blocks_ = own_.vertex_blocks = blocks;
  }
}

void FakeDevice::check_blocks(const VertexBlocks& blocks, const Changes& changes) const {
  const std::set<Index> named(changes.blocks.begin(), changes.blocks.end());
  std::set<Index> vertices;
  for (const auto& [kind, id] : changes.constraints) {
    if (kind == PhaseKind::vertex) {
      vertices.insert(id);
    }
  }
  const VertexBlocks::Arrays before = blocks_.arrays(), after = blocks.arrays();
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const VertexBlock& block = after.blocks[b];
    const VertexBlocks::BlockRoom room = blocks.room_of(b);
    bool is_named = named.contains(b);
    bool is_right = is_named || (b < blocks_.block_count() && same_frame(before.blocks[b], block));
    for (Index lane = 0; is_right && lane < block.lane_count; ++lane) {
      const Index place = place_at(block.corners[lane]);
      is_named = is_named || vertices.contains(place);
      is_right = vertices.contains(place) ||
                 (same_lane(before.pulls, after.pulls, room.pulls, lane) &&
                  same_lane(before.springs, after.springs, room.springs, lane) &&
                  same_lane(before.volumes, after.volumes, room.volumes, lane) &&
                  same_lane(before.hinges, after.hinges, room.hinges, lane) &&
                  same_lane(before.triangles, after.triangles, room.triangles, lane) &&
                  same_lane(before.fibres, after.fibres, room.fibres, lane));
    }
    is_right = is_right && (is_named || same_counts(before.blocks[b], block));
    if (!is_right) {
      throw Error("nobody told of a change in block " + std::to_string(b));
    }
  }
  for (Index v = 0; v < blocks.vertex_count(); ++v) {
    const Index block = blocks.place_of(v).block;
    const bool is_known = v < blocks_.vertex_count() && blocks_.place_of(v).block == block;
    if (!is_known && !vertices.contains(v) && !named.contains(block)) {
      throw Error("nobody told that vertex " + std::to_string(v) + " is elsewhere");
    }
  }
}

Executor device_of_test(MakeBackend make, Executor instead) {
  return Executor(std::make_shared<ExecutorState>(std::make_shared<DeviceOfTest>(std::move(make)),
                                                  std::move(instead)));
}

Executor fake_device(int number) {
  return device_of_test(
      [number](const SolverData& data) { return std::make_unique<FakeDevice>(data, number); });
}

FakeDevice& fake_device_of(Solver& solver) {
  return dynamic_cast<FakeDevice&>(*inspect(solver).backend);
}

}  // namespace pbdsurg::testing
