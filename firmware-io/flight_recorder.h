#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::fw {

/// Keeps the last lines each way, for the report after a fault. Any thread; guarded by its own mutex.
class FlightRecorder {
 public:
  explicit FlightRecorder(std::size_t lines_each_way = 200);
  void sent(double at_s, std::string_view line) { put(sent_, at_s, line); }
  void received(double at_s, std::string_view line) { put(received_, at_s, line); }
  /// Oldest first: "12.345 > sent", "12.346 < received".
  std::vector<std::string> lines() const;

 private:
  struct Entry {
    std::uint64_t order = 0;  ///< 0: never written
    double at_s = 0;
    std::string text;
  };
  struct Ring {
    std::vector<Entry> entries;
    std::size_t at = 0;
  };
  void put(Ring& ring, double at_s, std::string_view line);

  mutable std::mutex mutex_;
  Ring sent_;
  Ring received_;
  std::uint64_t order_ = 0;
};

}  // namespace voidpath::fw
