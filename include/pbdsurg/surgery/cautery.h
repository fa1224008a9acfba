// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An electrosurgical hook: current where it touches, tissue that boils, shrinks and goes, links
/// that part.

#include <Eigen/Core>
#include <optional>
#include <span>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/elements.h"
#include "pbdsurg/heat/generator.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/heat/thermal_model.h"
#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

struct Renumbering;

/// The bare part of an instrument: a straight wire, or a point where both ends are one.
struct Electrode {
  Eigen::Vector3f tip;   ///< m, in the world
  Eigen::Vector3f heel;  ///< m
};

/// An electrode, and when its heat tears, removes and parts.
struct CauteryOptions {
  /// m: surface that is nearer to the electrode's axis is touched, and up to four times as far
  /// where the electrode has gone through it into the tissue. A point then has a contact of
  /// pi radius^2, here 5 mm^2; 0.5 to 5 is usual for a hook's edge, 10 for its flat side.
  double contact_radius = 1.26e-3;
  /// ohm, of the way through the patient's body, in series; usually 50 to 200. Heats nothing here.
  double body_resistance = 150;
  /// W/(m^2 K) from touched tissue into the metal of the electrode, out of the heat that the
  /// current makes there, and no more than that. Where DiskSource takes over, vertices stand for
  /// the contact by their share of its heat; a mesh so coarse is colder there than tissue would be,
  /// and gives the metal less. Calibrated, with
  /// the next two: 10 mm^2 of contact, 6.6 mm across its way and 1.6 mm along, that move at 10 mm/s
  /// over liver leave no mark at 10 W, whiten at 25 W and cut at 50 W, as Karaki et al. 2020
  /// observed. Literature leaves that shape open, too.
  double electrode_cooling = 2e4;
  double electrode_capacity = 0.1;  ///< J/K of that metal, which warms: 25 mm^3 of steel
  /// 1/s, positive: tissue that boils off this share of its water a second, and has lost
  /// tearing_loss, is torn by its steam before it is dry.
  double tearing_rate = 0.3;
  double tearing_loss = 0.01;  ///< share of its water, [0, 1]: see tearing_rate
  /// Of RemovalRule::boiled_vertices, which knows no water: share by which lengths between boiled
  /// vertices shrink, [0, 0.9]; refused with another rule, unless it is at its default.
  double boiled_shrinkage = 0.3;
  /// Elements, and edges, whose rest shape one update changes at most, and elements whose
  /// stiffness, those farthest behind first; the others wait. Bounds what an edit costs; 0: no
  /// bound.
  Index shrink_limit = 0;
  /// J that part one link: 0.5 mm^3 of membrane warmed until steam tears it, as tissue is torn
  double link_energy = 0.085;
  /// S of a link at the axis of an electrode that touches pi contact_radius^2, in proportion less
  /// where it touches more, and falling to 0 at the contact radius; none once a link has its
  /// energy. By conductance the current divides itself. Of the default, a link takes as much heat a
  /// volume as tissue does within one radius of the contact, where half of a disk's heat is (Newman
  /// 1966): 1.5 sigma V / A, for 0.5 mm^3 of membrane with 0.35 S/m on 5 mm^2.
  double link_conductance = 5.2e-5;
  ThermalModel model{};                           ///< which physics of heat
  HeatOptions heat{};                             ///< how heat is computed
  PotentialOptions potential{.region_radii = 6};  ///< how current is computed
};

