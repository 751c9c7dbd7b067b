#include "firmware-io/marlin/window.h"

#include "firmware-io/marlin/reply.h"
#include "tests/firmware-io/model_firmware.h"

#include <functional>
#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::fw::marlin;
using voidpath::test::ModelFirmware;

namespace {

// Varied text, as two lines whose damage cancels in the checksum are beyond any host.
std::string command(int i) {
  return "G1 X" + std::to_string(i * 7919 % 2000) + " Y" + std::to_string(i) + " E" +
         std::to_string(i * 31 % 777);
}

void hear(Window& window, const std::string& line) {
  const Reply reply = parse_reply(line);
  if (const auto* ok = std::get_if<Ok>(&reply)) return window.on_ok(ok->line, ok->queue_free);
  if (const auto* resend = std::get_if<Resend>(&reply)) return window.on_resend(resend->line);
  if (const auto* error = std::get_if<Error>(&reply); error && error->kind == Error::Kind::framing) {
    return window.on_framing_error(error->last_line);
  }
  window.on_other_line();
}

/// Damages a transmission: returns the bytes that arrive. Numbered from 0 in order of sending.
using Fault = std::function<std::string(std::size_t index, std::string line)>;

struct Run {
  Window window;
  ModelFirmware firmware;
  std::size_t sent = 0;
  std::size_t heard = 0;
  int silences = 0;
  int most_in_flight = 0;
  bool finished = false;
};

/// Plays `lines` commands through a window into the model. Without time: both sides act as long as they can;
/// when nothing moves, the clock events come in the order of their delays. `lazy` delays the firmware's
/// execution by random steps; with `one_in` it executes in one step of so many, so that its queue is full.
void play(Run& run, int lines, const Fault& to_printer, const Fault& to_host, std::mt19937* lazy = nullptr,
          unsigned one_in = 0) {
  int next = 0;
  bool confirmed = false;
  for (int step = 0; step < 200 * lines + 2000; ++step) {
    bool moved = false;
    const auto transmit = [&](const std::string& framed) {
      run.firmware.receive(to_printer(run.sent++, framed));
      run.most_in_flight = std::max(run.most_in_flight, run.window.bytes_in_flight());
      moved = true;
    };
    while (const auto again = run.window.resend()) transmit(*again);
    while (next < lines && run.window.may_send(command(next))) transmit(run.window.send(command(next++)));
    if (run.window.wants_probe() && run.window.may_send("M105")) transmit(run.window.send("M105"));
    moved |= run.firmware.pull();
    const int executions = !lazy         ? 1
                           : one_in == 0 ? static_cast<int>((*lazy)() % 3)
                                         : static_cast<int>((*lazy)() % one_in == 0);
    for (int i = 0; i < executions && run.firmware.front(); ++i) run.firmware.execute(), moved = true;
    moved |= run.firmware.front() != nullptr;
    for (const std::string& line : std::exchange(run.firmware.replies, {})) {
      const std::string arrived = to_host(run.heard++, line);
      if (!arrived.empty()) hear(run.window, arrived);
      confirmed = next == lines && arrived.starts_with("ok T:") && run.window.idle();
      moved = true;
    }
    if (run.window.health() != Window::Health::good) return;
    if (next == lines && run.window.idle()) {
      if (confirmed) {
        run.finished = true;
        return;
      }
      transmit(run.window.send("M105"));  // its answer cannot be mistaken
    }
    if (moved) continue;
    if (run.window.draining()) {
      run.window.on_quiet();
    } else if (run.window.throttled()) {
      run.window.on_patience();
      if (++run.silences % 4 == 0) run.window.on_stall();
    } else {
      run.window.on_stall();
    }
  }
}

std::string pass(std::size_t, std::string line) { return line; }

std::vector<std::string> expected(int lines) {
  std::vector<std::string> out;
  for (int i = 0; i < lines; ++i) out.push_back(command(i));
  return out;
}

std::vector<std::string> moves_of(const ModelFirmware& firmware) {
  std::vector<std::string> out = firmware.executed;
  std::erase(out, "M105");
  return out;
}

std::string corrupted(std::string line) {
  line[line.size() / 2] = static_cast<char>(line[line.size() / 2] ^ 1);
  return line;
}

}  // namespace

TEST_CASE("a clean wire is filled to the window and nothing is asked for twice", "[window]") {
  for (const int max_bytes : {63, 127, 255}) {
    Run run{Window({.max_bytes = max_bytes}),
            ModelFirmware({.ring_bytes = static_cast<std::size_t>(max_bytes)})};
    play(run, 500, pass, pass);
    CHECK(run.finished);
    CHECK(moves_of(run.firmware) == expected(500));
    CHECK(run.firmware.overflowed == 0);
    CHECK(run.window.resend_requests() == 0);
    CHECK(run.most_in_flight <= max_bytes);
    CHECK(run.most_in_flight > max_bytes - 30);
  }
}

