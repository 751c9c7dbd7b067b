#include "engine/gcode/estimate.h"
#include "engine/pipeline/prepare.h"

#include <iostream>

// consumer MODEL OUT.gcode: which way up, sliced, and how long it takes.
int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const auto model = voidpath::mesh::import_model(argv[1]);
    const auto choice = voidpath::orient::search(model.mesh, {});
    const auto& best = choice.candidates[choice.chosen];
    std::cout << "height " << best.criteria.height_mm << " direction " << best.direction.transpose() << '\n';

    voidpath::pipeline::PrepareOptions options;
    options.direction = best.direction;
    voidpath::pipeline::prepare(argv[1], argv[2], options, false);
    const auto time = voidpath::gcode::estimate_file(argv[2], options.limits);
    std::cout << "layers " << time.layers.size() << " seconds " << time.predicted_s << '\n';
  } catch (const std::exception& e) {
    std::cerr << e.what() << '\n';
    return 1;
  }
}
