#include "daemon/app.h"

#include "daemon/event_log.h"
#include "daemon/event_loop.h"
#include "daemon/intake/folder_watcher.h"
#include "daemon/jobs/s3g_machine.h"
#include "daemon/jobs/runner.h"
#include "daemon/systemd_notify.h"
#include "daemon/version.h"
#include "daemon/web/api.h"

#include <cerrno>
#include <set>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace voidpath::daemon {
namespace {

namespace fs = std::filesystem;

/// How often waiting files are looked at, s: a fraction of the shortest sensible settling time.
constexpr double kSettlePoll_s = 0.2;
/// How often what users see is published while it changes, s.
constexpr double kPublish_s = 0.2;
/// How often folders are looked at anew, s: network file systems do not tell of what others write.
constexpr double kRescan_s = 15.0;
constexpr double kFolderCheck_s = 1.0;

/// One daemon per state directory, for as long as this lives.
class StateLock {
 public:
  explicit StateLock(const fs::path& state_dir) {
    std::error_code error;
    fs::create_directories(state_dir, error);
    if (error) throw std::runtime_error("cannot make " + state_dir.string() + ": " + error.message());
    const fs::path file = state_dir / "lock";
    fd_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd_ < 0) {
      throw std::runtime_error("cannot write " + file.string() + ": " +
                               std::generic_category().message(errno) +
                               "; give state_dir to this user, or choose another");
    }
    if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      ::close(fd_);
      throw std::runtime_error("another voidpathd uses " + state_dir.string() +
                               "; stop it, or set another state_dir");
    }
  }
  ~StateLock() { ::close(fd_); }
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;

 private:
  int fd_ = -1;
};

fs::path plain(const fs::path& path) {
  fs::path out = fs::absolute(path).lexically_normal();
  if (!out.has_filename() && out.has_relative_path()) out = out.parent_path();
  return out;
}

std::vector<fs::path> all_folders(const config::DaemonConfig& config) {
  std::vector<fs::path> out;
  for (const auto& printer : config.printers)
    out.insert(out.end(), printer.watch.begin(), printer.watch.end());
  return out;
}

fw::PortOptions port_options(const config::PrinterConfig& printer) {
  const auto profile = config::load_profile(printer.profile, printer.material, printer.quality);
  fw::PortOptions out;
  out.port = printer.port;
  out.baud = printer.baud;
  out.meatpack = printer.meatpack;
  out.keepalive_s = printer.keepalive_s;
  out.reset_on_connect = printer.reset_on_connect;
  out.rx_bytes = profile.limits.rx_bytes;
  out.cancel_gcode = profile.cancel_gcode;
  if (profile.limits.firmware == motion::Firmware::s3g) out.s3g = s3g_machine(profile);
  return out;
}

}  // namespace

config::DaemonConfig with_plain_paths(config::DaemonConfig config) {
  config.state_dir = plain(config.state_dir);
  for (auto& printer : config.printers) {
    for (auto& folder : printer.watch) folder = plain(folder);
  }
  return config;
}

void check_config(const config::DaemonConfig& config) {
  const std::string where = config.file.empty() ? "" : config.file.string() + ": ";
  std::set<std::string> names;
  for (const auto& printer : config.printers) {
    if (!names.insert(printer.name).second) {
      throw config::ConfigError(where + "two printers are called " + printer.name +
                                ": give each its own name");
    }
    port_options(printer);
  }
  config::check_folders(config);
  try {
    split_address(config.listen);
  } catch (const std::invalid_argument& error) {
    throw config::ConfigError(where + "web.listen: " + error.what());
  }
}

struct App::Parts {
  explicit Parts(config::DaemonConfig given)
      : config(std::move(given)),
        lock(config.state_dir),
        store(config.state_dir / "voidpath.db"),
        log([this](const auto& at, const auto& level, const auto& text) { store.log(at, level, text); }),
        settler(config.settle_s, real_probe()),
        pins(fw::kernel_pins()),
        runner({loop, store, settler, log, prepare_input, real_services(), port_options, pins.get()}, config),
        watcher(
            all_folders(config), [this](const fs::path& file) { found(file); },
            [this](const fs::path& folder, const std::string& what) {
              log.warning("folder", {{"folder", folder.string()}, {"what", what}});
            }),
        api(
            loop, runner, box, [this](const std::string& printer) { halt(printer); }, [this] { publish(); }),
        server(
            config.listen, [this](const HttpRequest& request) { return api.handle(request); },
            "/api/v1/files",
            [this](const HttpRequest& request, const auto& receive) { return api.upload(request, receive); }),
        signal_fd(open_signal_fd()) {
    publish();  // whoever asks first gets an answer
  }
  ~Parts() {
    api.close();
    ::close(signal_fd);
  }