TEST_CASE("the window counts newlines and never exceeds its bytes", "[window]") {
  Window window({.max_bytes = 50});
  int bytes = 0;
  while (window.may_send("G1 X1")) bytes += static_cast<int>(window.send("G1 X1").size());
  CHECK(bytes == window.bytes_in_flight());
  CHECK(bytes <= 50);
  window.on_ok({});
  CHECK(window.bytes_in_flight() < bytes);
  CHECK(window.may_send("G1 X1"));
}

TEST_CASE("a line longer than the window goes alone", "[window]") {
  Window window({.max_bytes = 20});
  const std::string payload(60, 'X');
  REQUIRE(window.may_send(payload));
  window.send(payload);
  CHECK_FALSE(window.may_send("M105"));
  window.on_ok({});
  CHECK(window.may_send(payload));
}

TEST_CASE("after a resend request: quiet, one line, then growing", "[window]") {
  Window window;
  for (int i = 0; i < 4; ++i) window.send(command(i));
  window.on_framing_error(1);
  window.on_resend(2);
  window.on_ok({});  // belongs to the request
  CHECK(window.draining());
  CHECK(window.acknowledged() == 0);
  CHECK_FALSE(window.resend());
  window.on_ok({});  // line 1, still owed
  CHECK(window.acknowledged() == 1);
  window.on_quiet();
  REQUIRE(window.resend() == "N2 " + command(1) + "*" + std::to_string([] {
                               unsigned sum = 0;
                               for (const char c : "N2 " + command(1)) sum ^= static_cast<unsigned char>(c);
                               return sum;
                             }()) +
                                 "\n");
  CHECK_FALSE(window.resend());
  window.on_ok({});
  CHECK(window.resend());
  CHECK(window.limit_bytes() > 0);
}

TEST_CASE("an ok with a number acknowledges everything up to it", "[window]") {
  Window window;
  for (int i = 0; i < 4; ++i) window.send(command(i));
  window.on_ok(3);
  CHECK(window.acknowledged() == 3);
  window.on_ok(2);  // late
  CHECK(window.acknowledged() == 3);
  window.on_ok(99);  // damaged
  CHECK(window.acknowledged() == 3);
  window.on_ok(4);
  CHECK(window.idle());
}

TEST_CASE("with nothing in flight and nothing asked for all was taken, whatever became of the oks",
          "[window]") {
  Window window;
  for (int i = 1; i <= 4; ++i) window.send(command(i));
  window.on_ok({});
  // The second is asked for although it is on its way, for which the next request is.
  window.on_resend(2);
  window.on_ok({});
  window.on_quiet();
  REQUIRE(window.resend());
  window.on_resend(5);
  window.on_quiet();
  CHECK_FALSE(window.resending());
  CHECK(window.acknowledged() == 1);
  window.on_ok({});
  CHECK(window.acknowledged() == 4);
  CHECK(window.idle());
}

TEST_CASE("a line that can never pass is given up", "[window]") {
  Run run;
  play(
      run, 10, [](std::size_t, std::string line) { return line.starts_with("N5 ") ? corrupted(line) : line; },
      pass);
  CHECK_FALSE(run.finished);
  CHECK(run.window.health() == Window::Health::stuck);
  CHECK(run.firmware.executed == expected(4));
}

TEST_CASE("a printer that says nothing any more is given up", "[window]") {
  Run run;
  play(run, 100, pass, [](std::size_t i, std::string line) { return i < 20 ? line : std::string(); });
  CHECK_FALSE(run.finished);
  CHECK(run.window.health() == Window::Health::silent);
}

TEST_CASE("a request for a line that was never sent is refused in the end", "[window]") {
  Window window({.stuck_rounds = 3});
  window.send("G28");
  for (int i = 0; i < 5; ++i) {
    window.on_resend(4711);
    window.on_ok({});
    window.on_quiet();
  }
  CHECK(window.health() != Window::Health::good);
}

TEST_CASE("a request beyond the history is refused in the end", "[window]") {
  Window window({.stuck_rounds = 3, .history = 16});
  for (int i = 0; i < 100; ++i) {
    window.send(command(i));
    window.on_ok({});
  }
  for (int i = 0; i < 5; ++i) {
    window.on_resend(50);
    window.on_quiet();
  }
  CHECK(window.health() == Window::Health::no_history);
}

