#include "firmware-io/flight_recorder.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace voidpath::fw {
namespace {

std::string text_of(double at_s, char arrow, const std::string& line) {
  char digits[64];
  const auto end = std::to_chars(digits, digits + sizeof digits, at_s, std::chars_format::fixed, 3).ptr;
  std::string out(digits, end);
  out += ' ';
  out += arrow;
  out += ' ';
  out += line;
  return out;
}

}  // namespace

FlightRecorder::FlightRecorder(std::size_t lines_each_way) {
  sent_.entries.resize(lines_each_way);
  received_.entries.resize(lines_each_way);
}

void FlightRecorder::put(Ring& ring, double at_s, std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  const std::lock_guard lock(mutex_);
  Entry& entry = ring.entries[ring.at];
  ring.at = (ring.at + 1) % ring.entries.size();
  entry.order = ++order_;
  entry.at_s = at_s;
  entry.text.assign(line);
}

std::vector<std::string> FlightRecorder::lines() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::pair<const Entry*, char>> all;
  for (const Entry& entry : sent_.entries) all.emplace_back(&entry, '>');
  for (const Entry& entry : received_.entries) all.emplace_back(&entry, '<');
  std::erase_if(all, [](const auto& item) { return item.first->order == 0; });
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b) { return a.first->order < b.first->order; });
  std::vector<std::string> out;
  out.reserve(all.size());
  for (const auto& [entry, arrow] : all) out.push_back(text_of(entry->at_s, arrow, entry->text));
  return out;
}

}  // namespace voidpath::fw
