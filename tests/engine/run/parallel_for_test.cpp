#include "engine/run/parallel_for.h"

#include <atomic>
#include <functional>
#include <stdexcept>
#include <vector>

#include <catch2/catch.hpp>

namespace voidpath::run {
namespace {

using Work = std::function<void(std::size_t)>;

// A way to run `count` pieces of work; in a chain, as its links, what follows them or what they wait for.
struct Way {
  const char* name;
  std::function<void(const Context&, std::size_t count, const Work&)> run;
};

std::vector<Way> ways() {
  const Work nothing = [](std::size_t) {};
  return {
      {"parallel_for",
       [](const Context& ctx, std::size_t count, const Work& work) { parallel_for(ctx, count, work); }},
      {"links of a chain", [=](const Context& ctx, std::size_t count,
                               const Work& work) { parallel_after(ctx, count, work, nothing); }},
      {"what follows a chain", [=](const Context& ctx, std::size_t count,
                                   const Work& work) { parallel_after(ctx, count, nothing, work); }},
      {"what a chain waits for", [=](const Context& ctx, std::size_t count,
                                     const Work& work) { parallel_before(ctx, count, work, nothing); }},
      {"links that wait", [=](const Context& ctx, std::size_t count,
                              const Work& work) { parallel_before(ctx, count, nothing, work); }},
  };
}

}  // namespace

TEST_CASE("every index is visited once, for any number of threads and grain") {
  for (const unsigned threads : {1u, 2u, 3u, 8u})
    for (const std::size_t count : {0u, 1u, 7u, 1000u})
      for (const std::size_t grain : {0u, 1u, 3u, 64u, 5000u}) {
        Context ctx;
        ctx.threads = threads;
        std::vector<std::atomic<int>> visits(count);
        parallel_for(
            ctx, count, [&](std::size_t i) { ++visits[i]; }, grain);
        for (const auto& v : visits) REQUIRE(v == 1);
      }
}

TEST_CASE("workers are numbered below the thread count and each runs alone") {
  Context ctx;
  ctx.threads = 4;
  std::vector<std::atomic<int>> busy(4);
  std::atomic<bool> clash{false};
  parallel_for_workers(ctx, 2000, [&](std::size_t, unsigned worker) {
    if (worker >= 4 || busy[worker].fetch_add(1) != 0) clash = true;
    if (worker < 4) busy[worker].fetch_sub(1);
  });
  CHECK_FALSE(clash);
}

TEST_CASE("an exception ends the work and comes out here") {
  for (const Way& way : ways())
    for (const unsigned threads : {1u, 2u, 4u}) {
      INFO(way.name << ", threads " << threads);
      Context ctx;
      ctx.threads = threads;
      std::atomic<int> calls{0};
      CHECK_THROWS_AS(way.run(ctx, 100'000,
                              [&](std::size_t i) {
                                ++calls;
                                if (i == 5) throw std::out_of_range("five");
                              }),
                      std::out_of_range);
      CHECK(calls < 100'000);
    }
}

TEST_CASE("a stop request ends the work as Stopped") {
  for (const Way& way : ways())
    for (const unsigned threads : {1u, 4u}) {
      INFO(way.name << ", threads " << threads);
      std::stop_source source;
      Context ctx;
      ctx.stop = source.get_token();
      ctx.threads = threads;
      std::atomic<int> calls{0};
      CHECK_THROWS_AS(way.run(ctx, 100'000,
                              [&](std::size_t i) {
                                ++calls;
                                if (i == 10) source.request_stop();
                              }),
                      Stopped);
      CHECK(calls < 100'000);
      CHECK_THROWS_AS(ctx.check(), Stopped);
    }
  CHECK_NOTHROW(Context{}.check());
}

TEST_CASE("no link of a chain begins after a stop request") {
  for (const unsigned threads : {1u, 4u}) {
    std::stop_source source;
    Context ctx;
    ctx.stop = source.get_token();
    ctx.threads = threads;
    std::size_t links = 0;
    const auto link = [&](std::size_t i) {
      ++links;
      if (i == 10) source.request_stop();
    };
    CHECK_THROWS_AS(parallel_after(ctx, 100'000, link, [](std::size_t) {}), Stopped);
    CHECK(links == 11);
  }
}

TEST_CASE("work whose time is over ends as Stopped, though nobody asked it to stop") {
  for (const unsigned threads : {1u, 4u}) {
    std::atomic<int> calls{0};
    Context ctx;
    ctx.threads = threads;
    ctx.over = [&] { return calls >= 10; };
    CHECK_THROWS_AS(parallel_for(ctx, 100'000, [&](std::size_t) { ++calls; }), Stopped);
    CHECK(calls >= 10);
    CHECK(calls < 100'000);
    CHECK_FALSE(ctx.stop.stop_requested());
  }
}

TEST_CASE("what follows a chain sees its own link done, and every link the one before") {
  for (const unsigned threads : {1u, 2u, 3u, 8u})
    for (const std::size_t count : {0u, 1u, 7u, 1000u}) {
      Context ctx;
      ctx.threads = threads;
      std::size_t sum = 0;  // by the chain alone, from one thread
      std::vector<std::size_t> links(count), found(count);
      parallel_after(
          ctx, count, [&](std::size_t i) { links[i] = sum += i + 1; },
          [&](std::size_t i) { found[i] += links[i]; });
      for (std::size_t i = 0; i < count; ++i) REQUIRE(found[i] == (i + 1) * (i + 2) / 2);
    }
}

TEST_CASE("a chain that waits for bodies sees each of its own done, in order") {
  for (const unsigned threads : {1u, 2u, 3u, 8u})
    for (const std::size_t count : {0u, 1u, 7u, 1000u}) {
      Context ctx;
      ctx.threads = threads;
      std::vector<std::size_t> found(count);
      std::vector<std::size_t> order;  // by the chain alone, from one thread
      parallel_before(
          ctx, count, [&](std::size_t i) { found[i] += i + 1; },
          [&](std::size_t i) { order.push_back(found[i]); });
      REQUIRE(order.size() == count);
      for (std::size_t i = 0; i < count; ++i) REQUIRE(order[i] == i + 1);
    }
}

TEST_CASE("the context has at least one thread and passes progress on") {
  Context ctx;
  CHECK(ctx.thread_count() >= 1);
  ctx.threads = 3;
  CHECK(ctx.thread_count() == 3);
  CHECK_NOTHROW(ctx.progress("nobody listens", 0.5));
  double seen = 0;
  ctx.on_progress = [&](std::string_view phase, double fraction) {
    CHECK(phase == "slice");
    seen = fraction;
  };
  ctx.progress("slice", 0.25);
  CHECK(seen == 0.25);
}

}  // namespace voidpath::run
