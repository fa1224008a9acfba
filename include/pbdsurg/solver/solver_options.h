// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a solver steps, and on what.

#include <cstdint>

#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/coloring/color.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/step_plan.h"

namespace pbdsurg {

/// What a step finds new positions with.
enum class SolverMethod : std::uint8_t {
  /// vertex_block where the scene and the other options allow it, projection where not: see
  /// there. Chosen when the solver is made; a plan's name tells which.
  automatic,
  projection,  ///< constraint by constraint: PBD or XPBD, as ProjectionMode says
  /// Vertex by vertex, each to the least energy that its neighbours leave it. After Chen et al.
  /// 2024, "Vertex Block Descent". Compliance mode only, and no compliance of a material may be
  /// zero.
  vertex_block,
  /// Leapfrog (Verlet 1967): forces where a substep starts, all vertices at once, no sweeps; of
  /// second order. Nothing but drag damps, so soft tissue in short steps moves more exactly than by
  /// any other method for its time; stiff tissue and fine meshes take many substeps. Velocities are
  /// those half a substep before positions, and taken for those of now where they are written. A
  /// substep is at most the longest that is stable: 0.91 times 2 / frequency of a bound of the
  /// highest mode, by Gershgorin's circles of
  /// each vertex at rest (StepPlan::longest_substep); shorter, in stages, as volumes have
  /// stiffened since, which is found before each step and, where substeps are automatic, within a
  /// long one after every 16 of them. Flat tetrahedra of stiff tissue in violent motion may burst
  /// all the same. Longer ones are refused before a step. Tools hold and push as with vertex_block.
  /// Compliance mode only, without inner friction, sweeps and BDF2; no
  /// compliance may be zero.
  explicit_steps,
};

/// How accelerations become motion.
enum class TimeIntegration : std::uint8_t {
  /// Of first order: robust, and damps what swings, the more the longer a substep is.
  implicit_euler,
  /// Backward differences over two substeps (Curtiss and Hirschfelder 1952; for substeps that
  /// differ Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", III.5): of
  /// second order, and
  /// with little damping of what a substep resolves. In compliance mode; costs 32 bytes a vertex
  /// and two passes over vertices a substep. Its first substep is implicit Euler's: at the start,
  /// and after Solver::write_positions() and write_velocities(). A vertex that an edit brings
  /// shares the past of those that it lies between; one of a new body has that of a fall. What a
  /// tool pushes does not spring back from it. A motion that a rigid limit of stretch, of
  /// projections, stops at once overshoots: implicit Euler is better there.
  bdf2,
};

/// Whether all vertices move together once a substep, by the modes of a coarse space, so that slow,
/// wide motions need no sweeps: up to 48 nodes, one for 16 free vertices at most, each with the
/// affine motions of what is near it (Sumner et al. 2007).
enum class CoarseCorrection : std::uint8_t {
  /// on with vertex_block where substeps or sweeps are automatic, unless iterations is 1 or the
  /// scene is in more pieces than there are nodes; else off. Chosen when the solver is made, of
  /// scene and options alone; a plan's name tells.
  automatic,
  off,
  /// After the first sweep of a substep, which has two or more. Vertex blocks alone.
  on,
};

/// How numbers are rounded.
enum class MathMode : std::uint8_t {
  /// Fused multiply-adds and refined estimates of reciprocals where the backend has them: the same
  /// bits in every run on one instruction set, for any number of threads.
  fast,
  /// IEEE single precision, operation by operation: the serial backend's bits for the same plan, so
  /// name a composition to compare backends. Heat of a World on a device is then a host's.
  strict,
};

/// How the CUDA backend brings a step to its device.
enum class DeviceStrategy : std::uint8_t {
  automatic,  ///< the fastest that the device and the scene allow
  stream,     ///< one launch a phase
  graph,      ///< the whole step recorded once, launched as one
  /// All sweeps of a substep in one kernel, on one cluster of thread blocks; not of vertex blocks.
  cluster,
  /// All sweeps of a substep in one kernel, on the whole device; of vertex blocks without stiff
  /// links or a lumen. What brings one goes on as graph. Of explicit steps all substeps of a step,
  /// while no tool pushes or holds anything.
  cooperative,
};

/// In place of a number of substeps, and of sweeps: as many as the step, the scene and the accuracy
/// asked for need. At an accuracy of 2 % a substep is at most so long, and longer or shorter with
/// the square root of that:
///
/// - with a coarse correction, the smaller of sqrt(10 ms t) and 1/300 s, where t is the time in
/// which a wave of
///   pressure crosses an edge of a body's mesh. It has two sweeps, whatever inner friction there
///   is;
/// - vertex blocks without, 0.95 t, and projections, 0.3 t. It has one sweep, and 1 + tau / substep
///   of them with inner friction tau.
///
/// For a Neo-Hookean body t is edge sqrt(density / M), with M = E (1 - nu) / ((1 + nu) (1 - 2 nu)).
/// Fibres add the stiffness of their stiffest to M. `statics` measures what comes of it. Where the
/// other of the two numbers is given, this one makes up for it: n times the sweeps stand for
/// substeps sqrt(n) times as long, and the reverse. Bodies count as they are when the solver is
/// made; links and hinges do not. A body that an edit brings is in no mode, so it counts as without
/// a correction. Explicit steps have substeps alone, as many as they need to be stable, with links,
/// hinges and edits. Others have up to four times as many while a tool that presses on tissue is
/// fast for how thin it is: see StepReport::fast_tools.
inline constexpr int kAutomatic = 0;
inline constexpr int kMostAutomatic = 1000;  ///< substeps of the longest step, sweeps of a substep

/// How much edits may add before memory has to be found for it.
struct SpareRoom {
  Index vertices = 0;  ///< that parting and dividing bring
  Index tets = 0;      ///< about 40 bytes a tetrahedron for each colour of them
  Index edges = 0;     ///< about 30 bytes an edge, or a link, for each colour of distances
  Index links = 0;     ///< as edges
};

/// How a solver steps. By default it steps as finely as the scene's stiffness needs for an accuracy
/// of 2 % at rest: substeps of two sweeps with a coarse correction between them; many substeps of
/// few sweeps converge better than many sweeps of one step (Macklin et al. 2019, "Small Steps in
/// Physics Simulation"). Who names substeps and iterations gets these, without a correction.
///
/// What another option leaves without a reader is refused, unless it is at its default; seed and
/// executor of a colouring go with every algorithm.
struct PBDSURG_API SolverOptions {
  SolverMethod method = SolverMethod::automatic;     ///< what finds new positions
  ProjectionMode mode = ProjectionMode::compliance;  ///< how stiffness is read
  int substeps = kAutomatic;                         ///< per step, >= 1, or kAutomatic
  int iterations = kAutomatic;  ///< sweeps over all phases per substep, >= 1, or kAutomatic
  /// Of stiffness at rest, as a share, in [0.001, 1]: with automatic substeps or sweeps, tissue
  /// that hangs or is held comes this near to what its material says in twenty times the time in
  /// which its slowest wave fades. Measured at 0.02 (`statics`); others follow from a square root.
  float accuracy = 0.02F;
  /// s, > 0: with automatic substeps or sweeps, the longest step that is to be taken. A scene that
  /// needs more than kMostAutomatic of them in it is refused. Longer steps are subdivided, too.
  float longest_step = 1.0F / 60;
  /// 1/s, >= 0: a rate of drag against the world; implicit Euler divides speeds by 1 + damping h.
  float damping = 0;
  /// In [1, 2), of the vertex-block method: in all sweeps of a substep but the last, vertices go
  /// this much further than to their least energy, so that motion crosses a body in fewer sweeps.
  /// Where stiff bars had four sweeps a substep, 1.6 left their ends 1.5 to 25 times closer to
  /// where endless sweeps would; with two, 1.5 to 2.5 times. Soft tissue wants 1.3. Too much for
  /// few sweeps of nearly incompressible tissue (0.49) makes it tremble or burst: the default is
  /// none. Of a single sweep nothing is left for it, and vertices at stiff links do without. With a
  /// coarse correction, which automatic numbers bring, more than 1.2 does harm.
  float over_relaxation = 1;
  /// Takes as long as 4 sweeps of a substep. With links that are much stiffer than the tissue at
  /// their ends (constraints/stiff_link.h) substeps need more sweeps, which automatic numbers give.
  /// A solver takes longer to make: 0.02 s of 300 vertices, 0.3 s of 2600, 0.6 s of 7000, 1.5 s of
  /// 20,000.
  CoarseCorrection coarse_correction = CoarseCorrection::automatic;
  TimeIntegration integration = TimeIntegration::implicit_euler;  ///< bdf2 in compliance mode only
  /// Contacts of a tool in a substep, and of all bodies with each other, >= 0.
  Index contact_capacity = 4096;
  /// Whether a step that has more of them throws, once it is done: see
  /// StepReport::dropped_contacts.
  bool refuses_dropped_contacts = false;
  /// Of the scene, >= 1, stepped together: see Solver.
  Index copies = 1;
  /// Who works: executor::threads() where it is nobody, with the best vector registers that the
  /// processor has (SSSE3, AVX2, AVX-512; without any, the serial backend). The state of a solver
  /// on a device lives there: reading all of it each step costs more than watching a part.
  Executor executor{};
  MathMode math = MathMode::fast;  ///< the serial backend is always strict
  DeviceStrategy device_strategy = DeviceStrategy::automatic;  ///< of a CUDA device
  /// How constraints of each type are coloured, and so the order of work; or vertices, for the
  /// vertex-block method, which takes saturation for the natural order and no max_colors, and
  /// searches for fewer colours where repair is on.
  ColoringOptions coloring{.repair = true};
  /// With the vertex-block method of stiff links alone, and never joint; explicit steps have none.
  PlanComposition composition = PlanComposition::automatic;
  SpareRoom spare{};  ///< each >= 0
  /// Every so many steps the report has StepReport::convergence, see Solver::convergence() for what
  /// that costs; 0 for none.
  Index convergence_interval = 0;

  /// The paper's settings: fraction mode, one substep, 30 iterations, types coloured separately by
  /// the random colouring disc.
  [[nodiscard]] static SolverOptions paper();
};

}  // namespace pbdsurg
