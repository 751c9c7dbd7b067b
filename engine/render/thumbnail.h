#pragma once

#include "engine/render/picture.h"

#include <string>
#include <utility>

namespace voidpath::render {

/// The picture as a PNG file's bytes. Throws std::runtime_error if the library fails.
std::string png(const Picture& picture);

/// The picture as G-code viewers, printers' screens and print hosts find it in a file's comments: PNG in
/// base64 between `thumbnail begin` and `thumbnail end`. Lines without their `; `.
std::string thumbnail(const Picture& picture);

/// "400x300" as width and height in pixels. Throws std::invalid_argument, saying what is wrong.
std::pair<int, int> picture_size(const std::string& text);

}  // namespace voidpath::render
