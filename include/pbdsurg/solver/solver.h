// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Steps a scene in time: the paper's algorithm 1, with contacts and grasped vertices.

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/convergence.h"
#include "pbdsurg/solver/copy_factors.h"
#include "pbdsurg/solver/custom_constraints.h"
#include "pbdsurg/solver/grip.h"
#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/solver/step_plan.h"
#include "pbdsurg/solver/step_report.h"
#include "pbdsurg/solver/tissue_contact.h"
#include "pbdsurg/solver/tool.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// What a snapshot has of a contact of a tool with a surface: from which side it came, and how it
/// pushes. Steps go on from it.
struct SnapshotContact {
  ToolId tool;                    ///< that it touches
  std::array<Index, 3> vertices;  ///< as ToolContact has them
  Eigen::Vector3f normal;         ///< out of the tool
  float force;                    ///< N, on the tissue, along the normal
  Eigen::Vector3f friction;       ///< N, likewise, across it
};

/// What a snapshot has of a contact between bodies, likewise: a vertex has one with each body, and
/// two edges have one.
struct SnapshotBodyContact {
  Index vertex;              ///< scene vertex, of two edges an end of the first
  Index body;                ///< of the tissue, whose surface it touches; none of two edges
  Eigen::Vector3f normal;    ///< out of that body, or from the second edge to the first
  float force;               ///< N, on the vertex or the first edge, along the normal
  Eigen::Vector3f friction;  ///< N, likewise, across it
  /// Of two edges: the other end of the first and both of the second, scene vertices; else none.
  std::array<Index, 3> edges{kInvalidIndex, kInvalidIndex, kInvalidIndex};
};

/// The moving part of a copy's state. Restores only into a solver of the same tissue, into any of
/// its copies, and only while the topology is what it was, or is so again by undo.
struct Snapshot {
  std::vector<Eigen::Vector3f> positions;   ///< [vertex_count] m
  std::vector<Eigen::Vector3f> velocities;  ///< [vertex_count] m/s
  std::vector<ToolPose> tool_poses;         ///< [tool_count] where they are to be
  TissueVersion tissue;                     ///< of the topology
  /// [vertex_count] in compliance mode, else empty: in [0, 1], the share of gravity with which
  /// vertices last sped up, which tells where the next sweeps of the vertex-block method start. A
  /// snapshot made by hand may leave it out: sweeps then start as from free fall.
  std::vector<float> falling{};
  /// [vertex_count] m, in compliance mode, else empty: what positions lack by rounding, at most
  /// 2^-22 of the largest coordinate. Left out, positions are exact.
  std::vector<Eigen::Vector3f> roundings{};
  /// What BDF2 remembers of the substep before. Left out, the next substep is implicit Euler's.
  /// Explicit steps remember its length; left out, velocities count as those of now.
  float past_substep = 0;                            ///< s, its length; 0 where there was none
  std::vector<Eigen::Vector3f> ways{};               ///< [vertex_count] m, gone in it
  std::vector<Eigen::Vector3f> velocities_before{};  ///< [vertex_count] m/s, where it began
  /// [vertex_count] N, of Solver::set_forces(). Left out, there are none.
  std::vector<Eigen::Vector3f> forces{};
  /// [n] Left out, tools meet all anew.
  std::vector<SnapshotContact> contacts{};
  /// [n] Left out, bodies meet each other anew.
  std::vector<SnapshotBodyContact> body_contacts{};
  /// [tool_count][joint_count of each] rad. Left out, joints stay where they are. What is of a tool
  /// that was removed since has no effect.
  std::vector<std::vector<float>> joint_angles{};
  /// [tool_count] m, from where coupled tools are to be to where they are. Left out, they are
  /// there.
  std::vector<Eigen::Vector3f> tool_displacements{};
};

class SolverData;
class SolverCopy;
struct ToolState;

