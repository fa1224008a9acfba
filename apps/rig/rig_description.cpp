// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/rig_description.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

namespace rig {
namespace {

using nlohmann::json;
using pbdsurg::FileError;
using pbdsurg::InvalidArgument;

// The left and the right of two arms, as people are told to call them in the vendor's setup.
constexpr std::array<const char*, 2> kArmNames{"Left Device", "Right Device"};

// An object of the file, of which each key is read once: what is left over is a mistake.
class Reader {
 public:
  Reader(const json& object, std::string place) : object_(object), place_(std::move(place)) {
    if (!object.is_object()) {
      throw FileError(place_ + " is no JSON object; it must be one");
    }
  }

  [[nodiscard]] bool has(const char* key) {
    known_.push_back(key);
    return object_.contains(key);
  }

  [[nodiscard]] const json& at(const char* key) const { return object_.at(key); }

  /// A text that must be there.
  [[nodiscard]] std::string need(const char* key) {
    std::string value;
    read(key, value);
    if (value.empty()) {
      throw FileError(place_ + " has no \"" + key + "\"; it must have one");
    }
    return value;
  }

  [[noreturn]] void refuse(const char* key, const std::string& rule) const {
    throw FileError(place_ + ": \"" + key + "\" is " + object_.at(key).dump() + "; it must be " +
                    rule);
  }

  void read(const char* key, std::string& value) {
    if (!has(key)) {
      return;
    }
    if (!object_.at(key).is_string()) {
      refuse(key, "a text");
    }
    value = object_.at(key).get<std::string>();
  }

  void read(const char* key, bool& value) {
    if (!has(key)) {
      return;
    }
    if (!object_.at(key).is_boolean()) {
      refuse(key, "true or false");
    }
    value = object_.at(key).get<bool>();
  }

  /// A number from `least` to `most`, both included.
  template <class Number>
  void read(const char* key, Number& value, double least, double most) {
    if (!has(key)) {
      return;
    }
    const json& found = object_.at(key);
    const double number = found.is_number() ? found.get<double>() : std::nan("");
    if (!(number >= least && number <= most) ||
        (std::is_integral_v<Number> && number != std::floor(number))) {
      refuse(key, std::string(std::is_integral_v<Number> ? "a whole number" : "a number") +
                      " from " + json(least).dump() + " to " + json(most).dump());
    }
    value = static_cast<Number>(number);
  }

  /// One of some words.
  template <class Value, std::size_t N>
  void read(const char* key, Value& value,
            const std::array<std::pair<const char*, Value>, N>& words) {
    if (!has(key)) {
      return;
    }
    std::string known;
    for (const auto& [word, meaning] : words) {
      if (object_.at(key) == word) {
        value = meaning;
        return;
      }
      known += std::string(known.empty() ? "" : ", ") + '"' + word + '"';
    }
    refuse(key, "one of " + known);
  }

  /// After all was read.
  void finish() const {
    for (const auto& item : object_.items()) {
      if (std::find(known_.begin(), known_.end(), item.key()) == known_.end()) {
        std::string known;
        for (const std::string& key : known_) {
          known += (known.empty() ? "" : ", ") + key;
        }
        throw FileError(place_ + " has a \"" + item.key() + "\"; it may have " + known);
      }
    }
  }

  [[nodiscard]] const std::string& place() const { return place_; }

