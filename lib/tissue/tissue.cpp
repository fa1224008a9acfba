// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/tissue.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "pbdsurg/mesh/topology.h"

#include "lib/base/check.h"
#include "lib/tissue/edit_checks.h"
#include "lib/tissue/hinges.h"
#include "lib/tissue/new_bodies.h"
#include "lib/tissue/part_tissue.h"
#include "lib/tissue/removal.h"
#include "lib/tissue/sheet.h"
#include "lib/tissue/split_tets.h"
#include "lib/tissue/tissue_data.h"

namespace pbdsurg {
namespace {

std::unique_ptr<TissueData> make_data(const Scene& scene) {
  auto made = std::make_unique<TissueData>();
  TissueData& data = *made;
  data.identity = next_tissue_identity();
  data.gravity = scene.gravity();
  const auto vertex_count = static_cast<std::size_t>(scene.vertex_count());
  data.bodies = UndoArray(std::vector<Body>(scene.bodies().begin(), scene.bodies().end()));
  data.rest_positions =
      UndoArray(std::vector<Eigen::Vector3d>(scene.positions().begin(), scene.positions().end()));
  data.masses = UndoArray(std::vector<double>(scene.masses().begin(), scene.masses().end()));
  std::vector<std::uint8_t> fixed(vertex_count);
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    fixed[v] = scene.is_fixed(v) ? 1 : 0;
  }
  data.fixed = UndoArray(std::move(fixed));
  std::vector<Index> counts(scene.bodies().size(), 0);
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    counts[data.body_of_vertex(v)] += data.masses[v] > 0 ? 1 : 0;
  }
  data.tissue_counts = UndoArray(std::move(counts));

  data.tets = UndoArray(std::vector<Tet>(scene.tets().begin(), scene.tets().end()));
  data.tet_alive = UndoArray(std::vector<std::uint8_t>(scene.tets().size(), 1));
  std::vector<double> tet_masses;
  tet_masses.reserve(scene.tets().size());
  for (const Body& body : scene.bodies()) {
    for (const Tet& tet : scene.tets().subspan(body.first_tet, body.tet_count)) {
      tet_masses.push_back(body.material.density * tet_volume(scene.positions(), tet));
    }
  }
  data.tet_masses = UndoArray(std::move(tet_masses));
  data.stiffnesses =
      UndoArray(std::vector<float>(scene.stiffnesses().begin(), scene.stiffnesses().end()));
  data.fibres = UndoArray(std::vector<Fibre>(scene.fibres().begin(), scene.fibres().end()));
  data.triangles =
      UndoArray(std::vector<Triangle>(scene.triangles().begin(), scene.triangles().end()));
  data.triangle_alive = UndoArray(std::vector<std::uint8_t>(scene.triangles().size(), 1));
  std::vector<double> triangle_masses;
  for (const Body& body : scene.bodies()) {
    for (const Triangle& triangle :
         scene.triangles().subspan(body.first_triangle, body.triangle_count)) {
      triangle_masses.push_back(triangle_mass(body, scene.positions(), triangle));
    }
  }
  data.triangle_masses = UndoArray(std::move(triangle_masses));
  data.triangle_stiffnesses = UndoArray(
      std::vector<float>(scene.triangle_stiffnesses().begin(), scene.triangle_stiffnesses().end()));
  data.links = UndoArray(std::vector<Link>(scene.links().begin(), scene.links().end()));
  data.link_alive = UndoArray(std::vector<std::uint8_t>(scene.links().size(), 1));
  data.hinges = UndoArray(std::vector<Hinge>(scene.hinges().begin(), scene.hinges().end()));
  data.hinge_alive = UndoArray(std::vector<std::uint8_t>(scene.hinges().size(), 1));
  connect(data);
  return made;
}

