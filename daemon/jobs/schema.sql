CREATE TABLE IF NOT EXISTS printers (
  name      TEXT PRIMARY KEY,
  bed_clear INTEGER NOT NULL DEFAULT 0,   -- 0 until a person or auto_clear says otherwise
  held      TEXT NOT NULL DEFAULT '',     -- why nothing may start, until the bed is cleared; empty: not held
  firmware  TEXT NOT NULL DEFAULT '',     -- as it last named itself
  may_be_hot INTEGER NOT NULL DEFAULT 0   -- a print was cut off: heaters off at the next connection
);

CREATE TABLE IF NOT EXISTS printer_limits (
  name    TEXT PRIMARY KEY,
  wiring  TEXT NOT NULL,                  -- port and profile it was asked at: another one may be another machine
  machine TEXT NOT NULL,                  -- what the firmware called itself
  limits  TEXT NOT NULL                   -- JSON
);

CREATE TABLE IF NOT EXISTS jobs (
  id          INTEGER PRIMARY KEY AUTOINCREMENT,
  printer     TEXT NOT NULL,
  folder      TEXT NOT NULL,
  input       TEXT NOT NULL,
  location    TEXT NOT NULL,
  device      INTEGER NOT NULL,
  inode       INTEGER NOT NULL,
  size        INTEGER NOT NULL,
  mtime_ns    INTEGER NOT NULL,
  state       TEXT NOT NULL,
  position    INTEGER NOT NULL,
  copies      INTEGER NOT NULL,
  copies_done INTEGER NOT NULL,
  options     TEXT NOT NULL,              -- JSON
  facts       TEXT NOT NULL,              -- JSON
  message     TEXT NOT NULL,
  filed       INTEGER NOT NULL,
  received    TEXT NOT NULL
);
-- A file that is not yet filed belongs to exactly one job.
CREATE UNIQUE INDEX IF NOT EXISTS jobs_file ON jobs (location, device, inode, size, mtime_ns) WHERE filed = 0;

CREATE TABLE IF NOT EXISTS prints (
  id              INTEGER PRIMARY KEY AUTOINCREMENT,
  job             INTEGER NOT NULL,
  file            TEXT NOT NULL,
  started         TEXT NOT NULL,
  ended           TEXT NOT NULL,
  state           TEXT NOT NULL,          -- open, done, failed, cancelled, interrupted
  reason          TEXT NOT NULL,
  printer         TEXT NOT NULL,
  firmware        TEXT NOT NULL,
  profile_sha256  TEXT NOT NULL,
  predicted_raw_s REAL NOT NULL,
  measured_s      REAL,
  heating_s       REAL NOT NULL,
  paused_s        REAL NOT NULL,
  total_s         REAL,
  resends         INTEGER NOT NULL,
  layer_s         TEXT NOT NULL,          -- JSON, measured, beside the layers of facts
  facts           TEXT NOT NULL,          -- JSON
  doubts          INTEGER NOT NULL DEFAULT 0
);
CREATE INDEX IF NOT EXISTS prints_calibration ON prints (printer, profile_sha256, firmware) WHERE state = 'done';

CREATE TABLE IF NOT EXISTS events (
  id    INTEGER PRIMARY KEY AUTOINCREMENT,
  at    TEXT NOT NULL,
  level TEXT NOT NULL,
  text  TEXT NOT NULL
);