/// Bodies in motion.
///
/// One solver is used by one thread at a time. Results depend on the calls and their order alone:
/// the same program gives the same bits in every run.
///
/// A solver may step many copies of its scene at once, for throughput: a CUDA device has room for
/// hundreds. Copies share what a scene is: topology, edits, materials, plan, and which tools there
/// are. Each has its own state: positions, velocities, poses and forces of tools, and what they
/// hold; and, where set_factors() gives it one, a material of its own. Vertices, edges, tetrahedra
/// and tools have the same ids in all. Each copy moves as the one of a solver without others would,
/// given the same calls; in strict mode, with the same bits, and on one backend in fast mode, too,
/// but for DeviceStrategy::cooperative: how many threads share a vertex there depends on the number
/// of copies.
///
/// Functions on the state take a copy, the first by default.
/// @throws InvalidArgument  from all of them, naming the copy that there is not, and how many there
///                          are
class PBDSURG_API Solver {
 public:
  /// Colours the constraints of a tissue and builds the step plan.
  /// @throws InvalidArgument     naming the option out of range or without a reader, or the
  ///                             Neo-Hookean body in fraction mode, or what the vertex-block method
  ///                             cannot follow: fractions, joint plans, limits of colours,
  ///                             clusters, a compliance of zero; or a joint plan of a tissue that
  ///                             was edited; or the body that no automatic number of substeps or
  ///                             sweeps makes accurate: see kAutomatic
  /// @throws BackendUnavailable  if the executor is a device that cannot step this, saying why
  /// @param tissue  must outlive the solver; as far as edits have changed it, it starts at rest
  explicit Solver(Tissue& tissue, const SolverOptions& options = {});

  /// With a tissue of its own, made of a scene.
  /// @throws InvalidArgument, BackendUnavailable  as above
  explicit Solver(const Scene& scene, const SolverOptions& options = {});
  ~Solver();
  /// Takes over. The other can then only be destroyed or assigned to.
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;  ///< likewise

  /// Advances by dt: gravity and forces, damping, prediction, sweeps, velocities, for each substep.
  /// Heat, edits, rendering and readback are outside it. All copies advance.
  /// @param dt  s, positive and finite, and not so small that 1e12 / substep^2 overflows
  /// @throws InvalidArgument  for any other dt, or if a step was begun; never for physics
  /// @throws what a callback of CustomConstraints throws; then all is as before the step, to the
  /// bit
  /// @throws Error            if a device fails, as may all that steps, reads, writes or edits on
  /// one; or as finish_step()
  StepReport step(float dt);

  /// How well the sweeps solve the next substep of a step of dt, with tools where they are: a probe
  /// on a copy of the state, which stays what it is, to the bit. Elastic forces are summed in
  /// double precision, apart from the sweeps. Cost: a substep of the serial backend and about five
  /// sweeps of it, and memory for a copy of the state; on a device, it is read back, too. Custom
  /// constraints are projected, see ConstraintSweep::is_probe(); vertices that they may push do not
  /// count.
  /// @param dt  s, as step()
  /// @return    [body_count] see Convergence
  /// @throws InvalidArgument  as step(), and in fraction mode, which has no elastic forces
  [[nodiscard]] std::vector<Convergence> convergence(float dt, Index copy = 0);

  /// Refuses what step() refuses, and changes nothing.
  /// @throws InvalidArgument  as step()
  void check_step(float dt) const;

  /// Begins a step. A device works on while the caller has its thread for other work; on a host the
  /// whole step is done here, and finish_step() only has its report: who wants to do other work
  /// meanwhile calls step() in a thread of its own. Any call that reads or writes the state, or has
  /// to do with tools or watched vertices, waits for the step first; finish_step() then still has
  /// its report. Most edits do not wait, see tissue() for those that do:
  /// topology is the new one at once, and the next step is the first to follow it. So edits cost
  /// nothing that a device's step is long enough to hide. Of explicit steps of more than 24
  /// automatic substeps this waits for all but the last 24 at most.
  /// @throws InvalidArgument  as step(), or if a step was begun and finish_step() not called
  void start_step(float dt);

  /// Waits for the step that was begun.
  /// @throws InvalidArgument  if none was
  /// @throws Error            if SolverOptions::refuses_dropped_contacts says so; the step is done
  StepReport finish_step();

  /// Of one copy, of the last step.
  [[nodiscard]] StepReport last_report(Index copy = 0) const;

