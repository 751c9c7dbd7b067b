#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/file_command.h"
#include "firmware-io/marlin/words.h"
#include "firmware-io/printer_port.h"

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

  // Appends the next command; false at the end of the file.
  bool read_command() {
    while (read_line()) {
      const std::uint32_t index = lines_++;
      std::string command;
      try {
        command = marlin::file_command(line_);
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(name_ + ":" + std::to_string(index + 1) + ": " + error.what());
      }
      if (command.empty()) continue;
      note_units(command);
      ahead_[count_++] = {{marlin::trim_move(command, absolute_ && millimetres_), index}, read_};
      return true;
    }
    return false;
  }

  // A file that says neither is taken to count on what the printer was left in.
  void note_units(const std::string& command) {
    const marlin::Word word = marlin::first_word(command);
    if (word.letter != 'G') return;
    if (word.number == 90 || word.number == 91) absolute_ = word.number == 90;
    if (word.number == 20 || word.number == 21) millimetres_ = word.number == 21;
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
  std::uint32_t lines_ = 0;
  bool absolute_ = false;
  bool millimetres_ = true;  ///< as every firmware begins
  std::array<Ahead, kAhead> ahead_;
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
