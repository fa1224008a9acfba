// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/coarse_space.h"

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "pbdsurg/mesh/topology.h"

#include "lib/solver/coarse_choice.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kNegligible = 1e-5;  // of the mass of the heaviest motion
constexpr double kFar = std::numeric_limits<double>::infinity();

struct Neighbor {
  Index place;
  double distance;  // m
};

// Tissue at rest, by places.
struct Graph {
  std::vector<Vector3d> positions;               // m
  std::vector<std::vector<Neighbor>> neighbors;  // along edges and links, but those to sheets
};

Graph make_graph(const SolverData& data) {
  const Tissue& tissue = *data.tissue;
  Graph graph;
  graph.positions.resize(data.particles.size());
  graph.neighbors.resize(data.particles.size());
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    graph.positions[data.place_of_vertex[v]] = tissue.rest_positions()[v];
  }
  const auto join = [&](Index first, Index second) {
    const Index a = data.place_of_vertex[first], b = data.place_of_vertex[second];
    const double distance = (graph.positions[a] - graph.positions[b]).norm();
    graph.neighbors[a].push_back({b, distance});
    graph.neighbors[b].push_back({a, distance});
  };
  for (Index e = 0; e < static_cast<Index>(tissue.edges().size()); ++e) {
    if (tissue.is_edge_alive(e)) {
      join(tissue.edges()[e][0], tissue.edges()[e][1]);
    }
  }
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    if (tissue.is_link_alive(l) && !leads_to_sheet(tissue, l)) {
      join(tissue.links()[l].first, tissue.links()[l].second);
    }
  }
  return graph;
}

// The vertices that are furthest from each other and from those before, one after another.
std::vector<Index> choose_nodes(const Graph& graph, const SolverData& data) {
  std::vector<double> distances(graph.positions.size(), kFar);
  std::vector<Index> nodes;
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto free = static_cast<Index>(
      std::ranges::count_if(data.particles, [](const Particle& p) { return p.w > 0; }));
  const Index most = most_nodes(free);
  while (static_cast<Index>(nodes.size()) < most) {
    Index furthest = kInvalidIndex;
    for (Index v = 0; v < static_cast<Index>(distances.size()); ++v) {
      const bool counts = data.particles[v].w > 0 && !graph.neighbors[v].empty();
      if (counts && distances[v] > (furthest == kInvalidIndex ? 0 : distances[furthest])) {
        furthest = v;
      }
    }
    if (furthest == kInvalidIndex) {
      break;
    }
    nodes.push_back(furthest);
    distances[furthest] = 0;
    queue.emplace(0, furthest);
    while (!queue.empty()) {
      const auto [distance, v] = queue.top();
      queue.pop();
      if (distance > distances[v]) {
        continue;
      }
      for (const auto& [next, way] : graph.neighbors[v]) {
        if (distance + way < distances[next]) {
          distances[next] = distance + way;
          queue.emplace(distances[next], next);
        }
      }
    }
  }
  return nodes;
}

struct NearNode {
  Index node;
  double distance;  // m
};

// One more than move a vertex, the nearest first; fewer where there are no more.
std::vector<std::vector<NearNode>> find_near_nodes(const Graph& graph,
                                                   const std::vector<Index>& nodes) {
  std::vector<std::vector<NearNode>> near(graph.positions.size());
  using Entry = std::tuple<double, Index, Index>;  // distance, node, place
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (Index node = 0; node < static_cast<Index>(nodes.size()); ++node) {
    queue.emplace(0, node, nodes[node]);
  }
  while (!queue.empty()) {
    const auto [distance, node, v] = queue.top();
    queue.pop();
    std::vector<NearNode>& found = near[v];
    if (found.size() > kCoarseNodes ||
        std::ranges::find(found, node, &NearNode::node) != found.end()) {
      continue;
    }
    found.push_back({node, distance});
    for (const auto& [next, way] : graph.neighbors[v]) {
      if (near[next].size() <= kCoarseNodes) {
        queue.emplace(distance + way, node, next);
      }
    }
  }
  return near;
}

// Weights that fade to zero where a further node is as near (Sumner et al. 2007, equation 4).
void set_weights(const std::vector<NearNode>& near, CoarseVertex& vertex) {
  if (near.empty()) {
    return;
  }
  const auto count = std::min<std::size_t>(near.size(), kCoarseNodes);
  const double end =
      near.size() > kCoarseNodes ? near[kCoarseNodes].distance : 1.5 * near.back().distance;
  std::array<double, kCoarseNodes> weights{};
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = end > 0 ? 1 - near[i].distance / end : 1;
    weights[i] = share * share;
    sum += weights[i];
  }
  for (std::size_t i = 0; i < count; ++i) {  // all as near as the next: alike
    vertex.nodes[i] = near[i].node;
    vertex.weights[i] = static_cast<float>(sum > 0 ? weights[i] / sum : 1.0 / double(count));
  }
}