  /// As given, but with the method and the composition that were taken where these were automatic,
  /// and with who works.
  [[nodiscard]] const SolverOptions& options() const;
  /// The phases of one sweep, as they are now.
  [[nodiscard]] const StepPlan& plan() const;
  /// Who works: "serial", "threaded, 2 threads, AVX2", or the device's.
  [[nodiscard]] const char* backend_name() const;

  /// Bytes that the solver's arrays hold, those on a device included, without what their allocator
  /// adds.
  [[nodiscard]] std::size_t memory_bytes() const;

  /// @name State
  /// @{

  /// Of the tissue, vertices without tissue included.
  [[nodiscard]] Index vertex_count() const;

  /// [vertex_count] m
  [[nodiscard]] std::vector<Eigen::Vector3f> positions(Index copy = 0) const;

  /// Reads every vertex into a buffer that the caller owns.
  /// @param out  [vertex_count] m
  void read_positions(std::span<Eigen::Vector3f> out, Index copy = 0) const;

  /// Reads some vertices, for example the neighbourhood of a tool.
  /// @param vertices  [n] scene vertices
  /// @param out       [n] m
  /// @throws InvalidArgument  naming the vertex out of range, or if the sizes differ
  void read_positions(std::span<const Index> vertices, std::span<Eigen::Vector3f> out,
                      Index copy = 0) const;

  /// Chooses vertices whose positions each step brings along with its report, for example the
  /// neighbourhood of a tool: from a CUDA device, the cheapest way to read some every step.
  /// @param vertices  [n] scene vertices of all copies, in place of those watched before
  /// @throws InvalidArgument  naming the vertex out of range; then the list is what it was
  void watch(std::span<const Index> vertices);

  /// [n] m, of the vertices watched, as of the last step, or of watch() if that came later. Valid
  /// until the next call of watch(); each step changes its contents.
  [[nodiscard]] std::span<const Eigen::Vector3f> watched_positions(Index copy = 0) const;

  /// Moves every vertex, fixed ones included, and stops it.
  /// @param positions  [vertex_count] m
  /// @throws InvalidArgument  naming the first that is not finite, or if the size differs
  void write_positions(std::span<const Eigen::Vector3f> positions, Index copy = 0);

  /// [vertex_count] m/s; of explicit steps, half a substep before now
  [[nodiscard]] std::vector<Eigen::Vector3f> velocities(Index copy = 0) const;

  /// Sets every vertex's velocity of now; that of a vertex that cannot move has no effect.
  /// @param velocities  [vertex_count] m/s
  /// @throws InvalidArgument  as write_positions()
  void write_velocities(std::span<const Eigen::Vector3f> velocities, Index copy = 0);

  /// The state of a copy, but for what tools hold.
  [[nodiscard]] Snapshot snapshot(Index copy = 0) const;

  /// Goes back to a snapshot; what tools hold is released.
  /// @throws InvalidArgument  if the snapshot is of another size or topology, or not finite; then
  ///                          nothing has changed
  void restore(const Snapshot& snapshot, Index copy = 0);

  /// 64 bits that differ when any bit of a position or velocity differs, or of what a snapshot has
  /// besides of vertices (up to chance).
  [[nodiscard]] std::uint64_t state_hash(Index copy = 0) const;

  /// @}

  /// @name Forces and gravity
  /// What acts from outside, in every substep from the next step on, until it is replaced. Neither
  /// waits for a step that a device takes. What tools feel is the tissue's answer. Where nothing is
  /// set, steps cost nothing for it.
  /// @{

