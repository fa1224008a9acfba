// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/peers.h"

#include <algorithm>
#include <array>
#include <fstream>

#include "pbdsurg/base/error.h"

namespace pbdsurg::bench {
namespace {

Json read_peers() {
  std::ifstream file(PBDSURG_PEERS);
  Json peers = Json::parse(file, nullptr, false);
  if (!peers.is_object()) {
    throw FileError(PBDSURG_PEERS ": is no JSON object");
  }
  return peers;
}

bool is_beside(const Json& conditions, const Json& row) {
  return std::ranges::all_of(std::array{"scenario", "mesh", "away_m", "step_ms"},
                             [&](const char* key) { return conditions.at(key) == row.at(key); });
}

}  // namespace

Peers peers_beside(const Json& ours) {
  const Json peers = read_peers();
  const Json& conditions = peers.at("conditions");
  Peers result{"", Json::array()};
  if (std::ranges::none_of(ours, [&](const Json& row) { return is_beside(conditions, row); })) {
    return result;
  }
  result.notes = "- rows of others: " + text_of(peers.at("source")) + "\n- their error counts " +
                 text_of(peers.at("error")) + "\n";
  for (const Json& point : peers.at("points")) {
    Json known = conditions;
    known.update(point);
    Json row;
    for (const auto& item : ours.at(0).items()) {
      row[item.key()] = known.value(item.key(), Json());
    }
    row["ours"] = false;
    result.rows.push_back(row);
  }
  return result;
}

}  // namespace pbdsurg::bench
