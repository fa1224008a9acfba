// SPDX-License-Identifier: Apache-2.0
#include "edit/fingerprint.h"

#include <bit>
#include <span>

#include "pbdsurg/core/random.h"

namespace pbdsurg {
namespace {

class Fingerprint {
 public:
  void mix(std::uint64_t value) noexcept { hash_ = detail::mix_bits(hash_, value); }
  void mix(Index value) noexcept { mix(static_cast<std::uint64_t>(value)); }
  void mix(float value) noexcept { mix(std::uint64_t{std::bit_cast<std::uint32_t>(value)}); }

  void mix(const RestLengthChange& change) noexcept { mix_all(change.edge, change.rest_length); }
  void mix(const RestVolumeChange& change) noexcept { mix_all(change.tet, change.rest_volume); }
  void mix(const NewVertex& vertex) noexcept { mix_all(vertex.first, vertex.second, vertex.share); }
  void mix(const CornerMove& move) noexcept { mix_all(move.tet, move.from, move.to); }
  void mix(const LinkMove& move) noexcept { mix_all(move.link, move.from, move.to); }
  void mix(const NewTet& tet) noexcept { mix_all(tet.parent, tet.vertices); }
  void mix(const Link& link) noexcept {
    mix_all(link.first, link.second, link.rest_length, link.stiffness);
  }

  void mix(double value) noexcept { mix(std::bit_cast<std::uint64_t>(value)); }
  void mix(const Tet& tet) noexcept {
    for (const Index v : tet) {
      mix(v);
    }
  }
  void mix(const Eigen::Vector3d& x) noexcept { mix_all(x.x(), x.y(), x.z()); }
  void mix(const Stiffness& stiffness) noexcept {
    mix_all(stiffness.fraction, stiffness.compliance);
  }
  void mix(const Body& body) noexcept {
    for (const char letter : body.name) {
      mix(static_cast<Index>(letter));
    }
    const Material& material = body.material;
    mix_all(static_cast<Index>(material.model), material.density, material.stretch, material.volume,
            Index{material.has_volume_constraints}, material.youngs_modulus,
            material.poissons_ratio, material.damping, material.max_stretch, body.first_vertex,
            body.first_tet);
  }
  void mix(const Scene& scene) noexcept {
    mix_each(scene.bodies());
    mix_each(scene.positions());
    mix_each(scene.masses());
    mix_each(scene.tets());
    mix_each(scene.links());
    for (Index v = 0; v < scene.vertex_count(); ++v) {
      mix(Index{scene.is_fixed(v)});
    }
  }

  template <class Entry>
  void mix(const std::vector<Entry>& entries) noexcept {
    mix_each(std::span(entries));
  }
  template <class Entry>
  void mix_each(std::span<const Entry> entries) noexcept {
    mix(std::uint64_t{entries.size()});
    for (const Entry& entry : entries) {
      mix(entry);
    }
  }

  template <class... Values>
  void mix_all(const Values&... values) noexcept {
    (mix(values), ...);
  }

  [[nodiscard]] std::uint64_t value() const noexcept { return hash_; }

 private:
  std::uint64_t hash_ = 0;
};

}  // namespace

std::uint64_t fingerprint_of(const TopologyEdit& edit, const EditResult& result) noexcept {
  Fingerprint fingerprint;
  fingerprint.mix_all(edit.remove_tets, edit.remove_links, edit.remove_bodies, edit.rest_lengths,
                      edit.rest_volumes, edit.new_vertices, edit.corner_moves, edit.link_moves,
                      edit.new_tets, edit.new_links, edit.new_bodies);
  fingerprint.mix_all(result.tets, result.edges, result.links, result.vertices,
                      result.first_new_vertex, result.first_new_tet, result.first_new_link,
                      result.first_new_edge, result.first_new_body, result.topology_version);
  return fingerprint.value();
}

}  // namespace pbdsurg
