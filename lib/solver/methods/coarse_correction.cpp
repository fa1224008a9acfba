// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/coarse_correction.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <span>

#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/coarse_space.h"
#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// sum += share * numbers: in the order of calls, so that registers of any width give the same bits.
void add(float share, std::span<const float> numbers, std::span<float> sum) {
  const float* const from = numbers.data();
  float* const to = sum.data();
  const std::size_t count = sum.size();
  for (std::size_t i = 0; i < count; ++i) {
    to[i] += share * from[i];
  }
}

using Quad = Eigen::Map<Eigen::Array4f, Eigen::Aligned16>;
using ConstQuad = Eigen::Map<const Eigen::Array4f, Eigen::Aligned16>;

ConstQuad quad_of(const Particle& p) {
  return ConstQuad(&p.x);
}

// A vector times shares, summed up in registers.
struct SharedSum {
  std::array<Eigen::Array4f, 4> of{Eigen::Array4f::Zero(), Eigen::Array4f::Zero(),
                                   Eigen::Array4f::Zero(), Eigen::Array4f::Zero()};

  void add(const Eigen::Array4f& vector, const CoarseShares& shares) {
    for (int k = 0; k < 4; ++k) {
      of[k] += shares.of[k] * vector;
    }
  }
  void add(const SharedSum& more) {
    for (int k = 0; k < 4; ++k) {
      of[k] += more.of[k];
    }
  }
  void store(AffineNumbers& to) const {
    for (int k = 0; k < 4; ++k) {
      Quad(to.of[k]) = of[k];
    }
  }
};

// Over a list of a node, in the order of kNodeSums and kNodePart.
// @param add  (std::size_t, Sum&)
template <class Sum, class Add>
Sum sum_of(const std::vector<Index>& list, const Add& add) {
  std::array<Sum, kNodeSums> sums;
  Sum all;
  for (std::size_t first = 0; first < list.size(); first += kNodePart) {
    const std::size_t end = std::min(first + kNodePart, list.size());
    for (Index n = 0; n < kNodeSums; ++n) {
      Sum sum;
      for (std::size_t i = first + static_cast<std::size_t>(n); i < end; i += kNodeSums) {
        add(i, sum);
      }
      sums[n] = sum;
    }
    for (Index half = kNodeSums / 2; half > 0; half /= 2) {
      for (Index n = 0; n < half; ++n) {
        sums[n].add(sums[n + half]);
      }
    }
    all.add(sums[0]);
  }
  return all;
}

// sum_i shares_i numbers_i, in kCoarseSums and then half by half.
// @param numbers_of  (Index) as long as the sum
template <class NumbersOf>
void sum_up(std::span<const float> shares, const NumbersOf& numbers_of, std::vector<float>& sums,
            std::span<float> sum) {
  const std::size_t size = sum.size();
  std::fill_n(sums.begin(), kCoarseSums * size, 0.0F);
  const auto nth = [&](std::size_t n) { return std::span(sums.data() + n * size, size); };
  for (std::size_t i = 0; i < shares.size(); ++i) {
    add(shares[i], numbers_of(static_cast<Index>(i)), nth(i % kCoarseSums));
  }
  for (std::size_t half = kCoarseSums / 2; half > 0; half /= 2) {
    for (std::size_t n = 0; n < half; ++n) {
      add(1, nth(n + half), nth(n));
    }
  }
  std::ranges::copy(nth(0), sum.begin());
}

Index number_of(Index node, int k, int axis) {
  return kAffineNumbers * node + 3 * k + axis;
}

// From rest to now.
void find_turns(const StepContext& step) {
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  for (Index piece = 0; piece < space.piece_count(); ++piece) {
    double sums[4][4] = {};
    for (Index node = 0; node < space.node_count(); ++node) {
      if (space.piece_of(node) != piece || space.members(node).own.empty()) {
        continue;
      }
      const AffineNumbers& shape = scratch.sums[node].shape;
      const Particle origin = shape_origin(step.copy.particles[space.members(node).own[0]]);
      const float from[3] = {origin.x, origin.y, origin.z};
      for (int k = 0; k < 4; ++k) {
        const double count{shape.of[k][3]};
        for (int axis = 0; axis < 3; ++axis) {
          sums[k][axis] += double{shape.of[k][axis]} + count * double{from[axis]};
        }
        sums[k][3] += count;
      }
    }
    scratch.turns[piece] = turn_of(sums);
  }
}

