#include "firmware-io/s3g/link.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace voidpath::fw::s3g {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
/// The same packet damaged so often means a wire that carries nothing.
constexpr int kMostFailures = 50;
/// Glances at a queue that moves on in between, before waiting until it is empty instead.
constexpr int kMostGlances = 8;
/// Share of its nominal time that a byte takes at least: clocks differ by some percent.
constexpr double kFastestWire = 0.9;

// A code that nobody knows is damage that the checksum does not show: one in 256 passes.
bool means_try_again(ReplyCode code) {
  return code > ReplyCode::packet_timeout || code == ReplyCode::generic_error || code == ReplyCode::bad_crc ||
         code == ReplyCode::too_long || code == ReplyCode::packet_timeout || code == ReplyCode::tool_lock ||
         code == ReplyCode::downstream_timeout;
}

}  // namespace

std::string hex(std::string_view bytes) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (!out.empty()) out += ' ';
    out += kDigits[byte >> 4U];
    out += kDigits[byte & 15U];
  }
  return out;
}

void Link::restart(double t) {
  reader_.clear();
  account_.restart();
  output_.clear();
  outcome_.reset();
  action_.reset();
  step_ = Step::idle;
  aside_ = owed_ = running_ = unsure_ = false;
  failures_ = glances_ = 0;
  good_t_ = t;
}

void Link::send(std::string_view payload, double t) {
  recorder_.sent(stamp_.now_s(), hex(payload));
  output_ += frame(payload);
  packet_bytes_ = payload.size() + kFrameBytes;
  ++packets_sent_;
  bytes_sent_ += packet_bytes_;
  due_t_ = t + timing_.reply_s;
  sent_t_ = t;
}

void Link::ask(Question question, double t) {
  failures_ = 0;
  good_t_ = std::max(good_t_, t);
  aside_ = draining();
  step_ = Step::asking;
  why_ = Why::caller;
  once_ = false;
  query_ = std::move(question);
  send(query_.payload, t);
}

void Link::ask_once(std::string payload, double t) {
  ask({std::move(payload)}, t);
  once_ = true;
}

void Link::send_query(Query query, Why why, double t) {
  step_ = Step::asking;
  why_ = why;
  query_ = question(query);
  send(query_.payload, t);
}

void Link::act(Action action, double t) {
  failures_ = 0;
  in_doubt_ = false;
  good_t_ = std::max(good_t_, t);
  action_ = std::move(action);
  begin_action(t);
}

void Link::begin_action(double t) {
  if (unsure_) return send_query(Query::build, Why::cancel, t);
  send_action(t);
}

void Link::send_action(double t) {
  step_ = Step::acting;
  why_ = Why::caller;
  send(action_->payload, t);
}

void Link::insist(std::string payload, double t) {
  // A packet that has begun to leave is finished: the firmware would take what follows for its rest.
  const bool begun = output_.size() < packet_bytes_;
  if (!begun) output_.resize(output_.size() - packet_bytes_);
  owed_ = begun && (step_ == Step::asking || step_ == Step::acting);
  step_ = Step::insisting;
  aside_ = false;
  query_ = {std::move(payload)};
  action_.reset();
  outcome_.reset();
  patient_until_ = t + timing_.insist_s;
  say_again(t);
}

void Link::say_again(double t) {
  send(query_.payload, t);
  due_t_ = t + timing_.quiet_s;
}

void Link::done(Outcome outcome) {
  failures_ = glances_ = 0;
  outcome_ = std::move(outcome);
  if (std::exchange(aside_, false) && !std::holds_alternative<Dead>(*outcome_)) {
    step_ = Step::drain_wait;
    due_t_ = drain_t_;
    return;
  }
  step_ = Step::idle;
  action_.reset();
}

void Link::give_up() {
  account_.lose_track();
  step_ = Step::idle;
  action_.reset();
}

std::optional<Outcome> Link::take() { return std::exchange(outcome_, {}); }

double Link::deadline() const noexcept { return step_ == Step::idle ? kNever : due_t_; }

