// Prints through every fault the mock knows, by the thousand: soak [s3g] [COUNT [FIRST_SEED]]; one of them
// with its whole dialogue: soak [s3g] show SEED, soak noisy SEED.
#include "tests/firmware-io/soak.h"

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace {

// Endings so rare are named with their seeds.
constexpr std::size_t kFew = 20;

}  // namespace

int main(int argc, char** argv) {
  using namespace voidpath::test;
  const bool s3g = argc > 1 && std::string(argv[1]) == "s3g";
  if (s3g) --argc, ++argv;
  if (const std::string verb = argc > 2 ? argv[1] : ""; verb == "show" || verb == "noisy") {
    const std::uint64_t seed = std::strtoull(argv[2], nullptr, 10);
    const SoakPrint print = s3g              ? s3g_soak_print(seed, show_dialogue)
                            : verb == "show" ? soak_print(seed, show_dialogue)
                                             : noisy_print(seed, show_dialogue);
    std::printf("%s / %s / %s\n", print.what.c_str(), print.violation.c_str(), print.reason.c_str());
    return print.violation.empty() ? 0 : 1;
  }
  const std::uint64_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10000;
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  std::uint64_t finished = 0, paused = 0, violations = 0, invisible = 0, noticed = 0, resends = 0;
  std::map<std::string, std::vector<std::uint64_t>> reasons;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const SoakPrint print = s3g ? s3g_soak_print(seed) : soak_print(seed);
    finished += print.finished ? 1u : 0u;
    resends += print.resends;
    if (print.invisible > 0) ++invisible, noticed += print.noticed || !print.finished ? 1u : 0u;
    paused += print.pauses > 0 ? 1u : 0u;
    if (!print.finished) reasons[print.reason].push_back(seed);
    if (!print.violation.empty()) {
      ++violations;
      std::printf("VIOLATION %s: %s (%s)\n", print.what.c_str(), print.violation.c_str(),
                  print.reason.c_str());
    }
  }
  std::printf("%llu prints: %llu finished, %llu violations, %llu resend requests, %llu waited for a person\n",
              static_cast<unsigned long long>(count), static_cast<unsigned long long>(finished),
              static_cast<unsigned long long>(violations), static_cast<unsigned long long>(resends),
              static_cast<unsigned long long>(paused));
  std::printf("%llu with damage the firmware could not see, noticed in %llu\n",
              static_cast<unsigned long long>(invisible), static_cast<unsigned long long>(noticed));
  for (const auto& [reason, seeds] : reasons) {
    std::printf("%6zu  %s", seeds.size(), reason.c_str());
    for (std::size_t i = 0; i < seeds.size() && seeds.size() <= kFew; ++i)
      std::printf("%s %llu", i == 0 ? ":" : "", static_cast<unsigned long long>(seeds[i]));
    std::putchar('\n');
  }
  return violations == 0 ? 0 : 1;
}