// Where vertices lie in their pieces, if these have nodes.
// @return  the piece of each node
std::vector<Index> set_places(const Graph& graph, const std::vector<Index>& nodes,
                              std::vector<CoarseVertex>& vertices) {
  std::vector<Index> piece(vertices.size(), kInvalidIndex), members;
  Index count = 0;
  for (const Index start : nodes) {
    if (piece[start] != kInvalidIndex) {
      continue;
    }
    members.assign(1, start);
    piece[start] = count;
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < members.size(); ++i) {
      box.extend(graph.positions[members[i]]);
      for (const Neighbor& next : graph.neighbors[members[i]]) {
        if (piece[next.place] == kInvalidIndex) {
          piece[next.place] = count;
          members.push_back(next.place);
        }
      }
    }
    const double scale = 2 / box.sizes().maxCoeff();
    for (const Index v : members) {
      const Vector3d place = scale * (graph.positions[v] - box.center());
      for (int k = 0; k < 3; ++k) {
        vertices[v].place[k] = static_cast<float>(place[k]);
      }
    }
    ++count;
  }
  std::vector<Index> piece_of_node;
  for (const Index node : nodes) {
    piece_of_node.push_back(piece[node]);
  }
  return piece_of_node;
}

using Triplets = std::vector<Eigen::Triplet<double>>;

void add_block(Index row, Index column, const Matrix3d& block, Triplets& triplets) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      triplets.emplace_back(3 * row + i, 3 * column + j, block(i, j));
    }
  }
}

// What joins two vertices.
void add_pair(Index a, Index b, const Matrix3d& stiffness, Triplets& triplets) {
  add_block(a, a, stiffness, triplets);
  add_block(b, b, stiffness, triplets);
  add_block(a, b, -stiffness, triplets);
  add_block(b, a, -stiffness, triplets);
}

Matrix3d skew(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// stiffness / 2 (V - target)^2
void add_volume(const VertexTet& tet, const std::vector<Vector3d>& x, Triplets& triplets) {
  const auto& [a, b, c, d] = tet.vertices;
  const std::array<Vector3d, 3> sides{x[b] - x[a], x[c] - x[a], x[d] - x[a]};
  std::array<Vector3d, 4> gradient{};
  std::array<std::array<Matrix3d, 4>, 4> second{};
  for (auto& row : second) {
    row.fill(Matrix3d::Zero());
  }
  gradient[0].setZero();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    gradient[i + 1] = sides[j].cross(sides[k]) / 6;
    gradient[0] -= gradient[i + 1];
    second[i + 1][j + 1] = -skew(sides[k]) / 6;
    second[i + 1][k + 1] = skew(sides[j]) / 6;
  }
  for (int i = 1; i < 4; ++i) {
    for (int j = 1; j < 4; ++j) {
      second[0][i] -= second[j][i];
      second[i][0] -= second[i][j];
      second[0][0] += second[j][i];
    }
  }
  const double volume = sides[0].cross(sides[1]).dot(sides[2]) / 6;
  const double stiffness = tet.stiffness, pressure = stiffness * (volume - double{tet.target});
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      add_block(tet.vertices[i], tet.vertices[j],
                stiffness * gradient[i] * gradient[j].transpose() + pressure * second[i][j],
                triplets);
    }
  }
}

void add_fibre(const VertexTet& tet, const std::vector<Vector3d>& x, Triplets& triplets) {
  const auto [s1, s2, s3] = tet.fibre_shares;
  const std::array<double, 4> shares{-(double{s1} + s2 + s3), s1, s2, s3};
  Vector3d along = Vector3d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    along += shares[k] * x[tet.vertices[k]];
  }
  along.normalize();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      add_block(tet.vertices[i], tet.vertices[j],
                double{tet.fibre_stiffness} * shares[i] * shares[j] * along * along.transpose(),
                triplets);
    }
  }
}