// Forces at nodes, as they are in pieces at rest.
// @param sums_of  (Index node) N, times 1, X, Y and Z
template <class SumsOf>
void find_loads(const StepContext& step, const SumsOf& sums_of) {
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  for (Index node = 0; node < space.node_count(); ++node) {
    const AffineNumbers& sums = sums_of(node);
    for (int k = 0; k < 4; ++k) {
      const float(&sum)[4] = sums.of[k];
      const Vec3<float> load = scratch.turns[space.piece_of(node)].back({sum[0], sum[1], sum[2]});
      float* const loads = scratch.loads.data() + number_of(node, k, 0);
      loads[0] = load.x;
      loads[1] = load.y;
      loads[2] = load.z;
    }
  }
}

// Of a hold, and a node that moves some of it.
CoarseShares& hold_sum(const StepContext& step, Index hold, Index node) {
  return step.scratch.coarse.hold_sums[hold * step.data.coarse_space.node_count() + node];
}

CoarseRows gather_coarse_holds(const StepContext& step) {
  CoarseScratch& scratch = step.scratch.coarse;
  scratch.held.clear();
  for (const VertexHold& each : step.scratch.holds) {
    scratch.held.push_back(each.place);
  }
  for (const Index place : step.data.custom.places()) {
    const bool moves = step.data.vertex_blocks.place_of(place).block != kInvalidIndex;
    if (moves && is_pushed(step, place)) {
      scratch.held.push_back(place);
    }
  }
  std::ranges::sort(scratch.held);
  scratch.held.erase(std::unique(scratch.held.begin(), scratch.held.end()), scratch.held.end());

  CoarseRows holds;
  holds.wides = scratch.wide.count();
  const Index most_holds = CoarseRows::most_holds(holds.wides);
  const std::span<const CoarseVertex> vertices = step.data.coarse_space.vertices();
  const auto is_opposed = [](const CoarseVertex& vertex) {
    return vertex.takes_part() && vertex.stiffness > 0;
  };
  Index counts[kMostNodes] = {};
  for (const Index place : scratch.held) {
    counts[vertices[place].nodes[0]] += is_opposed(vertices[place]) ? 1 : 0;
  }
  Index hold_of[kMostNodes];
  for (Index node = 0; node < step.data.coarse_space.node_count(); ++node) {
    hold_of[node] = kInvalidIndex;
    if (counts[node] > 0 && holds.count < most_holds) {
      hold_of[node] = holds.count;
      holds.counts[holds.count] = counts[node];
      holds.sums[holds.count] = 0;
      ++holds.count;
    }
  }
  std::ranges::fill(scratch.hold_sums, CoarseShares{});
  for (const Index place : scratch.held) {
    const CoarseVertex& vertex = vertices[place];
    const Index hold = is_opposed(vertex) ? hold_of[vertex.nodes[0]] : kInvalidIndex;
    for (int i = 0; i < kCoarseNodes && hold != kInvalidIndex; ++i) {
      float(&sum)[4] = hold_sum(step, hold, vertex.nodes[i]).of;
      const float weight = vertex.stiffness * vertex.weights[i];
      sum[0] += weight;
      for (int k = 0; k < 3; ++k) {
        sum[k + 1] += weight * vertex.place[k];
      }
    }
  }
  for (Index hold = 0; hold < holds.count; ++hold) {
    for (Index node = 0; node < step.data.coarse_space.node_count(); ++node) {
      holds.sums[hold] += hold_sum(step, hold, node).of[0];
    }
  }
  return holds;
}

// How modes move what is held.
void find_hold_rows(const StepContext& step, const CoarseRows& holds) {
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  const Index rows = holds.rows();
  const auto modes = static_cast<Index>(scratch.amplitudes.size());
  std::array<float, kMostModes> sums;  // of a row: one after another in memory
  for (Index row = 0; row < 3 * holds.count; ++row) {
    sums.fill(0);
    for (Index node = 0; node < space.node_count(); ++node) {
      const float(&sum)[4] = hold_sum(step, row / 3, node).of;
      for (int k = 0; k < 4 && sum[0] > 0; ++k) {
        const std::span<const float> moves = space.numbers(number_of(node, k, row % 3));
        const float share = sum[k] / holds.sums[row / 3];
        for (Index m = 0; m < modes; ++m) {
          sums[m] += share * moves[m];
        }
      }
    }
    for (Index m = 0; m < modes; ++m) {
      scratch.hold_modes[m * rows + row] = sums[m];
    }
  }
}

