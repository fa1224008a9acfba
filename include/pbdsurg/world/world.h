// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The owner of a simulation: tissue, solver, heat, strands, tools, and the order of a frame.

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/world/surface.h"
#include "pbdsurg/world/world_state.h"

namespace pbdsurg {

/// How two bodies are joined.
struct JoinOptions {
  double max_distance = 3.5e-3;  ///< m between the surfaces; positive
  double density = 0.5e6;        ///< fibres per m^2 of the first surface, positive
  StrandOptions strands{};       ///< what strands are made of
};

/// Who asks for a change of topology in a frame, in the order in which they are asked.
enum class EditSource : std::uint8_t { heat, strands, program };

/// "heat", "strands", "program"
[[nodiscard]] PBDSURG_API const char* name_of(EditSource source);

/// What one source asked for, and why it was refused. Nothing of it was done.
struct RefusedEdit {
  EditSource source;  ///< who asked
  std::string why;    ///< the message of the refusal
};

/// What happened in a step of a world.
struct Frame {
  StepReport report;                     ///< of the solver, all replicas
  std::vector<CauteryReport> cauteries;  ///< [cautery]
  Index removed_tets = 0,                ///< by all edits of the step
      removed_triangles = 0,             ///< of sheets, likewise
      removed_links = 0;                 ///< likewise
  Index parted_strands = 0;              ///< for any cause: ConnectiveTissue::events()
  std::vector<ToolId> lost_grips;        ///< tools whose jaws slipped off or tore tissue: grip()
  std::vector<RefusedEdit> refused;      ///< in the order in which they were asked
  /// s of the processor's clock. The only part of a frame that differs from run to run.
  struct Times {
    double heat = 0,   ///< heat, and what it, strands and the program ask for
        edit = 0,      ///< edits with their followers
        step = 0,      ///< the solver's step
        readback = 0;  ///< surfaces
  } times;             ///< of this step

  /// Whether positions are finite, nothing was refused and the solver took the step.
  [[nodiscard]] PBDSURG_API bool ok() const noexcept;
  /// What is not, in one sentence; empty if all is.
  [[nodiscard]] PBDSURG_API std::string why() const;
};

/// One of the copies of a world that are stepped together. Valid as long as the world is, and stays
/// where it is.
class PBDSURG_API Replica {
 public:
  /// World::replica() makes these.
  Replica(Solver& solver, ReplicaId id) noexcept : solver_(&solver), id_(id) {}

  /// As Solver::move_tool().
  void move(ToolId tool, const ToolPose& pose);
  /// As Solver::set_joint().
  void set_joint(ToolId tool, Index joint, float angle);
  /// As Solver::grasp().
  void grasp(ToolId tool, std::span<const Index> vertices, float compliance = 0);
  /// As Solver::grasp() by jaws that press with a force.
  void grasp(ToolId tool, std::span<const TissuePoint> points, const Grip& grip);
  /// As Solver::close_jaws().
  std::size_t close_jaws(ToolId tool, std::array<ToolId, 2> jaws, const Grip& grip);
  /// As Solver::set_clamp_force().
  void set_clamp_force(ToolId tool, float force);
  /// As Solver::tool_grip().
  [[nodiscard]] GripReport grip(ToolId tool) const;
  /// As Solver::release().
  void release(ToolId tool);
  /// As Solver::set_forces().
  void set_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces);
  /// As Solver::clear_forces().
  void clear_forces();
  /// As Solver::set_factors(): World::save() keeps them.
  void set_factors(const CopyFactors& factors);
  /// As set.
  [[nodiscard]] CopyFactors factors() const;
  /// N, of the tissue on the tool, in the last step.
  [[nodiscard]] Eigen::Vector3f force(ToolId tool) const;
  /// [vertex_count] m
  [[nodiscard]] std::vector<Eigen::Vector3f> positions() const;
  /// [vertex_count] m/s
  [[nodiscard]] std::vector<Eigen::Vector3f> velocities() const;
  /// Of the last step.
  [[nodiscard]] StepReport report() const;
  /// As Solver::snapshot().
  [[nodiscard]] Snapshot snapshot() const;
  /// As Solver::restore().
  void restore(const Snapshot& snapshot);
  /// As Solver::state_hash().
  [[nodiscard]] std::uint64_t state_hash() const;

