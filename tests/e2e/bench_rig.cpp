#include "tests/e2e/bench_rig.h"

#include "firmware-io/marlin/file_command.h"
#include "tests/firmware-io/spaced.h"

#include <fstream>
#include <set>
#include <stdexcept>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

namespace voidpath::test {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A port nobody listens on right now.
int free_port() {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (::bind(fd, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw std::runtime_error("no free port");
  ::close(fd);
  return ntohs(address.sin_port);
}

std::string trimmed(std::string line) {
  const std::size_t comment = line.find(';');
  if (comment != std::string::npos) line.resize(comment);
  while (!line.empty() && (line.back() == ' ' || line.back() == '\t' || line.back() == '\r')) line.pop_back();
  const std::size_t begin = line.find_first_not_of(" \t");
  return begin == std::string::npos ? "" : line.substr(begin);
}

std::string first_word(const std::string& line) { return line.substr(0, line.find(' ')); }

}  // namespace

std::string program(const std::string& name) { return std::string(VOIDPATH_BIN_DIR) + "/" + name; }

std::vector<std::string> commands_of(const fs::path& gcode) {
  std::vector<std::string> out;
  for (const std::string& line : lines_of(read_file(gcode)))
    if (const std::string command = trimmed(line); !command.empty())
      out.push_back(fw::marlin::trim_move(command, true));  // as it goes over the wire
  return out;
}

BenchRig::BenchRig(Options options) : options_(std::move(options)), listen_("127.0.0.1:" + std::to_string(free_port())) {
  fs::create_directories(inbox());
  std::ofstream(scratch_ / "voidpath.yaml") << "state_dir: " << (scratch_ / "state").string() << "\nweb: {listen: \""
                                            << listen_ << "\"}\nsettle_s: 0.3\norient: {budget_s: 0}\n"
                                            << options_.extra_config
                                            << "printers:\n  - name: mock\n    profile: " << options_.profile << "\n    port: "
                                            << (scratch_ / options_.port).string() << "\n    watch: ["
                                            << inbox().string() << "]\n    auto_clear: "
                                            << (options_.auto_clear ? "true" : "false") << "\n    clock: "
                                            << (scratch_ / "clock").string() << "\n";
}

void BenchRig::start_mock(const std::string& link) {
  std::vector<std::string> args = {program("mock-printer"), "--link",  scratch_ / link,   "--speed", options_.mock_speed,
                                   "--clock",               scratch_ / "clock", "--log", scratch_ / "mock.log"};
  args.insert(args.end(), options_.mock_args.begin(), options_.mock_args.end());
  if (!options_.faults.empty()) {
    std::ofstream(scratch_ / "faults.yaml") << options_.faults;
    args.insert(args.end(), {"--faults", scratch_ / "faults.yaml"});
  }
  mock_ = std::make_unique<Process>(args, dir(), "mock");
  if (!eventually([&] { return mock_->out().find("ready ") != std::string::npos; }, 20))
    throw std::runtime_error("the mock printer did not get ready: " + mock_->err());
}

void BenchRig::start_daemon() {
  daemon_ = std::make_unique<Process>(
      std::vector<std::string>{program("voidpathd"), "--config", scratch_ / "voidpath.yaml"}, dir(), "daemon");
  if (!eventually([&] { return !daemon_->running() || cli({"status"}).code == 0; }, 30) || !daemon_->running())
    throw std::runtime_error("the daemon did not answer: " + daemon_->err());
}

void BenchRig::kill_daemon() {
  daemon_->signal(SIGKILL);
  daemon_->wait(10);
}

int BenchRig::stop_daemon() {
  daemon_->signal(SIGTERM);
  return daemon_->wait(30);
}

Result BenchRig::cli(std::vector<std::string> args, double limit_s) {
  args.insert(args.begin(), program("voidpath"));
  args.insert(args.end(), {"--config", scratch_ / "voidpath.yaml"});
  return run(args, dir(), limit_s);
}

json BenchRig::cli_json(std::vector<std::string> args) {
  const Result r = cli(args);
  if (r.code != 0) throw std::runtime_error("voidpath " + args[0] + " ended with " + std::to_string(r.code) + ": " + r.err);
  return json::parse(r.out);
}

bool BenchRig::wait_for_history(std::size_t rows, double limit_s) {
  const std::set<std::string> final_states = {"done", "failed", "cancelled"};
  return eventually(
      [&] {
        std::size_t ended = 0;
        for (const json& row : history()) ended += final_states.count(row.at("state").get<std::string>());
        return ended >= rows;
      },
      limit_s);
}

std::vector<std::string> BenchRig::executed_lines() const { return lines_of(read_file(scratch_ / "mock.log")); }

std::vector<std::string> BenchRig::executed_print_lines() const {
  const std::set<std::string> host = {"M110", "M115", "M105", "M155", "M113", "M400", "M503", "M211"};
  std::vector<std::string> out;
  for (const std::string& line : executed_lines())
    if (host.count(first_word(line)) == 0) out.push_back(spaced(line));
  return out;
}

json BenchRig::mock_counts() {
  const std::size_t before = lines_of(mock_->err()).size();
  mock_->signal(SIGUSR1);
  std::vector<std::string> lines;
  eventually([&] { lines = lines_of(mock_->err()); return lines.size() > before && lines.back().back() == '}'; }, 10);
  return json::parse(lines.back());
}

}  // namespace voidpath::test
