#pragma once

#include "daemon/jobs/database.h"
#include "tests/daemon/fakes.h"

namespace voidpath::test {

/// From here to its end no row of a job or a print can be written.
class FullDisk {
 public:
  explicit FullDisk(const RunnerRig& rig) : database_(rig.config.state_dir / "voidpath.db") {
    for (const char* sql :
         {"CREATE TRIGGER full1 BEFORE UPDATE ON jobs BEGIN SELECT RAISE(ABORT, 'disk is full'); END",
          "CREATE TRIGGER full2 BEFORE INSERT ON jobs BEGIN SELECT RAISE(ABORT, 'disk is full'); END",
          "CREATE TRIGGER full3 BEFORE INSERT ON prints BEGIN SELECT RAISE(ABORT, 'disk is full'); END",
          "CREATE TRIGGER full4 BEFORE UPDATE ON prints BEGIN SELECT RAISE(ABORT, 'disk is full'); END",
          "CREATE TRIGGER full5 BEFORE INSERT ON printers BEGIN SELECT RAISE(ABORT, 'disk is full'); END"})
      database_.execute(sql);
  }
  ~FullDisk() {
    for (const char* sql : {"DROP TRIGGER full1", "DROP TRIGGER full2", "DROP TRIGGER full3",
                            "DROP TRIGGER full4", "DROP TRIGGER full5"})
      database_.execute(sql);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  daemon::Database database_;
};

}  // namespace voidpath::test
