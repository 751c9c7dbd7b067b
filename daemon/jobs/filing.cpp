#include "daemon/jobs/filing.h"

#include "daemon/jobs/facts_json.h"
#include "daemon/jobs/report_text.h"

#include <cmath>
#include <fstream>
#include <system_error>

namespace voidpath::daemon {
namespace {

namespace fs = std::filesystem;

Json started_json(const PrintRecord& record) {
  return record.started.empty() ? Json() : Json(record.started);
}

std::string csv_cell(const Json& value) {
  if (value.is_null()) return {};
  std::string text = value.is_string() ? value.text() : value.dump();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

/// The history's fields with the nested ones spread out.
Json::Object csv_cells(const PrintRecord& record) {
  const Json row = history_json(record);
  Json flat = Json::object();
  for (const auto& [key, value] : row.members()) {
    if (key == "direction") {
      const auto& d = value.items();
      static constexpr const char* kNames[] = {"dx", "dy", "dz"};
      for (std::size_t i = 0; i < 3; ++i) flat.set(kNames[i], d.size() == 3 ? d[i] : Json());
    } else if (key == "criteria") {
      for (const char* name : {"H_mm", "V_mm3", "C", "D_mm"}) flat.set(name, value[name]);
    } else if (key != "layer_times") {
      flat.set(key, value);
    }
  }
  return flat.members();
}

void write_file(const fs::path& file, const std::string& text) {
  const fs::path part = file.parent_path() / ("." + file.filename().string() + ".part");
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out) throw std::runtime_error("cannot write " + file.string());
  fs::rename(part, file);
}

/// A file of this identity in the folder: what an earlier run moved there before it ended.
fs::path find_moved(const fs::path& folder, const FileId& id) {
  std::error_code error;
  for (auto entry = fs::directory_iterator(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    if (identify(entry->path()) == id) return entry->path();
  }
  return {};
}

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::exists(fs::symlink_status(file, error));
}

template <typename Taken>
fs::path numbered(const fs::path& wanted, Taken&& taken) {
  fs::path out = wanted;
  for (int n = 2; taken(out); ++n) {
    out = wanted.parent_path() /
          (wanted.stem().string() + "-" + std::to_string(n) + wanted.extension().string());
  }
  return out;
}

fs::path report_of(const fs::path& input) { return input.string() + ".report.json"; }

/// Null if there is none that can be read.
Json report_beside(const fs::path& input) {
  std::ifstream in(report_of(input), std::ios::binary);
  if (!in) return {};
  try {
    return Json::parse(std::string(std::istreambuf_iterator<char>(in), {}));
  } catch (const JsonError&) {
    return {};
  }
}

/// A name that neither an input has nor the reports of another print; this print's own may be written again.
fs::path free_for_report(const fs::path& wanted, const PrintRecord& record) {
  return numbered(wanted, [&](const fs::path& name) {
    if (is_there(name)) return true;
    if (!is_there(report_of(name))) return false;
    const Json report = report_beside(name);
    return report["job"].integer(-1) != record.job || report["id"].integer(-1) != record.id;
  });
}

}  // namespace

Json history_json(const PrintRecord& record) {
  const auto& facts = record.facts;
  Json layers = Json::array();
  for (std::size_t i = 0; i < facts.layer_times.size() && i < record.layer_measured_s.size(); ++i) {
    layers.push(Json::object()
                    .set("z_mm", facts.layer_times[i].z_mm)
                    .set("predicted_s", facts.layer_times[i].seconds)
                    .set("measured_s", record.layer_measured_s[i]));
  }
  return Json::object()
      .set("id", record.id)
      .set("file", record.file)
      .set("model_sha256", facts.model_sha256)
      .set("started", started_json(record))
      .set("state", record.state)
      .set("method", facts.method)
      .set("direction", direction_json(facts.direction))
      .set("criteria", criteria_json(facts.criteria))
      .set("predicted_s", facts.predicted_s)
      .set("predicted_raw_s", facts.predicted_raw_s)
      .set("measured_s", record.measured_s)
      .set("heating_s", record.heating_s)
      .set("paused_s", record.paused_s)
      .set("total_s", record.total_s)
      .set("layers", facts.layers)
      .set("filament_mm", facts.filament_mm)
      .set("printer", record.printer)
      .set("firmware", record.firmware)
      .set("profile_sha256", facts.profile_sha256)
      .set("limits_from", facts.limits_from)
      .set("limits", facts.limits)
      .set("job", record.job)
      .set("ended", record.ended)
      .set("reason", record.reason)
      .set("why", facts.why)
      .set("resends", record.resends)
      .set("doubts", record.doubts)
      .set("layer_times", std::move(layers));
}

std::string history_csv_header() {
  std::string out;
  for (const auto& [key, value] : csv_cells({})) out += (out.empty() ? "" : ",") + key;
  return out;
}

std::string history_csv(const PrintRecord& record) {
  std::string out;
  for (bool first = true; const auto& [key, value] : csv_cells(record)) {
    if (!std::exchange(first, false)) out += ',';
    out += csv_cell(value);
  }
  return out;
}

std::string name_when_dropped(const fs::path& input) {
  return report_beside(input)["file"].text(input.filename().string());
}

fs::path free_name(const fs::path& wanted) { return numbered(wanted, is_there); }

void file_input(Job& job, const std::string& subfolder, const PrintRecord& record) {
  const fs::path target = job.folder / subfolder;
  fs::create_directories(target);
  fs::path reported;
  if (identify(job.location) == job.file) {
    if (job.location.parent_path() != target) {
      const fs::path to = free_for_report(target / job.file_name(), record);
      fs::rename(job.location, to);
      job.location = to;
    }
    reported = job.location;
  } else if (const fs::path moved = find_moved(target, job.file); !moved.empty()) {
    job.location = moved;
    reported = moved;
  } else {
    reported = free_for_report(target / job.file_name(), record);
  }
  Json report = history_json(record);
  report.set("as_delivered", Json::object()
                                 .set("criteria", criteria_json(record.facts.criteria_as_delivered))
                                 .set("predicted_s", record.facts.as_delivered_s)
                                 .set("is_rough", record.facts.as_delivered_is_rough));
  report.set("copies_done", job.copies_done);
  Json notes = Json::array();
  for (const auto& note : record.facts.notes) notes.push(note);
  report.set("notes", std::move(notes));
  write_file(report_of(reported), report.dump(2) + "\n");
  write_file(reported.string() + ".report.txt", report_text(job, record));
}

}  // namespace voidpath::daemon
