#include "daemon/cli/choice_json.h"

#include <nlohmann/json.hpp>

namespace voidpath::cli {

using nlohmann::ordered_json;

namespace {

ordered_json vector_json(const geom::Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

ordered_json criteria_json(const orient::Criteria& c) {
  return {{"H_mm", c.height_mm}, {"V_mm3", c.trapped_mm3}, {"C", c.contours}, {"D_mm", c.void_mm}};
}

ordered_json choice_json(const orient::Candidate& c, const std::string& why) {
  const geom::Quaternion q = geom::Quaternion(Eigen::AngleAxisd(c.turn_rad, geom::Vec3::UnitZ())) *
                             mesh::rotation_to_up(c.direction);
  const orient::Angles a = orient::angles_of(c.direction);
  ordered_json j = {{"direction", vector_json(c.direction)},  {"quaternion", {q.w(), q.x(), q.y(), q.z()}},
                    {"angles_rad", {{"x", a.x}, {"z", a.z}}}, {"turn_rad", c.turn_rad},
                    {"criteria", criteria_json(c.criteria)},  {"score", c.score}};
  if (c.predicted_s)
    j["predicted_s"] = *c.predicted_s;
  else if (c.sampled_s)
    j["sampled_s"] = *c.sampled_s;
  j["printable"] = c.printable;
  j["why"] = c.printable ? why : c.why;
  return j;
}

ordered_json orient_json(const mesh::Import& model, const std::string& file, const orient::Choice& choice,
                         double elapsed_s) {
  const auto& r = model.delivered;
  ordered_json ties = ordered_json::array();
  for (const std::size_t t : choice.ties) ties.push_back(vector_json(choice.candidates[t].direction));
  ordered_json j = {
      {"model",
       {{"file", file},
        {"triangles", r.triangles},
        {"size_mm", vector_json(r.size_mm)},
        {"volume_mm3", mesh::volume(model.mesh)},
        {"shells", r.shells},
        {"watertight", r.watertight()}}},
      {"method", orient::to_string(choice.method)},
      {"weights",
       {{"h", choice.weights.h}, {"v", choice.weights.v}, {"d", choice.weights.d}, {"c", choice.weights.c}}},
      {"candidates", choice.candidates.size()},
      {"chosen", choice_json(choice.candidates[choice.chosen], choice.why)},
      {"as_delivered", choice_json(choice.candidates[choice.as_delivered], "as delivered")},
      {"ties", ties},
      {"elapsed_s", elapsed_s}};
  if (choice.method == orient::Method::toolpath) {
    ordered_json baselines = ordered_json::object();
    for (const auto& [name, i] : choice.baselines) baselines[name] = choice_json(choice.candidates[i], name);
    j["baselines"] = baselines;
    const auto& t = choice.timing;
    j["timing"] = {{"directions", t.asked},          {"in_full", t.in_full},
                   {"sampled", t.sampled},           {"complete", t.complete},
                   {"budget_spent", t.budget_spent}, {"sample_error", t.sample_error}};
  }
  return j;
}

}  // namespace voidpath::cli