// N/m, the second derivative of the elastic energy at rest, without hinges and limits, which are
// soft where shapes change little. Fibres count as taut.
Sparse stiffness_at_rest(const VertexBlocks& blocks, const std::vector<Vector3d>& x) {
  Triplets triplets;
  for (const VertexTet& tet : blocks.tets()) {
    if (tet.stiffness > 0) {
      add_volume(tet, x, triplets);
    }
    if (tet.fibre_stiffness > 0) {
      add_fibre(tet, x, triplets);
    }
    for (std::size_t e = 0; e < tet.weights.size(); ++e) {
      if (tet.weights[e] != 0) {
        const auto [i, j] = kTetEdges[e];
        add_pair(tet.vertices[i], tet.vertices[j], double{tet.weights[e]} * Matrix3d::Identity(),
                 triplets);
      }
    }
  }
  for (const VertexSpring& spring : blocks.springs()) {
    const auto [a, b] = spring.vertices;
    const Vector3d way = spring.stiffness > 0 ? Vector3d(x[b] - x[a]) : Vector3d::Zero();
    const double length = way.norm();
    if (length > 0) {
      const Vector3d along = way / length;
      const double slack = std::max(0.0, 1 - double{spring.rest} / length);
      add_pair(a, b,
               double{spring.stiffness} *
                   (slack * Matrix3d::Identity() + (1 - slack) * along * along.transpose()),
               triplets);
    }
  }
  const auto size = static_cast<Eigen::Index>(3 * x.size());
  Sparse stiffness(size, size);
  stiffness.setFromTriplets(triplets.begin(), triplets.end());
  return stiffness;
}

// How free vertices follow the numbers of nodes, alike along each axis.
Sparse make_interpolation(const std::vector<CoarseVertex>& vertices, const SolverData& data,
                          Index node_count, int axes) {
  Triplets triplets;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    if (!(data.particles[v].w > 0)) {
      continue;
    }
    const CoarseVertex& vertex = vertices[v];
    for (int i = 0; i < kCoarseNodes; ++i) {
      for (int k = 0; k < 4 && vertex.weights[i] > 0; ++k) {
        const double weight = double{vertex.weights[i]} * (k == 0 ? 1.0F : vertex.place[k - 1]);
        for (int axis = 0; axis < axes; ++axis) {
          triplets.emplace_back(axes * static_cast<Index>(v) + axis,
                                axes * (4 * vertex.nodes[i] + k) + axis, weight);
        }
      }
    }
  }
  Sparse interpolation(static_cast<Eigen::Index>(axes * vertices.size()), axes * 4 * node_count);
  interpolation.setFromTriplets(triplets.begin(), triplets.end());
  return interpolation;
}

// Motions of unit mass along one axis, orthogonal to each other: all that nodes can do but what
// moves next to nothing.
MatrixXd unit_motions(const std::vector<CoarseVertex>& vertices, const SolverData& data,
                      Index node_count) {
  const Sparse interpolation = make_interpolation(vertices, data, node_count, 1);
  Eigen::VectorXd masses(static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const float w = data.particles[v].w;
    masses[static_cast<Eigen::Index>(v)] = w > 0 ? 1 / double{w} : 0;
  }
  const Sparse weighed = masses.asDiagonal() * interpolation;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(
      MatrixXd(Sparse(interpolation.transpose() * weighed)));
  const Eigen::VectorXd& values = solver.eigenvalues();  // ascending
  const double least = kNegligible * values[values.size() - 1];
  const auto kept = std::ranges::count_if(values, [&](double value) { return value > least; });
  return solver.eigenvectors().rightCols(kept) *
         values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

// The same along all three axes.
MatrixXd along_axes(const MatrixXd& motions) {
  MatrixXd all = MatrixXd::Zero(3 * motions.rows(), 3 * motions.cols());
  for (Eigen::Index i = 0; i < motions.rows(); ++i) {
    for (Eigen::Index j = 0; j < motions.cols(); ++j) {
      all.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(motions(i, j));
    }
  }
  return all;
}

}  // namespace

