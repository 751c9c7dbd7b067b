#include "firmware-io/heaters_off.h"

namespace voidpath::fw {

std::vector<std::string> heaters_off(const FirmwareInfo& firmware) {
  std::vector<std::string> lines;
  // It does not say how many hotends it has.
  if (firmware.name.find("Klipper") != std::string::npos) lines.push_back("TURN_OFF_HEATERS");
  lines.push_back("M104 S0");
  for (int tool = 0; firmware.extruders > 1 && tool < firmware.extruders; ++tool)
    lines.push_back("M104 T" + std::to_string(tool) + " S0");
  lines.push_back("M140 S0");
  const auto chamber = firmware.capabilities.find("CHAMBER_TEMPERATURE");
  if (chamber != firmware.capabilities.end() && chamber->second) lines.push_back("M141 S0");
  lines.push_back("M107");
  return lines;
}

}  // namespace voidpath::fw
