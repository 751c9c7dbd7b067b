#pragma once

#include <string>

/// The receiving end of MeatPack, as a firmware has it: between the receive buffer and the line reader,
/// knowing nothing of lines, deaf to a flush of the buffer.
namespace voidpath::test::mock {

class Unpacker {
 public:
  /// One byte from the receive buffer; appends what the line reader gets. `told` is true after a command,
  /// which is answered by state().
  void take(char byte, std::string& out, bool& told) {
    const auto c = static_cast<unsigned char>(byte);
    if (c == kCommand) {
      if (commands_ > 0) {
        command_next_ = true;
        commands_ = 0;
      } else {
        ++commands_;
      }
      return;
    }
    if (command_next_) {
      command_next_ = false;
      obey(c);
      told = true;
      return;
    }
    if (commands_ > 0) {
      commands_ = 0;
      unpack(kCommand, out);
    }
    unpack(c, out);
  }
  std::string state() const {
    return std::string("[MP] PV01 ") + (active_ ? "ON" : "OFF") + (no_spaces_ ? " NSP" : " ESP");
  }
  void reset() { *this = {}; }

 private:
  static constexpr unsigned char kCommand = 0xFF;

  void obey(unsigned char command) {
    switch (command) {
      case 0xFB:
        active_ = true;
        break;
      case 0xFA:
        active_ = false;
        break;
      case 0xF9:
        reset();
        break;
      case 0xF7:
        no_spaces_ = true;
        break;
      case 0xF6:
        no_spaces_ = false;
        break;
      default:
        break;
    }
  }
  char character(unsigned nibble) const {
    if (nibble == 11 && no_spaces_) return 'E';
    return "0123456789. \nGX"[nibble];
  }
  void unpack(unsigned char c, std::string& out) {
    if (!active_) {
      out += static_cast<char>(c);
      return;
    }
    if (literals_ > 0) {
      out += static_cast<char>(c);
      if (second_ != 0) out += second_;
      second_ = 0;
      --literals_;
      return;
    }
    const unsigned low = c & 15u, high = c >> 4;
    if (low == 15) {
      ++literals_;
      if (high == 15)
        ++literals_;
      else
        second_ = character(high);
      return;
    }
    out += character(low);
    if (character(low) == '\n') return;
    if (high == 15)
      ++literals_;
    else
      out += character(high);
  }

  bool active_ = false, no_spaces_ = false, command_next_ = false;
  int commands_ = 0, literals_ = 0;
  char second_ = 0;
};

}  // namespace voidpath::test::mock