void clear(TissueChange& change) {
  for (std::vector<Index>* const ids :
       {&change.removed_tets, &change.removed_edges, &change.removed_edge_ends,
        &change.removed_triangles, &change.removed_links, &change.removed_hinges,
        &change.moved_hinges, &change.emptied_vertices, &change.weighed_vertices,
        &change.corner_edges, &change.moved_edges}) {
    ids->clear();
  }
  change.reshaped_tets.clear();
  change.parted_edges.clear();
}

// Makes room for an edit that changes or brings so many, or some thousands of them.
void reserve(TissueChange& change, std::size_t vertices, std::size_t tets, std::size_t edges,
             std::size_t links) {
  const auto make_room = [](std::size_t count, auto&... lists) {
    (lists.reserve(std::min(count, kEntriesOfEdit)), ...);
  };
  TopologyEdit& edit = change.edit;
  make_room(vertices, edit.new_vertices, edit.fix_vertices, edit.unfix_vertices,
            change.emptied_vertices, change.weighed_vertices);
  make_room(tets, edit.remove_tets, edit.corner_moves, edit.new_tets, change.removed_tets,
            change.removed_edge_ends, change.reshaped_tets);
  make_room(edges, change.removed_edges, change.corner_edges, change.moved_edges,
            change.parted_edges);
  make_room(links, edit.remove_links, edit.link_lengths, edit.link_moves, edit.new_links,
            change.removed_links);
}

std::size_t bytes_of(const TissueChange& change) {
  const auto sum = [](const auto&... lists) {
    return (... + (lists.capacity() * sizeof(lists[0])));
  };
  const TopologyEdit& edit = change.edit;
  return sum(edit.remove_tets, edit.remove_triangles, edit.remove_links, edit.remove_bodies,
             edit.rest_lengths, edit.rest_volumes, edit.rest_areas, edit.stiffnesses,
             edit.triangle_stiffnesses, edit.fibres, edit.link_lengths, edit.fix_vertices,
             edit.unfix_vertices, edit.new_vertices, edit.corner_moves, edit.triangle_moves,
             edit.link_moves, edit.new_tets, edit.new_links) +
         sum(change.removed_tets, change.removed_edges, change.removed_edge_ends,
             change.removed_triangles, change.removed_links, change.removed_hinges,
             change.moved_hinges, change.emptied_vertices, change.weighed_vertices,
             change.reshaped_tets, change.corner_edges, change.moved_edges, change.parted_edges);
}

void begin_edit(TissueData& data, const TopologyEdit& edit) {
  data.can_undo = false;
  data.for_each_array([](auto& array) { array.begin_edit(); });
  data.buffer.clear();
  TissueChange& change = data.change;
  clear(change);
  change.edit = edit;
  change.first_new_vertex = data.vertex_count();
  change.first_new_tet = data.tets.size();
  change.first_new_triangle = data.triangles.size();
  change.first_new_link = data.links.size();
  change.first_new_hinge = data.hinges.size();
  change.first_new_edge = data.edges.size();
  change.first_new_body = data.bodies.size();
  change.version_before = data.version;
  change.version = data.last_version + 1;
}

