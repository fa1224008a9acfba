// SPDX-License-Identifier: Apache-2.0
// Damaged files. Run under the sanitizers, this is what finds reads and allocations out of bounds.
#include <algorithm>
#include <array>
#include <cctype>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/read.h"

#include "tests/support/catch.h"
#include "tests/support/sample_files.h"

namespace pbdsurg {
namespace {

using testing::SampleFile;
using testing::TemporaryFolder;

/// Whether a mesh that a reader lets through keeps the promise of MeshData.
bool in_range(const MeshData& mesh) {
  const auto good = [&](const auto& elements) {
    return std::all_of(elements.begin(), elements.end(), [&](const auto& element) {
      return std::all_of(element.begin(), element.end(), [&](Index v) {
        return v >= 0 && static_cast<std::size_t>(v) < mesh.points.size();
      });
    });
  };
  return good(mesh.tets) && good(mesh.triangles) &&
         std::all_of(mesh.points.begin(), mesh.points.end(),
                     [](const Eigen::Vector3d& p) { return p.allFinite(); });
}

/// Reads a damaged file, which may succeed or throw FileError, nothing else.
/// @return  whether it was refused
bool refused(const std::filesystem::path& path, std::size_t file_size) {
  try {
    const MeshData mesh = read_mesh(path);
    REQUIRE(in_range(mesh));
    // each element takes a byte at least; nothing is invented
    REQUIRE(mesh.points.size() + mesh.tets.size() <= file_size);
    return false;
  } catch (const FileError&) {
    return true;
  }
}

/// A few bytes changed: bits flipped, digits and numbers made extreme, pieces cut out or repeated.
std::string damaged(const std::string& bytes, std::uint64_t round) {
  const auto random = [&](std::uint64_t draw, std::size_t below) {
    return static_cast<std::size_t>(random_bits(1, round, draw) % below);
  };
  std::string out = bytes;
  const std::size_t at = random(0, bytes.size());
  switch (random(1, 6)) {
    case 0:
      out[at] = static_cast<char>(out[at] ^ (1 << random(2, 8)));
      break;
    case 1:
      out[at] = static_cast<char>(random(2, 256));
      break;
    case 2: {  // the next number in text becomes another
      const auto digit = std::find_if(out.begin() + static_cast<std::ptrdiff_t>(at), out.end(),
                                      [](char c) { return std::isdigit(c & 0x7F) != 0; });
      constexpr std::array<const char*, 6> kNumbers{"-1",  "4294967296", "9223372036854775807",
                                                    "nan", "99999",      "0"};
      if (digit != out.end()) {
        out.replace(static_cast<std::size_t>(digit - out.begin()), 1, kNumbers[random(2, 6)]);
      }
      break;
    }
    case 3:  // an extreme binary number
      for (std::size_t i = at; i < std::min(at + 4 + 4 * random(2, 2), out.size()); ++i) {
        out[i] = random(3, 2) == 0 ? '\xff' : '\x7f';
      }
      break;
    case 4:
      out.erase(at, 1 + random(2, 64));
      break;
    default:
      out.insert(at, bytes.substr(random(2, bytes.size()), 1 + random(3, 64)));
  }
  return out;
}

std::vector<SampleFile> all_samples() {
  const MeshData box = testing::box_mesh(2);
  std::vector<SampleFile> samples = testing::tet_samples(box);
  for (const auto& more :
       {testing::tet_only_samples(box), testing::surface_samples(testing::box_surface(2))}) {
    samples.insert(samples.end(), more.begin(), more.end());
  }
  return samples;
}

}  // namespace

TEST_CASE("read mutation: a cut-off file is refused or complete, never worse", "[property]") {
  const TemporaryFolder folder;
  for (const SampleFile& sample : all_samples()) {
    INFO(sample.encoding);
    for (const SampleFile::Part& part : sample.parts) {
      for (const SampleFile::Part& other : sample.parts) {
        folder.put(other.name, other.bytes);
      }
      int refusals = 0;
      int cuts = 0;
      const std::size_t step = std::max<std::size_t>(1, part.bytes.size() / 150);
      for (std::size_t size = 0; size < part.bytes.size() * 3 / 4; size += step) {
        folder.put(part.name, part.bytes.substr(0, size));
        refusals += refused(folder / sample.parts[0].name, part.bytes.size()) ? 1 : 0;
        ++cuts;
      }
      // OBJ has no counts, Medit, PLY-like sections and VTK polydata may end early; the others
      // notice
      const bool counted = part.name.find(".obj") == std::string::npos &&
                           part.name.find(".mesh") == std::string::npos;
      CHECK(cuts > 100);
      if (counted) {
        CHECK(refusals >= cuts * 9 / 10);
      }
    }
  }
}

TEST_CASE("read mutation: damaged files are refused or read within bounds", "[property]") {
  const TemporaryFolder folder;
  int refusals = 0;
  std::uint64_t round = 0;
  for (const SampleFile& sample : all_samples()) {
    INFO(sample.encoding);
    for (const SampleFile::Part& part : sample.parts) {
      for (const SampleFile::Part& other : sample.parts) {
        folder.put(other.name, other.bytes);
      }
      for (int i = 0; i < 250; ++i) {
        const std::string bytes = damaged(part.bytes, round++);
        INFO("round " << round);
        folder.put(part.name, bytes);
        refusals += refused(folder / sample.parts[0].name, bytes.size()) ? 1 : 0;
      }
    }
  }
  CHECK(refusals > static_cast<int>(round) / 4);
}

}  // namespace pbdsurg
