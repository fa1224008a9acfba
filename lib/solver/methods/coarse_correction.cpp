// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/coarse_correction.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/coarse_space.h"
#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// Those of a part.
template <class Element>
std::span<Element> share_of(std::vector<Element>& all, Index part) {
  const std::size_t count = all.size() / kCoarseParts;
  return {all.data() + static_cast<std::size_t>(part) * count, count};
}

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

// Adds share times the products of a vector and 1, X, Y and Z.
void add(float share, const Eigen::Array4f& vector, const std::array<float, 3>& place,
         AffineSums& sums) {
  const Eigen::Array4f v = share * vector;
  Quad(sums.of[0].data()) += v;
  for (int k = 0; k < 3; ++k) {
    Quad(sums.of[k + 1].data()) += place[k] * v;
  }
}

// From rest to now, of a piece; one of those that do where it is flat.
std::array<float, 9> turn_of(const StepContext& step, Index piece) {
  Eigen::Vector4d count_and_places = Eigen::Vector4d::Zero();
  Eigen::Matrix<double, 3, 4> products = decltype(products)::Zero();  // of positions
  for (Index part = 0; part < kCoarseParts; ++part) {
    const AffineSums& sums = share_of(step.scratch.coarse.part_shapes, part)[piece];
    const Particle& origin = step.copy.particles[coarse_part(step, part).first];
    const Eigen::Vector3d from(origin.x, origin.y, origin.z);
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector4d sum = Eigen::Vector4f(sums.of[k].data()).cast<double>();
      count_and_places[k] += sum.w();
      products.col(k) += sum.head<3>() + sum.w() * from;
    }
  }
  const Eigen::Matrix3d product =
      products.rightCols<3>() -
      products.col(0) * count_and_places.tail<3>().transpose() / std::max(1.0, count_and_places[0]);
  Eigen::Matrix<float, 3, 3, Eigen::RowMajor> turn = decltype(turn)::Identity();
  if (product.allFinite()) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) {
      u.col(2) *= -1;
    }
    turn = (u * svd.matrixV().transpose()).cast<float>();
  }
  std::array<float, 9> result;
  std::copy_n(turn.data(), 9, result.begin());
  return result;
}

Vec3<float> turned(const std::array<float, 9>& r, const Vec3<float>& v) {
  return {r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.x + r[4] * v.y + r[5] * v.z,
          r[6] * v.x + r[7] * v.y + r[8] * v.z};
}

Vec3<float> turned_back(const std::array<float, 9>& r, const Vec3<float>& v) {
  return {r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
          r[2] * v.x + r[5] * v.y + r[8] * v.z};
}

// Tissue that a tool holds near a node: a spring at the mean of its vertices.
struct CoarseHold {
  Index node;
  Index count;
  float sum;  // N/m, of the stiffnesses of vertices

  // N/m, of the tissue around all of them: it goes with their extent, so with a root of their
  // number
  [[nodiscard]] double stiffness() const { return double{sum} / std::sqrt(double(count)); }
};

using CoarseHolds = std::array<CoarseHold, kCoarseHolds>;

// [1, X, Y, Z] of a node
std::span<float, 4> hold_share(const StepContext& step, Index hold, Index node) {
  const Index nodes = step.data.coarse_space.node_count();
  return std::span<float, 4>(step.scratch.coarse.hold_shares.data() + 4 * (hold * nodes + node), 4);
}

