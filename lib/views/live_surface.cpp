// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/live_surface.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/tissue/renumber.h"
#include "lib/tissue/sheet.h"
#include "lib/tissue/tissue_data.h"

namespace pbdsurg {
namespace {

// States of a face that no other shares; one on the surface is kOnSurface - slot.
constexpr Index kGone = -1;  // its tetrahedron is not, or not of the body
constexpr Index kOpen = -2;  // within an edit: neither joined nor on the surface yet
constexpr Index kOnSurface = -3;

}  // namespace

LiveSurface::LiveSurface(const Tissue& tissue, Index body) : body_(body) {
  const bool is_of_sheet = is_sheet(tissue.body(body));  // throws if there is none
  face_count_ = is_of_sheet ? 2 : 4;
  number(tissue);
  const Index own_elements =
      is_of_sheet ? elements_.count : elements_.local(static_cast<Index>(tissue.tets().size()));
  const Index own_vertices = vertices_.local(tissue.vertex_count());
  faces_ =
      UndoArray(std::vector<Index>(static_cast<std::size_t>(face_count_ * own_elements), kGone));
  vertex_triangles_ = UndoArray(std::vector<Index>(static_cast<std::size_t>(own_vertices), 0));
  for (Index face = 0; face < faces_.size(); ++face) {
    const Index element = elements_.scene(face / face_count_);
    if (is_of_sheet ? tissue.is_triangle_alive(element)
                    : tissue.is_tet_alive(element) && tissue.body_of_tet(element) == body) {
      open(face);
    }
  }
  join_open_faces(tissue);
  show_open_faces(tissue);
  // what follows is smaller
  open_ = std::vector<Index>();
  sorted_open_ = std::vector<OpenFace>();
  changes_ = ChangeLog(slot_count());
  version_before_ = version();
  tissue.add_follower(*this, FollowerRank::view);
}

// Where the tissue has what is of the body.
void LiveSurface::number(const Tissue& tissue) {
  constexpr Index kNone = std::numeric_limits<Index>::max();  // edits bring no triangles
  if (body_ == kInvalidIndex) {  // only what edits bring to other bodies
    elements_ = {0, 0, is_two_sided() ? kNone : static_cast<Index>(tissue.tets().size())};
    vertices_ = {0, 0, tissue.vertex_count()};
    return;
  }
  const Body& own = tissue.body(body_);
  elements_ = is_two_sided()
                  ? Numbering{own.first_triangle, own.triangle_count, kNone}
                  : Numbering{own.first_tet, own.tet_count, tissue.first_later_tet(body_)};
  vertices_ = {own.first_vertex, own.vertex_count, tissue.first_later_vertex(body_)};
}

bool LiveSurface::is_on_surface(Index vertex) const {
  check_id("vertex", vertex, static_cast<std::size_t>(vertices_.scene(vertex_triangles_.size())));
  return vertices_.has(vertex) && vertex_triangles_[vertices_.local(vertex)] > 0;
}

void LiveSurface::renumber(const Tissue& tissue, const Renumbering& ids) noexcept {
  const Numbering old_elements = elements_;
  const std::vector<Index>& element_ids = is_two_sided() ? ids.triangles : ids.tets;
  body_ = new_id(body_, ids.bodies);
  number(tissue);
  const auto moved_face = [&](Index face) {  // old to new
    const Index element = element_ids[old_elements.scene(face / face_count_)];
    return face_count_ * elements_.local(element) + face % face_count_;
  };
  std::vector<Index> faces(static_cast<std::size_t>(face_count_ * elements_.count), kGone);
  for (Index face = 0; face < faces_.size(); ++face) {
    const Index state = faces_[face];
    if (state != kGone) {
      faces[moved_face(face)] = state < 0 ? state : moved_face(state);
    }
  }
  faces_ = UndoArray(std::move(faces));

  std::vector<Triangle> triangles(static_cast<std::size_t>(slot_count()), kEmptyTriangle);
  std::vector<TetFace> origins(triangles.size());
  std::vector<Index> vertex_triangles(static_cast<std::size_t>(vertices_.count), 0);
  for (Index slot = 0; slot < slot_count(); ++slot) {
    const auto [tet, face] = origins_[slot];
    if (tet == kInvalidIndex) {
      continue;
    }
    origins[slot] = {element_ids[tet], face};
    triangles[slot] = vertices_of(tissue, face_count_ * elements_.local(element_ids[tet]) + face);
    for (const Index v : triangles[slot]) {
      ++vertex_triangles[vertices_.local(v)];
    }
  }
  triangles_ = UndoArray(std::move(triangles));
  origins_ = UndoArray(std::move(origins));
  vertex_triangles_ = UndoArray(std::move(vertex_triangles));
  changes_.note_all();
  ++renumberings_;
  version_before_ = version();
}

void LiveSurface::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  for (UndoArray<Index>* array : {&faces_, &free_slots_, &vertex_triangles_}) {
    array->begin_edit();
  }
  triangles_.begin_edit();
  origins_.begin_edit();
  version_before_ = version();