TEST_CASE("every pattern of damage on a short print leaves each line once", "[window]") {
  // 0: arrives, 1: one bit flipped, 2: lost, 3: newline lost. Five transmissions, two of the first replies.
  const int lines = 4;
  std::size_t runs = 0;
  int undetectable = 0;
  for (int pattern = 0; pattern < 4 * 4 * 4 * 4 * 4; ++pattern) {
    for (int lost = 0; lost < 32; ++lost) {
      for (const bool says_ok : {true, false}) {
        const auto to_printer = [&](std::size_t i, std::string line) {
          const int what = i < 5 ? (pattern >> (2 * i)) & 3 : 0;
          if (what == 1) return corrupted(line);
          if (what == 2) return std::string();
          if (what == 3) line.pop_back();
          return line;
        };
        const auto to_host = [&](std::size_t i, std::string line) {
          return i < 5 && ((lost >> i) & 1) != 0 ? std::string() : line;
        };
        Run run{Window(), ModelFirmware({.resend_says_ok = says_ok})};
        play(run, lines, to_printer, to_host);
        ++runs;
        const bool exact = run.finished && moves_of(run.firmware) == expected(lines);
        undetectable += run.firmware.undetectable;
        if (!exact && run.firmware.undetectable == 0) {
          INFO("pattern " << pattern << " lost " << lost << " says ok " << says_ok << " health "
                          << static_cast<int>(run.window.health()) << " executed "
                          << run.firmware.executed.size());
          CHECK(exact);
        }
      }
    }
  }
  CHECK(runs == 1024u * 32u * 2u);
  CHECK(undetectable < 3300);  // three lines run together, in one pattern of twenty
}

TEST_CASE("seeded storms of faults leave each line once and in order", "[window]") {
  int finished = 0;
  int undetectable = 0;
  std::uint64_t requests = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    std::mt19937 random(seed);
    const double rate = std::vector<double>{0.002, 0.02, 0.1, 0.25}[seed % 4];
    const auto hit = [&] { return std::uniform_real_distribution<>(0, 1)(random) < rate; };
    const auto to_printer = [&](std::size_t, std::string line) {
      if (!hit()) return line;
      switch (random() % 4) {
        case 0:
          return std::string();
        case 1:
          line.pop_back();
          break;
        case 2:
          line.erase(1 + random() % (line.size() - 2), 1);
          break;
        default: {
          // Not the first byte (a line without its N is obeyed unchecked: no host can see that) nor the last.
          const auto at = 1 + random() % (line.size() - 2);
          line[at] = static_cast<char>(line[at] ^ (1 << (random() % 3)));
        }
      }
      return line;
    };
    const auto to_host = [&](std::size_t, std::string line) {
      if (!hit()) return line;
      if (random() % 2 == 0) return std::string();
      line[random() % line.size()] = '#';
      return line;
    };
    Run run{Window(), ModelFirmware({.resend_says_ok = seed % 3 != 0, .advanced_ok = seed % 5 == 0})};
    play(run, 300, to_printer, to_host, seed % 2 == 0 ? &random : nullptr);
    requests += run.window.resend_requests();
    finished += run.finished ? 1 : 0;
    undetectable += run.firmware.undetectable;
    if (run.firmware.undetectable > 0) continue;
    const auto moves = moves_of(run.firmware);
    INFO("seed " << seed << " health " << static_cast<int>(run.window.health()) << " executed "
                 << moves.size());
    CHECK((run.finished || run.window.health() != Window::Health::good));
    std::vector<std::string> prefix = expected(300);
    prefix.resize(run.finished ? 300 : std::min<std::size_t>(300, moves.size()));
    CHECK(moves == prefix);
  }
  CHECK(finished > 360);
  CHECK(undetectable < 80);
  CHECK(requests > 1000);
}

TEST_CASE("doubled acknowledgements never lose a line", "[window]") {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    Run run;
    const auto doubled = [&](std::size_t, std::string line) {
      if (line == "ok" && random() % 20 == 0) run.window.on_ok({});
      return line;
    };
    play(run, 300, pass, doubled);
    INFO("seed " << seed);
    CHECK(run.finished);
    CHECK(moves_of(run.firmware) == expected(300));
  }
}