// How modes change a constraint of many neighbours, by vertices that take part in the correction:
// as they answer to a load along its gradients.
void find_wide_row(const StepContext& step, CoarseRows& holds, Index wide) {
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  std::ranges::fill(scratch.wide_sums, AffineNumbers{});
  for (const auto& [place, gradient] : scratch.wide.corners(wide)) {
    const CoarseVertex& vertex = space.vertices()[place];
    if (!vertex.takes_part() || !(scratch.residuals[place].w > 0)) {
      continue;
    }
    for (int i = 0; i < kCoarseNodes; ++i) {
      for (int k = 0; k < 4; ++k) {
        const float share = vertex.weights[i] * (k == 0 ? 1 : vertex.place[k - 1]);
        float(&sum)[4] = scratch.wide_sums[vertex.nodes[i]].of[k];
        sum[0] += share * gradient.x;
        sum[1] += share * gradient.y;
        sum[2] += share * gradient.z;
      }
    }
  }
  find_loads(step, [&](Index node) -> const AffineNumbers& { return scratch.wide_sums[node]; });
  sum_up(
      scratch.loads, [&](Index number) { return space.numbers(number); }, scratch.sums_of_all,
      scratch.wide_modes);
  const Index row = holds.row_of_wide(wide);
  const auto modes = static_cast<Index>(scratch.amplitudes.size());
  for (Index m = 0; m < modes; ++m) {
    scratch.hold_modes[m * holds.rows() + row] = scratch.wide_modes[m];
  }
  holds.wide_compliances[wide] = scratch.wide.compliance(wide);
}

using EntrySums = std::array<double, HoldSystem::entries(kHoldRows)>;

// HoldSystem::sum_of_modes() of all entries, in its order of modes and of parts: side by side, for
// the sum of one alone has to wait for each mode.
EntrySums sum_entries(const CoarseScratch& scratch, Index rows) {
  EntrySums sums, part;
  std::array<double, kHoldRows> moves;
  const Index entries = HoldSystem::entries(rows);
  std::fill_n(sums.begin(), entries, 0);
  const auto modes = static_cast<Index>(scratch.amplitudes.size());
  for (Index first = 0; first < modes; first += kModesOfPart) {
    std::fill_n(part.begin(), entries, 0);
    for (Index m = first; m < std::min(first + kModesOfPart, modes); ++m) {
      std::copy_n(scratch.hold_modes.begin() + m * rows, rows, moves.begin());
      const double give{scratch.gives[m]}, amplitude{scratch.amplitudes[m]};
      for (Index row = 0; row < rows; ++row) {
        double* const entry = part.data() + row * (rows + 1);
        const double given = give * moves[row];
        for (Index other = 0; other <= row; ++other) {
          entry[other] += given * moves[other];
        }
        entry[rows] += moves[row] * amplitude;
      }
    }
    for (Index entry = 0; entry < entries; ++entry) {
      sums[entry] += part[entry];
    }
  }
  return sums;
}

// Takes off the amplitudes what would move what is held. Springs act alike along all axes, so in
// pieces as they are at rest.
void oppose_holds(const StepContext& step) {
  CoarseScratch& scratch = step.scratch.coarse;
  if (step.scratch.holds.empty() && !has_custom(step)) {
    return;
  }
  CoarseRows holds = gather_coarse_holds(step);
  std::ranges::fill(scratch.hold_modes, 0.0F);
  find_hold_rows(step, holds);
  for (Index wide = 0; wide < holds.wides; ++wide) {
    find_wide_row(step, holds, wide);
  }
  const Index rows = holds.rows();
  const auto modes = static_cast<Index>(scratch.amplitudes.size());
  const EntrySums sums = sum_entries(scratch, rows);
  HoldSystem system;
  system.solve(OneWorker{}, holds, [&](Index entry) { return sums[entry]; });
  for (Index m = 0; m < modes; ++m) {
    scratch.amplitudes[m] -=
        system.taken(rows, scratch.gives[m], scratch.hold_modes.data() + m * rows);
  }
}

}  // namespace

void WideConstraints::clear() noexcept {
  corners_.clear();
  firsts_.clear();
  compliances_.clear();
}

bool WideConstraints::begin(float compliance) {
  if (count() == kMostWides) {
    return false;
  }
  firsts_.push_back(corners_.size());
  compliances_.push_back(compliance);
  return true;
}

std::span<const WideConstraints::Corner> WideConstraints::corners(Index constraint) const noexcept {
  const std::size_t first = firsts_[constraint];
  const std::size_t end = constraint + 1 < count() ? firsts_[constraint + 1] : corners_.size();
  return {corners_.data() + first, end - first};
}

std::size_t WideConstraints::memory_bytes() const noexcept {
  return corners_.capacity() * sizeof(Corner) + firsts_.capacity() * sizeof(std::size_t) +
         compliances_.capacity() * sizeof(float);
}

