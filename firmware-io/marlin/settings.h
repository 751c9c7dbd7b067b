#pragma once

#include "firmware-io/firmware_limits.h"

#include <optional>
#include <string_view>

/// What a Marlin-class firmware says of its own set-up. Pure.
namespace voidpath::fw::marlin {

/// Gathers the answers to M503 and M211 and the area of M115, line by line, from Marlin 1.0 to 2.1 and their
/// relatives. Lines of anything else are passed over.
class SettingsReader {
 public:
  /// `line` as the firmware said it, `echo:` included.
  void take(std::string_view line);
  /// Everything in mm and seconds; empty when nothing was understood.
  std::optional<FirmwareLimits> limits() const;

 private:
  void take_command(std::string_view command);
  void take_endstops(std::string_view line);
  void take_area(std::string_view line);

  FirmwareLimits limits_;
  std::optional<MachineBox> area_, endstops_;
  bool inches_ = false;
};

}  // namespace voidpath::fw::marlin
