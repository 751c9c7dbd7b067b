#pragma once

#include "firmware-io/lines_of.h"
#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/driver.h"
#include "tests/firmware-io/driver_bench.h"
#include "tests/fuzz/check.h"
#include "tests/mock_printer/line_protocol.h"
#include "tests/mock_printer/unpacker.h"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// What the fuzz target of Marlin's whole driver runs: also called with seeded random input by the tests.
namespace voidpath::test {

/// Holds what a driver writes against the protocol's laws: numbers one after the other, a number's line
/// always the same, every line of a file once and in order, nothing else without a number.
class SentLaws {
 public:
  void take(std::string_view bytes) {
    std::string text;
    bool told = false;
    for (const char c : bytes) unpacker_.take(c, text, told);
    for (const char c : text) {
      if (c != '\n')
        line_ += c;
      else
        check(std::exchange(line_, {}));
    }
  }
  std::uint32_t next() const { return next_; }
  std::size_t urgent = 0;  ///< M112 seen

 private:
  void check(const std::string& line) {
    if (line.empty()) return;
    if (line[0] != 'N') {
      static const char* const kRaw[] = {"M108", "M112",    "M410",    "M876",
                                         "M104", "M140 S0", "M141 S0", "M107"};
      require(std::any_of(std::begin(kRaw), std::end(kRaw),
                          [&](const char* raw) { return line.starts_with(raw); }),
              "a line without its number");
      urgent += line == "M112" ? 1u : 0u;
      return;
    }
    const auto star = line.rfind('*');
    require(line.size() <= fw::marlin::kMaxFramed);
    std::uint32_t number = 0;
    unsigned sum = 256;
    std::from_chars(line.data() + 1, line.data() + line.size(), number);
    if (star != line.npos) std::from_chars(line.data() + star + 1, line.data() + line.size(), sum);
    if (star == line.npos || sum != mock::checksum_of(std::string_view(line).substr(0, star))) {
      // Only the last line may be cut off, in favour of one from before it.
      require(cut_.empty(), "two lines cut off");
      cut_ = line;
      return;
    }
    std::string payload(mock::command_text(line));
    if (payload.starts_with("M110")) {
      lines_.clear();
      cut_.clear();
      next_ = 1;
      return;
    }
    std::erase(payload, ' ');
    if (payload == "M112") return;  // numbered: behind the one without, and the last
    require(number <= next_, "a number left out");
    if (number < next_) {
      return require(lines_.at(number) == payload, "a number given to two lines");
    }
    require(line.starts_with(std::exchange(cut_, {})), "a line cut off and never sent again");
    lines_[next_++] = payload;
    follow_file(payload);
  }
  // "G1X<index>Y<print>"
  void follow_file(const std::string& payload) {
    if (!payload.starts_with("G1X")) return;
    unsigned index = 0, print = 0;
    const auto digits = std::from_chars(payload.data() + 3, payload.data() + payload.size(), index);
    std::from_chars(digits.ptr + 1, payload.data() + payload.size(), print);
    require(index == sent_[print]++, "a line of the file skipped or repeated");
  }

  mock::Unpacker unpacker_;
  std::string line_;
  std::string cut_;  ///< of the line with the number next_, what was sent before
  std::uint32_t next_ = 1;
  std::map<std::uint32_t, std::string> lines_;
  std::map<unsigned, unsigned> sent_;  ///< lines of each print
};

/// A driver against a peer that answers as the input says: well, damaged, with anything, or not at all, while
/// the clock runs and the user presses every button.
class HostileMarlin {
 public:
  HostileMarlin(const std::uint8_t* data, std::size_t size)
      : data_(data),
        size_(size),
        driver_({}, clock_, recorder_, [this](const fw::Event& event) { note(event); }) {}

