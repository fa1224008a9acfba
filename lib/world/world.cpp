// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/world.h"

#include <algorithm>
#include <utility>

#include "pbdsurg/contact/between_jaws.h"
#include "pbdsurg/contact/proximity.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/surgery/membrane.h"

#include "lib/solver/solver_checks.h"
#include "lib/tissue/sheet.h"
#include "lib/world/world_state_data.h"

namespace pbdsurg {
namespace {

[[noreturn]] void throw_no_tool(ToolId tool) {
  throw InvalidArgument("there is no tool " + std::to_string(tool.value) + "; the world has 0");
}

constexpr char kWhereStiff[] = "where a body is stiff";

}  // namespace

template <class AddTo>
BodyId World::Data::add(const std::string& name, const TissueRecord& tissue_of,
                        const AddTo& add_to) {
  check_thermal_properties(tissue_of.heat);
  if (solver == nullptr) {
    const Index body = add_to(scene);
    return bodies.add(name, tissue_of, body);
  }
  if (std::ranges::count(tissue->bodies(), name, &Body::name) > 0) {
    throw InvalidArgument("there is, or was, a body named '" + name + "'; names must differ");
  }
  add_to(new_bodies);
  return bodies.add(name, tissue_of, BodyTable::kWaiting);
}

void World::Data::make_solver() {
  if (solver != nullptr) {
    return;
  }
  auto made = std::make_unique<Tissue>(scene);
  solver = std::make_unique<Solver>(*made, options);
  tissue = std::move(made);
  follow_tissue();
  scene = {};
}

void World::Data::follow_tissue() {
  tissue->add_follower(bodies, FollowerRank::view);
  tissue->add_follower(strands, FollowerRank::surgery);
}

Executor heat_executor(MathMode math, const Executor& stepping) {
  return math == MathMode::strict && stepping && stepping.kind() == ExecutorKind::device
             ? executor::threads()
             : stepping;
}

void World::Data::add_burner(const BurnerSetup& setup) {
  burners.push_back(std::make_unique<Burner>(
      Burner{setup, std::nullopt, Cautery(*tissue, setup.since_record.burnt, setup.options)}));
}

void World::Data::check_is_scene(const char* what) const {
  if (solver != nullptr) {
    throw InvalidArgument(
        std::string(what) +
        " comes before the solver is made, which the first tool, cautery, surface, "
        "look at pieces, record() or step does");
  }
}

// No call that is refused ends the time in which the scene is made.
Solver& World::Data::solver_of(ToolId tool) const {
  if (solver == nullptr) {
    throw_no_tool(tool);
  }
  return *solver;
}

Burner& World::Data::burner(CauteryId cautery) const {
  if (cautery < 0 || cautery >= static_cast<Index>(burners.size())) {
    throw InvalidArgument("there is no cautery " + std::to_string(cautery.value) +
                          "; the world has " + std::to_string(burners.size()));
  }
  return *burners[cautery];
}

const HeatField* World::Data::heat_of(BodyId body) const {
  for (const auto& burner : burners) {
    if (std::ranges::count(burner->setup.bodies, body) > 0) {
      return &burner->cautery.field();
    }
  }
  return nullptr;
}

void World::Data::refresh() {
  for (const auto& [body, surface] : surfaces) {
    surface->refresh(*solver, heat_of(BodyId(body)));
  }
}

World::World(const SolverOptions& options) : data_(std::make_unique<Data>(options)) {}
World::World(const Executor& executor) : World(SolverOptions{.executor = executor}) {}
World::World(const Scene& scene, std::span<const TissueRecord> tissues,
             const ConnectiveTissue& strands, const SolverOptions& options)
    : World(options) {
  Data& data = *data_;
  if (tissues.size() != scene.bodies().size()) {
    throw InvalidArgument("there are " + std::to_string(tissues.size()) + " tissues for " +
                          std::to_string(scene.bodies().size()) + " bodies; one each");
  }
  for (std::size_t b = 0; b < tissues.size(); ++b) {
    check_thermal_properties(tissues[b].heat);
    data.bodies.add(scene.bodies()[b].name, tissues[b], static_cast<Index>(b));
  }
  for (const Strand& strand : strands.strands()) {
    if (strand.first_link + strand.link_count > static_cast<Index>(scene.links().size())) {
      throw InvalidArgument("a strand begins with link " + std::to_string(strand.first_link) +
                            "; the scene has " + std::to_string(scene.links().size()) + " links");
    }
  }
  data.scene = scene;
  data.strands = strands;
  data.make_solver();
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

BodyId World::add_body(const std::string& name, const TetMesh& mesh, const TissueRecord& tissue) {
  return data_->add(name, tissue,
                    [&](Scene& scene) { return scene.add_body(name, mesh, tissue.mechanics); });
}

BodyId World::add_sheet(const std::string& name, std::span<const Eigen::Vector3d> positions,
                        std::span<const Triangle> triangles, float thickness,
                        const TissueRecord& tissue) {
  const SheetMaterial material = sheet_material(tissue.mechanics, thickness);
  return data_->add(name, tissue, [&](Scene& scene) {
    return scene.add_sheet(name, positions, triangles, material);
  });
}

std::span<const Eigen::Vector3d> World::rest_positions_of(BodyId body) const {
  data_->check_is_scene("what is fixed");
  const Body& own = data_->scene.body(data_->bodies.in_tissue(body));
  return data_->scene.positions().subspan(static_cast<std::size_t>(own.first_vertex),
                                          static_cast<std::size_t>(own.vertex_count));
}

std::vector<Eigen::Vector3d> World::rest_centers_of(BodyId body) const {
  data_->check_is_scene(kWhereStiff);
  const Scene& scene = data_->scene;
  const Body& own = scene.body(data_->bodies.in_tissue(body));
  std::vector<Eigen::Vector3d> centers;
  const auto add = [&](const auto& corners) {
    Eigen::Vector3d& center = centers.emplace_back(Eigen::Vector3d::Zero());
    for (const Index v : corners) {
      center += scene.positions()[v] / static_cast<double>(corners.size());
    }
  };
  std::ranges::for_each(scene.tets().subspan(own.first_tet, own.tet_count), add);
  std::ranges::for_each(scene.triangles().subspan(own.first_triangle, own.triangle_count), add);
  return centers;
}

void World::set_stiffnesses(BodyId body, std::span<const float> factors) {
  data_->check_is_scene(kWhereStiff);
  data_->scene.set_stiffnesses(data_->bodies.in_tissue(body), factors);
}

void World::set_fibres(BodyId body, std::span<const Fibre> fibres) {
  data_->check_is_scene("where a body has fibres");
  data_->scene.set_fibres(data_->bodies.in_tissue(body), fibres);
}

void World::fix(BodyId body, std::span<const Index> vertices) {
  data_->check_is_scene("what is fixed");
  data_->scene.fix_vertices(data_->bodies.in_tissue(body), vertices);
}

void World::fix(BodyId body, std::initializer_list<Index> vertices) {
  fix(body, std::span<const Index>(vertices.begin(), vertices.size()));
}

Index World::join(BodyId first, BodyId second, const JoinOptions& options) {
  Data& data = *data_;
  data.check_is_scene("what joins bodies");
  const Index from = data.bodies.in_tissue(first), to = data.bodies.in_tissue(second);
  const std::vector<MembraneLink> links =
      scattered_links(LinkedSurface(data.scene, from), LinkedSurface(data.scene, to),
                      {.max_distance = options.max_distance,
                       .density = options.density,
                       .seed = options.strands.seed});
  data.strands.join(data.scene, from, to, links, options.strands);
  return static_cast<Index>(links.size());
}

Index World::add_hinges(BodyId body, float rigidity) {
  data_->check_is_scene("what stiffens a surface");
  return data_->scene.add_hinges(data_->bodies.in_tissue(body), rigidity);
}

void World::set_gravity(const Eigen::Vector3f& gravity) {
  if (data_->solver == nullptr) {
    data_->scene.set_gravity(gravity);
  } else {
    data_->solver->set_gravity(gravity);
  }
}

void World::set_gravity(BodyId body, const Eigen::Vector3f& gravity) {
  const Index of_tissue = data_->bodies.in_tissue(body);
  check_gravity(gravity);
  data_->make_solver();
  data_->solver->set_gravity(of_tissue, gravity);
}

std::vector<Index> World::vertices_with_tissue(BodyId body) {
  const Index of_tissue = data_->bodies.in_tissue(body);
  data_->make_solver();
  const Tissue& tissue = *data_->tissue;
  std::vector<Index> vertices;
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    if (tissue.body_of_vertex(v) == of_tissue && tissue.has_tissue(v)) {
      vertices.push_back(v);
    }
  }
  return vertices;
}

void World::set_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces) {
  if (data_->solver == nullptr) {
    check_forces(vertices, forces, static_cast<std::size_t>(data_->scene.vertex_count()));
  }
  data_->make_solver();
  data_->solver->set_forces(vertices, forces);
}

