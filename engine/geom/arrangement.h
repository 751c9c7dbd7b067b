#pragma once

#include "engine/geom/polygon.h"

#include <cstdint>
#include <memory_resource>
#include <optional>
#include <span>
#include <vector>

namespace voidpath::geom {

/// Closed lines cut at all places where they meet: their edges have nothing in common but corners.
struct Arrangement {
  struct Corner {
    Point at;
    bool node = false;  ///< other edges than the two of its line may meet here
  };
  std::pmr::vector<Corner> corners;       ///< line by line
  std::pmr::vector<std::uint32_t> first;  ///< of each line, and the end of the last

  explicit Arrangement(std::pmr::memory_resource* memory) : corners(memory), first(memory) {}
  std::uint32_t next(std::size_t line, std::uint32_t corner) const {
    return corner + 1 == first[line + 1] ? first[line] : corner + 1;
  }
};

/// Crossings are rounded to whole nm, which bends the edges that meet there; what bends may meet others, so
/// it is gone over until nothing new comes (iterated snap rounding: Halperin and Packer 2002). Lines that
/// keep fewer than three corners once repeated ones are left out stay empty. Nothing if that finds no end.
/// What it needs on the way is taken from `memory` too, which need not take anything back.
std::optional<Arrangement> arrange(std::span<const Ring* const> lines,
                                   std::pmr::memory_resource* memory = std::pmr::get_default_resource());

}  // namespace voidpath::geom