void carry_out(TissueData& data, const TopologyEdit& edit) {
  for (const Index v : edit.fix_vertices) {
    data.fixed.set(v, 1);
  }
  for (const Index v : edit.unfix_vertices) {
    data.fixed.set(v, 0);
  }
  for (const StiffnessChange& change : edit.stiffnesses) {
    data.stiffnesses.set(change.tet, change.factor);
  }
  for (const TriangleStiffnessChange& change : edit.triangle_stiffnesses) {
    data.triangle_stiffnesses.set(change.triangle, change.factor);
  }
  for (const FibreChange& change : edit.fibres) {
    data.fibres.set(change.tet, change.fibre);
  }
  for (const LinkLengthChange& change : edit.link_lengths) {
    Link link = data.links[change.link];
    link.rest_length = change.rest_length;
    data.links.set(change.link, link);
  }
  for (const Index link : edit.remove_links) {
    remove_link(data, link);
  }
  for (const NewVertex& vertex : edit.new_vertices) {
    data.add_vertex(vertex);
  }
  move_links(data, edit);
  for (const Index tet : edit.remove_tets) {
    remove_tet(data, tet);
  }
  for (const Index triangle : edit.remove_triangles) {
    remove_triangle(data, triangle);
  }
  for (const Index body : edit.remove_bodies) {
    remove_body(data, body);
  }
  const PartedHinges parted(data, edit);
  move_corners(data, edit);
  move_triangles(data, edit);
  replace_parents(data, edit);
  parted.settle(data, edit);
  sum_masses(data);
  remove_links_of_emptied(data);
  add_bodies(data, edit.new_bodies);
  for (const Link& link : edit.new_links) {
    data.add_link(link);
  }
  for (Link link : edit.new_bodies.links()) {
    link.first += data.change.first_vertex_of_bodies();
    link.second += data.change.first_vertex_of_bodies();
    data.add_link(link);
  }
  for (Hinge hinge : edit.new_bodies.hinges()) {
    for (Index& v : hinge.vertices) {
      v += data.change.first_vertex_of_bodies();
    }
    data.add_hinge(hinge);
  }
}

}  // namespace

TissueData& tissue_data(Tissue& tissue) noexcept {
  return *tissue.data_;
}
const TissueData& tissue_data(const Tissue& tissue) noexcept {
  return *tissue.data_;
}
std::unique_ptr<Tissue> make_tissue(std::unique_ptr<TissueData> data) {
  return std::unique_ptr<Tissue>(new Tissue(std::move(data)));
}

Tissue::Tissue(const Scene& scene) : data_(make_data(scene)) {}
Tissue::Tissue(std::unique_ptr<TissueData> data) noexcept : data_(std::move(data)) {}
Tissue::~Tissue() = default;

const TissueChange& Tissue::apply(const TopologyEdit& edit) {
  TissueData& data = *data_;
  check_edit(data, edit);
  data.followers->for_each(
      [&](const FollowerList::Entry& entry) { entry.follower->validate(*this, edit); });
  prefetch_removals(data, edit.remove_tets);
  try {
    begin_edit(data, edit);
    carry_out(data, edit);
  } catch (...) {  // memory ran out
    data.for_each_array([](auto& array) { array.undo(); });
    throw;
  }
  data.version = data.last_version = data.change.version;
  data.can_undo = true;
  data.followers->for_each(
      [&](const FollowerList::Entry& entry) { entry.follower->follow(*this, data.change); });
  return data.change;
}

void Tissue::undo() {
  TissueData& data = *data_;
  if (!data.can_undo) {
    throw InvalidArgument(
        "there is no edit to undo: the last one was undone, or a compaction came "
        "after it");
  }
  data.followers->for_each([&](const FollowerList::Entry& entry) {
    if (entry.version >= data.change.version) {
      throw InvalidArgument("a follower came after the last edit, which it cannot undo");
    }
    entry.follower->validate_undo(*this, data.change);
  });
  data.can_undo = false;
  data.for_each_array([](auto& array) { array.undo(); });
  data.version = data.change.version_before;
  data.followers->for_each(
      [&](const FollowerList::Entry& entry) { entry.follower->undo(*this, data.change); });
}

const TissueChange& Tissue::last_change() const noexcept {
  return data_->change;
}

void Tissue::add_follower(Follower& follower, FollowerRank rank) const {
  follower.leave_tissue();
  data_->followers->add({&follower, rank, data_->last_version});
  follower.list_ = data_->followers;
}

void Tissue::check_follower(const Follower& follower, const char* who) const {
  if (follower.list_.lock() != data_->followers) {
    throw InvalidArgument(std::string(who) +
                          " does not follow this tissue: copies do not, nor does what was moved "
                          "from");
  }
}

