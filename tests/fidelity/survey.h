#pragma once

#include "tests/fidelity/slicing.h"

#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

/// Many prints looked at, and what became of them.
namespace voidpath::fidelity {

/// A part and a way to print it.
struct Case {
  std::string part;
  std::string way;  ///< empty: the plain one
  std::shared_ptr<const mesh::TriangleMesh> mesh;
  Set set;
  std::function<Bounds(const Rules&)> bounds = bounds_for;
};

struct Verdict {
  std::string part;
  std::string way;
  std::vector<Excess> beyond;
};

/// Slices and checks each, the largest first and as many at a time as there are processors, and writes what
/// was found as soon as it is. Verdicts come in the order of the cases; a case that throws is beyond its
/// bounds.
std::vector<Verdict> survey(const std::vector<Case>& cases, std::ostream& out);

bool all_within(const std::vector<Verdict>& verdicts);

/// How many parts, and prints of them, are within bounds, and a line for each part that is not: what it
/// exceeds, by how much at worst, and where.
std::string summary(const std::vector<Verdict>& verdicts);

}  // namespace voidpath::fidelity