TEST_CASE("a receive buffer smaller than said is found out, and then seldom overrun", "[window]") {
  for (const std::size_t ring : {40u, 63u, 90u}) {
    CAPTURE(ring);
    std::mt19937 lazy(3);
    Run run{Window(), ModelFirmware({.ring_bytes = ring, .queue_lines = 1})};
    play(run, 20000, pass, pass, &lazy, 4);
    CHECK(run.finished);
    CHECK(moves_of(run.firmware) == expected(20000));
    // What stands in the one place of the queue counts as well: a line of some 25 bytes.
    CHECK(run.window.ceiling_bytes() < static_cast<int>(ring) + 35);
    CHECK(run.window.resend_requests() < 200);  // one line in a hundred
  }
}

TEST_CASE("damage once in 10 kB does not lower the window for long", "[window]") {
  std::mt19937 random(7);
  Run run;
  int low = 0, samples = 0;
  const auto damage = [&](std::size_t, std::string line) {
    ++samples;
    low += run.window.ceiling_bytes() < 90 ? 1 : 0;
    return random() % 260 == 0 ? corrupted(line) : line;
  };
  play(run, 20000, damage, pass);
  CHECK(run.finished);
  CHECK(run.window.resend_requests() > 50);
  CHECK(low * 20 < samples);
}

TEST_CASE("free places reported with the ok let more out, and never too much", "[window]") {
  for (const std::size_t queue : {4u, 16u}) {
    CAPTURE(queue);
    std::mt19937 lazy(3);
    Run run{Window(), ModelFirmware({.queue_lines = queue, .advanced_ok = true})};
    // While nothing else is queued all places but its own are free.
    run.firmware.receive(run.window.send("M107"));
    run.firmware.pull();
    run.firmware.execute();
    for (const std::string& line : std::exchange(run.firmware.replies, {})) hear(run.window, line);
    std::size_t most_lines = 0;
    const auto count = [&](std::size_t, std::string line) {
      most_lines =
          std::max<std::size_t>(most_lines, run.window.next_number() - run.window.acknowledged() - 1);
      return line;
    };
    play(run, 2000, count, pass, &lazy, 4);
    CHECK(run.finished);
    CHECK(run.firmware.overflowed == 0);
    CHECK(run.window.resend_requests() == 0);
    // 127 bytes are five of these lines.
    CHECK(most_lines >= 5 + queue - 2);
  }
}

TEST_CASE("a firmware that says it was overrun gets less at once", "[window]") {
  Window window;
  const int before = window.ceiling_bytes();
  window.send(command(1));
  window.on_overrun();
  CHECK(window.ceiling_bytes() < before);
  CHECK(window.limit_bytes() <= window.ceiling_bytes());
}

TEST_CASE("a request for the first line after it was surely taken tells of a boot, once it is repeated",
          "[window]") {
  const bool by_answer = GENERATE(true, false);
  const bool both_halves = GENERATE(true, false);
  Window window;
  window.send("M115");
  window.on_ok({});
  if (by_answer) {
    window.on_first_line_taken();
  } else {
    window.send("M105");
    window.on_ok({}, {}, true);
  }
  for (int i = 0; i < 3; ++i) window.send(command(i));
  const auto at = window.cursor();
  window.on_framing_error(0);
  CHECK(window.health() == Window::Health::good);
  window.on_resend(both_halves ? 1 : at - 1);
  if (!both_halves) window.on_framing_error(0);
  CHECK(window.health() == (both_halves ? Window::Health::restarted : Window::Health::good));
  CHECK(window.cursor() == (both_halves ? at : at - 1));
}

TEST_CASE("a first line known by its ok alone may be wanted again", "[window]") {
  Window window;
  window.send("M115");
  window.on_ok({});
  window.on_framing_error(0);
  window.on_resend(1);
  window.on_quiet();
  CHECK(window.health() == Window::Health::good);
  CHECK(window.resend() == "N1 M115*39\n");
}

TEST_CASE("the answer to a question acknowledges what lost its ok, and of two questions one answer will do",
          "[window]") {
  Window window;
  for (int i = 0; i < 3; ++i) window.send(command(i));
  REQUIRE(window.may_ask("M105"));
  window.allow_question();
  window.send("M105");
  window.allow_question();
  window.send("M105");
  CHECK(window.asking());
  window.on_ok({}, {}, true);
  CHECK(window.lost_oks() == 3);
  CHECK(window.acknowledged() == 4);
  CHECK(window.answers_missing());
  window.on_patience();
  CHECK(window.idle());
}

TEST_CASE("a question is not asked where it could overfill the receive buffer", "[window]") {
  Window window({.max_bytes = 127});
  while (window.may_send("G1 X1")) window.send("G1 X1");
  int questions = 0;
  for (; questions < 50 && window.may_ask("M105"); ++questions) window.allow_question(), window.send("M105");
  CHECK(questions > 0);
  CHECK(window.bytes_in_flight() <= 127 + 2 * 14);
}