  while (vertices_.scene(vertex_triangles_.size()) < tissue.vertex_count()) {
    vertex_triangles_.push_back(0);
  }
  if (is_two_sided()) {
    follow_triangles(change);
  } else {
    follow_tets(tissue, change);
  }
  show_open_faces(tissue);
}

void LiveSurface::follow_triangles(const TissueChange& change) {
  for (const Index triangle : change.removed_triangles) {
    if (is_own(triangle)) {
      remove(triangle);
    }
  }
  for (const TriangleMove& move : change.edit.triangle_moves) {
    if (is_own(move.triangle)) {
      for (Index face = 2 * elements_.local(move.triangle), end = face + 2; face < end; ++face) {
        detach(face);
        open(face);
      }
    }
  }
}

void LiveSurface::follow_tets(const Tissue& tissue, const TissueChange& change) {
  const TopologyEdit& edit = change.edit;
  for (const NewTet& tet : edit.new_tets) {
    const bool own = is_own(tet.parent);
    for (int i = 0; i < 4; ++i) {
      faces_.push_back(kGone);
      if (own) {
        open(faces_.size() - 1);
      }
    }
  }
  while (elements_.scene(faces_.size() / 4) < static_cast<Index>(tissue.tets().size())) {
    for (int i = 0; i < 4; ++i) {
      faces_.push_back(kGone);  // of a body that comes in
    }
  }
  for (const Index tet : change.removed_tets) {
    if (is_own(tet)) {
      remove(tet);
    }
  }
  for (const CornerMove& move : edit.corner_moves) {
    if (is_own(move.tet)) {
      // the face opposite to the corner stays as it is
      const Tet& tet = tissue.tets()[move.tet];
      for (Index i = 0; i < 4; ++i) {
        if (tet[i] != move.to) {
          detach(4 * elements_.local(move.tet) + i);
          open(4 * elements_.local(move.tet) + i);
        }
      }
    }
  }
  // Faces at new vertices, and those of parents that new tetrahedra take over, have their partners
  // among those that this edit opened.
  if (!edit.corner_moves.empty() || !edit.new_tets.empty()) {
    join_open_faces(tissue);
  }
}

void LiveSurface::undo(const Tissue&, const TissueChange&) noexcept {
  changes_.note_again(version_before_);  // readers follow what changes back
  for (UndoArray<Index>* array : {&faces_, &free_slots_, &vertex_triangles_}) {
    array->undo();
  }
  triangles_.undo();
  origins_.undo();
}

bool LiveSurface::is_own(Index element) const noexcept {
  return elements_.has(element) && faces_[face_count_ * elements_.local(element)] != kGone;
}

void LiveSurface::remove(Index element) {
  const Index first = face_count_ * elements_.local(element);
  for (Index face = first; face < first + face_count_; ++face) {
    detach(face);
    faces_.set(face, kGone);
  }
}