  void run() {
    const std::uint8_t how = take();
    driver_.opened(t_);
    if (how % 2 == 1) shake_hands(how % 4 == 3);
    while (at_ < size_) {
      step();
      drain();
      require(!std::isnan(driver_.deadline()));
      if (driver_.closing()) driver_.opened(t_);
    }
    driver_.shut_down(t_);
    drain();
    driver_.lost("the end");
    require(driver_.closing() && driver_.finished());
    require(started_ == ended_, "a print without an end");
  }

 private:
  static constexpr std::uint32_t kLines = 60;
  // The window, and one line let out beyond it by a stall or where it is longer than the window.
  static constexpr std::size_t kMostAtOnce = 127 + 2 * fw::marlin::kMaxFramed;

  std::uint8_t take() { return at_ < size_ ? data_[at_++] : std::uint8_t{0}; }
  std::string bytes(std::size_t count) {
    std::string out;
    for (std::size_t i = 0; i < count; ++i) out += static_cast<char>(take());
    return out;
  }
  void drain() {
    const std::string out = std::exchange(driver_.output(), {});
    require(out.size() <= kMostAtOnce, "more at once than the receive buffer holds");
    laws_.take(out);
  }
  void say(const std::string& text) {
    if (!driver_.closing()) driver_.received(text, t_);
  }
  // As the session does: awake at each deadline.
  void pass(double seconds) {
    const double end = t_ + seconds;
    for (int wakes = 0; driver_.deadline() <= end; ++wakes) {
      require(wakes < 100 + 50 * seconds, "a deadline that does not pass");
      t_ = clock_.now = std::max(t_, driver_.deadline());
      driver_.elapsed(t_);
      drain();
      if (driver_.closing()) break;
    }
    t_ = clock_.now = std::max(t_, end);
  }

  void shake_hands(bool packs) {
    pass(3.5);
    say("ok\n");
    pass(0.2);
    say("FIRMWARE_NAME:Marlin 2.1.2 (x)\nCap:AUTOREPORT_TEMP:1\n");
    if (packs) say("Cap:MEATPACK:1\n");
    say("ok\n");
    drain();
    if (packs) say("[MP] PV01 ON NSP\n");
    pass(0.01);
    for (int i = 0; i < 3; ++i) say("ok\n");
    drain();
    print();
    drain();
  }
  void print() {
    std::vector<std::string> file;
    for (std::uint32_t i = 0; i < kLines; ++i)
      file.push_back("G1 X" + std::to_string(i) + " Y" + std::to_string(prints_));
    for (const char* other : {"M109 S200", "G28", "M0", "M600", "G29"}) {
      const std::uint8_t where = take();
      if (where < kLines) file.insert(file.begin() + where, other);
    }
    ++prints_;
    ++started_;
    driver_.print(std::make_unique<MemorySource>(std::move(file)), t_);
  }
  std::string near_number() { return std::to_string(laws_.next() - 4 + take() % 8); }

