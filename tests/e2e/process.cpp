#include "tests/e2e/process.h"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace voidpath::test {

namespace fs = std::filesystem;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool eventually_step(double began_s, double limit_s) {
  if (seconds_now() - began_s > limit_s) return false;
  ::poll(nullptr, 0, 20);
  return true;
}

Process::Process(const std::vector<std::string>& args, const fs::path& dir, const std::string& tag)
    : out_(dir / (tag + ".out")), err_(dir / (tag + ".err")) {
  std::vector<char*> argv;
  for (const std::string& a : args) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ > 0) return;
  const int out = ::open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int err = ::open(err_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  const int in = ::open("/dev/null", O_RDONLY);
  ::dup2(in, 0);
  ::dup2(out, 1);
  ::dup2(err, 2);
  ::execv(argv[0], argv.data());
  ::_exit(127);
}

Process::~Process() {
  if (running()) {
    ::kill(pid_, SIGKILL);
    wait(10);
  }
}

void Process::signal(int number) const {
  if (pid_ > 0) ::kill(pid_, number);
}

bool Process::running() {
  if (pid_ <= 0) return false;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return true;
  code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  pid_ = -1;
  return false;
}

int Process::wait(double limit_s) {
  if (!eventually([&] { return !running(); }, limit_s)) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
    return -1;
  }
  return code_;
}

std::string read_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string Process::out() const { return read_file(out_); }
std::string Process::err() const { return read_file(err_); }

Result run(const std::vector<std::string>& args, const fs::path& dir, double limit_s) {
  static int counter = 0;
  Process p(args, dir, "run" + std::to_string(counter++));
  Result r;
  r.code = p.wait(limit_s);
  r.out = p.out();
  r.err = p.err();
  return r;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

ScratchDir::ScratchDir() {
  std::string name = (fs::temp_directory_path() / "voidpath-e2e-XXXXXX").string();
  path_ = ::mkdtemp(name.data());
}

ScratchDir::~ScratchDir() {
  if (std::getenv("VOIDPATH_KEEP") != nullptr) return;
  std::error_code ec;
  fs::remove_all(path_, ec);
}

}  // namespace voidpath::test
