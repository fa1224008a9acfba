// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools that meet surfaces, jaws that hold tissue, and bodies that meet each other, by chance.

#include <span>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/choices.h"

namespace pbdsurg::testing {

/// Of one solver, and of a twin with the same tissue that is to do the same.
class RandomTouches {
 public:
  /// One change, of those that the method and the executor know.
  /// @param twin  or null
  void change(Choices& choices, Solver& solver, Solver* twin);

  /// @return  what tools feel, what they hold, or what bodies meet differently in the last step, to
  ///          the bit; empty if nothing does
  [[nodiscard]] std::string difference(const Solver& solver, const Solver& twin) const;

 private:
  void add_tool(Choices& choices, Solver& solver, Solver* twin);
  void change_tool(Choices& choices, Solver& solver, Solver* twin);
  void move_tools(Choices& choices, Solver& solver, Solver* twin) const;
  static void let_bodies_meet(Choices& choices, Solver& solver, Solver* twin);
  void grasp(Choices& choices, Solver& solver, Solver* twin);

  std::vector<ToolId> tools_;     // that push
  std::vector<ToolId> grippers_;  // that hold
};

/// @param surfaces  of all bodies, as of the last step
/// @return          of which body the solver has other triangles for what touches it; empty if of
///                  none, or if nothing does
[[nodiscard]] std::string surface_difference(const Solver& solver,
                                             std::span<const LiveSurface> surfaces);

}  // namespace pbdsurg::testing
