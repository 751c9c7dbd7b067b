#pragma once

#include "engine/orient/search.h"

#include <cstddef>
#include <string>
#include <vector>

namespace voidpath::report {

/// The best candidates, at most `count`, that point somewhere else (some 26° at least) than the chosen one,
/// the part as delivered and one another. Timed ones first, by their time; the others by score. For
/// Method::toolpath only printable ones.
std::vector<std::size_t> runners_up(const orient::Choice& choice, std::size_t count);

/// A candidate worth naming.
struct Named {
  std::size_t candidate = 0;
  std::string name;  ///< "Chosen", "As delivered", "axis +x", "runner-up"; several with " · " between
  std::string mark;  ///< on the map and in the table: a star, "D", then numbers
};

/// The chosen one first, as delivered, then the others by time and score. Each candidate once.
std::vector<Named> ranking(const orient::Choice& choice);

}  // namespace voidpath::report
