#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace voidpath::test {

/// A child process; killed and reaped at the end of its life.
class Process {
 public:
  /// Starts `args` (args[0] is the program) with stdout and stderr in files of the folder, named after `tag`.
  Process(const std::vector<std::string>& args, const std::filesystem::path& dir, const std::string& tag);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const;
  /// Exit code, or 128 + signal; waits up to `limit_s`, then kills and returns -1.
  int wait(double limit_s = 60);
  bool running();
  std::string out() const;
  std::string err() const;
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int code_ = -1;
  std::filesystem::path out_;
  std::filesystem::path err_;
};

struct Result {
  int code = -1;
  std::string out;
  std::string err;
};
/// Runs to the end.
Result run(const std::vector<std::string>& args, const std::filesystem::path& dir, double limit_s = 120);

std::string read_file(const std::filesystem::path& file);
std::vector<std::string> lines_of(const std::string& text);

/// A folder that is gone at the end, unless the test failed and $VOIDPATH_KEEP is set.
class ScratchDir {
 public:
  ScratchDir();
  ~ScratchDir();
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Polls until the condition holds; false after `limit_s`. For other processes' work, which has no handle
/// to wait on.
template <class Condition>
bool eventually(Condition&& condition, double limit_s = 60);

bool eventually_step(double began_s, double limit_s);
double seconds_now();

template <class Condition>
bool eventually(Condition&& condition, double limit_s) {
  const double began = seconds_now();
  while (!condition())
    if (!eventually_step(began, limit_s)) return false;
  return true;
}

}  // namespace voidpath::test
