// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/world.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <map>
#include <utility>

#include "pbdsurg/anatomy/membrane.h"
#include "pbdsurg/contact/proximity.h"
#include "pbdsurg/solver/compaction.h"

#include "world/edit_merge.h"

namespace pbdsurg {
namespace {

// A generator at a tool, and what it burns.
struct Burner {
  ToolId tool;
  std::vector<BodyId> bodies;
  Electrode electrode;  // in the tool's frame
  std::optional<GeneratorSettings> settings;
  Cautery cautery;
};

Electrode placed(const Electrode& electrode, const ToolPose& pose) {
  return {pose * electrode.tip, pose * electrode.heel};
}

class Stopwatch {
 public:
  /// s since the last call, or since it was made
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// What one source asks for.
struct Request {
  EditSource source;
  TopologyEdit edit;
};

}  // namespace

struct World::Data {
  static constexpr const char* kWho = "a world";

  explicit Data(const SolverOptions& wanted) : options(wanted) {}

  // Before the solver is made.
  SolverOptions options;
  Scene scene;
  std::vector<TetMesh> meshes;  // [body]

  std::vector<std::string> names;     // [body id]
  std::vector<TissueRecord> tissues;  // [body id]
  std::vector<Index> bodies;          // [body id] of the tissue; kInvalidIndex: not in it
  ConnectiveTissue strands;
  std::unique_ptr<Tissue> tissue;
  std::unique_ptr<Solver> solver;
  std::vector<ToolPose> poses;  // [tool] as wanted
  std::vector<std::unique_ptr<Burner>> burners;
  std::map<Index, std::unique_ptr<Surface>> surfaces;  // by body id

  // for the next step
  std::vector<TopologyEdit> edits;
  Scene new_bodies;
  std::vector<BladeSweep> blades;

  void make_solver();
  void check_is_scene(const char* what) const;
  [[nodiscard]] Index body_of(BodyId body) const;
  void check_tool(ToolId tool) const;
  [[nodiscard]] Burner& burner(CauteryId cautery) const;
  [[nodiscard]] const HeatField* heat_of(Index body) const;