// @return  their number
Index gather_coarse_holds(const StepContext& step, CoarseHolds& holds) {
  std::ranges::fill(step.scratch.coarse.hold_shares, 0.0F);
  Index count = 0;
  for (const VertexHold& each : step.scratch.holds) {
    const CoarseVertex& vertex = step.data.coarse_space.vertices()[each.place];
    if (!vertex.takes_part() || !(vertex.stiffness > 0)) {
      continue;
    }
    const auto end = holds.begin() + count;
    const auto known = std::find_if(
        holds.begin(), end, [&](const CoarseHold& hold) { return hold.node == vertex.nodes[0]; });
    const auto hold = static_cast<Index>(known - holds.begin());
    if (known == end) {
      if (count == kCoarseHolds) {
        continue;
      }
      holds[count++] = {vertex.nodes[0], 0, 0};
    }
    ++holds[hold].count;
    holds[hold].sum += vertex.stiffness;
    for (int i = 0; i < kCoarseNodes; ++i) {
      const std::span<float, 4> share = hold_share(step, hold, vertex.nodes[i]);
      const float weight = vertex.stiffness * vertex.weights[i];
      share[0] += weight;
      for (int k = 0; k < 3; ++k) {
        share[k + 1] += weight * vertex.place[k];
      }
    }
  }
  return count;
}

// Takes off the amplitudes what would move what is held. Springs act alike along all axes, so in
// pieces as they are at rest.
void oppose_holds(const StepContext& step) {
  constexpr Index kRows = 3 * kCoarseHolds;  // an axis of a hold each
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kRows, kRows>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kRows, 1>;
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  CoarseHolds holds;
  const Index count = gather_coarse_holds(step, holds), rows = 3 * count;
  if (count == 0) {
    return;
  }
  const std::size_t modes = scratch.amplitudes.size();
  std::ranges::fill(scratch.hold_modes, 0.0F);
  for (Index row = 0; row < rows; ++row) {
    const float sum = holds[row / 3].sum;
    for (Index node = 0; node < space.node_count(); ++node) {
      const std::span<float, 4> share = hold_share(step, row / 3, node);
      for (int k = 0; k < 4 && share[0] > 0; ++k) {
        const std::span<const float> moves = space.numbers(kAffineNumbers * node + 3 * k + row % 3);
        for (std::size_t m = 0; m < modes; ++m) {
          scratch.hold_modes[m * kRows + row] += share[k] / sum * moves[m];
        }
      }
    }
  }
  // (D + V^T K V)^-1 by Woodbury's identity: D of the modes, V how they move what is held, K
  // springs
  Matrix gives = Matrix::Zero(rows, rows);
  Vector moves = Vector::Zero(rows);
  for (std::size_t m = 0; m < modes; ++m) {
    const float* const of_mode = scratch.hold_modes.data() + m * kRows;
    for (Index row = 0; row < rows; ++row) {
      moves[row] += double{of_mode[row]} * scratch.amplitudes[m];
      const double give = double{scratch.gives[m]} * of_mode[row];
      for (Index other = 0; other < rows; ++other) {
        gives(row, other) += give * double{of_mode[other]};
      }
    }
  }
  for (Index row = 0; row < rows; ++row) {
    gives(row, row) += 1 / holds[row / 3].stiffness();
  }
  const Vector forces = gives.ldlt().solve(moves);
  for (std::size_t m = 0; m < modes; ++m) {
    double load = 0;
    for (Index row = 0; row < rows; ++row) {
      load += double{scratch.hold_modes[m * kRows + row]} * forces[row];
    }
    scratch.amplitudes[m] -= scratch.gives[m] * static_cast<float>(load);
  }
}

double power(const Particle& force, const Particle& way) {
  return double{force.x} * way.x + double{force.y} * way.y + double{force.z} * way.z;
}

// t; none of what is not finite.
double length_of(const PieceGain& gain) {
  constexpr double kFurthest = 0.5;  // beyond the balance, as a share of the way there
  const double length =
      gain.after >= -kFurthest * gain.before ? 1 : gain.before / (gain.before - gain.after);
  return gain.before > 0 && length > 0 && length <= 1 ? length : 0;
}

}  // namespace

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
  part_loads.resize(kCoarseParts * node_count);
  part_shapes.resize(kCoarseParts * pieces);
  part_gains.resize(kCoarseParts * pieces);
  turns.resize(pieces);
  nodes.resize(node_count);
  loads.resize(kAffineNumbers * node_count);
  numbers.resize(kAffineNumbers * node_count);
  amplitudes.resize(space.stiffnesses().size());
  gives.resize(amplitudes.size());
  hold_shares.resize(4 * kCoarseHolds * node_count);
  hold_modes.resize(3 * kCoarseHolds * amplitudes.size());
}