/// What one update did. Electrical quantities are of its last substep, root mean squares over
/// bursts and pauses.
struct CauteryReport {
  Index contact_vertices = 0;  ///< surface vertices that the electrode touches
  double contact_area = 0;     ///< m^2, nominal
  Index contact_links = 0;     ///< links that it touches
  double power = 0;            ///< W, mean of `energy` over the update
  double voltage = 0;          ///< V of the generator
  double current = 0;          ///< A
  double resistance = 0;       ///< ohm of the whole circuit; infinite where it is open
  GeneratorRegime regime = GeneratorRegime::open_circuit;  ///< which limit of the generator governs
  bool is_arcing = false;  ///< sparks pass over dry tissue, or to what is not quite touched
  bool is_disk = false;    ///< the mesh is coarser than the contact: DiskSource
  /// J into tissue (what HeatLedger::in rose by) and links; none where the circuit is open. Not in
  /// it: what the electrode and the patient's body took.
  double energy = 0;
  double link_energy = 0;       ///< J of these into links
  double electrode_energy = 0;  ///< J into the metal, out of what the current heats under it
  double body_energy = 0;     ///< J along the way through the body, CauteryOptions::body_resistance
  double surplus_energy = 0;  ///< J that links had no room for when they parted
  /// J that the generator delivered: energy, electrode_energy, body_energy and surplus_energy
  /// together, to rounding, but for substeps whose heat was not accepted (HeatReport::accepted).
  double generator_energy = 0;
  double hottest = 0;            ///< degrees Celsius
  int substeps = 0;              ///< of heat
  int potential_iterations = 0;  ///< over all substeps
  int heat_iterations = 0;       ///< over all substeps
  bool converged = true;         ///< each linear system reached its tolerance
  double removed_volume = 0;     ///< m^3 at rest
  Index torn = 0;                ///< elements of those removed that steam tore
  Index deferred = 0;            ///< elements, dry or torn before, that wait for energy
  TissueChange edit;             ///< of update(): what heat changed; empty if there was no edit
};

/// An element that heat took, or is to take.
struct DueElement {
  Index element;  ///< a tetrahedron, or a sheet's triangle, as heat/elements.h has them
  bool is_torn;   ///< by steam, rather than dry
};

/// What updates change of a cautery, at one version of its tissue, that of `heat`.
struct CauterySnapshot {
  HeatSnapshot heat;               ///< of its field
  std::vector<double> link_doses;  ///< [link_count] J that each link has taken, >= 0
  std::vector<DueElement> due;     ///< taken last, or waiting for energy; ascending
  double removal_energy = 0;       ///< J, as Cautery::removal_energy()
  double link_energy = 0;          ///< J, as Cautery::link_energy_spent()
  double electrode_energy = 0;     ///< J, as Cautery::electrode_energy()
  double electrode_temperature = kBodyTemperature;  ///< degrees Celsius
};

/// Couples an electrode to heat in tissue, and heat to topology. Deterministic.
///
/// A generator drives current from where the electrode touches the surface of live tissue; its heat
/// stiffens the tissue as it coagulates, to ThermalProperties::coagulated_stiffness in a
/// Neo-Hookean body or a sheet that was no stiffer, and boils it; it shrinks as it loses water and
/// collagen, and goes when it is dry or when steam tears it (or, by the paper's rule, when four
/// vertices have boiled). Where edges are longer than a disk as large as the contact is wide, its
/// closed form takes the place of the potential. Removal never outruns energy: all that heat has
/// removed would have cost no more to boil dry than what has been delivered; what is dry beyond
/// that waits, what steam would tear boils on.
///
/// A sheet takes part in all of it but one: the closed form of a disk is not for it, as current
/// spreads in its plane alone. Its triangles shrink in their plane and keep their thickness.
///
/// Undoing an edit does not take back the heat that led to it: what heat removed goes again in the
/// next update. A snapshot() goes back in heat, a WorldState in all.
class PBDSURG_API Cautery {
 public:
  /// At any time, also after edits, which it follows from here on. It starts at body temperature.
  /// @param tissue  must outlive this
  /// @throws InvalidArgument  naming the option out of range, or the body that is not there, is
  ///                          given twice or has no water to boil
  Cautery(const Tissue& tissue, std::span<const ThermalBody> bodies,
          const CauteryOptions& options = {});
  ~Cautery();
  /// Takes over. The other can then only be destroyed or assigned to.
  Cautery(Cautery&&) noexcept;
  Cautery& operator=(Cautery&&) noexcept;  ///< likewise