  void start();
  void found(const fs::path& file);
  void settle();
  void publish();
  void halt(const std::string& printer);
  void on_signal();
  /// Runs `work` now and every `seconds`.
  void every(double seconds, std::function<void()> work);

  config::DaemonConfig config;
  StateLock lock;
  EventLoop loop;
  JobStore store;
  EventLog log;
  Settler settler;
  std::unique_ptr<fw::Pins> pins;
  Runner runner;
  FolderWatcher watcher;
  SnapshotBox box;
  Api api;
  HttpServer server;  ///< after all that its threads use
  int signal_fd;
  std::uint64_t published = 0;
  std::string status;
  bool ending = false;
};

void App::Parts::every(double seconds, std::function<void()> work) {
  work();
  loop.after(seconds, [this, seconds, work = std::move(work)] { every(seconds, work); });
}

void App::Parts::found(const fs::path& file) {
  const auto id = identify(file);
  if (!id || runner.owns(file, *id)) return;
  settler.note(file, loop.now_s());
}

void App::Parts::settle() {
  if (settler.idle()) return;
  for (const auto& file : settler.poll(loop.now_s())) {
    try {
      runner.take(file);
    } catch (const std::exception& error) {
      log.error("intake", {{"file", file.path.string()}, {"reason", error.what()}});
      settler.note(file.path, loop.now_s());  // it stays in its folder, to be taken when that works again
    }
  }
}

void App::Parts::publish() {
  if (published == runner.revision() && settler.idle()) return;
  published = runner.revision();
  box.put(make_snapshot(runner, settler));
  std::string now;
  for (const auto& printer : runner.printers()) {
    const Job* job = runner.job_on(*printer);
    const std::string waiting = runner.waiting_reason(*printer);
    now += (now.empty() ? "" : "; ") + printer->name() + ": " +
           (job               ? std::string(name_of(job->state)) + " " + job->file_name()
            : waiting.empty() ? "idle"
                              : waiting);
  }
  if (now != status) notify_manager("STATUS=" + now);
  status = now;
}

/// HTTP threads come here. The list of printers does not change while the server runs.
void App::Parts::halt(const std::string& name) {
  for (const auto& printer : runner.printers()) {
    if (name.empty() || printer->name() == name) printer->halt_now("emergency stop");
  }
}

void App::Parts::on_signal() {
  const int signal = read_signal(signal_fd);
  if (signal == 0) return;
  log.info("stopping", {{"signal", std::to_string(signal)}});
  notify_manager("STOPPING=1");
  if (std::exchange(ending, true)) {
    loop.quit();
    return;
  }
  runner.shutdown([this] { loop.quit(); });
}

void App::Parts::start() {
  log.info("starting", {{"version", version()},
                        {"state_dir", config.state_dir.string()},
                        {"listen", config.listen},
                        {"printers", std::to_string(config.printers.size())}});
  loop.add_fd(signal_fd, [this] { on_signal(); });
  runner.start();
  loop.add_fd(watcher.fd(), [this] { watcher.on_readable(); });
  every(kFolderCheck_s, [this] { watcher.check(); });
  every(kRescan_s, [this] { watcher.scan_all(); });
  every(kSettlePoll_s, [this] { settle(); });
  every(kPublish_s, [this] { publish(); });
  // Fed from the loop alone: a loop that hangs must be seen to hang.
  if (const auto period = watchdog_period_s()) every(*period / 2, [] { notify_manager("WATCHDOG=1"); });
  notify_manager("READY=1");
}

App::App(config::DaemonConfig config) : parts_(std::make_unique<Parts>(std::move(config))) {}
App::~App() = default;

void App::run() {
  parts_->start();
  parts_->loop.run();
  parts_->log.info("stopped");
}

}  // namespace voidpath::daemon
