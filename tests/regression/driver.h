// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The one place in which the programs of this folder call the library: a solver, all that follows
/// its edits, and hashes of what can be read of them.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/surface_map.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/surgery/lumen.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/regression/record.h"
#include "tests/support/digest.h"

namespace pbdsurg::testing {

/// Follows all of it through every edit.
class Driver {
 public:
  /// @param options  with any executor and rounding: in strict mode the hashes are the same for all
  Driver(const Scene& scene, SolverOptions options, const Executor& executor);
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  // --- followers, in any order, before the edits that they follow --------------------------------

  void follow_surface(Index body);
  void follow_pieces();
  /// A line fills the first hollow of a body with gas, to 300 Pa.
  void fill_lumen(Index body);
  void follow_strands(const ConnectiveTissue& strands);
  /// Looks at contacts between bodies, at those of tools, and at grips.
  void follow_contacts() { follows_contacts_ = true; }
  void follow_heat(std::span<const ThermalBody> bodies);
  void switch_on_cautery(std::span<const ThermalBody> bodies, CauteryOptions options);

  // --- what happens ------------------------------------------------------------------------------

  void step(float dt);
  void start_step(float dt);
  void finish_step();
  void edit(const TopologyEdit& edit);
  /// Takes the last edit back, whoever made it.
  void undo();
  /// Cuts, and takes the front for the next call.
  void cut(const CutSurface& surface, CutStyle style);
  /// The same with a plan made elsewhere.
  void cut(const CutPlan& plan);
  /// Edits, without parts of fewer tetrahedra.
  void edit_without_crumbs(TopologyEdit edit, Index smallest);
  void tear(std::span<const BladeSweep> blades = {});
  /// @return  whether tissue or links went
  bool burn(const Electrode& electrode, const std::optional<GeneratorSettings>& generator,
            double dt);
  void heat(double dt, std::span<const HeatSource> sources);
  void compact();

  /// For tools, writes and all that needs no follower.
  [[nodiscard]] Solver& solver() { return solver_; }
  [[nodiscard]] const CutFront& front() const { return front_; }

  /// Records all that there is to read.
  /// @throws std::logic_error  if a vertex is not finite, or no bodies touch where contacts are
  ///                           followed: such a program would test nothing
  void look(Record& record, int checkpoint);

 private:
  [[nodiscard]] const HeatField* heat_field() const;
  void note(const TissueChange& change);
  void note(const StepReport& report);
  void note(const CauteryReport& report);
  void look_at_state(Record& record, int checkpoint) const;
  void look_at_heat(Record& record, int checkpoint);
  [[nodiscard]] std::uint64_t topology() const;
  [[nodiscard]] std::uint64_t rest_values() const;
  [[nodiscard]] std::uint64_t plan() const;
  [[nodiscard]] std::uint64_t tools(Index copy) const;
  [[nodiscard]] std::uint64_t contacts(Index copy) const;
  [[nodiscard]] std::uint64_t surfaces();
  [[nodiscard]] std::uint64_t pieces() const;
  [[nodiscard]] std::uint64_t strands() const;
  [[nodiscard]] std::uint64_t lumen() const;

  Solver solver_;
  Index copies_;
  Executor executor_;
  std::optional<HeatField> heat_;
  std::optional<Cautery> cautery_;
  std::optional<ConnectiveTissue> strands_;
  std::deque<LiveSurface> surfaces_;
  std::vector<std::uint64_t> seen_surfaces_;  // versions
  std::deque<SurfaceMap> maps_;               // of surfaces_, where there is heat
  std::optional<LivePieces> pieces_;
  std::shared_ptr<Lumen> lumen_;
  bool follows_contacts_ = false;

  CutFront front_;
  Digest reports_, edits_, burns_;
};

}  // namespace pbdsurg::testing
