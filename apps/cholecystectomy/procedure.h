// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The scripted operation: the paper's three experiments, one after another.

#include <span>
#include <string>
#include <vector>

#include "apps/cholecystectomy/simulation.h"

namespace cholecystectomy {

/// Watches a run.
class Observer {
 public:
  virtual ~Observer() = default;

  /// After every step. @param progress  share of the whole procedure that is done, (0, 1]
  virtual void step(const Simulation& simulation, double progress) = 0;

  /// At a moment worth a picture. @param name  usable in a file name
  virtual void moment(const Simulation& simulation, const std::string& name) = 0;
};

/// How far the dragged tissue is from where it was, after release (figure 9 of the paper).
struct Recovery {
  std::vector<double> times;      ///< s since release
  std::vector<double> distances;  ///< m, mean over the vertices that were held
};

/// How a run went.
struct Course {
  double held_force = 0;  ///< N, of the tissue on the grasper at the end of the drag
  Recovery recovery;      ///< as far as it came
  bool is_interrupted = false;
  std::string failure;  ///< why the operation could not go on; empty if it could
};

/// Runs everything: drag and release the fundus; burn Calot's fat; cut the membrane from the fundus
/// on while the grasper pulls.
/// It ends before its time when is_interrupted() tells so, asked after each step, then with a
/// moment "interrupted"; and where it cannot go on.
/// @param time_scale  of the lengths of all parts; 1 is the operation as designed, less is a
/// sketch,
///                    in which hands and heat are as much faster
Course run_procedure(Simulation& simulation, std::span<Observer* const> observers,
                     double time_scale);

}  // namespace cholecystectomy
