#include "firmware-io/transport/serial_port.h"

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

using namespace voidpath::fw;

namespace {

/// Both ends of a pseudo terminal, held open.
class Terminal {
 public:
  Terminal() : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    REQUIRE(master_ >= 0);
    REQUIRE(::grantpt(master_) == 0);
    REQUIRE(::unlockpt(master_) == 0);
    name_ = ::ptsname(master_);
    slave_ = ::open(name_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    REQUIRE(slave_ >= 0);
  }
  ~Terminal() {
    ::close(slave_);
    ::close(master_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  const std::string& name() const { return name_; }
  bool hangs_up() const {
    termios state{};
    REQUIRE(::tcgetattr(slave_, &state) == 0);
    return (state.c_cflag & HUPCL) != 0;
  }

 private:
  int master_;
  int slave_ = -1;
  std::string name_;
};

}  // namespace

TEST_CASE("a port is left hung up, so that the next opening resets the board, unless told otherwise",
          "[serial_port]") {
  const Terminal terminal;
  open_serial_port(terminal.name(), 115200);
  CHECK(terminal.hangs_up());
  // Also where the last one to use it wanted the other.
  open_serial_port(terminal.name(), 115200, false);
  CHECK_FALSE(terminal.hangs_up());
  open_serial_port(terminal.name(), 250000, true);
  CHECK(terminal.hangs_up());
}
