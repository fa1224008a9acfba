// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/tet_check.h"

#include <algorithm>
#include <locale>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "pbdsurg/mesh/quality.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/mesh/findings.h"

namespace pbdsurg {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kSliver = 10;  // degrees: smaller dihedral angles slow convergence

std::string number(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(4);
  text << value;
  return text.str();
}

}  // namespace

void measure_tets(const MeshData& mesh, std::size_t twice, MeshReport& report) {
  std::vector<Index> flat, negative, positive;
  double smallest = std::numbers::pi, largest = 0, ratio_sum = 0, signed_volume = 0;
  Index slivers = 0;
  report.min_radius_ratio = 1;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const double volume = tet_volume(mesh.points, tet);
    signed_volume += volume;
    if (is_flat(mesh.points, tet)) {
      flat.push_back(static_cast<Index>(t));
    } else {
      (volume < 0 ? negative : positive).push_back(static_cast<Index>(t));
    }
    const auto angles = dihedral_angles(mesh.points, tet);
    const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
    smallest = std::min(smallest, *least);
    largest = std::max(largest, *most);
    slivers += *least * kDegrees < kSliver ? 1 : 0;
    const double ratio = radius_ratio(mesh.points, tet);
    report.min_radius_ratio = std::min(report.min_radius_ratio, ratio);
    ratio_sum += ratio;
  }
  report.min_dihedral = smallest;
  report.max_dihedral = largest;
  report.mean_radius_ratio = ratio_sum / static_cast<double>(mesh.tets.size());
  report.turned = negative.size() > positive.size();
  const std::vector<Index>& inverted = report.turned ? positive : negative;
  report.inverted = static_cast<Index>(inverted.size());
  report.flat = static_cast<Index>(flat.size());
  report.volume = report.turned ? -signed_volume : signed_volume;
  add_finding(report, Severity::error, "inverted tets", inverted);
  if (flat.size() > twice) {
    add_finding(report, Severity::error, "flat tets (volume zero to rounding)", flat);
  }
  if (report.turned) {
    add_finding(report, Severity::note,
                "the corners of most tets are counted the other way round; all were "
                "judged after turning the whole mesh");
  }
  if (slivers > 0) {
    add_finding(report, Severity::warning,
                std::to_string(slivers) + " of " + std::to_string(report.tets) +
                    " tets have a dihedral angle under " + number(kSliver) +
                    " degrees; the smallest is " + number(smallest * kDegrees));
  }
}

void count_faces(std::span<const Tet> tets, MeshReport& report) {
  std::vector<Triangle> faces;
  faces.reserve(4 * tets.size());
  for (const Tet& tet : tets) {
    for (const auto& [i, j, k] : kTetTriangles) {
      faces.push_back({tet[i], tet[j], tet[k]});
      std::sort(faces.back().begin(), faces.back().end());
    }
  }
  std::sort(faces.begin(), faces.end());
  std::vector<Triangle> overfull;
  for (std::size_t begin = 0; begin < faces.size();) {
    std::size_t end = begin + 1;
    while (end < faces.size() && faces[end] == faces[begin]) {
      ++end;
    }
    if (end - begin > 2) {
      overfull.push_back(faces[begin]);
    }
    ++report.faces;
    begin = end;
  }
  report.overfull_faces = static_cast<Index>(overfull.size());
  add_finding(report, Severity::error, "faces of three or more tets, which overlap", overfull);
}

}  // namespace pbdsurg