void Link::received(std::string_view bytes, double t) {
  for (const char byte : bytes) {
    if (const auto packet = reader_.take(byte)) {
      recorder_.received(stamp_.now_s(), packet->good ? hex(packet->payload) : "damaged");
      on_packet(*packet, t);
    }
  }
  if (step_ == Step::quiet || step_ == Step::insisting)
    due_t_ = std::min(t + timing_.quiet_s, patient_until_);
}

// A copy of the reply before. One that is none, and comes early, tells that the wire is faster than was said.
bool Link::is_copy(const Packet& packet, double t) {
  if (!packet.good || owed_ || !times_tell_) return false;
  const std::size_t size = packet.payload.size();
  const auto bytes = static_cast<double>(packet_bytes_ + size + kFrameBytes);
  if (t >= sent_t_ + kFastestWire * timing_.byte_s * bytes) return false;
  const bool fits = step_ == Step::asking && (query_.answer_bytes == 0 || size == query_.answer_bytes);
  times_tell_ = !fits || failures_ > 0 || size <= 1 || size == last_bytes_;
  return times_tell_;
}

void Link::on_packet(const Packet& packet, double t) {
  if (packet.good) good_t_ = t;
  if (is_copy(packet, t)) return;
  if (packet.good) last_bytes_ = packet.payload.size();
  if (step_ == Step::asking) {
    if (packet.good) {
      on_query_reply(packet.payload, t);
    } else {
      disturbed(t);
    }
  } else if (step_ == Step::acting) {
    if (packet.good && packet.payload.size() == 1) {
      on_action_reply(reply_code(packet.payload[0]), t);
    } else {
      disturbed(t);
    }
  } else if (step_ == Step::insisting) {
    on_insisted(packet, t);
  }
}

// What came right behind another packet is easily lost: once that one is answered, the firmware listens
// again.
void Link::on_insisted(const Packet& packet, double t) {
  if (std::exchange(owed_, false)) return say_again(t);
  if (!packet.good || packet.payload.size() != 1) return;
  const ReplyCode code = reply_code(packet.payload[0]);
  if (code == ReplyCode::ok || code == ReplyCode::heater_failure) done(Answer{query_.payload, {}, code});
}

// A build cancelled long ago still says so.
bool Link::notes_cancel(const std::string& data) {
  if (query_of(query_.payload) != Query::build || data.empty()) return false;
  const auto state = static_cast<BuildState>(data[0]);
  const bool running =
      state == BuildState::running || state == BuildState::paused || state == BuildState::cancelling;
  unsure_ = false;
  return std::exchange(running_, running) && state == BuildState::cancelled;
}

// Of a cancel the firmware tells but once, in place of any reply, and obeys again after that.
void Link::lost_reply() {
  ++failures_;
  unsure_ = running_;
}

void Link::on_query_reply(const std::string& payload, double t) {
  const ReplyCode code = reply_code(payload[0]);
  if (code == ReplyCode::ok && (query_.answer_bytes == 0 || payload.size() == query_.answer_bytes)) {
    failures_ = 0;
    const std::string data = payload.substr(1);
    const bool cancelled = notes_cancel(data);
    if (why_ == Why::caller) return done(Answer{query_.payload, data, code});
    if (cancelled) return done(Refused{*action_, ReplyCode::cancelled});
    return on_inner_answer(data, t);
  }
  // Of an earlier command, late.
  if (code == ReplyCode::ok || code == ReplyCode::overflow) return;
  // Of a tool's own silence the board tells undamaged.
  const bool no_tool = code == ReplyCode::downstream_timeout && query_of(query_.payload) == Query::tool;
  if (means_try_again(code) && !no_tool) return disturbed(t);
  if (why_ == Why::caller) return done(Answer{query_.payload, {}, code});
  if (code == ReplyCode::unsupported && why_ == Why::line_before) return drain(t);
  if (code == ReplyCode::unsupported && why_ == Why::position) {
    in_doubt_ = true;
    return settle(false, t);
  }
  done(Refused{*action_, code});
}