void CoarseScratch::fit(const SolverData& data) {
  const CoarseSpace& space = data.coarse_space;
  const std::size_t places = data.particles.size(), room = data.particles.capacity();
  residuals.reserve(room);
  moves.reserve(room);
  if (rows_revision != data.rows_revision || residuals.size() != places) {
    residuals.assign(places, {});  // of vertices that no block has any more
    rows_revision = data.rows_revision;
  }
  moves.resize(places);
  const auto node_count = static_cast<std::size_t>(space.node_count());
  const auto pieces = static_cast<std::size_t>(space.piece_count());
  sums.resize(node_count);
  gains.resize(node_count);
  turns.resize(pieces);
  moves_of_nodes.resize(node_count);
  loads.resize(kAffineNumbers * node_count);
  numbers.resize(kAffineNumbers * node_count);
  amplitudes.resize(space.stiffnesses().size());
  gives.resize(amplitudes.size());
  sums_of_all.resize(kCoarseSums * std::max(amplitudes.size(), numbers.size()));
  hold_sums.resize(kCoarseHolds * node_count);
  wide_sums.resize(data.custom.empty() ? 0 : node_count);
  wide_modes.resize(data.custom.empty() ? 0 : amplitudes.size());
  hold_modes.resize(kHoldRows * amplitudes.size());
  if (!data.custom.empty()) {
    left_out.resize(static_cast<std::size_t>(data.vertex_blocks.block_count()));
  }
}

std::size_t CoarseScratch::memory_bytes() const noexcept {
  return (residuals.capacity() + moves.capacity()) * sizeof(Particle) +
         sums.capacity() * sizeof(NodeSums) + gains.capacity() * sizeof(CoarseGain) +
         hold_sums.capacity() * sizeof(CoarseShares) + wide.memory_bytes() +
         (moves_of_nodes.capacity() + wide_sums.capacity()) * sizeof(AffineNumbers) +
         (loads.capacity() + sums_of_all.capacity() + amplitudes.capacity() + gives.capacity() +
          numbers.capacity() + hold_modes.capacity() + wide_modes.capacity()) *
             sizeof(float) +
         left_out.capacity() * sizeof(LaneBits) + held.capacity() * sizeof(Index) +
         turns.capacity() * sizeof(Turn);
}

bool has_correction(const SolverData& data, int sweeps) noexcept {
  return data.coarse_space.node_count() > 0 && sweeps > 1;
}

void leave_out_pushed(const StepContext& step) {
  std::vector<LaneBits>& left_out = step.scratch.coarse.left_out;
  std::ranges::copy(step.scratch.held, left_out.begin());
  const VertexBlocks& blocks = step.data.vertex_blocks;
  for (const Index place : step.data.custom.places()) {
    const Index block = blocks.place_of(place).block;
    if (block != kInvalidIndex && is_pushed(step, place)) {
      left_out[block] |= blocks.lanes_of(place);
    }
  }
}

CoarsePart coarse_part(const StepContext& step, Index part) noexcept {
  const auto count = static_cast<std::int64_t>(step.copy.particles.size());
  return {static_cast<Index>(count * part / kCoarseParts),
          static_cast<Index>(count * (part + 1) / kCoarseParts)};
}

void project_residuals(const StepContext& step, Index node) {
  CoarseScratch& scratch = step.scratch.coarse;
  // by name: Clang before 16 captures no structured binding
  const NodeMembers& members = step.data.coarse_space.members(node);
  const auto &own = members.own, &places = members.places;
  const std::span<const CoarseVertex> vertices = step.data.coarse_space.vertices();
  const std::vector<Particle>& particles = step.copy.particles;
  const auto load = sum_of<SharedSum>(places, [&](std::size_t i, SharedSum& sum) {
    const Particle& residual = scratch.residuals[places[i]];
    if (residual.w > 0) {
      sum.add(quad_of(residual), members.shares[i]);
    }
  });
  load.store(scratch.sums[node].load);
  const Particle origin = own.empty() ? Particle{} : shape_origin(particles[own[0]]);
  const Eigen::Array4f axes(1, 1, 1, 0), one(0, 0, 0, 1);
  const auto shape = sum_of<SharedSum>(own, [&](std::size_t i, SharedSum& sum) {
    const Index v = own[i];
    if (scratch.residuals[v].w > 0) {
      const auto& place = vertices[v].place;
      sum.add((quad_of(particles[v]) - quad_of(origin)) * axes + one,
              {1, place[0], place[1], place[2]});
    }
  });
  shape.store(scratch.sums[node].shape);
}

