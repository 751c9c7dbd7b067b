#pragma once

#include "tests/fidelity/slicing.h"

#include <string>
#include <vector>

namespace voidpath::fidelity {

/// A way of slicing beside the plain one, and the shapes of shapes.h that show what it does.
struct Mode {
  std::string name;
  Set set;
  std::vector<std::string> shapes;

  bool suits(const std::string& shape) const;
  Bounds bounds(const Rules& rules) const;
};

/// One for each way that changes what is printed where.
const std::vector<Mode>& modes();
/// Throws std::logic_error when there is none of that name.
const Mode& mode(const std::string& name);

}  // namespace voidpath::fidelity