std::uint64_t Tissue::version() const noexcept {
  return data_->version;
}
TissueVersion Tissue::identified_version() const noexcept {
  return {data_->identity, data_->version};
}

std::span<const Body> Tissue::bodies() const noexcept {
  return data_->bodies.values();
}

const Body& Tissue::body(Index index) const {
  if (index < 0 || index >= data_->bodies.size()) {
    throw InvalidArgument("there is no body " + std::to_string(index) + "; there are " +
                          std::to_string(data_->bodies.size()));
  }
  return data_->bodies[index];
}

bool Tissue::is_body_alive(Index index) const {
  static_cast<void>(body(index));  // throws if there is none
  return data_->tissue_counts[index] > 0;
}

Index Tissue::body_of_vertex(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(data_->vertex_count()));
  return data_->body_of_vertex(vertex);
}

Index Tissue::body_of_tet(Index tet) const {
  check_id("tet", tet, data_->tets.values().size());
  return data_->body_of_tet(tet);
}

Index Tissue::body_of_triangle(Index triangle) const {
  check_id("triangle", triangle, data_->triangles.values().size());
  return data_->body_of_triangle(triangle);
}

Index Tissue::first_later_vertex(Index index) const {
  static_cast<void>(body(index));
  return data_->first_later_vertex(index);
}

Index Tissue::first_later_tet(Index index) const {
  static_cast<void>(body(index));
  return data_->first_later_tet(index);
}

std::vector<Index> Tissue::vertices_of(Index index) const {
  static_cast<void>(body(index));
  std::vector<Index> ids;
  for_each_vertex_of(*data_, index, [&](Index v) { ids.push_back(v); });
  return ids;
}

std::vector<Index> Tissue::tets_of(Index index) const {
  static_cast<void>(body(index));
  std::vector<Index> ids;
  for_each_tet_of(*data_, index, [&](Index t) { ids.push_back(t); });
  return ids;
}

Index Tissue::vertex_count() const noexcept {
  return data_->vertex_count();
}
std::span<const Eigen::Vector3d> Tissue::rest_positions() const noexcept {
  return data_->rest_positions.values();
}
std::span<const double> Tissue::masses() const noexcept {
  return data_->masses.values();
}

bool Tissue::has_tissue(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(data_->vertex_count()));
  return data_->masses[vertex] > 0;
}

bool Tissue::is_fixed(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(data_->vertex_count()));
  return data_->fixed[vertex] != 0;
}

std::span<const Index> Tissue::tets_at(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(data_->vertex_count()));
  return data_->vertex_tets[vertex];
}

std::span<const Index> Tissue::triangles_at(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(data_->vertex_count()));
  return data_->triangles_at(vertex);
}

std::span<const Index> Tissue::links_at(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(data_->vertex_count()));
  return data_->vertex_links[vertex];
}

std::span<const Index> Tissue::hinges_at(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(data_->vertex_count()));
  return data_->hinges_at(vertex);
}

std::span<const Tet> Tissue::tets() const noexcept {
  return data_->tets.values();
}
std::span<const TetEdges> Tissue::tet_edges() const noexcept {
  return data_->tet_edges.values();
}

std::span<const Index, 6> Tissue::tet_edges(Index tet) const {
  check_id("tet", tet, data_->tets.values().size());
  return data_->tet_edges[tet];
}

double Tissue::tet_mass(Index tet) const {
  check_id("tet", tet, data_->tets.values().size());
  return data_->tet_masses[tet];
}

float Tissue::stiffness(Index tet) const {
  check_id("tet", tet, data_->tets.values().size());
  return data_->stiffnesses[tet];
}

const Fibre& Tissue::fibre(Index tet) const {
  check_id("tet", tet, data_->tets.values().size());
  return data_->fibres[tet];
}

std::span<const Triangle> Tissue::triangles() const noexcept {
  return data_->triangles.values();
}

double Tissue::triangle_mass(Index triangle) const {
  check_id("triangle", triangle, data_->triangles.values().size());
  return data_->triangle_masses[triangle];
}

