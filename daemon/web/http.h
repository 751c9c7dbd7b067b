#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

/// HTTP for the rest of the daemon and the command line, which never see the library behind it.
namespace voidpath::daemon {

struct HttpRequest {
  std::string method;
  std::string path;
  std::map<std::string, std::string> query;
  std::string body;      ///< empty for uploads
  bool trusted = false;  ///< carries the X-Voidpath header, which no foreign web page can send unasked
  std::string query_or(const std::string& name, const std::string& otherwise = {}) const;
};

struct HttpResponse {
  int status = 200;
  std::string body;
  std::string type = "application/json";
};

/// Cannot listen there; what() says on which address and why.
class ListenError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Answers on threads of its own. Handlers are called from several of them at once and must not throw.
class HttpServer {
 public:
  using Handler = std::function<HttpResponse(const HttpRequest&)>;
  /// Takes one piece of an upload; false: no more of it.
  using Sink = std::function<bool(const char* data, std::size_t size)>;
  /// `receive` delivers the body to a sink; it returns false when the peer went away or the sink refused.
  using Upload =
      std::function<HttpResponse(const HttpRequest&, const std::function<bool(const Sink&)>& receive)>;

  /// "HOST:PORT"; port 0 takes a free one. `upload_path` takes POST bodies of any size.
  /// Throws ListenError.
  HttpServer(const std::string& listen, Handler handler, std::string upload_path, Upload upload);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;
  int port() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// "HOST:PORT", "[v6]:PORT"; throws std::invalid_argument for anything else.
std::pair<std::string, int> split_address(const std::string& address);

/// One request to a server; empty when it cannot be reached or does not answer within `timeout_s`.
std::optional<HttpResponse> http_call(const std::string& address, const std::string& method,
                                      const std::string& path, const std::string& body = {},
                                      int timeout_s = 15);
/// POSTs a file, read as it is sent. Throws std::runtime_error when the file cannot be read.
std::optional<HttpResponse> http_upload(const std::string& address, const std::string& path,
                                        const std::string& file);
/// For use in a path or query.
std::string url_escape(const std::string& text);

}  // namespace voidpath::daemon
