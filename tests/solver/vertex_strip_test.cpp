// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_strip.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/meshes.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using Face = std::array<Index, 3>;

// Of each vertex, the faces opposite.
std::vector<std::vector<Face>> faces_of(const TetMesh& mesh) {
  std::vector<std::vector<Face>> faces(mesh.positions().size());
  for (const Tet& tet : mesh.tets()) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const auto& opposite = kTetTriangles[corner];
      faces[tet[corner]].push_back({tet[opposite[0]], tet[opposite[1]], tet[opposite[2]]});
    }
  }
  return faces;
}

Face sorted_by_turning(Face face) {
  std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return face;
}

// What a kernel makes of the steps: see StripRow. [face]
std::vector<std::vector<Face>> follow(std::span<const VertexStrip::Step> steps, std::size_t count) {
  std::vector<std::vector<Face>> found(count);
  Face last{kInvalidIndex, kInvalidIndex, kInvalidIndex};
  for (const auto& [corner, face, turns] : steps) {
    last = turns ? Face{last[2], last[1], corner} : Face{last[0], last[2], corner};
    if (face != kInvalidIndex) {
      found[face].push_back(sorted_by_turning(last));
    }
  }
  return found;
}

}  // namespace

// Would catch a face that is left out, is there twice or is turned inside out.
TEST_CASE("vertex strip: its steps end in each face once, the right way round", "[property]") {
  VertexStrip strip;
  const int share = GENERATE(100, 80, 40);  // % of the faces that are there
  std::uint64_t seed = 0;
  for (const std::vector<Face>& all : faces_of(testing::make_box({3, 3, 3}, 1e-3))) {
    std::vector<Face> faces;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (100 * random_unit(7, seed++, i) < share) {
        faces.push_back(all[i]);
      }
    }
    const auto found = follow(strip.find(faces), faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
      CHECK(found[i] == std::vector<Face>{sorted_by_turning(faces[i])});
    }
  }
}

// Would catch strips so short that they save nothing: two steps are lost at the start of each.
TEST_CASE("vertex strip: whole tissue takes one around each vertex", "[property]") {
  VertexStrip strip;
  for (const std::vector<Face>& faces : faces_of(testing::make_box({4, 4, 4}, 1e-3))) {
    CHECK(strip.find(faces).size() == faces.size() + 2);
  }
}

// Would catch strips that do not follow edits: of those that find no room, those that come back,
// and those of vertices that come or move to another lane; and volumes that are not damped where a
// tool or a stiff link has a vertex moved otherwise.
TEST_CASE("vertex strip: fast arithmetic moves tissue as strict does, through edits", "[unit]") {
  Material material = testing::neo_hookean(2e4F, 0.45F);
  material.damping = GENERATE(0.0F, 2e-3F);
  Scene scene = testing::make_bar(material);
  scene.add_particles("bead", std::vector<Eigen::Vector3d>{{0, -0.01, 0}}, 1e-4);
  scene.add_link({20, scene.vertex_count() - 1, 0.01F, {1, 0}});
  const auto make = [&](MathMode math) {
    SolverOptions options = testing::vertex_options(2, 4);
    options.executor = executor::threads(1);
    options.math = math;
    return Solver(scene, options);
  };
  Solver strict = make(MathMode::strict);
  Solver fast = make(MathMode::fast);
  for (Solver* const solver : {&strict, &fast}) {
    solver->grasp(solver->add_tool({}, ToolPose::Identity()), std::array{Index{30}, Index{31}},
                  1e-3F);
  }
  for (std::uint64_t round = 0; round < 12; ++round) {
    TopologyEdit edit;
    if (round % 4 == 2) {
      edit = testing::part_vertex(strict, static_cast<Index>(5 + round), round);
    } else if (round % 4 == 3) {
      edit = testing::split_edge(strict, static_cast<Index>(7 * round), 0.5F);
    } else {
      for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
        if (strict.tissue().is_tet_alive(t) && random_unit(3, round, t) < 0.04) {
          edit.remove_tets.push_back(t);
        }
      }
    }
    for (Solver* const solver : {&strict, &fast}) {
      solver->tissue().apply(edit);
      if (round % 3 == 1) {
        solver->tissue().undo();
      }
      testing::run(*solver, 2, 2e-3F);
    }
    CHECK(testing::farthest(strict, fast) < 1e-6F);
  }
}

}  // namespace pbdsurg
