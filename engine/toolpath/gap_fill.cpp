#include "engine/toolpath/gap_fill.h"

namespace voidpath::toolpath {
std::vector<CentreLine> centre_lines(const geom::Region&) { return {}; }
}  // namespace voidpath::toolpath