 private:
  const json& object_;
  std::string place_;
  std::vector<std::string> known_;
};

bool is_trace(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  return std::getline(file, line) && line.rfind("# pbdsurg device trace", 0) == 0;
}

HandleDescription read_handle(const json& object, const std::string& place) {
  Reader reader(object, place);
  HandleDescription handle;
  handle.port = reader.need("port");
  reader.read("closed", handle.range.closed, 0, 65535);
  reader.read("open", handle.range.open, 0, 65535);
  reader.finish();
  return handle;
}

HandDescription read_hand(const json& object, const std::string& place,
                          const std::filesystem::path& folder) {
  constexpr float kMostScale = 20;
  Reader reader(object, place);
  HandDescription hand;
  std::string device = "mouse";
  reader.read("device", device);
  if (device == "arm") {
    hand.mover = Mover::arm;
    reader.read("name", hand.arm_name);
    reader.read("serial_number", hand.serial_number);
    reader.read<pbdsurg::HeldPart, 2>(
        "holds", hand.held,
        {{{"tip", pbdsurg::HeldPart::tip}, {"handle", pbdsurg::HeldPart::handle}}});
    reader.read("motion_scale", hand.motion_scale, 1 / kMostScale, kMostScale);
    reader.read("force_scale", hand.force_scale, 0, kMostScale);
    reader.read("firm", hand.is_firm);
    reader.read<pbdsurg::ServoMode, 2>(
        "servo", hand.servo,
        {{{"model", pbdsurg::ServoMode::model}, {"paper", pbdsurg::ServoMode::paper}}});
    if (reader.has("handle")) {
      hand.handle = read_handle(object.at("handle"), place + ".handle");
    }
  } else if (device != "mouse") {
    hand.mover = Mover::trace;
    hand.trace = folder / device;
    if (!is_trace(hand.trace)) {
      reader.refuse("device", "\"mouse\", \"arm\", or the file of a device trace");
    }
  }
  reader.finish();
  return hand;
}

PedalsDescription read_pedals(const json& object, const std::string& place) {
  Reader reader(object, place);
  PedalsDescription pedals;
  pedals.keyboard = reader.need("keyboard");
  reader.read("cut", pedals.keys.cut, 0, 767);
  reader.read("coagulation", pedals.keys.coagulation, 0, 767);
  reader.finish();
  return pedals;
}

FaultDescription read_fault(const json& object, const std::string& place) {
  Reader reader(object, place);
  FaultDescription fault{};
  fault.fault = reader.need("fault");
  reader.read<Side, 2>("hand", fault.side, {{{"left", Side::left}, {"right", Side::right}}});
  reader.read("begin_s", fault.begin, 0, 1e6);
  reader.read("duration_s", fault.duration, 0, 1e6);
  reader.finish();
  return fault;
}

template <class Read>
auto read_list(Reader& reader, const char* key, Read&& read) {
  std::vector<decltype(read(json(), ""))> list;
  if (reader.has(key)) {
    const json& items = reader.at(key);
    if (!items.is_array()) {
      reader.refuse(key, "a list");
    }
    for (std::size_t i = 0; i < items.size(); ++i) {
      list.push_back(read(items[i], reader.place() + "." + key + "[" + std::to_string(i) + "]"));
    }
  }
  return list;
}

RigDescription read_file(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) {
    throw FileError(path.string() +
                    " cannot be opened; devices are mouse, openhaptics, emulator, "
                    "a device trace, or a rig's file");
  }
  json file;
  try {
    file = json::parse(stream);
  } catch (const std::exception& error) {  // a folder, too, or a number that no double holds
    throw FileError(path.string() +
                    " is neither a device trace nor a rig in JSON: " + error.what());
  }
  Reader reader(file, path.string());
  RigDescription rig;
  reader.read("emulated", rig.is_emulated);
  for (const Side side : kSides) {
    if (reader.has(name_of(side))) {
      rig.hands[static_cast<std::size_t>(side)] = read_hand(
          file.at(name_of(side)), path.string() + "." + name_of(side), path.parent_path());
    }
  }
  rig.pedals = read_list(reader, "pedals", read_pedals);
  rig.faults = read_list(reader, "faults", read_fault);
  reader.finish();
  if (rig.is_emulated && !rig.has(Mover::arm)) {
    throw FileError(path.string() + " is emulated; only arms are, and no hand has one");
  }
  if (!rig.faults.empty() && !(rig.is_emulated && rig.has(Mover::arm))) {
    throw FileError(path.string() + " has faults; only emulated arms have them");
  }
  return rig;
}

std::vector<std::string> split(const std::string& devices) {
  std::vector<std::string> words;
  std::istringstream stream(devices + ',');
  for (std::string word; std::getline(stream, word, ',');) {
    words.push_back(word);
  }
  return words;
}

}  // namespace

RigDescription read_rig(const std::string& devices) {
  const std::vector<std::string> words = split(devices);
  if (words.size() > 2) {
    throw InvalidArgument("devices " + devices + " are " + std::to_string(words.size()) +
                          "; there are two hands");
  }
  RigDescription rig;
  const auto describe = [&](const std::string& word, Side side) {
    HandDescription& hand = rig.hands[static_cast<std::size_t>(side)];
    if (word == "openhaptics" || word == "emulator") {
      hand.mover = Mover::arm;
      rig.is_emulated = rig.is_emulated || word == "emulator";
    } else if (word != "mouse") {
      if (!is_trace(word)) {
        throw InvalidArgument("device " + word +
                              " is none of mouse, openhaptics, emulator or the file of a device "
                              "trace");
      }
      hand.mover = Mover::trace;
      hand.trace = word;
    }
  };
  if (words.size() == 1) {
    const bool is_file = devices != "mouse" && devices != "openhaptics" && devices != "emulator";
    if (is_file && !is_trace(devices)) {
      return read_file(devices);
    }
    describe(devices, Side::right);
    if (!is_file) {
      describe(devices, Side::left);
    }
  } else {
    describe(words[0], Side::left);
    describe(words[1], Side::right);
    if (rig.is_emulated && (words[0] == "openhaptics" || words[1] == "openhaptics")) {
      throw InvalidArgument("devices " + devices +
                            ": a program has real arms or emulated ones, not both");
    }
  }
  if (rig.hands[0].mover == Mover::arm && rig.hands[1].mover == Mover::arm) {
    for (const Side side : kSides) {
      rig.hands[static_cast<std::size_t>(side)].arm_name =
          kArmNames[static_cast<std::size_t>(side)];
    }
  }
  return rig;
}

}  // namespace rig