void World::add_constraints(std::shared_ptr<CustomConstraints> set) {
  data_->make_solver();
  data_->solver->add_constraints(std::move(set));
}

void World::clear_forces() {
  data_->make_solver();
  data_->solver->clear_forces();
}

void World::remove_body(BodyId body) {
  static_cast<void>(data_->bodies.in_tissue(body));  // throws if it is not there
  data_->make_solver();
  data_->leaving.push_back(body);
}

void World::set_contact(BodyId first, BodyId second, const TissueContact& contact) {
  const Index one = data_->bodies.in_tissue(first), other = data_->bodies.in_tissue(second);
  data_->make_solver();
  data_->solver->set_body_contact(one, other, contact);
}

void World::clear_contact(BodyId first, BodyId second) {
  const Index one = data_->bodies.in_tissue(first), other = data_->bodies.in_tissue(second);
  data_->make_solver();
  data_->solver->clear_body_contact(one, other);
}

ToolId World::add_tool(std::span<const Capsule> capsules, const ToolPose& pose,
                       const ToolSurface& surface, std::span<const ToolJoint> joints) {
  data_->make_solver();
  return data_->solver->add_tool(capsules, pose, surface, joints);
}
ToolId World::add_tool(std::initializer_list<Capsule> capsules, const ToolPose& pose,
                       const ToolSurface& surface, std::span<const ToolJoint> joints) {
  return add_tool(std::span<const Capsule>(capsules.begin(), capsules.size()), pose, surface,
                  joints);
}

