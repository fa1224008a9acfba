// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/generator.h"
#include "pbdsurg/tissue/library.h"

#include "tests/regression/programs.h"
#include "tests/support/meshes.h"
#include "tests/support/slabs.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {
namespace {

// A way of solving, and what the slabs are made of.
struct Way {
  const char* name;
  SolverOptions options;
  Material material = kSprings;
  CauteryOptions burning{.link_energy = 0.05};
};

Material soft_tissue() {
  return elastic_material(make_box({6, 6, 2}, kSlabEdge), 1000, 20e3);
}

Way make_way(const char* name, PlanComposition composition) {
  return {name, plain_options(composition), soft_tissue()};
}

std::vector<Way> make_ways() {
  std::vector<Way> ways;
  ways.push_back(make_way("separate", PlanComposition::separate));
  ways.push_back(make_way("joint", PlanComposition::joint));
  ways.push_back(make_way("overflow", PlanComposition::separate));
  ways.back().options.coloring = {.max_colors = 6};
  ways.push_back(make_way("fraction", PlanComposition::separate));
  ways.back().options.mode = ProjectionMode::fraction;
  ways.back().material = kSprings;
  ways.push_back(make_way("neo-hookean", PlanComposition::separate));
  ways.back().material = {
      .model = ElasticModel::neo_hookean, .damping = 1e-3F, .max_stretch = 1.2F};
  ways.push_back(make_way("vertex-block", PlanComposition::separate));
  ways.back().options.method = SolverMethod::vertex_block;
  ways.back().material.damping = 1e-3F;
  ways.back().material.max_stretch = 1.2F;
  ways.push_back(make_way("vertex-block-neo-hookean", PlanComposition::separate));
  ways.back().options.method = SolverMethod::vertex_block;
  ways.back().material = {.model = ElasticModel::neo_hookean};
  ways.push_back(make_way("copies", PlanComposition::joint));
  ways.back().options.copies = 2;
  return ways;
}

void follow_slabs(Driver& driver, const Slabs& slabs) {
  driver.follow_strands(slabs.strands);
  driver.follow_surface(0);
  driver.follow_surface(1);
  driver.follow_pieces();
}

// Some tetrahedra and links, at random.
TopologyEdit random_removal(const Solver& solver, Index round) {
  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    if (solver.tissue().is_tet_alive(t) && random_unit(5, t, round) < 0.02) {
      edit.remove_tets.push_back(t);
    }
  }
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    if (solver.tissue().is_link_alive(l) && random_unit(6, l, round) < 0.02) {
      edit.remove_links.push_back(l);
    }
  }
  return edit;
}

TopologyEdit with_guest(Index round) {
  Scene guest;
  guest.add_body("guest " + std::to_string(round), make_box({2, 2, 2}, kSlabEdge), soft_tissue());
  return {.new_bodies = guest};
}

// A grasper that lifts a corner of the upper slab, in each copy a little more.
class Lift {
 public:
  explicit Lift(Driver& driver) : driver_(driver) {
    Solver& solver = driver_.solver();
    tool_ = solver.add_tool({}, ToolPose::Identity());
    const Index corner =
        solver.tissue().body(1).first_vertex + solver.tissue().body(1).vertex_count - 1;
    for (Index copy = 0; copy < solver.options().copies; ++copy) {
      solver.grasp(tool_, std::array{corner, corner - 1}, 1e-4F, copy);
    }
  }
  void raise(Index round) {
    Solver& solver = driver_.solver();
    for (Index copy = 0; copy < solver.options().copies; ++copy) {
      ToolPose pose = ToolPose::Identity();
      pose.translation().z() = 2e-4F * static_cast<float>((round + 1) * (copy + 1));
      solver.move_tool(tool_, pose, copy);
    }
  }

 private:
  Driver& driver_;
  ToolId tool_;
};

// Cuts of both styles, strands that blades and tension part, removals, crumbs, a body that comes
// and goes; every few of these taken back, and compaction.
void run_cuts(const Way& way, const Executor& executor, Record& record) {
  const Slabs slabs(way.material);
  Driver driver(slabs.scene, way.options, executor);
  const std::array bodies{ThermalBody{0, tissues::fat().heat},
                          ThermalBody{1, tissues::liver().heat}};
  driver.follow_heat(bodies);
  follow_slabs(driver, slabs);
  Lift lift(driver);
  for (Index round = 0; round < 12; ++round) {
    lift.raise(round);
    const CutStyle style = round % 3 == 2 ? CutStyle::along_faces : CutStyle::through_tets;
    driver.cut(random_cut(1, round), style);
    if (round % 4 == 3) {
      driver.undo();
      driver.cut(random_cut(2, round), style);
    }
    const float x = 1e-3F * static_cast<float>(round);
    const BladeSweep blade{{{x, 0, 5e-3F}, {x, 4e-3F, 5e-3F}},
                           {{x, 0, 6e-3F}, {x + 1e-3F, 4e-3F, 6e-3F}}};
    driver.tear({&blade, 1});
    driver.edit_without_crumbs(random_removal(driver.solver(), round), 6);
    if (round % 2 == 1) {
      driver.undo();
    }
    if (round == 3) {
      driver.edit(with_guest(round));
    } else if (round == 8) {
      driver.edit(
          {.remove_bodies = {static_cast<Index>(driver.solver().tissue().bodies().size()) - 1}});
    }
    driver.step(kSlabTimeStep);
    if (round % 4 == 3) {
      driver.look(record, round + 1);
      driver.compact();
    }
  }
  driver.step(kSlabTimeStep);
  driver.look(record, 13);
}

