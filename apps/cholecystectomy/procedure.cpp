// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/procedure.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "apps/cholecystectomy/interruption.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;

constexpr double kCutPower = 30;       // W, a usual setting in laparoscopy
constexpr double kSeparatePower = 40;  // W
constexpr float kHandSpeed = 0.08F;    // m/s, between places
constexpr float kWorkSpeed = 0.012F;   // m/s, while cutting

// Lengths of the parts, s.
constexpr double kSettle = 0.3, kDrag = 0.35, kHold = 0.5, kRecover = 0.5;
constexpr double kApproach = 0.8, kRetract = 0.4, kBurn = 3.5;
constexpr double kRegrasp = 1.2, kPull = 0.8, kSeparate = 6.0;

// Ends a script where a signal came.
struct Interrupted {};

// Steps through the script and tells the observers.
class Script {
 public:
  Script(Simulation& simulation, std::span<Observer* const> observers, double time_scale)
      : simulation_(simulation), observers_(observers), time_scale_(time_scale) {
    for (const double part : {kSettle, kApproach, kDrag, kHold, kRecover, kApproach, kRetract,
                              kBurn, kRegrasp, kPull, kSeparate}) {
      planned_ += steps(part);
    }
  }

  /// Runs a part. @param power  W, in an operation of full length
  /// @param act  void(double share), called before each step with its share (0, 1]
  template <class Act>
  void run(double seconds, double power, Act act) {
    const int count = steps(seconds);
    for (int i = 1; i <= count; ++i) {
      act(static_cast<double>(i) / count);
      simulation_.advance(power > 0 ? std::optional(pbdsurg::cut_settings(power / time_scale_))
                                    : pbdsurg::off_settings());
      if (simulation_.totals.non_finite_vertices > 0) {
        throw CannotGoOn("the state is no longer finite");
      }
      ++done_;
      for (Observer* observer : observers_) {
        observer->step(simulation_, static_cast<double>(done_) / planned_);
      }
      if (is_interrupted()) {
        throw Interrupted();
      }
    }
  }

  /// Moves a tip towards a point. @param speed  m/s at most, in an operation of full length
  void approach(Instrument& instrument, const Eigen::Vector3f& point, float speed) {
    simulation_.approach(instrument, point, speed / static_cast<float>(time_scale_));
  }

  void moment(const std::string& name) {
    for (Observer* observer : observers_) {
      observer->moment(simulation_, name);
    }
  }

 private:
  [[nodiscard]] int steps(double seconds) const {
    return std::max(1, static_cast<int>(time_scale_ * seconds / simulation_.time_step + 0.5));
  }

  Simulation& simulation_;
  std::span<Observer* const> observers_;
  double time_scale_;
  int planned_ = 0;
  int done_ = 0;
};

// The vertex of an organ that lies farthest in a direction.
Eigen::Vector3f farthest(const Simulation& simulation, Organ organ,
                         const Eigen::Vector3f& direction) {
  const auto positions = simulation.tissue_of(organ);
  if (positions.empty()) {
    throw CannotGoOn(std::string("nothing is left of the ") + pbdsurg::name_of(organ));
  }
  return *std::max_element(positions.begin(), positions.end(),
                           [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
                             return a.dot(direction) < b.dot(direction);
                           });
}

Eigen::Vector3f centre_of(const Simulation& simulation, Organ organ) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  const auto positions = simulation.tissue_of(organ);
  for (const Eigen::Vector3f& x : positions) {
    sum += x / static_cast<float>(positions.size());
  }
  return sum;
}

// The vertex with tissue that is nearest to a point, or the point itself if none is left.
Eigen::Vector3f nearest_tissue(const Simulation& simulation, Organ organ,
                               const Eigen::Vector3f& point) {
  Eigen::Vector3f nearest = point;
  float least = std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& x : simulation.tissue_of(organ)) {
    if ((x - point).squaredNorm() < least) {
      least = (x - point).squaredNorm();
      nearest = x;
    }
  }
  return nearest;
}

// Where the membrane parts next: the middle of the living link nearest to the fundus, with a bias
// towards where the hook is; the point itself if none is left.
Eigen::Vector3f membrane_front(const Simulation& simulation, const Eigen::Vector3f& point) {
  const auto positions = simulation.solver.positions();
  Eigen::Vector3f front = point;
  float least = std::numeric_limits<float>::max();
  for (Index l = 0; l < simulation.scene.membrane_link_count; ++l) {
    if (!simulation.solver.tissue().is_link_alive(l)) {
      continue;
    }
    const pbdsurg::Link& link = simulation.solver.tissue().links()[l];
    const Eigen::Vector3f middle = 0.5F * (positions[link.first] + positions[link.second]);
    const float cost = middle.x() + 0.3F * (middle - point).norm();
    if (cost < least) {
      least = cost;
      front = middle;
    }
  }
  return front;
}

