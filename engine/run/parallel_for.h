#pragma once

#include "engine/run/context.h"

#include <cstddef>
#include <functional>

namespace voidpath::run {

/// Calls body(i) once for every i in [0, count), from up to ctx.thread_count() threads, in any order.
/// Give each i its own place to write: then the result does not depend on the number of threads.
/// The first exception a body throws is rethrown here after all threads have ended; Stopped is thrown
/// when the context asks to stop. `grain` indices are taken at a time.
void parallel_for(const Context& ctx, std::size_t count, const std::function<void(std::size_t)>& body,
                  std::size_t grain = 1);

/// The same, telling body which worker (0 .. thread_count-1) runs it, for per-thread scratch memory.
void parallel_for_workers(const Context& ctx, std::size_t count,
                          const std::function<void(std::size_t index, unsigned worker)>& body,
                          std::size_t grain = 1);

/// Work of which every step needs the one before, and more work that only waits for its own step: link(i) in
/// order, from the calling thread; body(i) once for every i after link(i), from up to ctx.thread_count()
/// threads, in any order. Exceptions and Stopped as above.
void parallel_after(const Context& ctx, std::size_t count, const std::function<void(std::size_t)>& link,
                    const std::function<void(std::size_t)>& body);

/// The other way round: body(i) once for every i, from up to ctx.thread_count() threads, begun in order;
/// link(i) in order, from the calling thread, each after its own body. Exceptions and Stopped as above.
void parallel_before(const Context& ctx, std::size_t count, const std::function<void(std::size_t)>& body,
                     const std::function<void(std::size_t)>& link);

}  // namespace voidpath::run
