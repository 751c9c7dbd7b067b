#pragma once

#include "firmware-io/line_source.h"
#include "firmware-io/s3g/action.h"
#include "firmware-io/s3g/machine.h"
#include "firmware-io/s3g/words.h"

#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::fw::s3g {

/// A command that cannot be carried out as meant; what() names it and says why.
class EncodeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// With its line in the file.
  EncodeError(const SourceLine& line, const std::string& what)
      : std::runtime_error("line " + std::to_string(line.index + 1) + ": " + what) {}
};

/// What one line of G-code comes to.
struct Encoded {
  /// What the host does itself, before anything that follows.
  enum class Host { nothing, pause, finish, halt, report };
  std::vector<Action> actions;
  std::vector<std::string> notes;  ///< of what is left out, each once
  Host host = Host::nothing;
};

/// Translates G-code into S3G actions, as a slicer's file for these machines means it. Pure; one thread.
///
/// X, Y and Z go out absolute, rounded to steps. The extruders A and B go out relative, carrying what
/// rounding left over, and negative: forward is down in their count. A move keeps each axis within its
/// greatest feed; one shorter than a step on all axes waits for the next. After homing or recalling a home
/// position X, Y and Z stand where only the firmware knows, until a move or G92 names them; such a first move
/// is unaccelerated. Arcs become chords. What would change the print and cannot be done is refused
/// (EncodeError); settings that have no counterpart are left out, with a note.
class Encoder {
 public:
  explicit Encoder(Machine machine) : machine_(machine) {}

  /// Throws EncodeError; then nothing has changed.
  Encoded encode(std::string_view line);
  /// The same; the error names the line in the file.
  Encoded encode(const SourceLine& line);

  /// Build notifications, sent once whatever the file does.
  Action build_start(std::string_view name);
  Action build_end();
  bool build_started() const { return state_.build_started; }

  /// A new print: absolute positions, millimetres, all unknown.
  void restart();
  /// Where the firmware says it stands; all axes are known then.
  void set_stand(const std::array<std::int32_t, kAxes>& steps);
  /// Where the firmware's count of the extruders' steps begins.
  void set_extruders(std::int32_t a, std::int32_t b) {
    state_.stand.steps[kA] = a;
    state_.stand.steps[kB] = b;
  }
  const Stand& stand() const { return state_.stand; }

 private:
  using Vec3 = std::array<double, 3>;
  struct State {
    Stand stand;
    Vec3 position_mm{};                   ///< logical X, Y, Z; may lie a fraction of a step off the stand
    std::array<double, 2> extruder_mm{};  ///< logical E of each extruder
    std::array<double, 2> remainder{};    ///< of a step of A, B, not yet sent
    double feed_mm_s = 25;                ///< before the first F
    double unit_mm = 1;
    double speed_ratio = 1, flow_ratio = 1;
    int tool = 0;
    bool tool_told = false;   ///< to the firmware, which keeps the one it had
    bool keeps_tool = false;  ///< until one is named: where it stands was told for the one it has
    bool relative = false, relative_e = false;
    bool build_started = false;
  };

  void encode_g(const Words& words);
  void encode_m(const Words& words);
  void encode_heat(const Words& words);
  void encode_build(const Words& words);
  void encode_text(std::string_view text, int seconds);

  void line_to(const Words& words);
  void arc_to(const Words& words, bool clockwise);
  Vec3 target_of(const Words& words);
  std::array<double, 2> extrusion_of(const Words& words);
  void move_to(const Vec3& target, std::array<double, 2> extrusion, std::uint8_t named);
  void move_unknown(const Stand& to);
  void send_move(const Stand& to);
  void home(const Words& words, bool to_max);
  void home_axes(std::uint8_t axes, bool to_max, double feed_mm_s);
  void set_position(const Words& words);
  void change_tool(int tool);
  void tell_tool();
  void require_tool(int tool) const;
  int tool_of(const Words& words) const;
  std::uint8_t axes_of(const Words& words, std::uint8_t otherwise) const;
  void act(Payload payload, Action::Kind kind = Action::Kind::other, int tool = 0);
  void note(const std::string& text);

  Machine machine_;
  State state_;
  Encoded out_;
  std::set<std::string> noted_;
};

}  // namespace voidpath::fw::s3g