CoarseSpace::CoarseSpace(const SolverData& data) {
  const Graph graph = make_graph(data);
  const std::vector<Index> nodes = choose_nodes(graph, data);
  std::vector<CoarseVertex> vertices(graph.positions.size());
  piece_of_node_ = set_places(graph, nodes, vertices);
  members_.resize(nodes.size());
  if (nodes.empty()) {
    vertices_ = std::move(vertices);
    return;
  }
  piece_count_ = 1 + *std::ranges::max_element(piece_of_node_);
  const std::vector<std::vector<NearNode>> near = find_near_nodes(graph, nodes);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    set_weights(near[v], vertices[v]);
  }
  const MatrixXd motions = along_axes(unit_motions(vertices, data, node_count()));
  const Sparse interpolation = make_interpolation(vertices, data, node_count(), 3);
  const Sparse of_vertices = stiffness_at_rest(data.vertex_blocks, graph.positions);
  const Eigen::VectorXd diagonal = of_vertices.diagonal();
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    vertices[v].stiffness =
        static_cast<float>(diagonal.segment<3>(static_cast<Eigen::Index>(3 * v)).mean());
  }
  for (const CoarseVertex& vertex : vertices) {
    add(vertex);
  }
  const Sparse pulled = of_vertices * interpolation;
  const MatrixXd stiffness(Sparse(interpolation.transpose() * pulled));
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(motions.transpose() * stiffness * motions);
  const auto count =
      std::min<Eigen::Index>(std::max(kLeastModes, kModesOfNode * node_count()), motions.cols());
  const Eigen::MatrixXf modes = (motions * solver.eigenvectors().leftCols(count)).cast<float>();
  for (Eigen::Index m = 0; m < count; ++m) {
    stiffnesses_.push_back(static_cast<float>(std::max(0.0, solver.eigenvalues()[m])));
  }
  modes_.assign(modes.data(), modes.data() + modes.size());
  const Eigen::MatrixXf numbers = modes.transpose();
  numbers_.assign(numbers.data(), numbers.data() + numbers.size());
  first_changed_ = kMostParticles;  // all of this is the start
}

void CoarseSpace::add(std::span<const NewVertex> vertices, std::span<const Index> place_of_vertex) {
  for (const NewVertex& vertex : vertices) {
    const CoarseVertex first = vertices_[place_of_vertex[vertex.first]];
    const CoarseVertex second = vertices_[place_of_vertex[vertex.second]];
    CoarseVertex added = vertex.share < 0.5F ? first : second;
    const bool is_between = first.takes_part() && second.takes_part() &&
                            piece_of(first.nodes[0]) == piece_of(second.nodes[0]);
    for (int k = 0; k < 3 && is_between; ++k) {
      added.place[k] = first.place[k] + vertex.share * (second.place[k] - first.place[k]);
    }
    add(added);
  }
}

void CoarseSpace::add(const CoarseVertex& vertex) {
  const auto place = static_cast<Index>(vertices_.size());
  first_changed_ = std::min(first_changed_, place);
  vertices_.push_back(vertex);
  for (int i = 0; i < kCoarseNodes; ++i) {
    const float weight = vertex.weights[i];
    if (weight > 0) {
      NodeMembers& members = members_[vertex.nodes[i]];
      if (i == 0) {
        members.own.push_back(place);
      }
      members.places.push_back(place);
      members.shares.push_back(
          {weight, weight * vertex.place[0], weight * vertex.place[1], weight * vertex.place[2]});
    }
  }
}

void CoarseSpace::resize(std::size_t place_count) {
  if (place_count != vertices_.size()) {
    first_changed_ = std::min(
        {first_changed_, static_cast<Index>(place_count), static_cast<Index>(vertices_.size())});
  }
  vertices_.resize(place_count);
  for (NodeMembers& members : members_) {
    while (!members.places.empty() && members.places.back() >= static_cast<Index>(place_count)) {
      members.places.pop_back();
      members.shares.pop_back();
    }
    while (!members.own.empty() && members.own.back() >= static_cast<Index>(place_count)) {
      members.own.pop_back();
    }
  }
}

Index CoarseSpace::take_first_changed() noexcept {
  return std::exchange(first_changed_, kMostParticles);
}

void CoarseSpace::reserve(std::size_t more) {
  vertices_.reserve(vertices_.size() + more);
  for (NodeMembers& members : members_) {
    // an edit is near a few nodes, but many are not
    const std::size_t size = members.places.size() + std::min(more, members.places.size());
    members.own.reserve(size);
    members.places.reserve(size);
    members.shares.reserve(size);
  }
}

std::size_t CoarseSpace::memory_bytes() const noexcept {
  std::size_t bytes =
      vertices_.capacity() * sizeof(CoarseVertex) + piece_of_node_.capacity() * sizeof(Index) +
      (stiffnesses_.capacity() + modes_.capacity() + numbers_.capacity()) * sizeof(float);
  for (const NodeMembers& members : members_) {
    bytes += (members.own.capacity() + members.places.capacity()) * sizeof(Index) +
             members.shares.capacity() * sizeof(CoarseShares);
  }
  return bytes;
}

}  // namespace pbdsurg