void Link::on_action_reply(ReplyCode code, double t) {
  switch (code) {
    case ReplyCode::ok:
      return settle(true, t);
    case ReplyCode::overflow:
      return done(NoRoom{*action_});
    case ReplyCode::unsupported:
    case ReplyCode::more:
    case ReplyCode::cancelled:
    case ReplyCode::busy:
    case ReplyCode::heater_failure:
      return done(Refused{*action_, code});
    default:
      return disturbed(t);
  }
}

// A reply that is damaged, lost, or tells of a damaged packet.
void Link::disturbed(double t) {
  lost_reply();
  step_ = Step::quiet;
  patient_until_ = t + timing_.silence_s;
  due_t_ = t + timing_.quiet_s;
}

void Link::elapsed(double t) {
  if (step_ == Step::idle || t < due_t_) return;
  switch (step_) {
    case Step::asking:
    case Step::acting:
      reader_.clear();
      lost_reply();
      return go_on(t);
    case Step::quiet:
      return go_on(t);
    case Step::drain_wait:
      return drain(t);
    case Step::insisting:
      reader_.clear();
      if (t >= patient_until_) return done(Dead{"the printer does not hear the abort"});
      return say_again(t);
    case Step::idle:
      return;
  }
}

// After a disturbance, with nothing more on the wire.
void Link::go_on(double t) {
  if (t >= good_t_ + timing_.silence_s) return done(Dead{"the printer no longer answers"});
  if (failures_ >= kMostFailures) return done(Dead{"the printer refuses one packet again and again"});
  ++resends_;
  if (!action_ || aside_) {
    if (once_) return done(Answer{query_.payload, {}, ReplyCode::generic_error});
    step_ = Step::asking;
    return send(query_.payload, t);
  }
  if (why_ == Why::cancel) return send_query(Query::build, Why::cancel, t);
  glances_ = 0;
  send_query(Query::build, Why::line_before, t);
}

void Link::on_inner_answer(const std::string& data, double t) {
  switch (why_) {
    case Why::cancel:
      return send_action(t);
    case Why::line_before:
      glance_.line = little_endian(data, 3, 4);
      return send_query(Query::free_buffer, Why::free, t);
    case Why::free:
      glance_.free = little_endian(data, 0, 4);
      return send_query(Query::build, Why::line_after, t);
    case Why::line_after: {
      const std::uint32_t line = little_endian(data, 3, 4);
      if (line == glance_.line) return judge(glance_, t);
      glance_.line = line;
      if (++glances_ >= kMostGlances) return drain(t);
      return send_query(Query::free_buffer, Why::free, t);
    }
    case Why::finished:
      position_.clear();
      if (!data.empty() && data[0] == 1) return send_query(Query::position, Why::position, t);
      step_ = Step::drain_wait;
      due_t_ = drain_t_ = t + timing_.drain_poll_s;
      return;
    case Why::position:
      return judge_position(data, t);
    case Why::caller:
      return;
  }
}

void Link::judge(const Glance& glance, double t) {
  if (const auto taken = account_.took(glance, action_->payload.size())) return settle(*taken, t);
  if (!action_->repeatable()) return drain(t);
  account_.lose_track();
  settle(false, t);
}

// All is done, so that the motors stand where the last command left them.
void Link::judge_position(const std::string& data, double t) {
  const auto stands_at = [&](const Stand& stand) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      if ((stand.known & bit_of(i)) == 0) continue;
      if (static_cast<std::int32_t>(little_endian(data, 4 * i, 4)) != stand.steps[i]) return false;
    }
    return true;
  };
  const bool before = stands_at(action_->before);
  const bool after = stands_at(action_->after);
  // Neither may be damage that the checksum does not show: only what is said twice counts.
  if (!before && !after && std::exchange(position_, data) != data)
    return send_query(Query::position, Why::position, t);
  if (before == after) {
    in_doubt_ = true;
    account_.lose_track();
  }
  settle(after && !before, t);
}

void Link::settle(bool was_taken, double t) {
  if (!was_taken) return begin_action(t);
  account_.accepted(action_->payload.size(), action_->kind == Action::Kind::move);
  done(Accepted{*action_, in_doubt_});
}

}  // namespace voidpath::fw::s3g