  void step() {
    const std::uint8_t what = take();
    switch (what % 20) {
      case 0:
        return say(bytes(1U + take() % 40U) + "\n");
      case 1:
      case 2:
        return say("ok\n");
      case 3:
        return say("ok N" + near_number() + " P15 B" + std::to_string(what >> 5) + "\n");
      case 4:
        return say("Resend: " + near_number() + "\nok\n");
      case 5: {
        const std::string wanted = near_number();
        return say("Error:checksum mismatch, Last Line: " + wanted + "\nResend: " + wanted + "\nok\n");
      }
      case 6:
        return say("ok T:21.00 /0.00 B:20.00 /0.00 @:0 B@:0\n");
      case 7:
        return say(" T:21.00 /0.00 B:20.00 /0.00 @:0 B@:0\n");
      case 8:
        return say("FIRMWARE_NAME:Marlin x\nCap:MEATPACK:1\nok\n");
      case 9:
        return say("[MP] PV01 ON NSP\n");
      case 10:
        return pass(0.001 * take());
      case 11:
        return pass(1 + take());
      case 12:
        return pass(0.1);
      case 13:
        return words(take());
      case 14:
        return buttons(take());
      case 15:
        return say(bytes(what >> 4));
      case 16:
        return say("start\n");
      case 17:
        return say("wait\n");
      case 18:
        return say("rs N" + near_number() + "\n");
      default:
        return say("ok\nok\nok\n");
    }
  }
  void words(std::uint8_t which) {
    static const char* const kWords[] = {"echo:busy: processing\n",
                                         "echo:busy: paused for user\n",
                                         "//action:paused\n",
                                         "//action:pause\n",
                                         "//action:resume\n",
                                         "//action:cancel\n",
                                         "//action:prompt_begin x\n//action:prompt_choice y\n",
                                         "//action:prompt_show\n",
                                         "//action:prompt_end\n",
                                         "echo: cold extrusion prevented\n",
                                         "echo:Unknown command: \"x\"\n",
                                         "RX BUF overflow, increase RX_BUFFER_SIZE: 1\n",
                                         "Error:Printer halted. kill() called!\n",
                                         "!!\n",
                                         "Error:Probing Failed\n",
                                         "echo:  M92 X80.00 Y80.00 Z400.00 E93.00\n"};
    say(kWords[which % std::size(kWords)]);
  }
  void buttons(std::uint8_t which) {
    switch (which % 8) {
      case 0:
        return print();
      case 1:
        return driver_.pause();
      case 2:
        return driver_.resume(t_);
      case 3:
        return driver_.cancel("user", t_);
      case 4:
        return halt();
      case 5:
        return driver_.command("M220 S" + std::to_string(which), t_);
      case 6:
        return command(bytes(which >> 4));
      default:
        return driver_.lost("unplugged");
    }
  }
  // What would be taken for a line of the file is left out.
  void command(const std::string& text) {
    for (const std::string_view line : fw::lines_of(text)) {
      std::string bare = fw::marlin::sanitise(line);
      std::erase(bare, ' ');
      if (bare.starts_with("G1X")) return;
    }
    driver_.command(text, t_);
  }
  void halt() {
    drain();
    const std::size_t before = laws_.urgent;
    const bool open = !driver_.closing();
    driver_.take_urgent();  // of an M112 among the user's commands
    driver_.halt("button", t_);
    const bool urgent = driver_.take_urgent();
    drain();
    require(!open || !urgent || laws_.urgent == before + 1, "an emergency stop that is not first");
  }
  void note(const fw::Event& event) {
    if (const auto* failed = std::get_if<fw::PrintFailed>(&event.what)) {
      require(!failed->reason.empty(), "a failure without a reason");
      ++ended_;
    } else if (const auto* lost = std::get_if<fw::Disconnected>(&event.what)) {
      require(!lost->reason.empty(), "a loss without a reason");
    } else if (const auto* paused = std::get_if<fw::Paused>(&event.what)) {
      require(!paused->by_printer || !paused->reason.empty(), "a pause without a reason");
    } else if (std::holds_alternative<fw::PrintStarted>(event.what)) {
      done_ = 0;
    } else if (const auto* line = std::get_if<fw::LineDone>(&event.what)) {
      // What pauses here is not sent.
      require(line->index >= done_, "a line done out of its turn");
      done_ = line->index + 1;
    } else if (std::holds_alternative<fw::PrintCancelled>(event.what) ||
               std::holds_alternative<fw::PrintFinished>(event.what)) {
      ++ended_;
    }
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
  double t_ = 1000;
  unsigned prints_ = 0, started_ = 0, ended_ = 0;
  std::uint32_t done_ = 0;
  SentLaws laws_;
  FakeClock clock_;
  fw::FlightRecorder recorder_;
  fw::marlin::Driver driver_;
};

inline void fuzz_marlin_driver(const std::uint8_t* data, std::size_t size) {
  HostileMarlin(data, size).run();
}

}  // namespace voidpath::test