void World::remove_tool(ToolId tool) {
  Solver& solver = data_->solver_of(tool);
  for (std::size_t c = 0; c < data_->burners.size(); ++c) {
    if (data_->burners[c]->setup.tool == tool) {
      throw InvalidArgument("tool " + std::to_string(tool.value) + " has cautery " +
                            std::to_string(c) + ", so it cannot be removed");
    }
  }
  solver.remove_tool(tool);
}

void World::couple(ToolId tool, const ToolCoupling& coupling) {
  data_->solver_of(tool).couple_tool(tool, coupling);
}

void World::move(ToolId tool, const ToolPose& pose) {
  data_->solver_of(tool).move_tool(tool, pose);
}

void World::set_joint(ToolId tool, Index joint, float angle) {
  data_->solver_of(tool).set_joint(tool, joint, angle);
}

void World::grasp(ToolId tool, std::span<const Index> vertices, float compliance) {
  data_->solver_of(tool).grasp(tool, vertices, compliance);
}

std::vector<Index> World::grasp_near(ToolId tool, BodyId body, float radius, float compliance) {
  Solver& solver = data_->solver_of(tool);
  std::vector<Index> vertices = find_vertices_near(solver, data_->bodies.in_tissue(body),
                                                   solver.tool_pose(tool).translation(), radius);
  if (!vertices.empty()) {
    solver.grasp(tool, vertices, compliance);
  }
  return vertices;
}

void World::grasp(ToolId tool, std::span<const TissuePoint> points, const Grip& grip) {
  data_->solver_of(tool).grasp(tool, points, grip);
}

std::size_t World::grasp_between(ToolId tool, BodyId body, float opening, const Grip& grip,
                                 float spacing) {
  Solver& solver = data_->solver_of(tool);
  const std::vector<TissuePoint> points =
      find_points_between(solver, data_->bodies.in_tissue(body), tool, grip.pad, opening, spacing);
  if (!points.empty()) {
    solver.grasp(tool, points, grip);
  }
  return points.size();
}

std::size_t World::close_jaws(ToolId tool, std::array<ToolId, 2> jaws, const Grip& grip) {
  return data_->solver_of(tool).close_jaws(tool, jaws, grip);
}

void World::set_clamp_force(ToolId tool, float force) {
  data_->solver_of(tool).set_clamp_force(tool, force);
}

GripReport World::grip(ToolId tool) const {
  return data_->solver_of(tool).tool_grip(tool);
}

void World::release(ToolId tool) {
  data_->solver_of(tool).release(tool);
}

ToolPose World::pose(ToolId tool) const {
  return data_->solver_of(tool).tool_target(tool);
}

float World::joint_angle(ToolId tool, Index joint) const {
  return data_->solver_of(tool).joint_target(tool, joint);
}

Eigen::Vector3f World::force(ToolId tool) const {
  return data_->solver_of(tool).tool_force(tool);
}