 private:
  Solver* solver_;
  ReplicaId id_;
};

/// A whole simulation. Bodies, what is fixed and what is joined come first; the first call of any
/// other function makes a solver of them. From then on bodies still come and go.
///
///     World world;
///     const BodyId liver = world.add_body("liver", mesh, tissues::liver());
///     world.fix(liver, [](const Eigen::Vector3d& x) { return x.z() > 0.05; });
///     const ToolId hook = world.add_tool(capsules);
///     const CauteryId burner = world.add_cautery(hook, {liver});
///     const Surface& skin = world.surface(liver);
///     for (;;) {
///       world.move(hook, pose);
///       world.energise(burner, pedal ? cut_settings(30) : off_settings());
///       const Frame frame = world.step(5e-3);
///       draw(skin.positions(), skin.triangles(), skin.normals(), skin.marks());
///     }
///
/// A step does this, in this order:
///   1. instruments travel to where move() wants them, over the substeps of 5;
///   2. cauteries drive current and let heat spread, in the order in which they were added;
///   3. what heat removes and shrinks, what strands tear or blades cut of them, and what edit(),
///      remove_body() and add_body() asked for become one edit, checked as one, in which each
///      source sees what those before it named. If it is refused, each is tried by itself, in this
///      order, and what is still refused is reported in the Frame;
///   4. the tissue changes, then each of its followers, once;
///   5. the solver steps: contacts, substeps, forces on tools;
///   6. surfaces that were asked for are read back.
///
/// The parts are public: tissue(), solver(), strands(), cautery(). Deterministic: the same calls
/// give the same bits, for any number of threads. Not thread-safe. Can be moved; what was moved
/// from refuses all but destruction and assignment.
class PBDSURG_API World {
 public:
  /// Without bodies.
  /// @throws InvalidArgument, BackendUnavailable  as Solver; at the latest when the solver is made
  /// @param options  their executor does the work of all parts
  explicit World(const SolverOptions& options = {});
  /// Without bodies, and with all other options at their defaults.
  explicit World(const Executor& executor);

  /// Of a scene that is whole, with bodies and strands of a program's own making.
  /// @param tissues  [body_count of the scene] what is burnt and drawn; mechanics are the scene's
  /// @param strands  that were joined in that scene
  /// @throws InvalidArgument  as above, or if there is not one tissue a body
  World(const Scene& scene, std::span<const TissueRecord> tissues,
        const ConnectiveTissue& strands = {}, const SolverOptions& options = {});

  /// As another world was when it was saved, with the ids that it had; it goes on as that did from
  /// there: see save(). Surfaces and pieces are asked for anew. It is recorded on from the same
  /// beginning; the last edit before cannot be taken back. That other world need not be there any
  /// more.
  ///
  /// Cost: that of copying tissue and constraints, and of the edits since record(): 53 ms for
  /// 73,370 tetrahedra in vertex blocks, and 56 ms for 1,000 edits of a cautery, on a core of a
  /// Xeon.
  /// @throws InvalidArgument     if the state is of no world, or of one whose positions, velocities
  ///                             or heat were not finite: see Frame::ok()
  /// @throws BackendUnavailable  if a device does not take another solver
  /// @throws Error               if a device fails
  explicit World(const WorldState& state);
  ~World();
  /// Takes over. The other can then only be destroyed or assigned to.
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;  ///< likewise

  /// @name The scene
  /// What is fixed, joined and stiffened comes before the solver is made. These
  /// functions throw InvalidArgument if it is, or if there is no such body, and as Scene and
  /// ConnectiveTissue.
  /// @{