// Figure 9: drag, hold, release, and watch the tissue come back.
void drag_and_release(Simulation& simulation, Script& script, Course& course) {
  const Eigen::Vector3f start = simulation.grasper.tip;
  const std::vector<Eigen::Vector3f> untouched = simulation.solver.positions();
  script.run(kApproach, 0, [&](double) {
    script.approach(simulation.grasper, farthest(simulation, Organ::gallbladder, {-1, 0, -0.7F}),
                    2 * kHandSpeed);
  });
  const Eigen::Vector3f fundus = simulation.grasper.tip;
  const std::vector<Index> held = simulation.grasp(Organ::gallbladder, 6e-3F);
  std::vector<Eigen::Vector3f> now(held.size());
  const auto distance = [&] {
    simulation.solver.read_positions(held, now);
    double sum = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      sum += (now[i] - untouched[held[i]]).norm();
    }
    return sum / static_cast<double>(now.size());
  };

  const Eigen::Vector3f pull(-0.014F, -0.004F, -0.016F);
  script.run(kDrag, 0, [&](double share) {
    simulation.grasper.tip = fundus + static_cast<float>(share) * pull;
  });
  script.run(kHold, 0, [](double) {});
  course.held_force = simulation.world.force(simulation.grasper.tool).norm();
  script.moment("drag_000ms");

  simulation.release();
  Recovery& recovery = course.recovery;
  recovery = {{0}, {distance()}};
  const double released = simulation.time();
  double next = 0.025;
  script.run(kRecover, 0, [&](double) {
    script.approach(simulation.grasper, start, 3 * kHandSpeed);
    const double since = simulation.time() - released;
    if (since > 0) {
      recovery.times.push_back(since);
      recovery.distances.push_back(distance());
    }
    if (since >= next - 1e-6 && next < 0.11) {
      script.moment(next < 0.03 ? "drag_025ms" : next < 0.06 ? "drag_050ms" : "drag_100ms");
      next *= 2;
    }
  });
  recovery.times.push_back(simulation.time() - released);
  recovery.distances.push_back(distance());
  script.moment("drag_500ms");
}

// Figures 5 and 11: the hook burns its way along the side of Calot's fat that faces the scope.
void burn_fat(Simulation& simulation, Script& script) {
  const Eigen::Vector3f pouch = farthest(simulation, Organ::gallbladder, {0.8F, -0.5F, -0.6F});
  const Eigen::Vector3f facing = nearest_tissue(
      simulation, Organ::calot_fat,
      centre_of(simulation, Organ::calot_fat) + Eigen::Vector3f(-0.004F, -0.03F, -0.03F));
  script.run(kApproach, 0, [&](double) {
    script.approach(simulation.grasper, nearest_tissue(simulation, Organ::gallbladder, pouch),
                    2 * kHandSpeed);
    script.approach(simulation.hook, facing, 2 * kHandSpeed);
  });
  simulation.grasp(Organ::gallbladder, 5e-3F);
  const Eigen::Vector3f held = simulation.grasper.tip;
  script.run(kRetract, 0, [&](double share) {
    simulation.grasper.tip =
        held + static_cast<float>(share) * Eigen::Vector3f(-0.006F, -0.004F, -0.006F);
  });
  script.moment("burn_begin");

  for (int half = 0; half < 2; ++half) {
    script.run(kBurn / 2, kCutPower, [&](double share) {
      // there and back again, 5 mm along the fat
      const double way = half == 0 ? share : 1 - share;
      const Eigen::Vector3f aim =
          facing + static_cast<float>(way) * Eigen::Vector3f(0.005F, 0.001F, 0);
      script.approach(simulation.hook, nearest_tissue(simulation, Organ::calot_fat, aim),
                      kWorkSpeed);
    });
    script.moment(half == 0 ? "burn_middle" : "burn_end");
  }
}

// Figure 7: from the fundus on, under traction, link by link.
void separate(Simulation& simulation, Script& script) {
  simulation.release();
  // another port for the hook, so that its shaft reaches the gap past the fundus
  simulation.hook.port = {-0.15F, -0.06F, -0.04F};
  const Eigen::Vector3f fundus = farthest(simulation, Organ::gallbladder, {-0.6F, -0.2F, -1});
  script.run(kRegrasp, 0, [&](double share) {
    script.approach(simulation.grasper, nearest_tissue(simulation, Organ::gallbladder, fundus),
                    2 * kHandSpeed);
    // around the organ, not through it
    const Eigen::Vector3f waiting =
        membrane_front(simulation, fundus) + Eigen::Vector3f(-0.02F, -0.01F, -0.01F);
    const Eigen::Vector3f beside(waiting.x(), -0.06F, -0.04F);
    script.approach(simulation.hook, share < 0.6 ? beside : waiting, 4 * kHandSpeed);
  });
  simulation.grasp(Organ::gallbladder, 6e-3F);
  const Eigen::Vector3f held = simulation.grasper.tip;
  script.run(kPull, 0, [&](double share) {
    simulation.grasper.tip =
        held + static_cast<float>(share) * Eigen::Vector3f(0, -0.003F, -0.008F);
    script.approach(simulation.hook, membrane_front(simulation, simulation.hook.tip), kHandSpeed);
  });
  script.moment("separate_begin");

  const Eigen::Vector3f pulled = simulation.grasper.tip;
  for (int half = 0; half < 2; ++half) {
    script.run(kSeparate / 2, kSeparatePower, [&](double share) {
      const float way = static_cast<float>((half + share) / 2);
      simulation.grasper.tip = pulled + way * Eigen::Vector3f(0.006F, -0.006F, -0.026F);
      script.approach(simulation.hook, membrane_front(simulation, simulation.hook.tip), kHandSpeed);
    });
    script.moment(half == 0 ? "separate_middle" : "separate_end");
  }
  script.moment("separate_bed");
}

}  // namespace

Course run_procedure(Simulation& simulation, std::span<Observer* const> observers,
                     double time_scale) {
  Course course;
  Script script(simulation, observers, time_scale);
  try {
    script.run(kSettle, 0, [](double) {});
    script.moment("start");
    drag_and_release(simulation, script, course);
    burn_fat(simulation, script);
    separate(simulation, script);
  } catch (const Interrupted&) {
    course.is_interrupted = true;
    script.moment("interrupted");
  } catch (const CannotGoOn& error) {
    course.failure = error.what();
  }
  return course;
}

}  // namespace cholecystectomy
