#include "tests/mock_printer/fault_script.h"

#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

namespace voidpath::test::mock {
namespace {

const std::map<std::string, FaultKind> kKinds{
    {"drop_byte", FaultKind::kDropByte},
    {"flip_byte", FaultKind::kFlipByte},
    {"double_byte", FaultKind::kDoubleByte},
    {"insert_byte", FaultKind::kInsertByte},
    {"drop_line", FaultKind::kDropLine},
    {"garble_line", FaultKind::kGarbleLine},
    {"double_line", FaultKind::kDoubleLine},
    {"lose_ok", FaultKind::kLoseOk},
    {"double_ok", FaultKind::kDoubleOk},
    {"garble_ok", FaultKind::kGarbleOk},
    {"resend_without_ok", FaultKind::kResendWithoutOk},
    {"spurious_resend", FaultKind::kSpuriousResend},
    {"reset", FaultKind::kReset},
    {"halt", FaultKind::kHalt},
    {"unplug", FaultKind::kUnplug},
    {"silence", FaultKind::kSilence},
    {"slow", FaultKind::kSlow},
    {"dead_heater", FaultKind::kDeadHeater},
    {"pause", FaultKind::kPause},
    {"cancel", FaultKind::kCancel},
    {"busy", FaultKind::kBusy},
};

[[noreturn]] void mistake(const YAML::Node& node, const std::string& what) {
  throw std::runtime_error("faults, line " + std::to_string(node.Mark().line + 1) + ": " + what);
}

void set_trigger(Fault& fault, FaultTrigger trigger, const YAML::Node& value) {
  fault.trigger = trigger;
  fault.at = value.as<double>();
}

void set_key(Fault& fault, const std::string& key, const YAML::Node& value) {
  if (key == "kind") return;
  if (key == "byte") return set_trigger(fault, FaultTrigger::kByte, value);
  if (key == "line") return set_trigger(fault, FaultTrigger::kLine, value);
  if (key == "ok") return set_trigger(fault, FaultTrigger::kOk, value);
  if (key == "time") return set_trigger(fault, FaultTrigger::kTime, value);
  if (key == "resend") return set_trigger(fault, FaultTrigger::kLine, value);
  if (key == "probability") {
    fault.probability = value.as<double>();
  } else if (key == "count") {
    fault.limit = value.as<std::uint64_t>();
  } else if (key == "seconds") {
    fault.seconds = value.as<double>();
  } else if (key == "lines") {
    fault.lines = value.as<std::uint64_t>();
  } else if (key == "text") {
    fault.text = value.as<std::string>();
  } else if (key == "heater") {
    fault.heater = value.as<std::string>();
    if (fault.heater != "hotend" && fault.heater != "bed") mistake(value, "heater is hotend or bed");
  } else if (key == "direction") {
    const auto direction = value.as<std::string>();
    if (direction != "in" && direction != "out") mistake(value, "direction is in (to the printer) or out");
    fault.outwards = direction == "out";
  } else {
    mistake(value, "unknown key " + key);
  }
}

Fault parse_one(const YAML::Node& node) {
  if (!node.IsMap() || !node["kind"]) mistake(node, "a fault is a map with a kind");
  const auto name = node["kind"].as<std::string>();
  const auto kind = kKinds.find(name);
  if (kind == kKinds.end()) mistake(node["kind"], "unknown kind " + name);
  Fault fault;
  fault.kind = kind->second;
  fault.trigger = natural_trigger(fault.kind);
  for (const auto& entry : node) set_key(fault, entry.first.as<std::string>(), entry.second);
  if (!fault.at && fault.probability <= 0)
    mistake(node, "say when: byte, line, ok, time, resend or probability");
  const FaultTrigger natural = natural_trigger(fault.kind);
  if (natural != FaultTrigger::kLine && fault.trigger != natural)
    mistake(node, name + " happens at a " + (natural == FaultTrigger::kByte ? "byte" : "ok"));
  return fault;
}

}  // namespace

std::vector<Fault> parse_faults(const std::string& yaml) {
  try {
    const YAML::Node root = YAML::Load(yaml);
    const YAML::Node list = root.IsMap() ? root["faults"] : root;
    std::vector<Fault> faults;
    if (!list || list.IsNull()) return faults;
    if (!list.IsSequence()) mistake(list, "a list of faults is expected");
    for (const auto& node : list) faults.push_back(parse_one(node));
    return faults;
  } catch (const YAML::Exception& e) {
    throw std::runtime_error("faults, line " + std::to_string(e.mark.line + 1) + ": " + e.msg);
  }
}

std::vector<Fault> load_faults(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  try {
    return parse_faults(text);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

}  // namespace voidpath::test::mock