std::size_t CoarseScratch::memory_bytes() const noexcept {
  return (residuals.capacity() + moves.capacity()) * sizeof(Particle) +
         (part_loads.capacity() + part_shapes.capacity() + nodes.capacity()) * sizeof(AffineSums) +
         (loads.capacity() + amplitudes.capacity() + gives.capacity() + numbers.capacity() +
          hold_shares.capacity() + hold_modes.capacity()) *
             sizeof(float) +
         part_gains.capacity() * sizeof(PieceGain) + turns.capacity() * sizeof(turns[0]);
}

bool has_correction(const SolverData& data, int sweeps) noexcept {
  return data.coarse_space.node_count() > 0 && sweeps > 1;
}

CoarsePart coarse_part(const StepContext& step, Index part) noexcept {
  const auto count = static_cast<std::int64_t>(step.copy.particles.size());
  return {static_cast<Index>(count * part / kCoarseParts),
          static_cast<Index>(count * (part + 1) / kCoarseParts)};
}

void project_residuals(const StepContext& step, Index part) {
  CoarseScratch& scratch = step.scratch.coarse;
  const std::span<const CoarseVertex> vertices = step.data.coarse_space.vertices();
  const std::span<AffineSums> loads = share_of(scratch.part_loads, part);
  const std::span<AffineSums> shapes = share_of(scratch.part_shapes, part);
  std::ranges::fill(loads, AffineSums{});
  std::ranges::fill(shapes, AffineSums{});
  AffineSums shape;  // of the piece last seen: near vertices are of one
  Index piece = 0;
  const auto [first, last] = coarse_part(step, part);
  for (Index v = first; v < last; ++v) {
    const Particle& force = scratch.residuals[v];
    const CoarseVertex& vertex = vertices[v];
    if (!(force.w > 0) || !vertex.takes_part()) {
      continue;
    }
    if (vertex.piece != piece) {
      shapes[piece] = shape;
      piece = vertex.piece;
      shape = shapes[piece];
    }
    for (int i = 0; i < kCoarseNodes; ++i) {
      add(vertex.weights[i], quad_of(force), vertex.place, loads[vertex.nodes[i]]);
    }
    Eigen::Array4f x = quad_of(step.copy.particles[v]) - quad_of(step.copy.particles[first]);
    x[3] = 1;
    add(1, x, vertex.place, shape);
  }
  shapes[piece] = shape;
}

void solve_coarse(const StepContext& step, float inverse_dt_squared) {
  CoarseScratch& scratch = step.scratch.coarse;
  const CoarseSpace& space = step.data.coarse_space;
  for (Index piece = 0; piece < space.piece_count(); ++piece) {
    scratch.turns[piece] = turn_of(step, piece);
  }
  for (Index node = 0; node < space.node_count(); ++node) {
    for (int k = 0; k < 4; ++k) {
      Eigen::Array4f sum = Eigen::Array4f::Zero();
      for (Index part = 0; part < kCoarseParts; ++part) {
        sum += ConstQuad(share_of(scratch.part_loads, part)[node].of[k].data());
      }
      const Vec3<float> load =
          turned_back(scratch.turns[space.piece_of(node)], {sum[0], sum[1], sum[2]});
      std::ranges::copy(std::array{load.x, load.y, load.z},
                        scratch.loads.begin() + kAffineNumbers * node + 3 * k);
    }
  }
  std::ranges::fill(scratch.amplitudes, 0.0F);
  for (std::size_t n = 0; n < scratch.loads.size(); ++n) {
    add(scratch.loads[n], space.numbers(static_cast<Index>(n)), scratch.amplitudes);
  }
  for (std::size_t m = 0; m < scratch.amplitudes.size(); ++m) {
    scratch.gives[m] = 1 / (inverse_dt_squared + space.stiffnesses()[m]);
    scratch.amplitudes[m] *= scratch.gives[m];
  }
  oppose_holds(step);
  std::ranges::fill(scratch.numbers, 0.0F);
  for (std::size_t m = 0; m < scratch.amplitudes.size(); ++m) {
    add(scratch.amplitudes[m], space.mode(static_cast<Index>(m)), scratch.numbers);
  }
  for (Index node = 0; node < space.node_count(); ++node) {
    for (int k = 0; k < 4; ++k) {
      const float* const v = scratch.numbers.data() + kAffineNumbers * node + 3 * k;
      const Vec3<float> now = turned(scratch.turns[space.piece_of(node)], {v[0], v[1], v[2]});
      scratch.nodes[node].of[k] = {now.x, now.y, now.z, 0};
    }
  }
}

