#pragma once

#include "engine/mesh/read_model.h"

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace voidpath::mesh {

/// The attributes of an element.
class XmlAttributes {
 public:
  explicit XmlAttributes(const char** pairs) : pairs_(pairs) {}
  /// Of no namespace; null when there is none.
  const char* find(std::string_view name) const;
  /// Of a namespace that contains `space`; null when there is none.
  const char* find_in(std::string_view space, std::string_view name) const;

 private:
  const char** pairs_;
};

/// Feeds XML of a package part, piece by piece, to element callbacks. Elements come as local name and
/// namespace address.
/// Document type declarations (and so entities) and encodings other than UTF-8 and UTF-16 are refused.
/// Callbacks may throw; the exception reaches the caller of feed().
class XmlStream {
 public:
  struct Handler {
    std::function<void(std::string_view name, std::string_view space, const XmlAttributes&)> begin;
    std::function<void(std::string_view name, std::string_view space)> end;
  };

  XmlStream(const FileBytes& file, std::string part, Handler handler);
  ~XmlStream();
  XmlStream(const XmlStream&) = delete;
  XmlStream& operator=(const XmlStream&) = delete;

  void feed(std::string_view piece);
  void finish();
  /// Refuses with part and line.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voidpath::mesh
