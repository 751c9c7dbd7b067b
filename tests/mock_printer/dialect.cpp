#include "tests/mock_printer/dialect.h"

namespace voidpath::test::mock {
namespace {

constexpr std::string_view kCapabilities =
    "Cap:SERIAL_XON_XOFF:0\nCap:BINARY_FILE_TRANSFER:0\nCap:EEPROM:0\nCap:AUTOREPORT_TEMP:1\n"
    "Cap:PROGRESS:0\nCap:PRINT_JOB:1\nCap:AUTOLEVEL:0\nCap:Z_PROBE:0\nCap:BUILD_PERCENT:1\n"
    "Cap:SOFTWARE_POWER:0\nCap:HOST_ACTION_COMMANDS:1\nCap:PROMPT_SUPPORT:1\nCap:SDCARD:0\n"
    "Cap:THERMAL_PROTECTION:1\nCap:ARCS:1\n";

Dialect marlin2() {
  Dialect d;
  d.name = "marlin2";
  d.banner =
      " External Reset\nMarlin bugfix-2.1.x\n\necho: Last Updated: 2023-01-20 | Author: (voidpath, mock)\n"
      "echo: Free Memory: 4010  PlannerBufferBytes: 1168\n//action:notification Mock Ready.\n"
      "//action:prompt_end\n";
  d.identity =
      "FIRMWARE_NAME:Marlin bugfix-2.1.x (mock) SOURCE_CODE_URL:voidpath PROTOCOL_VERSION:1.0 "
      "MACHINE_TYPE:voidpath mock EXTRUDER_COUNT:1 UUID:cede2a2f-41a2-4748-9b12-c55c62f367ff\n";
  d.identity += kCapabilities;
  return d;
}

Dialect marlin1() {
  Dialect d;
  d.name = "marlin1";
  d.banner = "echo:Marlin 1.1.9\n\necho: Free Memory: 3861  PlannerBufferBytes: 1168\n";
  d.identity =
      "FIRMWARE_NAME:Marlin 1.1.9 (mock) SOURCE_CODE_URL:voidpath PROTOCOL_VERSION:1.0 "
      "MACHINE_TYPE:voidpath mock EXTRUDER_COUNT:1 UUID:cede2a2f-41a2-4748-9b12-c55c62f367ff\n";
  d.power_off.clear();
  d.repeats_silent = false;
  d.old_settings = true;
  d.wants_number = true;
  d.autoreport = false;
  return d;
}

/// What printers such as the first CR-10 came with.
Dialect marlin10() {
  Dialect d = marlin1();
  d.name = "marlin10";
  d.banner = "echo:Marlin 1.0.1\necho: Free Memory: 3861  PlannerBufferBytes: 1232\n";
  d.identity =
      "FIRMWARE_NAME:Marlin V1; Sprinter/grbl mashup for gen6 FIRMWARE_URL:voidpath PROTOCOL_VERSION:1.0 "
      "MACHINE_TYPE:Mendel EXTRUDER_COUNT:1 UUID:00000000-0000-0000-0000-000000000000\n";
  d.colon_ends_line = true;
  d.busy = false;
  return d;
}

Dialect prusa() {
  Dialect d = marlin1();
  d.name = "prusa";
  d.banner = "echo: 3.9.3-3556\nSpoolJoin is Off\necho: Free Memory: 1824  PlannerBufferBytes: 1760\n";
  d.identity =
      "FIRMWARE_NAME:Prusa-Firmware 3.9.3 based on Marlin (mock) FIRMWARE_URL:voidpath "
      "PROTOCOL_VERSION:1.0 MACHINE_TYPE:Prusa i3 MK3S EXTRUDER_COUNT:1 "
      "UUID:00000000-0000-0000-0000-000000000000\nCap:AUTOREPORT_TEMP:1\n";
  d.resend_ok = false;
  d.first_star = true;
  d.autoreport = true;
  return d;
}

Dialect repetier() {
  Dialect d;
  d.name = "repetier";
  d.banner = "Info:External Reset\nFree RAM:4212\n";
  d.identity =
      "FIRMWARE_NAME:Repetier_1.0.4 (mock) FIRMWARE_URL:voidpath PROTOCOL_VERSION:1.0 "
      "MACHINE_TYPE:Mock EXTRUDER_COUNT:1 REPETIER_PROTOCOL:3\n";
  d.halted = "fatal:Printer stopped. Reset it.\n";
  d.power_off.clear();
  d.resend_prefix = "Resend:";
  d.names_expected = true;
  d.sum_first = true;
  d.skips = 15;
  d.asks_again_s = 0.2;
  d.wrong_number = "expected line ";
  d.wrong_checksum = "Wrong checksum ";
  d.no_checksum = "Missing checksum ";
  d.repeats_silent = false;
  d.ok_at_enqueue = true;
  d.tells_wait = false;
  d.busy = false;
  d.autoreport = false;
  d.colon_ends_line = true;
  d.number_16_bit = true;
  d.wait_when_idle = true;
  return d;
}

Dialect smoothie() {
  Dialect d;
  d.name = "smoothie";
  d.banner = "Smoothie\nok\n";
  d.identity =
      "FIRMWARE_NAME:Smoothieware, FIRMWARE_URL:voidpath, X-SOURCE_CODE_URL:voidpath, "
      "FIRMWARE_VERSION:mock, X-FIRMWARE_BUILD_DATE:Nov 2023, X-SYSTEM_CLOCK:120MHz, X-AXES:4, "
      "X-GRBL_MODE:0\n";
  d.halted = "!!\n";
  d.power_off.clear();
  d.resend_prefix = "rs N";
  d.resend_ok = false;
  d.repeats_silent = false;
  d.blank_ok = true;
  d.busy = false;
  d.autoreport = false;
  return d;
}

/// Its pseudo terminal, /tmp/printer.
Dialect klipper() {
  Dialect d;
  d.name = "klipper";
  d.start.clear();
  d.restarted = "// Klipper state: Disconnect\n// Klipper state: Ready\n";
  d.identity = "FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.12.0-mock";
  d.halted =
      "// Once the underlying issue is corrected, use the\n// \"FIRMWARE_RESTART\" command to reset the "
      "firmware, reload the\n// config, and restart the host software.\n// Printer is shutdown\n";
  d.stopped = "Shutdown due to M112 command\n";
  d.power_off.clear();
  d.checks_lines = d.busy = d.autoreport = d.repeats_silent = d.tells_wait = false;
  d.blank_ok = d.identity_in_ok = d.refuses = d.lives_on = d.halts_early = d.bare_temperatures = true;
  d.queue = 20;
  d.commands = {"G0",
                "G1",
                "G4",
                "G28",
                "G90",
                "G91",
                "G92",
                "M18",
                "M82",
                "M83",
                "M84",
                "M104",
                "M105",
                "M106",
                "M107",
                "M109",
                "M110",
                "M112",
                "M114",
                "M115",
                "M117",
                "M118",
                "M119",
                "M140",
                "M190",
                "M204",
                "M220",
                "M221",
                "M400",
                "M73",
                "G2",
                "G3",
                "G21",
                "T0",
                "PAUSE",
                "RESUME",
                "CLEAR_PAUSE",
                "TURN_OFF_HEATERS",
                "START_PRINT",
                "BED_MESH_CALIBRATE",
                "QUAD_GANTRY_LEVEL"};
  d.unknown = "// Unknown command:";
  d.quotes_word_only = true;
  return d;
}

}  // namespace

std::optional<Dialect> find_dialect(std::string_view name) {
  if (name == "marlin2") return marlin2();
  if (name == "marlin1") return marlin1();
  if (name == "marlin10") return marlin10();
  if (name == "prusa") return prusa();
  if (name == "repetier") return repetier();
  if (name == "smoothie") return smoothie();
  if (name == "klipper") return klipper();
  return std::nullopt;
}

}  // namespace voidpath::test::mock
