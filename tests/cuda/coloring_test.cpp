// SPDX-License-Identifier: Apache-2.0
// The device colours as the host does, bit for bit.
#include "pbdsurg/cuda/coloring.h"

#include <string>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/cuda/device.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::ContainsSubstring;

struct Named {
  std::string name;
  ColoringOptions options;
};

std::vector<Named> parallel_algorithms() {
  std::vector<Named> result(6);
  result[0] = {"greedy natural", {}};
  result[1] = {"greedy largest_valence", {}};
  result[1].options.order = GreedyOrder::largest_valence;
  result[2] = {"luby", {}};
  result[2].options.algorithm = ColoringAlgorithm::luby;
  result[3] = {"jones_plassmann", {}};
  result[3].options.algorithm = ColoringAlgorithm::jones_plassmann;
  result[4] = {"random_disc", {}};
  result[4].options.algorithm = ColoringAlgorithm::random_disc;
  result[5] = {"random_disc, palettes by conflicts", {}};
  result[5].options.algorithm = ColoringAlgorithm::random_disc;
  result[5].options.disc = {Palette::conflicts, 2.2};
  return result;
}

std::vector<testing::SampleConstraints> device_samples() {
  std::vector<testing::SampleConstraints> samples = testing::all_samples();
  samples.push_back(testing::hub_sample(10000));
  // more constraints than a grid has threads
  const TetMesh box = testing::make_box({44, 44, 44}, 1e-3);
  const std::vector<Edge> edges = find_edges(box.tets());
  samples.push_back(testing::make_sample<4>("half a million tets", box.tets(), box.vertex_count()));
  samples.push_back(
      testing::make_sample<2>("as many edges", std::span<const Edge>(edges), box.vertex_count()));
  const TetMesh organ = table2_mesh(2);
  samples.push_back(testing::make_sample<4>("organ", organ.tets(), organ.vertex_count()));
  // vertex blocks
  testing::SampleConstraints blocks{"vertex blocks", 0, {}, organ.tet_count()};
  blocks.lists = find_vertex_constraints(ConstraintVertices(organ.tets(), organ.vertex_count()));
  samples.push_back(blocks);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    samples.push_back(testing::crowded_sample(seed));
  }
  return samples;
}

}  // namespace

TEST_CASE("cuda coloring: every algorithm gives the host's colours", "[device]") {
  for (const testing::SampleConstraints& sample : device_samples()) {
    DeviceColoring device(sample.view());
    for (Named algorithm : parallel_algorithms()) {
      for (const std::uint64_t seed : {0, 12345}) {
        INFO(sample.name << ", " << algorithm.name << ", seed " << seed);
        algorithm.options.seed = seed;
        device.color(algorithm.options);
        CHECK(device.download() == pbdsurg::color_constraints(sample.view(), algorithm.options));
      }
    }
  }
}

TEST_CASE("cuda coloring: repair, limit and balance give the host's colours", "[device]") {
  for (const testing::SampleConstraints& sample : device_samples()) {
    DeviceColoring device(sample.view());
    const bool large = sample.lists.list_count() > 100'000;
    for (Named algorithm : parallel_algorithms()) {
      algorithm.options.repair = !large;  // the host takes seconds for a large lattice
      for (const Index max_colors : {0, 12}) {
        INFO(sample.name << ", " << algorithm.name << ", at most " << max_colors);
        algorithm.options.balance = true;
        algorithm.options.max_colors = max_colors;
        algorithm.options.seed = 5;
        device.color(algorithm.options);
        CHECK(device.download() == pbdsurg::color_constraints(sample.view(), algorithm.options));
      }
    }
  }
}

TEST_CASE("cuda coloring: a colouring does not depend on the ones before it", "[device]") {
  const testing::SampleConstraints sample = testing::random_sample("tets", 5000, 900, 4, 8);
  DeviceColoring device(sample.view());
  CHECK(device.color_count() == 0);
  CHECK(device.download() == Coloring{});
  ColoringOptions options;
  options.algorithm = ColoringAlgorithm::random_disc;
  options.repair = options.balance = true;
  device.color(options);
  const Coloring first = device.download();
  device.color({});
  CHECK(device.download() != first);
  device.color(options);
  CHECK(device.download() == first);
  CHECK(cuda::color_constraints(sample.view(), options) == first);
}

TEST_CASE("cuda coloring: what is sequential by nature is refused", "[device]") {
  const testing::SampleConstraints sample = testing::hub_sample(3);
  DeviceColoring device(sample.view());
  ColoringOptions options;
  options.order = GreedyOrder::saturation;
  CHECK_THROWS_WITH(device.color(options),
                    ContainsSubstring("saturation") && ContainsSubstring("sequential by nature"));
  options.order = GreedyOrder::smallest_last;
  CHECK_THROWS_AS(device.color(options), InvalidArgument);
  options.order = static_cast<GreedyOrder>(9);
  CHECK_THROWS_AS(device.color(options), InvalidArgument);
  options.order = GreedyOrder::natural;
  options.max_colors = -3;
  CHECK_THROWS_AS(device.color(options), InvalidArgument);
}

TEST_CASE("cuda coloring: bad constraints are refused by name, with or without a device",
          "[unit]") {
  const std::vector<Edge> bad{{0, 1}, {2, 2}};
  CHECK_THROWS_WITH(cuda::color_constraints({std::span<const Edge>(bad), 3}),
                    ContainsSubstring("constraint 1"));
  if (find_devices().devices.empty()) {
    CHECK_THROWS_AS(cuda::color_constraints({std::span<const Edge>(bad).first(1), 3}),
                    BackendUnavailable);
  }
}

}  // namespace pbdsurg::cuda