CauteryId World::add_cautery(ToolId tool, std::span<const BodyId> bodies,
                             const CauteryOptions& options, const Electrode& electrode) {
  Data& data = *data_;
  static_cast<void>(data.solver_of(tool).tool_target(tool));  // throws if there is no such tool
  if (!electrode.tip.allFinite() || !electrode.heel.allFinite()) {
    throw InvalidArgument("the electrode's ends must be finite");
  }
  std::vector<ThermalBody> burnt;
  for (const BodyId body : bodies) {
    burnt.push_back({data.bodies.in_tissue(body), data.bodies.record(body).heat});
    if (data.heat_of(body) != nullptr) {
      throw InvalidArgument("body '" + data.bodies.name(body) +
                            "' is burnt by another cautery already");
    }
  }
  CauteryOptions wanted = options;
  for (Executor* const executor : {&wanted.heat.executor, &wanted.potential.executor}) {
    *executor = executor->or_else(heat_executor(
        data.options.math, data.options.executor.or_else(data.solver->options().executor)));
  }
  const std::size_t recorded = data.journal != nullptr ? data.journal->edits().size() : 0;
  const std::size_t earlier = data.origin != nullptr ? data.origin->edits_of_scene.size() : 0;
  data.add_burner({tool,
                   {bodies.begin(), bodies.end()},
                   electrode,
                   std::move(wanted),
                   {recorded, burnt},
                   {earlier + recorded, burnt}});
  data.refresh();
  return CauteryId(static_cast<Index>(data.burners.size()) - 1);
}
CauteryId World::add_cautery(ToolId tool, std::initializer_list<BodyId> bodies,
                             const CauteryOptions& options, const Electrode& electrode) {
  return add_cautery(tool, std::span<const BodyId>(bodies.begin(), bodies.size()), options,
                     electrode);
}

void World::energise(CauteryId cautery, const std::optional<GeneratorSettings>& settings) {
  Burner& burner = data_->burner(cautery);
  if (settings) {
    static_cast<void>(Generator(*settings));  // throws for what it cannot do
  }
  burner.settings = settings;
}

void World::sweep(const BladeSweep& blade) {
  for (const BladeEdge& edge : {blade.before, blade.now}) {
    if (!edge.first.allFinite() || !edge.second.allFinite()) {
      throw InvalidArgument("the blade is not finite");
    }
  }
  data_->blades.push_back(blade);
}

void World::edit(const TopologyEdit& edit) {
  data_->make_solver();
  data_->edits.push_back({edit, data_->tissue->version()});
}

void World::undo() {
  if (data_->tissue == nullptr) {
    throw InvalidArgument("there is no edit to undo: the world has not stepped");
  }
  data_->tissue->undo();
  data_->refresh();
}

void World::compact() {
  Data& data = *data_;
  data.make_solver();
  Compaction compaction(*data.solver);
  compaction.build();
  compaction.finish(*data.solver);
  data.refresh();
}

const Surface& World::surface(BodyId body) {
  Data& data = *data_;
  const BodyId of_tissue(data.bodies.in_tissue(body));
  data.make_solver();
  std::unique_ptr<Surface>& surface = data.surfaces[body];
  if (surface == nullptr) {
    surface = std::make_unique<Surface>(*data.solver, of_tissue);
    surface->refresh(*data.solver, data.heat_of(body));
  }
  return *surface;
}

const LivePieces& World::pieces() {
  Data& data = *data_;
  data.make_solver();
  if (data.pieces == nullptr) {
    data.pieces = std::make_unique<LivePieces>(*data.tissue);
  }
  return *data.pieces;
}

BodyId World::find_body(const std::string& name) const {
  return data_->bodies.find(name);
}

Index World::body_in_tissue(BodyId body) const {
  return data_->bodies.in_tissue(body);
}

const TissueRecord& World::tissue_of(BodyId body) const {
  return data_->bodies.record(body);
}

Replica World::replica(ReplicaId id) {
  const Index count = data_->options.copies;
  if (id < 0 || id >= count) {
    throw InvalidArgument("there is no replica " + std::to_string(id.value) + "; the world has " +
                          std::to_string(count));
  }
  data_->make_solver();
  return {*data_->solver, id};
}

Tissue& World::tissue() {
  data_->make_solver();
  return *data_->tissue;
}
Solver& World::solver() {
  data_->make_solver();
  return *data_->solver;
}
ConnectiveTissue& World::strands() {
  return data_->strands;
}
Cautery& World::cautery(CauteryId cautery) {
  return data_->burner(cautery).cautery;
}

}  // namespace pbdsurg