// One blade that goes on from step to step, wherever the tissue has moved.
void run_blade(const Way& way, CutStyle style, const Executor& executor, Record& record) {
  const Slabs slabs(way.material);
  Driver driver(slabs.scene, way.options, executor);
  follow_slabs(driver, slabs);
  BladeEdge before{{-1e-3F, 5e-3F, 12e-3F}, {-1e-3F, 6e-3F, 6e-3F}};
  for (Index round = 0; round < 12; ++round) {
    BladeEdge now = before;
    for (Eigen::Vector3f* end : {&now.first, &now.second}) {
      *end += Eigen::Vector3f(0.9e-3F, 1e-4F * static_cast<float>(round % 3), -1e-4F);
    }
    driver.cut(sweep_blade(std::array{before, now}), style);
    driver.step(kSlabTimeStep);
    before = now;
    if (round % 6 == 5) {
      driver.look(record, round + 1);
    }
  }
}

// A hook that lies on the lower slab, among the strands, askew; and cuts, undo and compaction.
void run_burns(const Way& way, double power, const Executor& executor, Record& record) {
  const Slabs slabs(way.material);
  Driver driver(slabs.scene, way.options, executor);
  const std::array bodies{ThermalBody{0, tissues::fat().heat},
                          ThermalBody{1, tissues::liver().heat}};
  driver.switch_on_cautery(bodies, way.burning);
  follow_slabs(driver, slabs);
  for (Index round = 0; round < 8; ++round) {
    const float x = 6e-3F + 2e-4F * static_cast<float>(round);
    const Electrode electrode{{x, 3.7e-3F, 4.2e-3F}, {x + 0.3e-3F, 7.6e-3F, 4.25e-3F}};
    const GeneratorSettings generator =
        round % 3 == 2 ? coagulate_settings(power) : cut_settings(power);
    bool has_edit = false;
    for (int i = 0; i < 6; ++i) {
      has_edit = driver.burn(electrode, generator, 20e-3);
    }
    if (has_edit && round % 2 == 0) {
      driver.undo();
    }
    driver.tear();
    if (round == 2 || round == 5) {
      driver.cut(random_cut(3, round), CutStyle::through_tets);
      driver.undo();
      driver.cut(random_cut(4, round), CutStyle::through_tets);
    }
    driver.burn(electrode, std::nullopt, 50e-3);
    driver.step(kSlabTimeStep);
    if (round % 4 == 3) {
      driver.look(record, round + 1);
      driver.compact();
    }
  }
  driver.step(kSlabTimeStep);
  driver.look(record, 9);
}

// A hollow box whose lumen is filled, loses of its wall, is pricked, closed again and compacted.
void run_lumen(const Way& way, const Executor& executor, Record& record) {
  Scene scene;
  scene.add_body("box", make_box({5, 5, 5}, kSlabEdge), way.material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kSlabEdge; });
  Driver driver(scene, way.options, executor);
  const auto take = [&](double first, double last) {  // cubes along x, in the middle of the box
    TopologyEdit edit;
    const Tissue& tissue = driver.solver().tissue();
    for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
      Eigen::Vector3d x = Eigen::Vector3d::Zero();
      for (const Index v : tissue.tets()[t]) {
        x += tissue.rest_positions()[v] / (4 * kSlabEdge);
      }
      const bool is_in = x.x() > first && x.x() < last && std::abs(x.y() - 2.5) < 0.5 &&
                         std::abs(x.z() - 2.5) < 0.5;
      if (is_in && tissue.is_tet_alive(t)) {
        edit.remove_tets.push_back(t);
      }
    }
    driver.edit(edit);
  };
  const auto go_on = [&](int checkpoint) {
    for (int step = 0; step < 3; ++step) {
      driver.step(kSlabTimeStep);
    }
    driver.look(record, checkpoint);
  };
  take(2, 3);
  driver.fill_lumen(0);
  go_on(0);
  take(3, 4);
  go_on(1);
  take(4, 5);
  go_on(2);
  driver.undo();
  go_on(3);
  driver.compact();
  go_on(4);
}

}  // namespace

std::vector<Program> surgery_programs() {
  std::vector<Program> programs;
  for (const Way& way : make_ways()) {
    const std::string name = way.name;
    programs.push_back({"cuts-" + name, [way](const Executor& executor, Record& record) {
                          run_cuts(way, executor, record);
                        }});
    programs.push_back({"burns-" + name, [way](const Executor& executor, Record& record) {
                          run_burns(way, 150, executor, record);
                        }});
    programs.push_back({"blade-through-" + name, [way](const Executor& executor, Record& record) {
                          run_blade(way, CutStyle::through_tets, executor, record);
                        }});
    programs.push_back({"lumen-" + name, [way](const Executor& executor, Record& record) {
                          run_lumen(way, executor, record);
                        }});
  }
  Way way = make_way("along", PlanComposition::separate);
  programs.push_back({"blade-along-separate", [way](const Executor& executor, Record& record) {
                        run_blade(way, CutStyle::along_faces, executor, record);
                      }});
  way.burning.model = ThermalModel::paper();
  way.burning.electrode_cooling = 0;
  programs.push_back({"burns-paper", [way](const Executor& executor, Record& record) {
                        run_burns(way, 30, executor, record);
                      }});
  way.burning = {.contact_radius = 3e-3, .link_energy = 0.05};
  way.burning.model.has_perfusion = true;
  way.burning.model.surface_transfer = 20;
  programs.push_back({"burns-wide", [way](const Executor& executor, Record& record) {
                        run_burns(way, 300, executor, record);
                      }});
  way.burning = {.contact_radius = 0.3e-3, .link_energy = 0.05};  // finer than the mesh, and fast
  programs.push_back({"burns-point", [way](const Executor& executor, Record& record) {
                        run_burns(way, 60, executor, record);
                      }});
  return programs;
}

}  // namespace pbdsurg::testing
