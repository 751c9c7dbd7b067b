#include "config/fields.h"
#include "daemon/cli/choice_json.h"
#include "daemon/cli/flags.h"
#include "daemon/cli/offline.h"
#include "engine/mesh/write.h"
#include "engine/report/ranking.h"
#include "engine/report/report.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <nlohmann/json.hpp>

namespace voidpath::cli {

namespace {

std::string nine_digits(double v) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.9g", v == 0 ? 0.0 : v);
  return buffer;
}

void write_candidates(const orient::Choice& choice, const std::string& file) {
  std::ofstream out(file, std::ios::trunc);
  out << "dx,dy,dz,H_mm,V_mm3,C,D_mm,score,printable,predicted_s\n";
  for (const auto& c : choice.candidates) {
    for (int a = 0; a < 3; ++a) out << nine_digits(c.direction[a]) << ',';
    for (const double v :
         {c.criteria.height_mm, c.criteria.trapped_mm3, c.criteria.contours, c.criteria.void_mm, c.score})
      out << config::number_text(v) << ',';
    out << (c.printable ? 1 : 0) << ',' << (c.predicted_s ? config::number_text(*c.predicted_s) : "") << '\n';
  }
  out.close();
  if (!out) throw std::runtime_error(file + ": cannot be written");
}

void print_row(const char* name, const orient::Candidate& c) {
  const auto& k = c.criteria;
  std::printf("  %-14s %8.2f mm %12.0f mm3 %8.2f %9.2f mm %9.4f %14s  (%+.4f, %+.4f, %+.4f)%s\n", name,
              k.height_mm, k.trapped_mm3, k.contours, k.void_mm, c.score,
              c.predicted_s ? duration_text(*c.predicted_s).c_str()
              : c.sampled_s ? ("~ " + duration_text(*c.sampled_s)).c_str()
                            : "",
              c.direction.x(), c.direction.y(), c.direction.z(), c.printable ? "" : ("  " + c.why).c_str());
}

mesh::TriangleMesh standing(const mesh::TriangleMesh& mesh, const orient::Candidate& c) {
  const auto turned = mesh::turned(mesh, c.direction);
  if (c.turn_rad == 0) return turned;
  return mesh::rotated(turned, geom::Quaternion(Eigen::AngleAxisd(c.turn_rad, geom::Vec3::UnitZ())));
}

void write_text(const std::string& text, const std::string& file) {
  std::ofstream out(file, std::ios::trunc | std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file + ": cannot be written");
}

void print_table(const mesh::Import& model, const orient::Choice& choice, double elapsed_s) {
  const auto& size = model.delivered.size_mm;
  std::printf("%zu triangles, %.1f x %.1f x %.1f mm; %zu directions in %.2f s (%s)\n",
              model.delivered.triangles, size.x(), size.y(), size.z(), choice.candidates.size(), elapsed_s,
              orient::to_string(choice.method).c_str());
  std::printf("  %-14s %11s %16s %8s %12s %9s %14s  %s\n", "", "height", "trapped", "contours", "void dist.",
              "score", "predicted", "direction that points up");
  print_row("as delivered", choice.candidates[choice.as_delivered]);
  print_row("chosen", choice.candidates[choice.chosen]);
  for (const std::size_t i : report::runners_up(choice, 3)) print_row("runner-up", choice.candidates[i]);
  for (const auto& [name, i] : choice.baselines)
    if (i != choice.chosen && i != choice.as_delivered) print_row(name.c_str(), choice.candidates[i]);
  if (choice.ties.size() > 1) std::printf("  %zu directions tie with the chosen one\n", choice.ties.size());
  if (const auto& t = choice.timing; t.asked > 0)
    std::printf("%zu of %zu directions timed in full, %zu on a sample of their layers%s\n", t.in_full,
                t.asked, t.sampled, t.budget_spent ? "; the budget was spent" : "");
  std::printf("%s\n", choice.why.c_str());
}

}  // namespace

int orient_command(const std::vector<std::string>& args) {
  CLI::App app("Chooses the orientation a part is printed in", "orient");
  CommonFlags common;
  OrientFlags orient;
  std::string model, candidates, out, page;
  app.add_option("model", model, "STL, OBJ or 3MF")->required();
  add_common(app, common);
  add_orient(app, orient);
  app.add_option("--candidates", candidates, "writes every direction to this CSV file");
  app.add_option("--out", out, "writes the turned mesh, .obj or .stl");
  app.add_option("--report", page, "writes a page with pictures of the choice to this HTML file");
  if (!parse(app, args)) return 0;

  const Settings s = settings_from(common, orient);
  const run::Context ctx = console_context(common.threads);
  const auto import = mesh::import_model(model, s.options.import, ctx);
  const auto begin = std::chrono::steady_clock::now();
  const orient::Choice choice = pipeline::choose(import.mesh, s.options, ctx);
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!page.empty()) {
    const std::string name = std::filesystem::path(model).filename().string();
    write_text(report::orientation_page(import, name, choice, s.options.orient,
                                        s.options.print.slice.support_angle_deg, ctx),
               page);
  }
  end_progress();

  if (!candidates.empty()) write_candidates(choice, candidates);
  if (!out.empty()) mesh::write_model(standing(import.mesh, choice.candidates[choice.chosen]), out);
  if (common.json)
    std::cout << orient_json(import, model, choice, elapsed).dump(2) << '\n';
  else
    print_table(import, choice, elapsed);
  return 0;
}

}  // namespace voidpath::cli
