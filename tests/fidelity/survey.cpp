#include "tests/fidelity/survey.h"

#include "engine/mesh/triangle_mesh.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <exception>
#include <map>
#include <mutex>
#include <numeric>
#include <ostream>
#include <set>
#include <sstream>

namespace voidpath::fidelity {

namespace {

std::string full_name(const std::string& part, const std::string& way) {
  return way.empty() ? part : part + ", " + way;
}

/// What a print costs goes with the layers and with what they are drawn on.
double cost(const Case& c) { return mesh::bounds(*c.mesh).size().prod(); }

std::string looked_at(const Case& c, Verdict& verdict) {
  const std::string name = full_name(c.part, c.way);
  try {
    const Sliced part = sliced(*c.mesh, options_for(c.set));
    const Findings f = checked(part);
    verdict.beyond = excesses(f, c.bounds(part.rules));
    return told(name, f);
  } catch (const std::exception& e) {
    verdict.beyond.push_back({e.what(), 0, 0, ""});
    return name + ":\n";
  }
}

std::string told(const Excess& e) {
  std::ostringstream s;
  s << e.name;
  if (e.value > 0) s << " " << e.value << " of " << e.limit;
  if (!e.where.empty()) s << " " << e.where;
  return s.str();
}

/// By what is exceeded, the worst of a part's ways and which that is.
using Worsts = std::map<std::string, std::pair<Excess, std::string>>;

}  // namespace

std::vector<Verdict> survey(const std::vector<Case>& cases, std::ostream& out) {
  std::vector<std::size_t> order(cases.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return cost(cases[a]) > cost(cases[b]); });
  std::vector<Verdict> verdicts(cases.size());
  std::mutex writing;
  run::parallel_for({}, order.size(), [&](std::size_t k) {
    const Case& c = cases[order[k]];
    Verdict& v = verdicts[order[k]];
    v.part = c.part;
    v.way = c.way;
    std::string text = looked_at(c, v);
    for (const Excess& e : v.beyond) text += "  BEYOND " + told(e) + "\n";
    const std::lock_guard lock(writing);
    out << text << std::flush;
  });
  return verdicts;
}

bool all_within(const std::vector<Verdict>& verdicts) {
  return std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.beyond.empty(); });
}

std::string summary(const std::vector<Verdict>& verdicts) {
  std::set<std::string> parts;
  std::map<std::string, Worsts> beyond;
  std::size_t prints_within = 0;
  for (const Verdict& v : verdicts) {
    parts.insert(v.part);
    prints_within += v.beyond.empty() ? 1u : 0u;
    for (const Excess& e : v.beyond) {
      const auto [at, fresh] = beyond[v.part].try_emplace(e.name, e, v.way);
      if (!fresh && e.value > at->second.first.value) at->second = {e, v.way};
    }
  }
  std::ostringstream s;
  s << parts.size() - beyond.size() << " of " << parts.size() << " parts within bounds (" << prints_within
    << " of " << verdicts.size() << " prints)\n";
  for (const auto& [part, worsts] : beyond) {
    s << "  " << part;
    const char* separator = ": ";
    for (const auto& [name, worst] : worsts) {
      s << separator << (worst.second.empty() ? "" : worst.second + ": ") << told(worst.first);
      separator = "; ";
    }
    s << "\n";
  }
  return s.str();
}

}  // namespace voidpath::fidelity
