#include "engine/render/thumbnail.h"

#include <charconv>
#include <stdexcept>

#include <png.h>

namespace voidpath::render {

namespace {

/// Longer lines are cut by some readers, characters.
constexpr std::size_t kLine = 78;
constexpr int kLargest = 1024;

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
  }
  return out;
}

}  // namespace

std::string png(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGBA;
  const auto failure = [&] { return std::runtime_error(std::string("PNG: ") + image.message); };
  // Asking for the size would compress everything once more.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string out(size, '\0');
  if (png_image_write_to_memory(&image, out.data(), &size, 0, picture.rgba.data(), 0, nullptr) == 0)
    throw failure();
  out.resize(size);
  return out;
}

std::string thumbnail(const Picture& picture) {
  const std::string text = base64(png(picture));
  std::string out = "thumbnail begin " + std::to_string(picture.width) + "x" +
                    std::to_string(picture.height) + " " + std::to_string(text.size()) + "\n";
  for (std::size_t i = 0; i < text.size(); i += kLine) out += text.substr(i, kLine) + "\n";
  return out + "thumbnail end";
}

std::pair<int, int> picture_size(const std::string& text) {
  std::pair<int, int> size{0, 0};
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.first);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.second);
    const bool sane =
        size.first >= 1 && size.first <= kLargest && size.second >= 1 && size.second <= kLargest;
    if (height.ec == std::errc() && height.ptr == end && sane) return size;
  }
  throw std::invalid_argument("'" + text + "' is no picture size such as 400x300 (at most 1024x1024)");
}

}  // namespace voidpath::render
