#include "daemon/web/http.h"

#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <thread>

#include <httplib.h>
#include <sys/socket.h>

/// The server's threads read requests, call the handler, write the answer; they own nothing else.
namespace voidpath::daemon {
namespace {

constexpr std::size_t kMaxBody = std::size_t{1} << 20;
constexpr std::size_t kMaxUpload = std::size_t{2} << 30;
constexpr std::size_t kChunk = 1 << 16;

HttpRequest convert(const httplib::Request& from) {
  HttpRequest request;
  request.method = from.method;
  request.path = from.path;
  request.body = from.body;
  request.trusted = from.has_header("X-Voidpath");
  for (const auto& [key, value] : from.params) request.query.emplace(key, value);
  return request;
}

void answer(HttpResponse&& from, httplib::Response& to) {
  to.status = from.status;
  to.set_header("Cache-Control", "no-store");
  to.set_header("X-Content-Type-Options", "nosniff");
  to.set_header(
      "Content-Security-Policy",
      "default-src 'self'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; frame-ancestors 'none'");
  to.set_content(std::move(from.body), from.type);
}

}  // namespace

std::string HttpRequest::query_or(const std::string& name, const std::string& otherwise) const {
  const auto found = query.find(name);
  return found == query.end() ? otherwise : found->second;
}

std::pair<std::string, int> split_address(const std::string& address) {
  const auto colon = address.rfind(':');
  int port = -1;
  if (colon != std::string::npos) {
    const char* end = address.data() + address.size();
    const auto read = std::from_chars(address.data() + colon + 1, end, port);
    if (read.ec != std::errc() || read.ptr != end || port > 65535) port = -1;
  }
  if (port < 0) throw std::invalid_argument("\"" + address + "\" is no HOST:PORT");
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  if (host.empty()) host = "0.0.0.0";
  return {host, port};
}

struct HttpServer::Impl {
  httplib::Server server;
  int port = 0;
  std::thread thread;
};

HttpServer::HttpServer(const std::string& listen, Handler handler, std::string upload_path, Upload upload)
    : impl_(std::make_unique<Impl>()) {
  auto& server = impl_->server;
  // Not SO_REUSEPORT, the library's default: it lets two daemons share a port unnoticed.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  server.new_task_queue = [] { return new httplib::ThreadPool(4); };
  server.set_payload_max_length(kMaxUpload);
  server.set_keep_alive_max_count(100);
  server.set_keep_alive_timeout(1);
  server.set_read_timeout(60, 0);
  server.Post(upload_path, [upload](const httplib::Request& request, httplib::Response& response,
                                    const httplib::ContentReader& reader) {
    bool read = false;
    answer(upload(convert(request),
                  [&](const Sink& sink) {
                    read = true;
                    return reader([&](const char* data, std::size_t size) { return sink(data, size); });
                  }),
           response);
    // A refusal reaches the sender only when it has got rid of its file: bytes left unread reset the connection.
    if (!read) reader([](const char*, std::size_t) { return true; });
  });
  const auto plain = [handler](const httplib::Request& request, httplib::Response& response) {
    if (request.body.size() > kMaxBody) {
      response.status = 413;
      return;
    }
    answer(handler(convert(request)), response);
  };
  server.Get(".*", plain);
  server.Post(".*", plain);

  const auto [host, port] = split_address(listen);
  errno = 0;
  if (port == 0) {
    impl_->port = server.bind_to_any_port(host);
  } else {
    impl_->port = server.bind_to_port(host, port) ? port : -1;
  }
  if (impl_->port <= 0) {
    const std::string why = errno != 0 ? std::strerror(errno) : "no such address";
    throw ListenError("cannot listen on " + listen + ": " + why +
                      "; another voidpathd may be running, or change web.listen");
  }
  impl_->thread = std::thread([this] { impl_->server.listen_after_bind(); });
  // stop() does nothing before the thread is that far.
  while (!impl_->server.is_running()) std::this_thread::yield();
}

HttpServer::~HttpServer() {
  if (!impl_->thread.joinable()) return;
  impl_->server.stop();
  impl_->thread.join();
}

int HttpServer::port() const noexcept { return impl_->port; }

namespace {

std::optional<HttpResponse> convert(const httplib::Result& result) {
  if (!result) return std::nullopt;
  return HttpResponse{result->status, result->body, result->get_header_value("Content-Type")};
}

httplib::Client client_for(const std::string& address, int timeout_s) {
  auto [host, port] = split_address(address);
  if (host == "0.0.0.0") host = "127.0.0.1";
  if (host == "::") host = "::1";
  httplib::Client client(host, port);
  client.set_connection_timeout(5, 0);
  client.set_read_timeout(timeout_s, 0);
  client.set_write_timeout(timeout_s, 0);
  return client;
}

const httplib::Headers kHeaders = {{"X-Voidpath", "1"}};

}  // namespace

std::optional<HttpResponse> http_call(const std::string& address, const std::string& method,
                                      const std::string& path, const std::string& body, int timeout_s) {
  auto client = client_for(address, timeout_s);
  return convert(method == "POST" ? client.Post(path, kHeaders, body, "application/json")
                                  : client.Get(path, kHeaders));
}

std::optional<HttpResponse> http_upload(const std::string& address, const std::string& path,
                                        const std::string& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) throw std::runtime_error("cannot read " + file + ": " + std::strerror(errno));
  const auto size = static_cast<std::size_t>(in.tellg());
  auto client = client_for(address, 120);
  std::array<char, kChunk> buffer{};
  const auto provide = [&](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
    in.clear();
    in.seekg(static_cast<std::streamoff>(offset));
    in.read(buffer.data(), static_cast<std::streamsize>(std::min(length, buffer.size())));
    if (in.gcount() <= 0) return false;
    sink.write(buffer.data(), static_cast<std::size_t>(in.gcount()));
    return true;
  };
  return convert(client.Post(path, kHeaders, size, provide, "application/octet-stream"));
}

std::string url_escape(const std::string& text) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') ||
                       (byte >= 'a' && byte <= 'z') || std::strchr("-._~", c) != nullptr;
    if (plain && c != '\0') {
      out += c;
    } else {
      out += '%';
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    }
  }
  return out;
}

}  // namespace voidpath::daemon