  /// Adds a body at rest, of one tissue. Once there is a solver, it comes in with the next step;
  /// until then other functions refuse it.
  /// @throws InvalidArgument  as Scene::add_body(), naming the value out of range
  BodyId add_body(const std::string& name, const TetMesh& mesh, const TissueRecord& tissue);

  /// Adds a sheet of one tissue likewise: the peritoneum, the wall of a duct. It has no heat, and
  /// join() takes none: links of a Scene or of an edit() join it.
  /// @param positions  [n] m
  /// @param triangles  ids in [0, n)
  /// @param thickness  m
  /// @throws InvalidArgument  as Scene::add_sheet(), or if the tissue's mechanics are springs
  BodyId add_sheet(const std::string& name, std::span<const Eigen::Vector3d> positions,
                   std::span<const Triangle> triangles, float thickness,
                   const TissueRecord& tissue);

  /// Holds vertices of a body where they are, until an edit() lets them go.
  /// @param vertices  [n] ids within the body
  void fix(BodyId body, std::span<const Index> vertices);
  /// Likewise.
  void fix(BodyId body, std::initializer_list<Index> vertices);
  /// Likewise, where a condition holds.
  /// @param condition  bool(const Eigen::Vector3d& position), position at rest in m
  /// @return           how many vertices were fixed
  template <std::predicate<const Eigen::Vector3d&> Condition>
  Index fix(BodyId body, Condition condition);

  /// Scatters strands over the first body's surface where it faces the second's; they tear, are cut
  /// and burn. Both sides of a sheet are one surface.
  /// @return  how many there are
  Index join(BodyId first, BodyId second, const JoinOptions& options = {});

  /// Gives the body's surface the bending stiffness of a plate, a capsule or serosa: see
  /// Scene::add_hinges(). Bodies that come later bring theirs by edit().
  /// @param rigidity  N m, flexural_rigidity() of constraints/bending.h
  /// @return          how many hinges that takes
  Index add_hinges(BodyId body, float rigidity);

  /// Makes a body stiffer in some places than in others: see Scene::set_stiffnesses(). Edits change
  /// that later.
  /// @param factors  [tet_count of the body, or triangle_count of the sheet] how many times as
  ///                 stiff as its tissue
  void set_stiffnesses(BodyId body, std::span<const float> factors);
  /// Likewise.
  /// @param field  float(const Eigen::Vector3d& center), of each tetrahedron or triangle at rest,
  ///               in m
  template <std::invocable<const Eigen::Vector3d&> Field>
  void set_stiffnesses(BodyId body, Field field);

  /// Gives a body fibres: see Scene::set_fibres(). Edits change them later.
  /// @param fibres  [tet_count of the body]
  void set_fibres(BodyId body, std::span<const Fibre> fibres);
  /// Likewise.
  /// @param field  Fibre(const Eigen::Vector3d& center), of each tetrahedron at rest, in m
  template <std::invocable<const Eigen::Vector3d&> Field>
  void set_fibres(BodyId body, Field field);

  /// Gravity of all bodies, in the steps to come as well. Default: earth's, downwards along y.
  /// @param gravity  m/s^2, finite
  void set_gravity(const Eigen::Vector3f& gravity);
  /// Of one body, likewise, until that of all is set. Makes the solver.
  void set_gravity(BodyId body, const Eigen::Vector3f& gravity);

  /// Takes a body out, with all its tissue, in the next step.
  void remove_body(BodyId body);

  /// @}

  /// @name Forces
  /// What acts from outside, in every substep until it is replaced; see Solver::set_forces(). These
  /// functions make the solver, and throw InvalidArgument as that, and naming the body that there
  /// is not; then nothing is set.
  /// @{

