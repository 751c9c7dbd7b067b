#include "daemon/jobs/job_options.h"

#include "config/config.h"
#include "engine/orient/search.h"

#include <charconv>
#include <stdexcept>

namespace voidpath::daemon {
namespace {

/// As in the files beside models.
constexpr double kMinScale = 1e-6;
constexpr double kMaxScale = 1e6;

template <typename T>
bool reads_as(const std::string& text, T& value) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  return read.ec == std::errc() && read.ptr == text.data() + text.size();
}

}  // namespace

std::string read_method(const std::string& text) {
  if (!orient::method_from(text)) {
    throw std::invalid_argument("method \"" + text + "\" is none of toolpath, thesis, ahsan, as-delivered");
  }
  return text;
}

std::string read_slicer(const std::string& text) {
  if (text != config::kBuiltinSlicer && text != config::kPrusaSlicer && text != config::kCuraEngine)
    throw std::invalid_argument("slicer \"" + text + "\" is none of builtin, prusa-slicer, cura-engine");
  return text;
}

int read_copies(const std::string& text) {
  int value = 0;
  if (!reads_as(text, value) || value < 1 || value > kMaxCopies) {
    throw std::invalid_argument("copies are a whole number from 1 to " + std::to_string(kMaxCopies) +
                                ", not \"" + text + "\"");
  }
  return value;
}

double read_scale(const std::string& text) {
  double value = 0;
  if (!reads_as(text, value) || !(value >= kMinScale && value <= kMaxScale)) {
    throw std::invalid_argument("the scale is a number above 0, at most a million, not \"" + text + "\"");
  }
  return value;
}

}  // namespace voidpath::daemon
