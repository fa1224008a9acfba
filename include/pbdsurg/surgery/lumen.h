// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What fills a hollow organ: gas or liquid under pressure, that flows in, out, and through holes.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/solver/custom_constraints.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/cavity.h"

namespace pbdsurg {

struct FillingLaw;

/// How contents answer to pressure.
enum class LumenContents : std::uint8_t {
  gas,     ///< ideal, at the temperature around it: pressure times volume stays (Boyle)
  liquid,  ///< its volume stays
};

/// What a lumen is filled with, and how that flows.
struct LumenOptions {
  LumenContents contents = LumenContents::gas;  ///< gas or liquid
  float density = 1.2F;  ///< kg/m^3, positive: of air; 1.8 of carbon dioxide, 1000 of water
  float ambient_pressure = 101325;  ///< Pa, positive: around the tissue
  /// In (0, 1], the coefficient of discharge of an orifice: 0.6 where its edge is sharp.
  float discharge = 0.6F;
};

/// Of one copy: what a program saves and brings back.
struct LumenState {
  double amount = 0;   ///< m^3, of the contents as they are at ambient pressure; >= 0
  float pressure = 0;  ///< Pa, above ambient, in the last substep
};

/// The contents of a Cavity: one constraint on its volume whose multiplier is the pressure, so that
/// the stiffest contents are stable in steps of any length. Pressure pushes the wall, and caps over
/// holes, along their normals; those of a closed surface sum to zero.
///
/// For a solver on a CPU, or on a device in compliance mode, launch by launch: there a pressure
/// that would take the wall where nothing is finite does nothing, and throws nothing.
///
/// At first there is as much as fills the lumen at ambient pressure. Flows are volumes at ambient
/// pressure, too. Through an orifice of area A, dp below the pressure inside, flow
/// Q = C A sqrt(2 dp / density), C the coefficient of discharge: the incompressible law (White,
/// "Fluid Mechanics", flow meters), for gas to 3 % up to 5 kPa. Below some pascals it falls in
/// proportion to dp, as C A sqrt(2 / density) dp / (dp^2 + (1 Pa)^2)^(1/4). It has the same form
/// from outside, whence the same contents come. Holes that edits make are orifices, too: see
/// Cavity.
///
/// An edit leaves pressure as it is: contents take the place of tissue that went. A lumen without a
/// wall is empty. Pressure is the same everywhere: weight and inertia of contents are left out.
///
/// Amounts do not go back with an undo, a Snapshot or a step that throws: save state().
/// Deterministic. Cost of a sweep: O(triangles).
class PBDSURG_API Lumen final : public CustomConstraints {
 public:
  /// For Solver::add_constraints() or World::add_constraints() of the same tissue.
  /// @param wall  closed, as of find_cavities()
  /// @throws InvalidArgument  as Cavity, and naming the option out of range
  Lumen(const Tissue& tissue, std::span<const Triangle> wall, const LumenOptions& options = {});
  ~Lumen() override;

  /// Its walls and holes.
  [[nodiscard]] const Cavity& cavity() const noexcept { return cavity_; }
  [[nodiscard]] const LumenOptions& options() const noexcept { return options_; }  ///< as given

  /// @name Flow
  /// Of all copies, from the next step on.
  /// @{

  /// An insufflator or a syringe.
  /// @param flow  m^3/s, finite; out of the lumen where negative, as long as there is something
  /// @throws InvalidArgument  naming the flow
  void set_inflow(float flow);
  /// An orifice to what is around the tissue, beside holes.
  /// @param area  m^2, finite, >= 0
  /// @throws InvalidArgument  naming the area
  void set_leak(float area);
  /// A line to a reservoir of the same contents: an insufflator that holds a pressure, a bag on a
  /// stand.
  /// @param area      m^2, finite, >= 0: of the orifice that it flows through; 0: closed
  /// @param pressure  Pa, above ambient, finite
  /// @throws InvalidArgument  naming what is out of range
  void set_reservoir(float area, float pressure);

  /// @}
  /// @name State
  /// @{

  /// After the last substep; before the first step that of an empty copy.
  /// @throws InvalidArgument  naming a copy below zero
  [[nodiscard]] LumenState state(Index copy = 0) const;
  /// Pa, above ambient.
  /// @throws InvalidArgument  as state()
  [[nodiscard]] float pressure(Index copy = 0) const { return state(copy).pressure; }
  /// From here on it has this.
  /// @throws InvalidArgument  naming a copy below zero, or the number that is not finite or
  ///                          negative, or a pressure below vacuum
  void set_state(const LumenState& state, Index copy = 0);

  /// @}

  [[nodiscard]] std::string name() const override { return "lumen"; }
  [[nodiscard]] std::span<const Index> vertices() const override { return vertices_; }
  /// @throws InvalidArgument  if set_state() named a copy that the solver does not have
  void begin_step(Index copies) override;
  /// @throws InvalidArgument  if the solver is of another tissue than the wall
  void begin_substep(const ConstraintSweep& sweep) override;
  void project(ConstraintSweep& sweep) override;
  [[nodiscard]] Filling* filling() noexcept override;
  void follow(const Tissue&, const TissueChange&) noexcept override {}  // cavity_ does
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering&) noexcept override;

 private:
  struct Copy {
    LumenState now;             // after the last substep
    std::uint64_t version = 0;  // of the cavity that it fills
    // of a substep
    double most = 0, drain = 0;  // as FillingSubstep, like the following
    float pressure = 0, multiplier = 0;
    std::vector<ConstraintSweep::Corner> corners;  // [vertices of the wall]
    std::vector<Vec3<double>> ways;                // likewise, m
  };
  class OnDevice;

  void list_vertices();
  [[nodiscard]] FillingLaw law() const noexcept;
  [[nodiscard]] double measure(Copy& own, const ConstraintSweep& sweep) const;
  [[nodiscard]] double volume_of(std::span<const Vec3<double>> places) const;
  [[nodiscard]] double hole_area(const ConstraintSweep& sweep) const;

  Cavity cavity_;
  LumenOptions options_;
  float inflow_ = 0, leak_ = 0, reservoir_area_ = 0, reservoir_pressure_ = 0;
  std::uint64_t listed_ = 0;         // version of the cavity, of these:
  std::vector<Index> vertices_;      // of the cavity
  std::vector<Triangle> triangles_;  // of the cavity, in places of vertices_
  std::vector<Index> hole_ends_;     // of triangles_
  Index wall_count_ = 0;             // likewise
  std::vector<Copy> copies_;
  std::unique_ptr<OnDevice> on_device_;
};

}  // namespace pbdsurg