Triangle LiveSurface::vertices_of(const Tissue& tissue, Index face) const noexcept {
  const Index element = elements_.scene(face / face_count_);
  if (is_two_sided()) {
    const auto& [a, b, c] = tissue.triangles()[element];
    return face % 2 == 0 ? Triangle{a, b, c} : Triangle{a, c, b};
  }
  const Tet& tet = tissue.tets()[element];
  const auto& [i, j, k] = kTetTriangles[face % 4];
  return {tet[i], tet[j], tet[k]};
}

// Takes a face from its partner or from the surface.
void LiveSurface::detach(Index face) {
  const Index state = faces_[face];
  if (state >= 0) {
    open(state);
  } else if (state <= kOnSurface) {
    hide(kOnSurface - state);
  }
}

void LiveSurface::open(Index face) {
  if (faces_[face] != kOpen) {
    faces_.set(face, kOpen);
    open_.push_back(face);
  }
}

// Makes partners of open faces with the same vertices; those of sheets have none.
void LiveSurface::join_open_faces(const Tissue& tissue) {
  if (is_two_sided()) {
    return;
  }
  sorted_open_.clear();
  for (const Index face : open_) {
    if (faces_[face] == kOpen) {
      Triangle key = vertices_of(tissue, face);
      std::sort(key.begin(), key.end());
      sorted_open_.push_back({key, face});
    }
  }
  std::sort(sorted_open_.begin(), sorted_open_.end(), [](const OpenFace& a, const OpenFace& b) {
    return a.key != b.key ? a.key < b.key : a.face < b.face;
  });
  for (std::size_t i = 1; i < sorted_open_.size(); ++i) {
    const OpenFace& face = sorted_open_[i];
    const OpenFace& last = sorted_open_[i - 1];
    if (face.key == last.key) {
      faces_.set(face.face, last.face);
      faces_.set(last.face, face.face);
    }
  }
}

// Puts what is still open onto the surface.
void LiveSurface::show_open_faces(const Tissue& tissue) {
  for (const Index face : open_) {
    if (faces_[face] != kOpen) {
      continue;
    }
    const Triangle triangle = vertices_of(tissue, face);
    const TetFace origin{elements_.scene(face / face_count_), face % face_count_};
    Index slot = slot_count();
    if (free_slots_.size() > 0) {
      slot = free_slots_[free_slots_.size() - 1];
      free_slots_.pop_back();
      triangles_.set(slot, triangle);
      origins_.set(slot, origin);
    } else {
      triangles_.push_back(triangle);
      origins_.push_back(origin);
    }
    faces_.set(face, kOnSurface - slot);
    for (const Index v : triangle) {
      vertex_triangles_.set(vertices_.local(v), vertex_triangles_[vertices_.local(v)] + 1);
    }
    changes_.note(slot);
  }
  open_.clear();
}

void LiveSurface::hide(Index slot) {
  for (const Index v : triangles_[slot]) {
    vertex_triangles_.set(vertices_.local(v), vertex_triangles_[vertices_.local(v)] - 1);
  }
  triangles_.set(slot, kEmptyTriangle);
  origins_.set(slot, {});
  free_slots_.push_back(slot);
  changes_.note(slot);
}

std::shared_ptr<const LiveSurface> shared_surface(const Tissue& tissue, Index body) {
  static_cast<void>(tissue.body(body));  // throws if there is none
  std::shared_ptr<const LiveSurface> found;
  tissue_data(tissue).followers->for_each([&](const FollowerList::Entry& entry) {
    const auto* surface = dynamic_cast<const LiveSurface*>(entry.follower);
    if (found == nullptr && surface != nullptr && surface->body() == body) {
      found = surface->weak_from_this().lock();
    }
  });
  return found != nullptr ? found : std::make_shared<LiveSurface>(tissue, body);
}

}  // namespace pbdsurg
