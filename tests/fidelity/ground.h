#pragma once

#include "tests/fidelity/mask.h"
#include "tests/fidelity/rules.h"
#include "tests/fidelity/sections.h"

#include <cstddef>
#include <deque>
#include <optional>

namespace voidpath::fidelity {

/// A layer that has been looked at.
struct Seen {
  Section section;
  Mask part, support;  ///< what was printed
  double bottom = 0, top = 0;
};

/// What lies under strands whose underside is at one height: whether they have something to lie on. Keeps
/// references to what it is given.
class Ground {
 public:
  /// `below`: the layers below, the lowest first, down to where reach() says. `height`: of the strands.
  Ground(const std::deque<Seen>& below, const Rules& rules, const Grid& grid, double underside,
         double height);

  /// For a strand of the part: strands one layer down, within the lean that the angle allows; sparse infill
  /// as far as its lines are apart; support a gap below, what lies between its lines included, and beside it
  /// as far as it must keep from the part; the part and the plate across a gap of the part's own so low that
  /// no layer of support has room in it with its gaps. There a strand lands on what is below, about as deep
  /// as support would have left it, and nothing better can be printed.
  bool holds(double x, double y);
  /// For a strand of support: support one layer down, what lies between its lines included, within the lean
  /// that branches may have; the plate; the part a gap below. Dense lines of a roof may go on beyond the last
  /// line below by half of what those are apart.
  bool holds_support(double x, double y, bool roof);

  /// Layers whose top lies further below a strand's underside hold nothing, mm.
  static double reach(const Rules& rules, double thickest_layer);

 private:
  bool support_fits(double from, double to) const;
  void look_down(double underside);

  const std::deque<Seen>& below_;
  const Rules& rules_;
  const Grid& grid_;
  const Seen* under_ = nullptr;  ///< the layer right below
  Mask held_up_;                 ///< by support a gap below, and between its lines
  Mask close_below_;             ///< the part across a gap of its own
  Mask rest_;                    ///< the part where support may stand on it
  Mask raft_top_;                ///< the raft's last layer, where no support fits above it
  Mask own_below_;               ///< support and what is between its lines
  std::optional<Nearby> part_, own_support_, support_, close_, rests_, raft_;
  double lean_ = 0, support_lean_ = 0, sparse_ = 0, between_ = 0, beside_ = 0, roof_lean_ = 0;
  bool near_plate_ = false;  ///< no support fits below
  bool on_plate_ = false;
};

}  // namespace voidpath::fidelity