  std::vector<Request> collect(double dt, Frame& frame);
  void change(const std::vector<Request>& requests, Frame& frame);
  void apply(const TopologyEdit& edit, Frame& frame);
  void refresh();
};

// --- the parts of a frame ------------------------------------------------------------------------

void World::Data::make_solver() {
  if (solver != nullptr) {
    return;
  }
  auto made = std::make_unique<Tissue>(scene);
  solver = std::make_unique<Solver>(*made, options);
  tissue = std::move(made);
  tissue->add_follower(strands, FollowerRank::surgery);
  scene = {};
  meshes.clear();
}

void World::Data::check_is_scene(const char* what) const {
  if (solver != nullptr) {
    throw InvalidArgument(
        std::string(what) +
        " comes before the solver is made, which the first tool, cautery, surface "
        "or step does");
  }
}

Index World::Data::body_of(BodyId body) const {
  if (body < 0 || body >= static_cast<Index>(bodies.size())) {
    throw InvalidArgument("there is no body " + std::to_string(body.value) + "; there are " +
                          std::to_string(bodies.size()));
  }
  if (bodies[body] == kInvalidIndex) {
    throw InvalidArgument("body '" + names[body] +
                          "' is not there: it comes with the next step, or was removed");
  }
  return bodies[body];
}

void World::Data::check_tool(ToolId tool) const {
  if (tool < 0 || tool >= static_cast<Index>(poses.size())) {
    throw InvalidArgument("there is no tool " + std::to_string(tool.value) + "; there are " +
                          std::to_string(poses.size()));
  }
}

Burner& World::Data::burner(CauteryId cautery) const {
  if (cautery < 0 || cautery >= static_cast<Index>(burners.size())) {
    throw InvalidArgument("there is no cautery " + std::to_string(cautery.value) + "; there are " +
                          std::to_string(burners.size()));
  }
  return *burners[cautery];
}

const HeatField* World::Data::heat_of(Index body) const {
  for (const auto& burner : burners) {
    if (std::ranges::count(burner->bodies, BodyId(body)) > 0) {
      return &burner->cautery.field();
    }
  }
  return nullptr;
}

std::vector<Request> World::Data::collect(double dt, Frame& frame) {
  std::vector<Request> requests;
  TopologyEdit named;
  for (const auto& burner : burners) {
    TopologyEdit edit;
    frame.cauteries.push_back(burner->cautery.heat(
        *solver, placed(burner->electrode, poses[burner->tool]), burner->settings, dt, edit));
    merge(named, edit);
    requests.push_back({EditSource::heat, std::move(edit)});
  }
  const std::size_t heat_links = named.remove_links.size();
  strands.find_parting(*solver, blades, named);
  requests.push_back({EditSource::strands, {}});
  requests.back().edit.remove_links.assign(
      named.remove_links.begin() + static_cast<std::ptrdiff_t>(heat_links),
      named.remove_links.end());
  for (TopologyEdit& edit : edits) {
    requests.push_back({EditSource::program, std::move(edit)});
  }
  if (!new_bodies.bodies().empty()) {
    requests.push_back({EditSource::program, {.new_bodies = std::move(new_bodies)}});
  }
  edits.clear();
  blades.clear();
  new_bodies = {};
  std::erase_if(requests, [](const Request& request) { return is_empty(request.edit); });
  return requests;
}

void World::Data::apply(const TopologyEdit& edit, Frame& frame) {
  const TissueChange& change = tissue->apply(edit);
  frame.removed_tets += static_cast<Index>(change.removed_tets.size());
  frame.removed_links += static_cast<Index>(change.removed_links.size());
  for (const Index gone : edit.remove_bodies) {
    std::ranges::replace(bodies, gone, kInvalidIndex);
  }
  for (std::size_t b = 0; b < edit.new_bodies.bodies().size(); ++b) {
    const auto id = std::ranges::find(names, edit.new_bodies.bodies()[b].name) - names.begin();
    bodies[id] = change.first_new_body + static_cast<Index>(b);
  }
}

// One edit where that can be; else one after another, so that a bad request stops no other.
void World::Data::change(const std::vector<Request>& requests, Frame& frame) {
  if (requests.empty()) {
    return;
  }
  const std::size_t events = strands.events().size();
  TopologyEdit merged;
  bool is_whole = true;
  for (const Request& request : requests) {
    is_whole = merge(merged, request.edit) && is_whole;
  }
  bool is_done = false;
  if (is_whole) {
    try {
      apply(merged, frame);
      is_done = true;
    } catch (const InvalidArgument&) {
      is_done = false;  // the sources are told apart below
    }
  }
  bool heat_is_done = is_done;
  for (const Request& request : requests) {
    if (is_done) {
      break;
    }
    try {
      apply(request.edit, frame);
      heat_is_done = heat_is_done || request.source == EditSource::heat;
    } catch (const InvalidArgument& refusal) {
      frame.refused.push_back({request.source, refusal.what()});
    }
  }
  for (std::size_t i = 0; i < burners.size() && heat_is_done; ++i) {
    burners[i]->cautery.commit(frame.cauteries[i]);
  }
  frame.parted_strands = static_cast<Index>(strands.events().size() - events);
}

void World::Data::refresh() {
  for (const auto& [body, surface] : surfaces) {
    surface->refresh(*solver, heat_of(body));
  }
}

// --- the public face -----------------------------------------------------------------------------

const char* name_of(EditSource source) {
  switch (source) {
    case EditSource::heat:
      return "heat";
    case EditSource::strands:
      return "strands";
    case EditSource::program:
      return "program";
  }
  throw InvalidArgument("unknown source of edits");
}

bool Frame::ok() const noexcept {
  return refused.empty() && report.non_finite_vertices == 0;
}

std::string Frame::why() const {
  if (report.non_finite_vertices > 0) {
    return std::to_string(report.non_finite_vertices) + " vertices are not finite, the first is " +
           std::to_string(report.first_non_finite);
  }
  if (!refused.empty()) {
    return std::string("an edit of ") + name_of(refused.front().source) +
           " was refused: " + refused.front().why;
  }
  return {};
}

void Replica::move(ToolId tool, const ToolPose& pose) {
  solver_->move_tool(tool, pose, id_);
}
void Replica::grasp(ToolId tool, std::span<const Index> vertices, float compliance) {
  solver_->grasp(tool, vertices, compliance, id_);
}
void Replica::release(ToolId tool) {
  solver_->release(tool, id_);
}
Eigen::Vector3f Replica::force(ToolId tool) const {
  return solver_->tool_force(tool, id_);
}
std::vector<Eigen::Vector3f> Replica::positions() const {
  return solver_->positions(id_);
}
std::vector<Eigen::Vector3f> Replica::velocities() const {
  return solver_->velocities(id_);
}
StepReport Replica::report() const {
  return solver_->last_report(id_);
}
Snapshot Replica::snapshot() const {
  return solver_->snapshot(id_);
}
void Replica::restore(const Snapshot& snapshot) {
  solver_->restore(snapshot, id_);
}
std::uint64_t Replica::state_hash() const {
  return solver_->state_hash(id_);
}

World::World(const SolverOptions& options) : data_(std::make_unique<Data>(options)) {}
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
    data.names.push_back(scene.bodies()[b].name);
    data.bodies.push_back(static_cast<Index>(b));
  }
  data.tissues.assign(tissues.begin(), tissues.end());
  data.scene = scene;
  data.strands = strands;
  data.make_solver();
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

BodyId World::add_body(const std::string& name, const TetMesh& mesh, const TissueRecord& tissue) {
  Data& data = *data_;
  check_thermal_properties(tissue.heat);
  if (std::ranges::count(data.names, name) > 0) {
    throw InvalidArgument("there is a body named '" + name + "' already; names must differ");
  }
  const bool is_scene = data.solver == nullptr;
  const Index body =
      (is_scene ? data.scene : data.new_bodies).add_body(name, mesh, tissue.mechanics);
  if (is_scene) {
    data.meshes.push_back(mesh);
  }
  data.names.push_back(name);
  data.tissues.push_back(tissue);
  data.bodies.push_back(is_scene ? body : kInvalidIndex);
  return BodyId(static_cast<Index>(data.names.size()) - 1);
}

std::span<const Eigen::Vector3d> World::rest_positions(BodyId body) const {
  data_->check_is_scene("what is fixed");
  const Body& own = data_->scene.body(data_->body_of(body));
  return data_->scene.positions().subspan(static_cast<std::size_t>(own.first_vertex),
                                          static_cast<std::size_t>(own.vertex_count));
}

void World::fix(BodyId body, std::span<const Index> vertices) {
  data_->check_is_scene("what is fixed");
  data_->scene.fix_vertices(data_->body_of(body), vertices);
}

Index World::join(BodyId first, BodyId second, const JoinOptions& options) {
  Data& data = *data_;
  data.check_is_scene("what joins bodies");
  const Index from = data.body_of(first), to = data.body_of(second);
  const std::vector<MembraneLink> links = scattered_links(data.meshes[from], data.meshes[to],
                                                          {.max_distance = options.max_distance,
                                                           .density = options.density,
                                                           .seed = options.strands.seed});
  data.strands.join(data.scene, from, to, links, options.strands);
  // strands of several segments bring a body of particles, which no id stands for
  while (data.meshes.size() < data.scene.bodies().size()) {
    data.meshes.emplace_back();
  }
  return static_cast<Index>(links.size());
}

void World::set_gravity(const Eigen::Vector3f& gravity) {
  data_->check_is_scene("gravity");
  data_->scene.set_gravity(gravity);
}

void World::remove_body(BodyId body) {
  data_->make_solver();
  data_->edits.push_back({.remove_bodies = {data_->body_of(body)}});
}

ToolId World::add_tool(std::span<const Capsule> capsules, const ToolPose& pose) {
  data_->make_solver();
  const Index tool = data_->solver->add_tool(capsules, pose);
  data_->poses.push_back(pose);
  return ToolId(tool);
}

void World::move(ToolId tool, const ToolPose& pose) {
  data_->check_tool(tool);
  data_->solver->move_tool(tool, pose);
  data_->poses[tool] = pose;
}

void World::grasp(ToolId tool, std::span<const Index> vertices, float compliance) {
  data_->check_tool(tool);
  data_->solver->grasp(tool, vertices, compliance);
}

std::vector<Index> World::grasp_near(ToolId tool, BodyId body, float radius, float compliance) {
  data_->check_tool(tool);
  std::vector<Index> vertices = find_vertices_near(*data_->solver, data_->body_of(body),
                                                   data_->poses[tool].translation(), radius);
  if (!vertices.empty()) {
    data_->solver->grasp(tool, vertices, compliance);
  }
  return vertices;
}

void World::release(ToolId tool) {
  data_->check_tool(tool);
  data_->solver->release(tool);
}

ToolPose World::pose(ToolId tool) const {
  data_->check_tool(tool);
  return data_->poses[tool];
}

Eigen::Vector3f World::force(ToolId tool) const {
  data_->check_tool(tool);
  return data_->solver->tool_force(tool);
}

CauteryId World::add_cautery(ToolId tool, std::span<const BodyId> bodies,
                             const CauteryOptions& options, const Electrode& electrode) {
  Data& data = *data_;
  data.make_solver();
  data.check_tool(tool);
  if (!electrode.tip.allFinite() || !electrode.heel.allFinite()) {
    throw InvalidArgument("the electrode's ends must be finite");
  }
  std::vector<ThermalBody> burnt;
  for (const BodyId body : bodies) {
    burnt.push_back({data.body_of(body), data.tissues[body].heat});
    if (data.heat_of(body) != nullptr) {
      throw InvalidArgument("body '" + data.names[body] + "' is burnt by another cautery already");
    }
  }
  data.burners.push_back(std::make_unique<Burner>(Burner{tool,
                                                         {bodies.begin(), bodies.end()},
                                                         electrode,
                                                         std::nullopt,
                                                         Cautery(*data.tissue, burnt, options)}));
  return CauteryId(static_cast<Index>(data.burners.size()) - 1);
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

Frame World::step(double dt) {
  Data& data = *data_;
  data.make_solver();
  data.solver->check_step(static_cast<float>(dt));
  Frame frame;
  Stopwatch watch;
  const std::vector<Request> requests = data.collect(dt, frame);
  frame.times.heat = watch.lap();
  data.change(requests, frame);
  frame.times.edit = watch.lap();
  frame.report = data.solver->step(static_cast<float>(dt));
  frame.times.step = watch.lap();
  data.refresh();
  frame.times.readback = watch.lap();
  return frame;
}

void World::edit(const TopologyEdit& edit) {
  data_->make_solver();
  data_->edits.push_back(edit);
}

void World::undo() {
  data_->make_solver();
  data_->tissue->undo();
  data_->refresh();
}

void World::compact() {
  Data& data = *data_;
  data.make_solver();
  Compaction compaction(*data.solver);
  compaction.build();
  const Renumbering ids = compaction.finish(*data.solver);
  for (Index& body : data.bodies) {
    body = body == kInvalidIndex ? kInvalidIndex : ids.bodies[body];
  }
  data.refresh();
}

const Surface& World::surface(BodyId body) {
  Data& data = *data_;
  data.make_solver();
  const Index of_tissue = data.body_of(body);
  std::unique_ptr<Surface>& surface = data.surfaces[body];
  if (surface == nullptr) {
    surface = std::make_unique<Surface>(*data.solver, BodyId(of_tissue));
    surface->refresh(*data.solver, data.heat_of(body));
  }
  return *surface;
}

BodyId World::find_body(const std::string& name) const {
  const auto found = std::ranges::find(data_->names, name);
  if (found == data_->names.end()) {
    std::string known;
    for (const std::string& each : data_->names) {
      known += (known.empty() ? "'" : ", '") + each + "'";
    }
    throw InvalidArgument("there is no body '" + name + "'; there are " +
                          (known.empty() ? "none" : known));
  }
  return BodyId(static_cast<Index>(found - data_->names.begin()));
}

const TissueRecord& World::tissue_of(BodyId body) const {
  static_cast<void>(data_->body_of(body));
  return data_->tissues[body];
}

Replica World::replica(ReplicaId id) {
  data_->make_solver();
  const Index count = data_->solver->options().copies;
  if (id < 0 || id >= count) {
    throw InvalidArgument("there is no replica " + std::to_string(id.value) + "; there are " +
                          std::to_string(count));
  }
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