void solve_coarse(const StepContext& step, float inverse_dt_squared) {
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  find_turns(step);
  find_loads(step, [&](Index node) -> const AffineNumbers& { return scratch.sums[node].load; });
  sum_up(
      scratch.loads, [&](Index number) { return space.numbers(number); }, scratch.sums_of_all,
      scratch.amplitudes);
  for (std::size_t m = 0; m < scratch.amplitudes.size(); ++m) {
    scratch.gives[m] = 1 / (inverse_dt_squared + space.stiffnesses()[m]);
    scratch.amplitudes[m] *= scratch.gives[m];
  }
  oppose_holds(step);
  sum_up(
      scratch.amplitudes, [&](Index mode) { return space.mode(mode); }, scratch.sums_of_all,
      scratch.numbers);
  for (Index node = 0; node < space.node_count(); ++node) {
    for (int k = 0; k < 4; ++k) {
      const float* const v = scratch.numbers.data() + number_of(node, k, 0);
      const Vec3<float> now = scratch.turns[space.piece_of(node)]({v[0], v[1], v[2]});
      float(&move)[4] = scratch.moves_of_nodes[node].of[k];
      move[0] = now.x;
      move[1] = now.y;
      move[2] = now.z;
      move[3] = 0;
    }
  }
}

void find_moves(const StepContext& step, Index part) {
  CoarseScratch& scratch = step.scratch.coarse;
  const std::span<const CoarseVertex> vertices = step.data.coarse_space.vertices();
  const auto [first, last] = coarse_part(step, part);
  for (Index v = first; v < last; ++v) {
    const CoarseVertex& vertex = vertices[v];
    Eigen::Array4f way = Eigen::Array4f::Zero();
    for (int k = 0; k < 4; ++k) {
      Eigen::Array4f blend = Eigen::Array4f::Zero();
      for (int i = 0; i < kCoarseNodes; ++i) {
        blend += vertex.weights[i] * ConstQuad(scratch.moves_of_nodes[vertex.nodes[i]].of[k]);
      }
      way += (k == 0 ? 1 : vertex.place[k - 1]) * blend;
    }
    const bool moves = scratch.residuals[v].w > 0 && vertex.takes_part() &&
                       is_finite_way({way[0], way[1], way[2]});
    scratch.moves[v] = moves ? Particle{way[0], way[1], way[2], 1} : Particle{};
  }
}

void displace(const StepContext& step, const VertexState& state, Index part) {
  const auto [first, last] = coarse_part(step, part);
  for (Index v = first; v < last; ++v) {
    const Particle& move = step.scratch.coarse.moves[v];
    if (move.w > 0) {
      Particle& p = state.displacements[v];
      const Vec3<float> before = load(p), after = before + load(move);
      store(p, after);
      state.fixed_points[v] = moved_point(state.fixed_points[v], before, after);
    }
  }
}

void weigh_moves(const StepContext& step, Index node) {
  struct Power {
    double of = 0;  // J

    void add(const Power& more) { of += more.of; }
  };
  CoarseScratch& scratch = step.scratch.coarse;
  const std::vector<Index>& own = step.data.coarse_space.members(node).own;
  const auto after = sum_of<Power>(own, [&](std::size_t i, Power& sum) {
    sum.of += power_after(scratch.residuals[own[i]], scratch.moves[own[i]]);
  });
  scratch.gains[node] = {power(scratch.sums[node].load, scratch.moves_of_nodes[node]), after.of};
}

bool turn_back_moves(const StepContext& step, Index part) {
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  CoarseGain gains[kMostNodes];  // [piece]
  for (Index node = 0; node < space.node_count(); ++node) {
    CoarseGain& gain = gains[space.piece_of(node)];
    gain.before += scratch.gains[node].before;
    gain.after += scratch.gains[node].after;
  }
  float backs[kMostNodes];
  bool goes_back = false;
  for (Index piece = 0; piece < space.piece_count(); ++piece) {
    backs[piece] = static_cast<float>(gains[piece].length() - 1);
    goes_back = goes_back || backs[piece] < 0;
  }
  if (!goes_back) {
    return false;
  }
  const auto [first, last] = coarse_part(step, part);
  for (Index v = first; v < last; ++v) {
    const float back = backs[space.piece_of(space.vertices()[v].nodes[0])];
    Particle& move = scratch.moves[v];
    move = {back * move.x, back * move.y, back * move.z, back < 0 ? move.w : 0};
  }
  return true;
}

}  // namespace pbdsurg