float Tissue::triangle_stiffness(Index triangle) const {
  check_id("triangle", triangle, data_->triangles.values().size());
  return data_->triangle_stiffnesses[triangle];
}

std::span<const Edge> Tissue::edges() const noexcept {
  return data_->edges.values();
}
std::span<const Index> Tissue::edge_tets() const noexcept {
  return data_->edge_tets.values();
}
std::span<const Link> Tissue::links() const noexcept {
  return data_->links.values();
}
std::span<const Hinge> Tissue::hinges() const noexcept {
  return data_->hinges.values();
}

bool Tissue::is_tet_alive(Index tet) const {
  check_id("tet", tet, data_->tets.values().size());
  return data_->tet_alive[tet] != 0;
}

bool Tissue::is_triangle_alive(Index triangle) const {
  check_id("triangle", triangle, data_->triangles.values().size());
  return data_->triangle_alive[triangle] != 0;
}

bool Tissue::is_edge_alive(Index edge) const {
  check_id("edge", edge, data_->edges.values().size());
  return data_->edge_tets[edge] > 0;
}

bool Tissue::is_link_alive(Index link) const {
  check_id("link", link, data_->links.values().size());
  return data_->link_alive[link] != 0;
}

bool Tissue::is_hinge_alive(Index hinge) const {
  check_id("hinge", hinge, data_->hinges.values().size());
  return data_->hinge_alive[hinge] != 0;
}

const Eigen::Vector3f& Tissue::gravity() const noexcept {
  return data_->gravity;
}

void Tissue::reserve(std::size_t vertices, std::size_t tets, std::size_t edges, std::size_t links) {
  TissueData& data = *data_;
  data.rest_positions.reserve(vertices);
  data.fixed.reserve(vertices, vertices);
  data.masses.reserve(vertices, vertices);
  data.later_vertex_bodies.reserve(vertices);
  data.tets.reserve(tets, tets);
  data.tet_edges.reserve(tets, tets);
  data.tet_alive.reserve(tets, tets);
  data.tet_masses.reserve(tets);
  data.stiffnesses.reserve(tets, tets);
  data.fibres.reserve(tets, tets);
  data.later_tet_bodies.reserve(tets);
  data.edges.reserve(edges, edges);
  data.edge_tets.reserve(edges, edges);
  data.links.reserve(links, links);
  data.link_alive.reserve(links, links);
  constexpr std::size_t kTetsAtVertex = 64, kLinksAtVertex = 8;  // room for a list that moves
  data.vertex_tets.reserve(vertices, 4 * kTetsAtVertex * tets, 4 * tets);
  if (data.triangles.size() > 0) {  // which have as many corners after an edit as before
    data.vertex_triangles.reserve(vertices, kTetsAtVertex * vertices, 4 * tets);
  }
  data.vertex_links.reserve(vertices, 2 * kLinksAtVertex * links, 2 * links);
  pbdsurg::reserve(data.change, vertices, tets, edges, links);
  if (data.hinges.size() > 0) {  // which go with tetrahedra
    constexpr std::size_t kHingesAtVertex = 32;
    const std::size_t hinges = kHingesOfTet * tets;
    data.hinge_alive.reserve(0, hinges);
    data.vertex_hinges.reserve(vertices, kHingesAtVertex * vertices, 4 * hinges);
    data.change.removed_hinges.reserve(std::min(hinges, kEntriesOfEdit));
    data.change.moved_hinges.reserve(std::min(hinges, kEntriesOfEdit));
    data.hinges.reserve(0, hinges);
  }
}

std::size_t Tissue::memory_bytes() const noexcept {
  std::size_t bytes = data_->buffer.capacity() * sizeof(Index) + bytes_of(data_->change);
  data_->for_each_array([&](const auto& array) { bytes += array.memory_bytes(); });
  return bytes;
}

}  // namespace pbdsurg
