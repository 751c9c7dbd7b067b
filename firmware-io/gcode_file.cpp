#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/file_command.h"
#include "firmware-io/marlin/words.h"
#include "firmware-io/printer_port.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace voidpath::fw {
namespace {

// Slicers write thumbnails as comments of up to 80 characters and settings of some thousand; a longer line is
// not G-code.
constexpr std::size_t kMaxFileLine = 1 << 20;
// Lines are prepared so many at a time: a thread that wakes for each few of them finds its caches cold.
constexpr std::size_t kAhead = 32;
constexpr char kAxes[] = {'X', 'Y'};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

class GcodeFile final : public LineSource {
 public:
  explicit GcodeFile(std::string name) : name_(std::move(name)), file_(std::fopen(name_.c_str(), "rbe")) {
    if (!file_) throw std::runtime_error(name_ + ": " + std::strerror(errno));
    std::fseek(file_.get(), 0, SEEK_END);
    const long end = std::ftell(file_.get());
    if (end < 0) throw std::runtime_error(name_ + ": not a regular file");
    size_ = static_cast<std::uint64_t>(end);
    std::rewind(file_.get());
  }

  std::optional<SourceLine> next() override {
    SourceLine line;
    if (!fetch(line)) return {};
    return line;
  }
  bool fetch(SourceLine& line) override {
    if (at_ == count_) read_ahead();
    if (at_ == count_) {
      if (!error_.empty()) throw std::runtime_error(error_);
      position_ = read_;
      return false;
    }
    Ahead& ahead = ahead_[at_++];
    position_ = ahead.end;
    std::swap(line, ahead.line);
    return true;
  }
  std::uint64_t position() const noexcept override { return position_; }
  std::uint64_t size() const noexcept override { return size_; }

 private:
  struct Ahead {
    SourceLine line;
    std::uint64_t end = 0;  ///< of it, in the file
  };

  // What is wrong with a line is only told when those before it have been fetched.
  void read_ahead() {
    at_ = count_ = 0;
    try {
      while (error_.empty() && count_ < kAhead && read_command()) {
      }
    } catch (const std::runtime_error& error) {
      error_ = error.what();
    }
  }

  // Appends the next command, perhaps with one before it; false at the end of the file.
  bool read_command() {
    while (next_line()) {
      const std::uint32_t index = lines_ - 1;
      std::string command;
      try {
        command = marlin::file_command(line_);
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(name_ + ":" + std::to_string(index + 1) + ": " + error.what());
      }
      if (command.empty()) continue;
      const marlin::Word word = marlin::first_word(command);
      if (word.letter == 'G') note_geometry(word.number, command, index);
      bool rounded = false;
      ahead_[count_++] = {{marlin::trim_move(command, rounds_ && absolute_ && millimetres_, &rounded), index},
                          read_};
      if (rounded || unlike_the_file()) note_place(word, command);
      return true;
    }
    return false;
  }

  // A file that says neither is taken to count on what the printer was left in.
  void note_geometry(int number, const std::string& command, std::uint32_t index) {
    if (number <= 1 || number == 4 || number == 10 || number == 11) return;
    if (number == 2 || number == 3) return begin_arcs(index);
    if (number == 90 || number == 91) absolute_ = number == 90;
    if (number == 20 || number == 21) millimetres_ = number == 21;
    if (number != 90 && number != 21 && !leaves_place(command)) exact_ = {};
  }

  // What stands between a file's moves and its first arc as a rule: the plane, the filament's count.
  static bool leaves_place(const std::string& command) {
    return command == "G17" || (command.starts_with("G92 E") && command.find_first_of("XY") == command.npos);
  }

  // What an arc begins and ends with decides where its middle is and which way it turns: half a micrometre is
  // too much there.
  void begin_arcs(std::uint32_t index) {
    if (!std::exchange(rounds_, false) || !unlike_the_file()) return;
    std::string exactly = "G1";
    for (std::size_t i = 0; i < exact_.size(); ++i)
      if (!exact_[i].empty()) exactly += std::string(" ") + kAxes[i] + exact_[i];
    exact_ = {};
    ahead_[count_++] = {{std::move(exactly), index}, read_};
  }

  bool unlike_the_file() const { return !exact_[0].empty() || !exact_[1].empty(); }

  void note_place(const marlin::Word& word, const std::string& command) {
    if (word.letter != 'G' || word.number > 1) return;
    for (std::size_t i = 0; i < exact_.size(); ++i) {
      std::string place = marlin::place_of(command, kAxes[i]);
      if (place.empty()) continue;
      const bool coarse =
          place.size() - std::min(place.find('.'), place.size()) <= marlin::kPlaceDecimals + 1;
      exact_[i] = coarse ? std::string() : std::move(place);
    }
  }

  // A carriage return amid a line ends a command, as in the printer, but counts as no line.
  bool next_line() {
    if (!behind_return_.empty()) {
      line_ = std::exchange(behind_return_, {});
    } else if (read_line()) {
      ++lines_;
    } else {
      return false;
    }
    const std::size_t end = line_.find('\r');
    if (end != line_.npos) {
      behind_return_ = line_.substr(end + 1);
      line_.resize(end);
    }
    return true;
  }

  // The next line without its end; false at the end of the file.
  bool read_line() {
    line_.clear();
    int c = 0;
    while ((c = ::getc_unlocked(file_.get())) != EOF) {
      ++read_;
      if (c == '\n') return true;
      line_ += static_cast<char>(c);
      if (line_.size() > kMaxFileLine) fail("not G-code: a line without end");
    }
    if (std::ferror(file_.get())) fail("cannot read");
    return !line_.empty();
  }

  [[noreturn]] void fail(const char* what) const {
    throw std::runtime_error(name_ + ":" + std::to_string(lines_ + 1) + ": " + what);
  }

  std::string name_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::string line_;
  std::string behind_return_;  ///< what of the last line is still to come
  std::uint32_t lines_ = 0;
  bool absolute_ = false;
  bool millimetres_ = true;           ///< as every firmware begins
  bool rounds_ = true;                ///< until the first arc
  std::array<std::string, 2> exact_;  ///< X and Y as the file has them, where the last move's were rounded
  std::array<Ahead, kAhead + 1> ahead_;
  std::size_t count_ = 0;   ///< of them
  std::size_t at_ = 0;      ///< the next
  std::string error_;       ///< met behind them
  std::uint64_t read_ = 0;  ///< bytes
  std::uint64_t position_ = 0;
  std::uint64_t size_ = 0;
};

}  // namespace

std::unique_ptr<LineSource> open_gcode_file(const std::string& file) {
  return std::make_unique<GcodeFile>(file);
}

}  // namespace voidpath::fw