  /// Gives vertices forces, in place of those that they had; others keep theirs. At a vertex that
  /// cannot move, or has no tissue, a force does nothing; one that an edit's undo brings back has
  /// its force again. New vertices have none, also where an edit splits an edge between two that
  /// have. Cost: O(n log n), and the first time O(vertex_count).
  /// @param vertices  [n] scene vertices, each once
  /// @param forces    [n] N, finite
  /// @throws InvalidArgument  naming the vertex out of range, named twice, or whose force is not
  ///                          finite, and that force, or if the sizes differ; then nothing is set
  void set_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces,
                  Index copy = 0);

  /// A field of force, as it is now: every vertex with tissue gets a force. Positions of a device
  /// are read back.
  /// @param field  Eigen::Vector3f(Index vertex, const Eigen::Vector3f& position), N of m
  /// @throws InvalidArgument  as above, and what the field throws; then nothing is set
  template <std::invocable<Index, const Eigen::Vector3f&> Field>
  void set_forces(Field field, Index copy = 0);

  /// Takes all forces away.
  void clear_forces(Index copy = 0);

  /// [vertex_count] N, or empty while none was set
  [[nodiscard]] std::vector<Eigen::Vector3f> forces(Index copy = 0) const;

  /// Gravity of all bodies and copies, those that are to come among them; at first the scene's.
  /// @param gravity  m/s^2, finite
  /// @throws InvalidArgument  with the value, if it is not finite
  void set_gravity(const Eigen::Vector3f& gravity);

  /// Gravity of one body, in all copies. Cost: O(vertex_count).
  /// @throws InvalidArgument  as above, and naming the body that there is not
  void set_gravity(Index body, const Eigen::Vector3f& gravity);

  /// m/s^2, that a body has now.
  /// @throws InvalidArgument  naming the body that there is not
  [[nodiscard]] Eigen::Vector3f gravity(Index body) const;

  /// @}

  /// @name Material of copies
  /// @{

  /// Makes a copy stiffer, heavier, or subject to another gravity than the scene, from the next
  /// step on; at first all factors are 1. They stay through edits, compaction and restore(), and
  /// are no part of a snapshot. Tissue says what the scene is made of, as before. Forces on tools,
  /// stress and convergence are the copy's. Automatic numbers of substeps and sweeps follow the
  /// copy that is the stiffest for its density. Cost: O(copies).
  /// @throws InvalidArgument  naming the copy and the factor out of range; or, of stiffness and
  ///                          density other than 1, fraction mode, explicit steps and custom
  ///                          constraints, which know nothing of them, and the copy that would need
  ///                          more than kMostAutomatic substeps; then nothing has changed
  void set_factors(const CopyFactors& factors, Index copy = 0);

  /// As set.
  [[nodiscard]] CopyFactors factors(Index copy = 0) const;

  /// @}

  /// @name Constraints of a program's own
  /// @{

  /// Adds a set, which steps project from now on: see CustomConstraints. It follows the tissue from
  /// here on, so an edit from before cannot be undone; it is kept until remove_constraints() or the
  /// end of the solver, and goes along with a Compaction. Snapshots and saved worlds have nothing
  /// of it.
  /// @throws InvalidArgument     if the pointer is null, the set was added before or follows a
  /// tissue
  ///                             otherwise, naming it, or the solver takes explicit steps, or a
  ///                             copy has a material of its own
  /// @throws BackendUnavailable  if the solver is on a device
  void add_constraints(std::shared_ptr<CustomConstraints> set);

  /// Takes a set out. It follows the tissue no more.
  /// @throws InvalidArgument  naming the set, if it was not added
  void remove_constraints(const CustomConstraints& set);

  /// @}

  /// @name Tools
  /// @{

  /// Adds an instrument to all copies. It pushes out of its capsules what of tissue its surface
  /// says: by default vertices, edges and triangles, without friction. The first such tool has the
  /// surfaces of all bodies found, in O(T log T) of their tetrahedra. What a tool meets first from
  /// within its tissue, as where heat has let it in, it does not push.
  /// @param capsules  [n] may be empty: such a tool only holds what it grasps
  /// @param joints    [m] from the shaft outwards, all at an angle of 0: a joint that turns some of
  ///                  the capsules of one before it turns no others, and is carried along by that
  /// @throws InvalidArgument  naming the capsule that is not finite or whose radius is not
  /// positive,
  ///                          or a pose that is not a rotation and a translation, or friction out
  ///                          of range, or the joint whose axis is no unit or whose capsules there
  ///                          are not, or are in part those of another
  ToolId add_tool(std::span<const Capsule> capsules, const ToolPose& pose,
                  const ToolSurface& surface = {}, std::span<const ToolJoint> joints = {});

  /// Adds what no vertex goes below: a tool in all else.
  /// @param half_space  in the tool's frame
  /// @param friction    as in ToolSurface
  /// @throws InvalidArgument  naming what of the half space is not finite or no unit, or as above
  ToolId add_half_space(const HalfSpace& half_space, float friction = 0,
                        const ToolPose& pose = ToolPose::Identity());

  /// Takes a tool out of all copies: it lets go of what it holds, and meets tissue no more. Its id
  /// stays its own: calls with it throw InvalidArgument, and snapshots have a pose for it, as
  /// before. A grip that close_jaws() made of its contacts stays with the tool that holds.
  /// @throws InvalidArgument  naming the tool that there is not, or that was removed
  void remove_tool(ToolId tool);

  /// Whether a tool was added and not removed.
  [[nodiscard]] bool has_tool(ToolId tool) const;

  /// Ties a tool in all copies to where it is to be by a spring, from the next step on, or ties it
  /// no more. Where nothing pushes it, it is where it is to be. Where tissue does, the spring bears
  /// that: both are solved for together, however stiff the tissue is. A tool that tissue lets go of
  /// comes back by half its least radius a substep at most, so that it meets what is in its way;
  /// one that tissue pushes goes along at up to 1 m/s beyond its own way. One that is tied no more
  /// is where it was, and travels in the next step to where it is to be.
  /// @throws InvalidArgument     naming the stiffness that is not positive, the tool that there is
  ///                             not, that meets no surfaces (see ToolSurface) or holds something;
  ///                             in explicit steps
  void couple_tool(ToolId tool, const ToolCoupling& coupling);

  /// Moves a tool: it travels there evenly over the next step.
  /// @throws InvalidArgument  as add_tool(), and if there is no such tool
  void move_tool(ToolId tool, const ToolPose& pose, Index copy = 0);

  /// Where a tool is; if it is coupled, where tissue lets it be.
  [[nodiscard]] ToolPose tool_pose(ToolId tool, Index copy = 0) const;
  /// m, from where it is to be to where it is; zero unless it is coupled and tissue pushes it.
  [[nodiscard]] Eigen::Vector3f tool_displacement(ToolId tool, Index copy = 0) const;
  /// Where it is to be at the end of the next step: as move_tool() said.
  [[nodiscard]] ToolPose tool_target(ToolId tool, Index copy = 0) const;

  /// Turns a joint: it goes there evenly over the next step, whatever the pose does meanwhile, and
  /// the tissue that its capsules touch goes along or slips. What the tool holds does not turn.
  /// @param joint  of those of add_tool(), in their order
  /// @param angle  rad, finite
  /// @throws InvalidArgument  naming the tool or joint that there is not, or the angle
  void set_joint(ToolId tool, Index joint, float angle, Index copy = 0);

  /// rad, where a joint is.
  /// @throws InvalidArgument  naming the tool or joint that there is not
  [[nodiscard]] float joint_angle(ToolId tool, Index joint, Index copy = 0) const;
  /// rad, where it is to be at the end of the next step.
  /// @throws InvalidArgument  likewise
  [[nodiscard]] float joint_target(ToolId tool, Index joint, Index copy = 0) const;

  /// Holds vertices where they are now in the tool's frame; they follow it until released. While a
  /// tool holds vertices it does not push any: its jaws are closed around them.
  /// @param vertices    [n] scene vertices with tissue; a vertex may be held by several tools, and
  ///                    a fixed one stays where it is and adds no force
  /// @param compliance  m/N, in [0, kLargestCompliance], in either projection mode; 0 holds
  ///                    rigidly
  /// @throws InvalidArgument  naming the tool, vertex or value out of range, the vertex without
  ///                          tissue, or that this tool holds already, or the tool that is
  ///                          coupled by a spring; then nothing is grasped
  void grasp(ToolId tool, std::span<const Index> vertices, float compliance = 0, Index copy = 0);

  /// Holds points of tissue by jaws that press with a force, no harder than their friction bears:
  /// see Grip. Each step costs O(points), and as much again a sweep while they slide, of vertex
  /// blocks. Points whose tissue goes are let go, and held again by an undo.
  /// @param points  [n] on vertices, edges and faces, as they are now; their places in the tool's
  ///                frame are on the pad, and three of them not on a line. One on tissue that is
  ///                fixed pulls back, too.
  /// @throws InvalidArgument  naming the tool, point or value out of range, or if the tool holds
  ///                          something or is coupled by a spring, or in explicit steps; then
  ///                          nothing is grasped
  void grasp(ToolId tool, std::span<const TissuePoint> points, const Grip& grip, Index copy = 0);

  /// Likewise what two jaws pressed in the last step, where it is on the pad: all their contacts
  /// become points of one grip. From then on they push nothing, until the tool lets go.
  /// @param jaws  tools with a ToolSurface, one on each side of the pad; the tool may be one. Twice
  ///              the same: it has both, on joints, and what of it presses towards the pad's center
  ///              is one or the other by its side
  /// @return      how many points there are: 0, and nothing is grasped, if a jaw presses with less
  ///              than kLeastPinch across the pad, or no three points are off a line
  /// @throws InvalidArgument  as above, and naming the jaw without a surface, or that is both
  ///                          without a joint
  std::size_t close_jaws(ToolId tool, std::array<ToolId, 2> jaws, const Grip& grip, Index copy = 0);

  /// Lets jaws press harder or less.
  /// @param force  N, finite and >= 0
  /// @throws InvalidArgument  naming the force out of range, or the tool without a grip
  void set_clamp_force(ToolId tool, float force, Index copy = 0);

  /// What became of a tool's grip. Cost: O(points), and O(tets) at what tore.
  [[nodiscard]] GripReport tool_grip(ToolId tool, Index copy = 0) const;

  /// N, GripReport::slip_limit of a tool that has a grip; infinite for all others. Cost: O(1).
  [[nodiscard]] float slip_limit(ToolId tool, Index copy = 0) const;

  /// Tools whose grips were lost or torn in the last step, ascending.
  [[nodiscard]] std::vector<ToolId> lost_grips(Index copy = 0) const;

  /// Lets go of everything the tool holds.
  void release(ToolId tool, Index copy = 0);

  /// Force of the tissue on a tool, N: the sum of the multipliers of its contacts and of what it
  /// holds, averaged over the last step. Unfiltered and unclamped; vertices that are not finite add
  /// nothing.
  [[nodiscard]] Eigen::Vector3f tool_force(ToolId tool, Index copy = 0) const;

  /// Torque of the same forces around the origin of the tool's frame, N m, averaged likewise.
  [[nodiscard]] Eigen::Vector3f tool_torque(ToolId tool, Index copy = 0) const;

  /// What touches a tool whose surface is not the default, in the last substep of the last step:
  /// vertices, edges and triangles, each in ascending order of the solver's places. Those within a
  /// quarter of a radius without a force are among them. Empty for other tools, and after restore()
  /// until the next step.
  [[nodiscard]] std::vector<ToolContact> tool_contacts(ToolId tool, Index copy = 0) const;

  /// @}

  /// @name Contact of bodies
  /// By default bodies pass through each other. Where pairs of them are to meet, each vertex of one
  /// surface keeps a distance from the nearest triangle of the other, both ways, in every substep,
  /// with the same force on both: momentum is theirs. So do edges that cross: all of sheets, the
  /// links of particles, and of tetrahedra those where the surface is bent outwards at rest by 18
  /// degrees or more. Cuts, burns and undo change surfaces as they change tissue. Vertices that
  /// links join to others, and their neighbours, do not meet each other; once the last link there
  /// is gone, they do.
  ///
  /// Where bodies are nearer than that distance when it starts to act, or overlap by less than
  /// three thicknesses, contacts open at 0.03 m/s at most; tissue that they squeeze may spring back
  /// faster. What is deeper is left alone. What moves farther than eight thicknesses in a substep
  /// may pass through. Particles meet surfaces and links, but without a link not each other; a link
  /// meets where both of its ends are of one body. Edges keep their side while they cross the same
  /// one.
  /// @{

  /// Lets two bodies meet in all copies, from the next step on, or changes how they do. The first
  /// pair has the surfaces of all bodies found, in O(T log T) of their tetrahedra. Each step costs
  /// O(n) of the pairs' surface vertices, and each edit O(T) of the triangles of bodies that it
  /// changes. Steps count no more than SolverOptions::contact_capacity contacts of all pairs
  /// together.
  /// @param first   of tetrahedra, a sheet or particles
  /// @param second  likewise; the first itself: parts of it that are no neighbours, nor nearer than
  ///                three thicknesses at rest, meet each other
  /// @throws InvalidArgument  naming the body that there is not, or the thickness or friction out
  /// of
  ///                          range
  void set_body_contact(Index first, Index second, const TissueContact& contact);

  /// Lets two bodies pass through each other again.
  /// @throws InvalidArgument  naming the body that there is not
  void clear_body_contact(Index first, Index second);

  /// Which vertices were near other bodies in the last substep of the last step, then which edges,
  /// within 1.5 thicknesses and their ways; each in the order in which they are projected, which is
  /// random, but the same for the same places. Those without a force are among them. An overlap is
  /// a negative distance. None after an undo that takes what touched, and none between restore()
  /// and the next step. Cost: O(vertices), if there are any; reads the state of a device.
  [[nodiscard]] std::vector<BodyContact> body_contacts(Index copy = 0) const;

  /// @}

  /// @name Tissue
  /// @{

  /// What all copies are made of. Its edits between two steps change the solver, those between
  /// start_step() and finish_step() change the next step, with the same bits as after
  /// finish_step(). Only these wait for the step that runs: Tissue::undo(), an edit that brings,
  /// fixes or unfixes vertices, any edit while jaws hold with a limit, followers that read the
  /// state, and on a device an edit that stops more vertices, counted in all copies, than 1024 and
  /// than any edit before.
  ///
  /// Constraints stay validly coloured: what is added takes a colour that is free at its vertices,
  /// or a new one; phases without a constraint leave the plan. A body that comes in is coloured by
  /// itself, into the colours that there are. New vertices move as what they are between. After an
  /// undo, vertices that had tissue before and after the edit stay where they are; others, and
  /// those that it fixed, are where the edit found them; so if nothing moved since, all bits are
  /// those of before the edit, and so are those of all later steps.
  ///
  /// An edit that changes no more than one before it, and adds no more than there is spare room for
  /// (SolverOptions::spare), allocates nothing; but one that brings bodies, in a joint plan, where
  /// edges change groups, and with the vertex-block method, where it adds anything. On a device,
  /// what adds anything takes spare room: where that runs out, its constraints are made anew before
  /// the next step, which costs as much as there is. So are rows of the vertex-block method, where
  /// an edit brings more than a quarter of the vertices, or the first damping.
  [[nodiscard]] Tissue& tissue();
  /// Likewise, to read.
  [[nodiscard]] const Tissue& tissue() const;

  /// Rest length of a live edge as it is now, m.
  /// @throws InvalidArgument  if there is none: edges of Neo-Hookean bodies have no rest length
  [[nodiscard]] float rest_length(Index edge) const;
  /// Rest volume of a live tetrahedron as it is now, m^3.
  /// @throws InvalidArgument  if there is none, as of springs without volume constraints
  [[nodiscard]] float rest_volume(Index tet) const;
  /// Rest area of a live triangle of a sheet as it is now, m^2.
  /// @throws InvalidArgument  if there is none
  [[nodiscard]] float rest_area(Index triangle) const;

  /// @}

 private:
  ToolId add(ToolState tool);

  friend class Compaction;  // which exchanges the data
  friend class SolverCopy;  // which copies it
  friend SolverData& solver_data(Solver& solver);
  friend const SolverData& solver_data(const Solver& solver);

  Solver(std::unique_ptr<Tissue> tissue, const SolverOptions& options);
  Solver(Tissue& tissue, std::unique_ptr<SolverData> data);
  void follow(std::unique_ptr<SolverData> data);

  Tissue* tissue_;
  Owned<SolverData> data_;
};

template <std::invocable<Index, const Eigen::Vector3f&> Field>
void Solver::set_forces(Field field, Index copy) {
  const std::vector<Eigen::Vector3f> now = positions(copy);
  std::vector<Index> vertices;
  std::vector<Eigen::Vector3f> forces;
  for (Index v = 0; v < vertex_count(); ++v) {
    if (tissue().has_tissue(v)) {
      vertices.push_back(v);
      forces.push_back(field(v, now[static_cast<std::size_t>(v)]));
    }
  }
  set_forces(vertices, forces, copy);
}

}  // namespace pbdsurg