  /// Drives current for dt, lets heat spread, shrinks, removes and cuts; in substeps of 2 ms or a
  /// fifth of the time to boil, at most 32.
  ///
  /// Contact that is lost, dry tissue, an island: the circuit opens, as reported, and nothing is
  /// delivered. In cutting mode, with voltage enough, sparks reach wet surface 0.3 mm beyond, and
  /// through dry tissue the vertices behind it.
  ///
  /// Cost: O(heated part), and now and then O(surface), for where the electrode is about.
  /// @param solver     of the tissue, always the same
  /// @param generator  absent: switched off, the tissue cools
  /// @param dt         s
  /// @throws InvalidArgument  for a value out of range, or a solver of another tissue; then nothing
  ///                          has changed. Whatever a follower throws to refuse the edit: the heat
  ///                          has been delivered then, and the edit is tried again in the next
  ///                          update.
  /// @throws Error            if a device fails; what links and metal took in that substep is
  ///                          counted, tissue has none of it
  CauteryReport update(Solver& solver, const Electrode& electrode,
                       const std::optional<GeneratorSettings>& generator, double dt);

  /// The same without the edit, for who merges it with others: what heat changes is added to an
  /// edit, and counts once commit() was called, after that was applied.
  CauteryReport heat(const Solver& solver, const Electrode& electrode,
                     const std::optional<GeneratorSettings>& generator, double dt,
                     TopologyEdit& edit);
  /// Reads the positions of the next heat(), which then reads none: until it returns, its thread
  /// may be another than the one that steps the solver, as long as nobody edits the tissue or its
  /// rest shape. Cost: O(vertices).
  /// @throws InvalidArgument  for a solver of another tissue
  void read_positions(const Solver& solver);
  /// Counts what heat() added to an edit that was then applied.
  /// @param report  of that call; takes removed_volume and torn
  void commit(CauteryReport& report);

  /// Heat, doses and energies, to go back to. Cost: O(vertices + links).
  [[nodiscard]] CauterySnapshot snapshot() const;

  /// Goes back to a snapshot of this, or of another of the same bodies and options, while the
  /// topology is what it was. With the generator off, updates from then on give the bits that they
  /// gave from there; with it on, potential and conductivities are found anew, so the former agrees
  /// to PotentialOptions::tolerance and the latter to 1.5 %. What is restored twice goes on with
  /// the same bits both times. Cost: O(elements + links).
  /// @throws InvalidArgument  as HeatField::restore(), and naming the number of links that differs,
  ///                          the element out of range or out of order, or the energy or
  ///                          temperature out of range; then nothing has changed
  void restore(const CauterySnapshot& snapshot);

  /// Temperature and state of what it burns.
  [[nodiscard]] const HeatField& field() const;

  /// Around the electrode, at the start of the last substep in which the generator was on and the
  /// potential was solved: not by CauteryReport::is_disk. Without vertices if nothing was touched,
  /// or since restore(), which makes it another.
  [[nodiscard]] const PotentialField& potential() const;

  /// State of a tetrahedron; normal where the hook may not burn.
  /// @throws InvalidArgument  naming the tetrahedron that is not of the scene
  [[nodiscard]] HeatState state(Index tet) const;
  /// The same of a triangle of a sheet.
  /// @throws InvalidArgument  naming the triangle that is not of the scene
  [[nodiscard]] HeatState state_of_triangle(Index triangle) const;

  /// What went into links, J.
  [[nodiscard]] double link_energy_spent() const;

  /// Heat that the electrode's metal took instead of the tissue under it, J.
  [[nodiscard]] double electrode_energy() const;

  /// J that it would have cost to warm and boil dry all that heat removed: at most what was
  /// delivered to tissue.
  [[nodiscard]] double removal_energy() const;

 private:
  struct Work;
  Owned<Work> work_;
};

}  // namespace pbdsurg
