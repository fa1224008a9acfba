// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/findings.h"

namespace pbdsurg {

std::string in_words(Index id) {
  return std::to_string(id);
}
std::string in_words(const Edge& edge) {
  return std::to_string(edge[0]) + "-" + std::to_string(edge[1]);
}
std::string in_words(const Triangle& t) {
  return std::to_string(t[0]) + "-" + std::to_string(t[1]) + "-" + std::to_string(t[2]);
}
std::string in_words(const std::pair<Triangle, Triangle>& pair) {
  return in_words(pair.first) + " with " + in_words(pair.second);
}
std::string in_words(const std::pair<Index, Index>& pair) {
  return std::to_string(pair.first) + " as " + std::to_string(pair.second);
}

void add_finding(MeshReport& report, Severity severity, std::string text) {
  report.findings.push_back({severity, std::move(text)});
}

}  // namespace pbdsurg
