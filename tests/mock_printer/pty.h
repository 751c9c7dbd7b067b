#pragma once

#include <string>
#include <string_view>

/// A pseudo-terminal whose other end stands at a path of our choice, raw from the start.
namespace voidpath::test::mock {

class Pty {
 public:
  /// Throws std::system_error.
  explicit Pty(std::string link);
  ~Pty();
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  int fd() const { return master_; }
  /// What the host has written; appends to `into`. Keeps track of whether a host is there.
  void read(std::string& into);
  /// Sends what fits; the rest stays in `from` unless no host is there (then nobody hears it).
  void write(std::string& from);
  /// Waits until there is input or `seconds` have passed.
  void wait(double seconds);
  /// A host has the port open.
  bool connected() const { return opens_ > 0; }
  /// A host has opened the port since the last call.
  bool take_opened();

  /// The cable is pulled: the host sees its port vanish.
  void unplug();
  /// And comes back, as a new device at the same path.
  void plug();
  bool plugged() const { return master_ >= 0; }

 private:
  void look_for_hosts();

  std::string link_;
  int master_ = -1;
  int watch_ = -1;  ///< tells of opens and closes, even when one follows the other at once
  int opens_ = 0;
  bool opened_ = false, ever_ = false;
  bool news_ = true;  ///< the watch has something to tell
  unsigned reads_ = 0;
};

}  // namespace voidpath::test::mock
