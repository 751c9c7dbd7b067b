#include "engine/render/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace voidpath::render {

namespace {

using geom::Vec3;

/// Each pixel is the mean of this many by this many.
constexpr int kOversampling = 2;
constexpr int kLargest = 4096;
/// The picture's border that stays empty, a share of its size.
constexpr double kMargin = 0.04;
/// Triangles between looks at the stop token.
constexpr std::size_t kCheckEvery = 65536;
/// The eye stands 30 degrees to the right of the front and 30 above the bed.
const double kHalf = 0.5, kRoot = std::sqrt(0.75);
const Vec3 kRight(kRoot, kHalf, 0);
const Vec3 kUp(-kHalf* kHalf, kHalf* kRoot, kRoot);
const Vec3 kToEye(kRoot* kHalf, -kRoot* kRoot, kHalf);
/// From the left above the eye.
const Vec3 kLight = (kToEye + 0.6 * kUp - 0.5 * kRight).normalized();
constexpr double kAmbient = 0.28;
constexpr std::array<double, 3> kColour = {70, 165, 160};

struct Screen {
  double x, y, depth;  ///< samples, samples, mm towards the eye
};

class Canvas {
 public:
  Canvas(int width, int height)
      : width_(width),
        height_(height),
        depth_(size(), -std::numeric_limits<float>::infinity()),
        shade_(size(), 0) {}

  void triangle(const std::array<Screen, 3>& p, std::uint8_t shade) {
    const double area = cross(p[0], p[1], p[2].x, p[2].y);
    if (area == 0) return;
    const auto first = [](double a, double b, double c) { return std::ceil(std::min({a, b, c}) - 0.5); };
    const auto last = [](double a, double b, double c) { return std::floor(std::max({a, b, c}) - 0.5); };
    const int x0 = std::max(0, static_cast<int>(first(p[0].x, p[1].x, p[2].x)));
    const int x1 = std::min(width_ - 1, static_cast<int>(last(p[0].x, p[1].x, p[2].x)));
    const int y0 = std::max(0, static_cast<int>(first(p[0].y, p[1].y, p[2].y)));
    const int y1 = std::min(height_ - 1, static_cast<int>(last(p[0].y, p[1].y, p[2].y)));
    // A share is below nothing where the area it is of has the other sign: most of what lies outside is known
    // without a division.
    const auto misses = [area](double part) { return area > 0 ? part < 0 : part > 0; };
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double of_a = cross(p[1], p[2], px, py);
        if (misses(of_a)) continue;
        const double of_b = cross(p[2], p[0], px, py);
        if (misses(of_b)) continue;
        const double a = of_a / area;
        const double b = of_b / area;
        const double c = 1 - a - b;
        if (c < 0) continue;
        put(x, y, static_cast<float>(a * p[0].depth + b * p[1].depth + c * p[2].depth), shade);
      }
  }

  Picture picture() const {
    Picture out{width_ / kOversampling, height_ / kOversampling, {}};
    out.rgba.reserve(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height) * 4);
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) add_pixel(out, x * kOversampling, y * kOversampling);
    return out;
  }

 private:
  std::size_t size() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  static double cross(const Screen& a, const Screen& b, double x, double y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
  }
  void put(int x, int y, float depth, std::uint8_t shade) {
    const std::size_t i = at(x, y);
    if (depth <= depth_[i]) return;
    depth_[i] = depth;
    shade_[i] = shade;
  }
  void add_pixel(Picture& out, int x, int y) const {
    int hit = 0;
    int sum = 0;
    for (int dy = 0; dy < kOversampling; ++dy)
      for (int dx = 0; dx < kOversampling; ++dx) {
        const std::size_t i = at(x + dx, y + dy);
        if (depth_[i] == -std::numeric_limits<float>::infinity()) continue;
        ++hit;
        sum += shade_[i];
      }
    const double shade = hit > 0 ? static_cast<double>(sum) / hit / 255 : 0;
    for (const double c : kColour)
      out.rgba.push_back(static_cast<std::uint8_t>(std::lround(std::min(255.0, c * 1.5 * shade))));
    out.rgba.push_back(static_cast<std::uint8_t>(hit * 255 / (kOversampling * kOversampling)));
  }

  int width_;
  int height_;
  std::vector<float> depth_;
  std::vector<std::uint8_t> shade_;
};

struct View {
  double scale = 1;  ///< samples a mm
  double x = 0, y = 0;

  View(const mesh::TriangleMesh& mesh, int width, int height) {
    Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
    for (const Vec3& v : mesh.vertices) {
      const Eigen::Vector2d p(v.dot(kRight), -v.dot(kUp));
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Eigen::Vector2d size = (high - low).cwiseMax(1e-9);
    scale = (1 - 2 * kMargin) * std::min(width / size.x(), height / size.y());
    x = 0.5 * width - 0.5 * scale * (low.x() + high.x());
    y = 0.5 * height - 0.5 * scale * (low.y() + high.y());
  }
  Screen operator()(const Vec3& v) const {
    return {x + scale * v.dot(kRight), y - scale * v.dot(kUp), v.dot(kToEye)};
  }
};

}  // namespace

Picture draw(const mesh::TriangleMesh& mesh, int width, int height, const run::Context& ctx) {
  width = std::clamp(width, 1, kLargest) * kOversampling;
  height = std::clamp(height, 1, kLargest) * kOversampling;
  Canvas canvas(width, height);
  const View view(mesh, width, height);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i % kCheckEvery == 0) ctx.check();
    const auto& t = mesh.triangles[i];
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    if (!(normal.dot(kToEye) > 0)) continue;  // faces away, or is no area at all
    const double lit = kAmbient + (1 - kAmbient) * std::max(0.0, normal.dot(kLight));
    canvas.triangle({view(a), view(b), view(c)},
                    static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, lit))));
  }
  return canvas.picture();
}

}  // namespace voidpath::render
