#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// How firmwares of one family differ on the wire, as data.
namespace voidpath::test::mock {

struct Dialect {
  std::string name;
  std::string start = "start\n";
  std::string banner;     ///< behind that, each line ended by \n
  std::string restarted;  ///< said where a restart is no boot
  std::string identity;   ///< answer to M115 without its ok
  std::string stopped = "echo:M112 Shutdown\n";
  std::string halted = "Error:Printer halted. kill() called!\n";
  std::string power_off = "//action:poweroff\n";  ///< after the halt line
  std::string error_prefix = "Error:";
  std::string resend_prefix = "Resend: ";
  bool resend_ok = true;         ///< an ok follows the resend request
  bool repeats_silent = true;    ///< a repeat of the last or last-but-one line is dropped without a word
  bool first_star = false;       ///< the checksum starts at the first `*`, not at the last
  bool wants_number = false;     ///< a checksum without a line number is an error
  bool ok_at_enqueue = false;    ///< ok says "in the queue", not "handled"
  bool old_settings = false;     ///< M503 and M211 in the words of Marlin 1.x
  bool blank_ok = false;         ///< empty and comment-only lines get an ok
  bool busy = true;              ///< `echo:busy: processing` while a command takes long
  bool autoreport = true;        ///< M155
  bool colon_ends_line = false;  ///< an ASCII line ends at `:`, in any text
  bool number_16_bit = false;    ///< line numbers compare in their low 16 bits
  bool wait_when_idle = false;   ///< `wait` each second while nothing is queued
  bool names_expected = false;   ///< errors of numbering say "expected X got Y"
  bool sum_first = false;        ///< the checksum is looked at before the number
  int skips = 0;  ///< so many lines out of order behind a request get `skip` and an ok, not a request each
  double asks_again_s =
      0;  ///< a line begun, or asked for, is asked for after so long a silence; 0: it is not
  bool checks_lines = true;     ///< else numbers and checksums are cut off and nothing is refused by them
  bool identity_in_ok = false;  ///< the identity stands behind the ok of M115
  bool refuses = false;         ///< moves before homing and cold extrusions are left undone, and `!!` says so
  bool lives_on = false;        ///< after a halt each line is still answered, and FIRMWARE_RESTART ends it
  bool halts_early = false;     ///< M112 is seen ahead of what is queued, while the queue has room
  bool tells_wait = true;       ///< W behind the temperatures while it waits for one
  bool bare_temperatures = false;     ///< B first, one decimal, no power
  std::size_t queue = 0;              ///< commands read ahead; 0: as the options say
  std::vector<std::string> commands;  ///< all it knows; empty: all the mock does
  std::string unknown = "echo:Unknown command: ";
  bool quotes_word_only = false;  ///< of an unknown command, not all of it
  std::string wrong_number = "Line Number is not Last Line Number+1, Last Line: ";
  std::string wrong_checksum = "checksum mismatch, Last Line: ";
  std::string no_checksum = "No Checksum with line number, Last Line: ";
  std::string no_number = "No Line Number with checksum, Last Line: ";
};

/// marlin2, marlin1, marlin10, prusa, repetier, smoothie, klipper; nothing for an unknown name.
std::optional<Dialect> find_dialect(std::string_view name);

}  // namespace voidpath::test::mock