  /// As Solver::set_forces().
  /// @param vertices  [n] ids in the tissue
  /// @param forces    [n] N
  void set_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces);
  /// A field of force on a body, as it is now: each of its vertices that has tissue gets a force.
  /// @param field  Eigen::Vector3f(Index vertex, const Eigen::Vector3f& position), N of m; vertex
  /// in
  ///               the tissue, whose masses() it may multiply by
  template <std::invocable<Index, const Eigen::Vector3f&> Field>
  void set_forces(BodyId body, Field field);
  /// Takes all forces away.
  void clear_forces();

  /// @}

  /// As Solver::add_constraints(), at any time. A world that is made of a saved one has none: what
  /// a program added it adds again, and saves itself. Where a callback throws, step() throws that:
  /// the solver is as before the frame; heat, and what was asked of the frame, are done. Makes the
  /// solver.
  void add_constraints(std::shared_ptr<CustomConstraints> set);

  /// @name Contact
  /// These functions make the solver, and throw InvalidArgument and BackendUnavailable as those of
  /// Solver, and naming the body that there is not.
  /// @{

  /// Lets two bodies, or the parts of one, meet each other from the next step on: see
  /// Solver::set_body_contact(). World::save() keeps it.
  void set_contact(BodyId first, BodyId second, const TissueContact& contact);
  /// As Solver::clear_body_contact().
  void clear_contact(BodyId first, BodyId second);

  /// @}

  /// @name Instruments
  /// These functions throw InvalidArgument as those of Solver and Cautery, and naming the id that
  /// there is not.
  /// @{

  /// Of the solver's add_tool().
  /// @param capsules  [n] in the tool's frame, whose origin is its tip
  /// @param joints    [m] around which capsules turn: jaws, blades
  ToolId add_tool(std::span<const Capsule> capsules, const ToolPose& pose = ToolPose::Identity(),
                  const ToolSurface& surface = {}, std::span<const ToolJoint> joints = {});
  /// Likewise.
  ToolId add_tool(std::initializer_list<Capsule> capsules,
                  const ToolPose& pose = ToolPose::Identity(), const ToolSurface& surface = {},
                  std::span<const ToolJoint> joints = {});
  /// As Solver::remove_tool(): what it holds is let go, and its id is not used again.
  /// @throws InvalidArgument  also if a cautery is at the tool: that is for as long as the world is
  void remove_tool(ToolId tool);
  /// As Solver::couple_tool(): from the next step on a spring holds it, in all replicas. pose() is
  /// where it is to be, Solver::tool_pose() where it is.
  void couple(ToolId tool, const ToolCoupling& coupling);
  /// As Solver::move_tool(): it travels there in the next step.
  void move(ToolId tool, const ToolPose& pose);
  /// As Solver::set_joint(): it turns there in the next step.
  /// @param angle  rad
  void set_joint(ToolId tool, Index joint, float angle);
  /// As Solver::grasp().
  /// @param vertices    [n] ids in the tissue
  /// @param compliance  m/N, 0 holds rigidly
  void grasp(ToolId tool, std::span<const Index> vertices, float compliance = 0);
  /// Grasps what of a body lies near the tool's tip, where that is now, and none if nothing does.
  /// @param radius  m
  /// @return        the vertices, ids in the tissue
  std::vector<Index> grasp_near(ToolId tool, BodyId body, float radius, float compliance = 0);
  /// As Solver::grasp() by jaws that press with a force.
  void grasp(ToolId tool, std::span<const TissuePoint> points, const Grip& grip);
  /// Grasps so what of a body lies between the tool's jaws, where that is now, and nothing if they
  /// cannot hold it: see find_points_between().
  /// @return  how many points there are
  std::size_t grasp_between(ToolId tool, BodyId body, float opening, const Grip& grip,
                            float spacing = 2e-3F);
  /// As Solver::close_jaws().
  std::size_t close_jaws(ToolId tool, std::array<ToolId, 2> jaws, const Grip& grip);
  /// As Solver::set_clamp_force().
  void set_clamp_force(ToolId tool, float force);
  /// As Solver::tool_grip(): what it holds, whether that slips or tore.
  [[nodiscard]] GripReport grip(ToolId tool) const;
  /// Lets go of everything the tool holds.
  void release(ToolId tool);
  /// Where it is to be at the end of the next step, and is after it unless a spring holds it.
  [[nodiscard]] ToolPose pose(ToolId tool) const;
  /// rad, likewise of a joint.
  [[nodiscard]] float joint_angle(ToolId tool, Index joint) const;
  /// N, of the tissue on the tool, in the last step.
  [[nodiscard]] Eigen::Vector3f force(ToolId tool) const;

  /// Lets a tool burn bodies, at any time. A body has the heat of one cautery.
  /// @param bodies     with the heat of their TissueRecord
  /// @param options    executors that are nobody are the world's, or threads if that is a device
  ///                   and MathMode is strict: strict bits are the same wherever the world is
  /// @param electrode  in the tool's frame; by default its tip alone
  CauteryId add_cautery(ToolId tool, std::span<const BodyId> bodies,
                        const CauteryOptions& options = {},
                        const Electrode& electrode = {Eigen::Vector3f::Zero(),
                                                      Eigen::Vector3f::Zero()});
  /// Likewise.
  CauteryId add_cautery(ToolId tool, std::initializer_list<BodyId> bodies,
                        const CauteryOptions& options = {},
                        const Electrode& electrode = {Eigen::Vector3f::Zero(),
                                                      Eigen::Vector3f::Zero()});
  /// What the generator does in the steps to come; off_settings(), as at first: nothing.
  void energise(CauteryId cautery, const std::optional<GeneratorSettings>& settings);
  /// Cuts strands in the next step.
  void sweep(const BladeSweep& blade);

  /// @}

  /// @name Frames
  /// @{

  /// Advances by dt: see above. With default options a step of 5 ms or less carries organs by their
  /// strands; in one of 1/60 s, strands that bear weight stretch so far that they tear.
  /// @throws InvalidArgument  for a dt that Solver::step() refuses; then nothing has changed
  /// @throws Error            if a device fails
  Frame step(double dt);

  /// Merges an edit into the next step, which refuses it if the tissue has changed by then. What it
  /// brings is numbered behind what earlier edits of the step bring. Bodies that it brings have no
  /// BodyId: add_body() gives one.
  void edit(const TopologyEdit& edit);

  /// Takes back the last edit of the tissue: Tissue::undo(). A body that came with it has gone for
  /// good. Refused if a surface, pieces, a cautery or record() was asked for since. Heat stays as
  /// it is: save() takes it along, and goes back further.
  void undo();

  /// New ids, memory and colours of what lives, between two steps: see Compaction. Ids of bodies
  /// and tools stay.
  void compact();

  /// @}

  /// @name Back in time
  /// @{

  /// From here on the world can be saved: keeps tissue and constraints as they are now, and each
  /// edit to come, so memory grows with edits. Call it again after a compaction, or where states
  /// should no longer go through so many edits; earlier ones stay of use. A first call before any
  /// edit keeps the scene, too, and all edits from then on, until a compaction: for write_world().
  ///
  /// Cauteries find potential and conductivities anew, as after Cautery::restore(): a burn goes on
  /// as before to their tolerances. Cost: O(all that there ever was), of memory bandwidth;
  /// WorldState::shared_bytes() says what it holds.
  /// @throws InvalidArgument  if the heat of a cautery is not finite any more; states are then
  /// saved
  ///                          as before, and other burns may go on as after restore()
  void record();

  /// All that there is, between two steps: topology and rest shapes, gravity; positions,
  /// velocities, forces, tools and what they hold in all replicas; heat, its marks, and the energy
  /// that went where; strands and their events; settings of generators. Not: what the next step was
  /// asked for by edit(), sweep(), add_body() and remove_body(), and what follows the tissue on a
  /// program's side, custom constraints among it.
  ///
  /// A world that is made of it gives, on a host, the bits that this one gives from here on, as
  /// long as no current flows; with current, potentials agree to PotentialOptions::tolerance and
  /// conductivities to 1.5 %. On a device it agrees as far as two solvers of different histories do
  /// there.
  ///
  /// Cost: O(vertices + links + edits since record()): see WorldState::memory_bytes(). From a
  /// device, the state is read back.
  /// @throws InvalidArgument  if record() was not called, or a compaction came since
  /// @throws Error            if a device fails
  [[nodiscard]] WorldState save() const;

  /// @}

  /// @name What there is
  /// @{

  /// Follows the body from here on; the same for all who ask.
  [[nodiscard]] const Surface& surface(BodyId body);
  /// What of the tissue hangs together; follows from here on, the same for all who ask.
  [[nodiscard]] const LivePieces& pieces();
  /// The body of a name.
  /// @throws InvalidArgument  naming the bodies that there are
  [[nodiscard]] BodyId find_body(const std::string& name) const;
  /// Its number in tissue(), which functions on the parts take; until the next compact().
  [[nodiscard]] Index body_in_tissue(BodyId body) const;
  /// What it was added with.
  [[nodiscard]] const TissueRecord& tissue_of(BodyId body) const;

  /// [replica_count] see SolverOptions::copies. World's own functions are of the first.
  [[nodiscard]] Replica replica(ReplicaId id);

  /// All bodies, as living tissue.
  [[nodiscard]] Tissue& tissue();
  /// What moves them.
  [[nodiscard]] Solver& solver();
  /// All strands of join(), or of the constructor.
  [[nodiscard]] ConnectiveTissue& strands();
  /// What add_cautery() made.
  [[nodiscard]] Cautery& cautery(CauteryId cautery);

  /// @}

 private:
  friend class WorldState;
  friend class WorldFile;  // which reads and writes its parts
  struct Data;
  struct Origin;
  [[nodiscard]] std::span<const Eigen::Vector3d> rest_positions_of(BodyId body) const;
  [[nodiscard]] std::vector<Eigen::Vector3d> rest_centers_of(BodyId body) const;
  [[nodiscard]] std::vector<Index> vertices_with_tissue(BodyId body);
  Owned<Data> data_;
};

