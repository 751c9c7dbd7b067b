#include "daemon/jobs/job_options.h"

#include "daemon/cli/client.h"

#include <stdexcept>

#include <catch2/catch.hpp>

using namespace voidpath::daemon;
using voidpath::cli::ClientError;
using voidpath::cli::kUsage;
using voidpath::cli::parse_client;

TEST_CASE("options of a job are read or refused, never bent") {
  for (const char* method : {"toolpath", "thesis", "ahsan", "as-delivered"})
    CHECK(read_method(method) == method);
  for (const char* bad : {"", "bogus", "Thesis", "thesis "})
    CHECK_THROWS_AS(read_method(bad), std::invalid_argument);
  for (const char* slicer : {"builtin", "prusa-slicer", "cura-engine"}) CHECK(read_slicer(slicer) == slicer);
  for (const char* bad : {"", "prusaslicer", "/bin/sh"})
    CHECK_THROWS_AS(read_slicer(bad), std::invalid_argument);
  CHECK(read_copies("1") == 1);
  CHECK(read_copies("1000") == 1000);
  for (const char* bad : {"", "0", "-1", "1001", "99999999999", "2x", "1.5"})
    CHECK_THROWS_AS(read_copies(bad), std::invalid_argument);
  CHECK(read_scale("25.4") == 25.4);
  for (const char* bad : {"", "0", "-1", "inf", "nan", "1e7", "2,5"})
    CHECK_THROWS_AS(read_scale(bad), std::invalid_argument);
}

TEST_CASE("a wrong option of add is wrong usage, before any daemon is asked") {
  const auto code = [](const std::string& command, const std::vector<std::string>& args) {
    try {
      parse_client(command, args);
      return 0;
    } catch (const ClientError& error) {
      return error.code();
    }
  };
  CHECK(code("add", {"a.stl", "--method", "bogus"}) == kUsage);
  CHECK(code("add", {"a.stl", "--copies", "0"}) == kUsage);
  CHECK(code("add", {"a.stl", "--slicer", "slic3r"}) == kUsage);
  CHECK(code("add", {"a.stl", "--copies", "1001"}) == kUsage);
  CHECK(code("add", {"a.stl", "--scale", "inf"}) == kUsage);
  const auto flags = parse_client("add", {"a.stl", "--method", "thesis", "--copies", "1000", "--scale", "2"});
  CHECK(flags.method == "thesis");
  CHECK(flags.copies == 1000);
  CHECK(flags.scale == 2);
}

TEST_CASE("watch and logs can follow") {
  CHECK(parse_client("watch", {"-f"}).follow);
  CHECK(parse_client("logs", {"--follow"}).follow);
  CHECK_FALSE(parse_client("watch", {}).follow);
  CHECK_THROWS_AS(parse_client("status", {"-f"}), ClientError);
}
