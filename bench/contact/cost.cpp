// SPDX-License-Identifier: Apache-2.0
#include "bench/contact/cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "bench/contact/blocks.h"
#include "bench/support/subject.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr int kPressSteps = 40;
constexpr float kDepth = 3e-3F, kRadius = 2.5e-3F, kBetween = 20e-3F;  // m
constexpr float kSway = 0.2e-3F;                                       // m, so that contacts change
constexpr TissueContact kBodies{.thickness = 0.5e-3F, .friction = 0.1F};
constexpr float kHeld = 4e-3F;  // m, around a place that jaws hold
constexpr float kLift = 4e-3F;  // m

// The lowest vertex of the gallbladder, and the lowest at some way from it.
std::array<Eigen::Vector3f, 2> lowest_places(const Scene& scene) {
  const Body& body = scene.body(scene.find_body("gallbladder"));
  std::vector<Eigen::Vector3f> places;
  for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
    places.push_back(scene.positions()[v].cast<float>());
  }
  const auto is_lower = [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return a.z() < b.z();
  };
  const Eigen::Vector3f first = *std::ranges::min_element(places, is_lower);
  std::erase_if(places, [&](const Eigen::Vector3f& place) {
    return (place - first).head<2>().norm() < kBetween;
  });
  return {first, *std::ranges::min_element(places, is_lower)};
}

// Its links beyond the middle, along the gallbladder.
std::vector<Index> half_of_membrane(const Scene& scene) {
  std::vector<double> along;
  for (const Link& link : scene.links()) {
    along.push_back(scene.positions()[link.first].x());
  }
  const double middle = median(along);
  std::vector<Index> links;
  for (std::size_t i = 0; i < along.size(); ++i) {
    if (along[i] > middle) {
      links.push_back(static_cast<Index>(i));
    }
  }
  return links;
}

// Vertices of the gallbladder around a place.
std::vector<TissuePoint> points_around(const Scene& scene, const Eigen::Vector3f& place) {
  const Body& body = scene.body(scene.find_body("gallbladder"));
  std::vector<TissuePoint> points;
  for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
    if ((scene.positions()[v].cast<float>() - place).norm() < kHeld) {
      points.push_back({{v, kInvalidIndex, kInvalidIndex}, {1, 0, 0}});
    }
  }
  return points;
}

struct Stage {
  const char* name;
  std::optional<ContactFeatures> features;  // that two shafts meet
  bool do_bodies_meet;
  bool do_jaws_hold;
};

// What steps, and what touches it.
class Variant {
 public:
  Variant(const Scene& scene, const CostSubject& subject, const Stage& stage)
      : solver_(scene, subject.options), step_(subject.step), places_(lowest_places(scene)) {
    solver_.tissue().apply({.remove_links = half_of_membrane(scene)});
    const Capsule shaft{{0, 0, 0}, {0, 0, -0.15F}, kRadius};
    for (std::size_t i = 0; stage.features && i < places_.size(); ++i) {
      tools_.push_back(solver_.add_tool({&shaft, 1}, pose(i, 0), {*stage.features, 0}));
    }
    if (stage.do_bodies_meet) {
      solver_.set_body_contact(0, 1, kBodies);
    }
    if (stage.do_jaws_hold) {
      Grip grip{.clamp_force = 1, .friction = 0.5F};
      grip.pad.half_length = grip.pad.half_width = 2 * kHeld;
      holder_ = solver_.add_tool({}, at(places_[0]));
      solver_.grasp(*holder_, points_around(scene, places_[0]), grip);
    }
  }

  // us: of the clock on a device, of the processor on one thread
  double time_step(int round) {
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      solver_.move_tool(tools_[i], pose(i, round));
    }
    if (holder_) {
      solver_.move_tool(*holder_,
                        at(places_[0] + Eigen::Vector3f(sway(round), 0, -kLift * share(round))));
    }
    if (solver_.options().executor.kind() == ExecutorKind::device) {
      return 1e3 * time_of([&] { solver_.step(step_); });
    }
    const double before = thread_seconds();
    solver_.step(step_);
    return 1e6 * (thread_seconds() - before);
  }

  [[nodiscard]] Index contacts() const {
    return solver_.last_report().contacts + static_cast<Index>(solver_.body_contacts().size());
  }

 private:
  [[nodiscard]] static float share(int round) {
    return static_cast<float>(std::min(round, kPressSteps)) / kPressSteps;
  }
  [[nodiscard]] static float sway(int round) {
    return round < kPressSteps ? 0 : kSway * std::sin(0.3F * static_cast<float>(round));
  }
  [[nodiscard]] ToolPose pose(std::size_t tool, int round) const {
    return at(places_[tool] + Eigen::Vector3f(sway(round), 0, kDepth * share(round) - kRadius));
  }

  Solver solver_;
  float step_;
  std::array<Eigen::Vector3f, 2> places_;
  std::vector<ToolId> tools_;
  std::optional<ToolId> holder_;
};

constexpr std::array kStages{Stage{"the step, without contact", std::nullopt, false, false},
                             Stage{"tools meet vertices", ContactFeatures::vertices, false, false},
                             Stage{"tools meet all features", ContactFeatures::all, false, false},
                             Stage{"the same, and bodies meet", ContactFeatures::all, true, false},
                             Stage{"jaws hold what is around", std::nullopt, false, true}};

}  // namespace

std::vector<ContactCost> contact_costs(const CostSubject& subject, int rounds) {
  Scene scene = make_liver_and_gallbladder(kLargestScene, subject.model);
  scene.set_gravity({0, 0, 9.81F});  // from the gallbladder to the liver
  std::array<std::unique_ptr<Variant>, kStages.size()> variants;
  std::array<std::vector<double>, kStages.size()> times;
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    try {
      variants[i] = std::make_unique<Variant>(scene, subject, kStages[i]);
    } catch (const BackendUnavailable&) {  // the row stays empty
    }
  }
  for (int round = 0; round < kPressSteps + rounds; ++round) {
    for (std::size_t i = 0; i < kStages.size(); ++i) {
      const double time = variants[i] ? variants[i]->time_step(round) : 0;
      if (round >= kPressSteps) {
        times[i].push_back(time);
      }
    }
  }
  std::vector<ContactCost> costs;
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    costs.push_back({kStages[i].name, std::nullopt, std::nullopt, 0});
    if (!variants[i]) {
      continue;
    }
    std::vector<double> longer = times[i];
    for (std::size_t round = 0; i > 0 && round < longer.size(); ++round) {
      longer[round] -= times[0][round];
    }
    costs[i].us = median(longer);
    costs[i].share = *costs[i].us / median(times[i]);
    costs[i].contacts = variants[i]->contacts();
  }
  return costs;
}

}  // namespace pbdsurg::bench