template <std::predicate<const Eigen::Vector3d&> Condition>
Index World::fix(BodyId body, Condition condition) {
  const std::span<const Eigen::Vector3d> positions = rest_positions_of(body);
  std::vector<Index> vertices;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (condition(positions[v])) {
      vertices.push_back(static_cast<Index>(v));
    }
  }
  fix(body, std::span<const Index>(vertices));
  return static_cast<Index>(vertices.size());
}

template <std::invocable<const Eigen::Vector3d&> Field>
void World::set_stiffnesses(BodyId body, Field field) {
  std::vector<float> factors;
  for (const Eigen::Vector3d& center : rest_centers_of(body)) {
    factors.push_back(field(center));
  }
  set_stiffnesses(body, std::span<const float>(factors));
}

template <std::invocable<const Eigen::Vector3d&> Field>
void World::set_fibres(BodyId body, Field field) {
  std::vector<Fibre> fibres;
  for (const Eigen::Vector3d& center : rest_centers_of(body)) {
    fibres.push_back(field(center));
  }
  set_fibres(body, std::span<const Fibre>(fibres));
}

template <std::invocable<Index, const Eigen::Vector3f&> Field>
void World::set_forces(BodyId body, Field field) {
  const std::vector<Index> vertices = vertices_with_tissue(body);
  std::vector<Eigen::Vector3f> values(vertices.size());
  solver().read_positions(vertices, values);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    values[i] = field(vertices[i], values[i]);
  }
  set_forces(vertices, values);
}

}  // namespace pbdsurg
