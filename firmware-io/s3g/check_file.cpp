#include "firmware-io/s3g/check_file.h"

#include "firmware-io/s3g/encoder.h"

namespace voidpath::fw::s3g {

void check_file(LineSource& gcode, const Machine& machine, const std::stop_token& stop) {
  Encoder encoder(machine);
  SourceLine line;
  while (!stop.stop_requested() && gcode.fetch(line)) encoder.encode(line);
}

}  // namespace voidpath::fw::s3g
