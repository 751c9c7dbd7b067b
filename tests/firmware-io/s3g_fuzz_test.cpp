#include "tests/fuzz/s3g_targets.h"

#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::test;

namespace {

std::vector<std::uint8_t> random_bytes(std::mt19937_64& random, std::size_t most) {
  std::vector<std::uint8_t> out(random() % most);
  for (std::uint8_t& byte : out) byte = static_cast<std::uint8_t>(random());
  return out;
}

}  // namespace

TEST_CASE("the S3G reader bears any bytes", "[s3g]") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 3000; ++i) {
    auto bytes = random_bytes(random, 200);
    for (std::uint8_t& byte : bytes) {
      if (random() % 8 == 0) byte = 0xD5;
    }
    fuzz_s3g_packet(bytes.data(), bytes.size());
  }
  SUCCEED();
}

TEST_CASE("the S3G encoder bears any text", "[s3g]") {
  std::mt19937_64 random(2);
  const std::string letters = "GMTXYZEABFSPIJR 0123456789.-\n\n; ";
  for (int i = 0; i < 3000; ++i) {
    std::string text = "G92 X0 Y0 Z0\n";
    for (std::size_t n = random() % 200; n > 0; --n) text += letters[random() % letters.size()];
    fuzz_s3g_encoder(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  }
  SUCCEED();
}

TEST_CASE("the S3G driver bears a hostile peer and a nervous user", "[s3g]") {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1500; ++i) {
    const auto bytes = random_bytes(random, 2000);
    fuzz_s3g_driver(bytes.data(), bytes.size());
  }
  SUCCEED();
}
