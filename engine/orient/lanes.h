#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

/// Several numbers at once, in whatever registers the machine has (GCC's and Clang's vector types).
namespace voidpath::orient {

/// Loaded and stored at any address.
typedef float Lanes __attribute__((vector_size(16), aligned(4), may_alias));
typedef std::int32_t Ints __attribute__((vector_size(16)));

inline Lanes lower_of(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes higher_of(Lanes a, Lanes b) { return a > b ? a : b; }

/// Whether a comparison holds for any of the four.
inline bool any(Ints truth) {
  typedef std::int64_t Longs __attribute__((vector_size(16)));
  const Longs l = reinterpret_cast<Longs>(truth);
  return (l[0] | l[1]) != 0;
}

/// Vectors laid out to be read in order, as many at a time as a register holds; padded with nil.
template <class Number>
struct ColumnsOf {
  typedef Number Register __attribute__((vector_size(16), aligned(sizeof(Number)), may_alias));
  static constexpr std::size_t kStep = sizeof(Register) / sizeof(Number);
  std::vector<Number> x, y, z;

  void assign(std::size_t count) {
    for (auto* column : {&x, &y, &z}) column->assign((count + kStep - 1) / kStep * kStep, Number{0});
  }
  template <class Vector>
  void set(std::size_t i, const Vector& v) {
    x[i] = static_cast<Number>(v.x());
    y[i] = static_cast<Number>(v.y());
    z[i] = static_cast<Number>(v.z());
  }
  std::size_t padded() const { return x.size(); }
  /// Products with d of the kStep vectors from i on.
  template <class Vector>
  Register dot(std::size_t i, const Vector& d) const {
    auto some = [i](const std::vector<Number>& c) {
      return *reinterpret_cast<const Register*>(c.data() + i);
    };
    return static_cast<Number>(d[0]) * some(x) + static_cast<Number>(d[1]) * some(y) +
           static_cast<Number>(d[2]) * some(z);
  }
};
using Columns = ColumnsOf<double>;
using NearColumns = ColumnsOf<float>;

}  // namespace voidpath::orient
