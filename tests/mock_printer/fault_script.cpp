#include "tests/mock_printer/fault_script.h"

#include <limits>

namespace voidpath::test::mock {

FaultTrigger natural_trigger(FaultKind kind) {
  switch (kind) {
    case FaultKind::kDropByte:
    case FaultKind::kFlipByte:
    case FaultKind::kDoubleByte:
    case FaultKind::kInsertByte:
      return FaultTrigger::kByte;
    case FaultKind::kLoseOk:
    case FaultKind::kDoubleOk:
    case FaultKind::kGarbleOk:
      return FaultTrigger::kOk;
    default:
      return FaultTrigger::kLine;
  }
}

FaultInjector::FaultInjector(std::vector<Fault> faults, std::uint64_t seed)
    : faults_(std::move(faults)), random_(seed) {}

bool FaultInjector::chance(double probability) {
  // 53 random bits make a double in [0, 1), the same on every machine.
  constexpr double kUnit = 1.0 / 9007199254740992.0;
  return static_cast<double>(random_() >> 11) * kUnit < probability;
}

std::size_t FaultInjector::pick(std::size_t n) { return static_cast<std::size_t>(random_() % n); }

bool FaultInjector::fires(Fault& fault, std::uint64_t count) {
  if (fault.at) {
    if (fault.fired >= (fault.limit == 0 ? 1 : fault.limit)) return false;
    if (static_cast<double>(count) < *fault.at) return false;
  } else {
    if (fault.limit != 0 && fault.fired >= fault.limit) return false;
    if (!chance(fault.probability)) return false;
  }
  ++fault.fired;
  ++fired_;
  return true;
}

void FaultInjector::pass_byte(char byte, bool outwards, std::string& out) {
  const std::uint64_t count = outwards ? ++bytes_out_ : ++bytes_in_;
  bool keep = true;
  for (Fault& fault : faults_) {
    if (fault.trigger != FaultTrigger::kByte || fault.outwards != outwards || !fires(fault, count)) continue;
    switch (fault.kind) {
      case FaultKind::kDropByte:
        keep = false;
        break;
      case FaultKind::kFlipByte:
        byte = static_cast<char>(byte ^ (1 << pick(8)));
        break;
      case FaultKind::kDoubleByte:
        out += byte;
        break;
      case FaultKind::kInsertByte:
        out += static_cast<char>(pick(256));
        break;
      default:
        break;
    }
  }
  if (keep) out += byte;
}

std::vector<Fault> FaultInjector::due(FaultTrigger trigger, std::uint64_t count) {
  std::vector<Fault> result;
  for (Fault& fault : faults_)
    if (fault.trigger == trigger && fault.kind != FaultKind::kResendWithoutOk && fires(fault, count))
      result.push_back(fault);
  return result;
}

std::vector<Fault> FaultInjector::at_line() { return due(FaultTrigger::kLine, ++lines_); }

std::vector<Fault> FaultInjector::at_ok() { return due(FaultTrigger::kOk, ++oks_); }

std::vector<Fault> FaultInjector::at_time(double now) {
  std::vector<Fault> result;
  for (Fault& fault : faults_) {
    if (fault.trigger != FaultTrigger::kTime || fault.fired > 0 || *fault.at > now) continue;
    ++fault.fired;
    ++fired_;
    result.push_back(fault);
  }
  return result;
}

double FaultInjector::next_time() const {
  double next = std::numeric_limits<double>::infinity();
  for (const Fault& fault : faults_)
    if (fault.trigger == FaultTrigger::kTime && fault.fired == 0) next = std::min(next, *fault.at);
  return next;
}

bool FaultInjector::resend_lacks_ok() {
  ++resends_;
  for (Fault& fault : faults_)
    if (fault.kind == FaultKind::kResendWithoutOk && fires(fault, resends_)) return true;
  return false;
}

}  // namespace voidpath::test::mock
