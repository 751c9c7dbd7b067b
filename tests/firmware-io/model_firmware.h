#pragma once

#include "tests/firmware-io/spaced.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace voidpath::test {

struct ModelOptions {
  std::size_t ring_bytes = 127;
  std::size_t queue_lines = 4;
  bool resend_says_ok = true;
  bool advanced_ok = false;
  bool autoreport = true;
  int extruders = 1;
};

/// A small, strict model of Marlin's receive side: bounded ring, command queue, line numbers, checksums,
/// error/resend/ok triples with a flushed ring, silence for repeats. Written from the protocol, not from the
/// code under test; knows no time: pull() and execute() are called by the test.
class ModelFirmware {
 public:
  explicit ModelFirmware(ModelOptions options = {}) : options_(options) {}

  void receive(std::string_view bytes) {
    for (const char c : bytes) {
      if (ring_.size() < options_.ring_bytes) {
        ring_ += c;
      } else {
        ++overflowed;
      }
    }
  }

  /// Reads the ring while the queue has room. True when anything was read.
  bool pull() {
    bool any = false;
    while (!dead && queue_.size() < options_.queue_lines && !ring_.empty()) {
      const char c = ring_.front();
      ring_.erase(0, 1);
      any = true;
      if (c == '\n' || c == '\r') {
        take_line(std::exchange(line_, {}));
      } else if (line_.size() < 95) {
        line_ += c;
      }
    }
    return any;
  }

  const std::string* front() const { return dead || queue_.empty() ? nullptr : &queue_.front().command; }

  /// Finishes the command at the head of the queue.
  void execute() {
    const Command command = queue_.front();
    queue_.pop_front();
    executed.push_back(command.command);
    const std::string& text = command.command;
    if (text == "M115") identify();
    if (text == "M105") {
      replies.push_back("ok T:21.00 /0.00 B:20.00 /0.00 @:0 B@:0");
      return;
    }
    if (text.starts_with("M155")) reporting = true;
    std::string ok = "ok";
    if (options_.advanced_ok) {
      if (command.number) ok += " N" + std::to_string(*command.number);
      ok += " P15 B" + std::to_string(options_.queue_lines - 1 - queue_.size());
    }
    replies.push_back(ok);
  }

  void reset() {
    ring_.clear(), line_.clear(), queue_.clear();
    last_ = 0;
    dead = reporting = false;
    replies.push_back("start");
    replies.push_back("Marlin 2.1.2");
  }

  std::vector<std::string> replies;   ///< not yet fetched
  std::vector<std::string> executed;  ///< in order
  std::size_t overflowed = 0;         ///< bytes that found the ring full
  int refused = 0;                    ///< lines wanted again
  int undetectable = 0;               ///< damaged lines that passed the checksum
  bool dead = false;                  ///< M112
  bool break_wait = false;            ///< M108 was seen
  bool reporting = false;

 private:
  struct Command {
    std::string command;
    std::optional<std::uint32_t> number;
  };

  void refuse(const char* why) {
    ++refused;
    ring_.clear();
    replies.push_back(std::string("Error:") + why + ", Last Line: " + std::to_string(last_));
    replies.push_back("Resend: " + std::to_string(last_ + 1));
    if (options_.resend_says_ok) replies.push_back("ok");
  }

  void take_line(std::string line) {
    line.erase(std::min(line.find(';'), line.size()));
    line.erase(0, std::min(line.find_first_not_of(' '), line.size()));
    if (line.empty()) return;
    Command command;
    if (line[0] == 'N') {
      std::uint32_t number = 0;
      const auto digits = std::from_chars(line.data() + 1, line.data() + line.size(), number);
      const bool sets_number = line.find("M110") != std::string::npos;
      if (digits.ec != std::errc{} || (number != last_ + 1 && !sets_number)) {
        if (digits.ec == std::errc{} && (number == last_ || number + 1 == last_)) return;  // silence
        return refuse("Line Number is not Last Line Number+1");
      }
      const auto star = line.rfind('*');
      if (star == std::string::npos) return refuse("No Checksum with line number");
      unsigned sum = 0;
      for (std::size_t i = 0; i < star; ++i) sum ^= static_cast<unsigned char>(line[i]);
      unsigned given = 256;
      std::from_chars(line.data() + star + 1, line.data() + line.size(), given);
      if (given != sum) return refuse("checksum mismatch");
      last_ = number;
      command.number = number;
      line.erase(star);
      line.erase(0, static_cast<std::size_t>(digits.ptr - line.data()));
      line.erase(0, std::min(line.find_first_not_of(' '), line.size()));
    }
    // Two lines run together whose damage cancels in the XOR: no host can know.
    if (line.find('*') != std::string::npos) ++undetectable;
    command.command = spaced(line);
    if (line == "M108") break_wait = true;
    if (line == "M112") {
      dead = true;
      replies.push_back("echo:M112 Shutdown");
      replies.push_back("Error:Printer halted. kill() called!");
      return;
    }
    queue_.push_back(std::move(command));
  }

  void identify() {
    replies.push_back(
        std::string(
            "FIRMWARE_NAME:Marlin 2.1.2 (Jun 1 2024) SOURCE_CODE_URL:github.com/x PROTOCOL_VERSION:1.0 "
            "MACHINE_TYPE:Model Machine EXTRUDER_COUNT:") +
        std::to_string(options_.extruders) + " UUID:cede2a2f-41a2-4748-9b12-c55c62f367ff");
    replies.push_back(options_.autoreport ? "Cap:AUTOREPORT_TEMP:1" : "Cap:AUTOREPORT_TEMP:0");
    replies.push_back("Cap:EMERGENCY_PARSER:0");
  }

  ModelOptions options_;
  std::string ring_;
  std::string line_;
  std::deque<Command> queue_;
  std::uint32_t last_ = 0;
};

}  // namespace voidpath::test