void find_moves(const StepContext& step, Index part) {
  CoarseScratch& scratch = step.scratch.coarse;
  const std::span<const CoarseVertex> vertices = step.data.coarse_space.vertices();
  const std::span<PieceGain> gains = share_of(scratch.part_gains, part);
  std::ranges::fill(gains, PieceGain{});
  const auto [first, last] = coarse_part(step, part);
  for (Index v = first; v < last; ++v) {
    const CoarseVertex& vertex = vertices[v];
    Eigen::Array4f way = Eigen::Array4f::Zero();
    for (int k = 0; k < 4; ++k) {
      Eigen::Array4f blend = Eigen::Array4f::Zero();
      for (int i = 0; i < kCoarseNodes; ++i) {
        blend += vertex.weights[i] * ConstQuad(scratch.nodes[vertex.nodes[i]].of[k].data());
      }
      way += (k == 0 ? 1 : vertex.place[k - 1]) * blend;
    }
    const bool moves = scratch.residuals[v].w > 0 && vertex.takes_part() &&
                       is_finite_way({way[0], way[1], way[2]});
    scratch.moves[v] = moves ? Particle{way[0], way[1], way[2], 1} : Particle{};
    gains[vertex.piece].before += power(scratch.residuals[v], scratch.moves[v]);
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

void weigh_moves(const StepContext& step, Index part) {
  CoarseScratch& scratch = step.scratch.coarse;
  const std::span<PieceGain> gains = share_of(scratch.part_gains, part);
  const auto [first, last] = coarse_part(step, part);
  for (Index v = first; v < last; ++v) {
    const bool is_overflown = scratch.moves[v].w > 0 && !(scratch.residuals[v].w > 0);
    gains[step.data.coarse_space.vertices()[v].piece].after +=
        is_overflown ? -std::numeric_limits<double>::infinity()
                     : power(scratch.residuals[v], scratch.moves[v]);
  }
}

bool turn_back_moves(const StepContext& step, Index part) {
  CoarseScratch& scratch = step.scratch.coarse;
  const std::span<const CoarseVertex> vertices = step.data.coarse_space.vertices();
  const auto way_back = [&](Index piece) {
    PieceGain gain;
    for (Index each = 0; each < kCoarseParts; ++each) {
      const PieceGain& more = share_of(scratch.part_gains, each)[piece];
      gain.before += more.before;
      gain.after += more.after;
    }
    return static_cast<float>(length_of(gain) - 1);
  };
  bool goes_back = false;
  for (Index piece = 0; piece < step.data.coarse_space.piece_count(); ++piece) {
    goes_back = goes_back || way_back(piece) < 0;
  }
  if (!goes_back) {
    return false;
  }
  Index piece = kInvalidIndex;  // the last seen: near vertices are of one
  float back = 0;
  const auto [first, last] = coarse_part(step, part);
  for (Index v = first; v < last; ++v) {
    if (vertices[v].piece != piece) {
      piece = vertices[v].piece;
      back = way_back(piece);
    }
    Particle& move = scratch.moves[v];
    move = {back * move.x, back * move.y, back * move.z, back < 0 ? move.w : 0};
  }
  return true;
}

}  // namespace pbdsurg
