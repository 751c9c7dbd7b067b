#include "daemon/jobs/facts_json.h"

#include <limits>

namespace voidpath::daemon {
namespace {

std::optional<orient::Criteria> criteria_from(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  orient::Criteria out;
  out.height_mm = json["H_mm"].number();
  out.trapped_mm3 = json["V_mm3"].number();
  out.contours = json["C"].number();
  out.void_mm = json["D_mm"].number();
  return out;
}

std::optional<double> maybe(const Json& json) {
  if (!json.is_number()) return std::nullopt;
  return json.number();
}

}  // namespace

Json criteria_json(const std::optional<orient::Criteria>& criteria) {
  if (!criteria) return {};
  return Json::object()
      .set("H_mm", criteria->height_mm)
      .set("V_mm3", criteria->trapped_mm3)
      .set("C", criteria->contours)
      .set("D_mm", criteria->void_mm);
}

Json direction_json(const std::optional<std::array<double, 3>>& direction) {
  if (!direction) return {};
  return Json::array().push((*direction)[0]).push((*direction)[1]).push((*direction)[2]);
}

std::string to_text(const JobFacts& facts) {
  Json layers = Json::array();
  for (const auto& layer : facts.layer_times) {
    layers.push(Json::array().push(layer.z_mm).push(layer.first_line).push(layer.seconds));
  }
  Json notes = Json::array();
  for (const auto& note : facts.notes) notes.push(note);
  return Json::object()
      .set("model_sha256", facts.model_sha256)
      .set("profile_sha256", facts.profile_sha256)
      .set("method", facts.method)
      .set("direction", direction_json(facts.direction))
      .set("criteria", criteria_json(facts.criteria))
      .set("criteria_as_delivered", criteria_json(facts.criteria_as_delivered))
      .set("why", facts.why)
      .set("predicted_raw_s", facts.predicted_raw_s)
      .set("predicted_s", facts.predicted_s)
      .set("estimate_s", facts.estimate_s)
      .set("as_delivered_s", facts.as_delivered_s)
      .set("as_delivered_is_rough", facts.as_delivered_is_rough)
      .set("layers", facts.layers)
      .set("filament_mm", facts.filament_mm)
      .set("layer_times", std::move(layers))
      .set("notes", std::move(notes))
      .set("limits_from", facts.limits_from)
      .set("limits", facts.limits)
      .dump();
}

JobFacts facts_from(const std::string& text) {
  const Json json = Json::parse(text);
  JobFacts facts;
  facts.model_sha256 = json["model_sha256"].text();
  facts.profile_sha256 = json["profile_sha256"].text();
  facts.method = json["method"].text();
  if (const auto& d = json["direction"].items(); d.size() == 3) {
    facts.direction = {d[0].number(), d[1].number(), d[2].number()};
  }
  facts.criteria = criteria_from(json["criteria"]);
  facts.criteria_as_delivered = criteria_from(json["criteria_as_delivered"]);
  facts.why = json["why"].text();
  facts.predicted_raw_s = json["predicted_raw_s"].number();
  facts.predicted_s = json["predicted_s"].number();
  facts.estimate_s = json["estimate_s"].number();
  facts.as_delivered_s = maybe(json["as_delivered_s"]);
  facts.as_delivered_is_rough = json["as_delivered_is_rough"].boolean();
  facts.layers = json["layers"].integer();
  facts.filament_mm = json["filament_mm"].number();
  for (const auto& layer : json["layer_times"].items()) {
    const auto& cell = layer.items();
    if (cell.size() != 3) continue;
    facts.layer_times.push_back(
        {cell[0].number(), static_cast<std::uint32_t>(cell[1].integer()), cell[2].number()});
  }
  for (const auto& note : json["notes"].items()) facts.notes.push_back(note.text());
  facts.limits_from = json["limits_from"].text();
  facts.limits = json["limits"].text();
  return facts;
}

std::string to_text(const JobOptions& options) {
  Json json = Json::object();
  if (!options.method.empty()) json.set("method", options.method);
  if (options.scale > 0) json.set("scale", options.scale);
  if (options.copies > 0) json.set("copies", options.copies);
  if (!options.slicer.empty()) json.set("slicer", options.slicer);
  return json.dump();
}

JobOptions options_from(const std::string& text) {
  const Json json = Json::parse(text);
  return {json["method"].text(), json["scale"].number(), static_cast<int>(json["copies"].integer()),
          json["slicer"].text()};
}

std::string to_text(const std::vector<double>& numbers) {
  Json json = Json::array();
  for (const double number : numbers) json.push(number);
  return json.dump();
}

std::vector<double> numbers_from(const std::string& text) {
  const Json json = Json::parse(text);
  std::vector<double> out;
  for (const auto& item : json.items()) {
    out.push_back(item.number(std::numeric_limits<double>::quiet_NaN()));
  }
  return out;
}

}  // namespace voidpath::daemon
