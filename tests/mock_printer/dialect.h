#pragma once

#include <optional>
#include <string>
#include <string_view>

/// How firmwares of one family differ on the wire, as data.
namespace voidpath::test::mock {

struct Dialect {
  std::string name;
  std::string banner;    ///< after `start`, each line ended by \n
  std::string identity;  ///< answer to M115 without its ok
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
  bool colon_ends_line = false;  ///< an ASCII line ends at `:` outside M117 and M118
  bool number_16_bit = false;    ///< line numbers compare in their low 16 bits
  bool wait_when_idle = false;   ///< `wait` each second while nothing is queued
  bool names_expected = false;   ///< errors of numbering say "expected X got Y"
  std::string wrong_number = "Line Number is not Last Line Number+1, Last Line: ";
  std::string wrong_checksum = "checksum mismatch, Last Line: ";
  std::string no_checksum = "No Checksum with line number, Last Line: ";
  std::string no_number = "No Line Number with checksum, Last Line: ";
};

/// marlin2, marlin1, prusa, repetier, smoothie; nothing for an unknown name.
std::optional<Dialect> find_dialect(std::string_view name);

}  // namespace voidpath::test::mock
