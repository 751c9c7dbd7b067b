#include "engine/evaluate/page.h"

#include "engine/evaluate/chart.h"
#include "engine/evaluate/summary.h"
#include "engine/orient/words.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace voidpath::evaluate {

namespace {

using orient::number;

/// J. Garcia, 2017, §4: four criteria against three, 953 models.
constexpr double kPublishedEqual = 62, kPublishedFaster = 15, kPublishedSlower = 23;

std::string percent(double share) { return number(100 * share, 1) + " %"; }
std::string paragraph(const std::string& html) { return "<p>" + html + "</p>\n"; }
std::string cell(const std::string& text, const std::string& css = "") {
  return "<td" + (css.empty() ? "" : " class=\"" + css + "\"") + ">" + escaped(text) + "</td>";
}

std::string clock_text(double seconds) {
  const long minutes = std::lround(seconds / 60);
  if (minutes < 60) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + (minutes % 60 < 10 ? "0" : "") + std::to_string(minutes % 60);
}

const std::string& words_of(const std::string& method) {
  static const std::pair<std::string, std::string> words[] = {
      {"thesis", "four criteria: the published weighted score, best printable direction"},
      {"ahsan", "three criteria: the same without void distance"},
      {"toolpath", "the default: candidates sliced and timed"},
      {"as-delivered", "not turned"},
      {"lowest", "least height"},
      {"axes", "quickest of the six axes"},
      {"tweaker", "least overhang with largest contact"},
      {"thesis-published", "four criteria exactly as published, where their choice can be printed"},
      {"ahsan-published", "three criteria exactly as published, likewise"},
      {"oracle", "every printable candidate sliced and timed"}};
  static const std::string none;
  for (const auto& [name, text] : words)
    if (name == method) return text;
  return none;
}

std::vector<std::string> methods_of(const std::vector<Row>& rows) {
  std::set<std::string> used;
  for (const Row& r : rows) used.insert(r.method);
  std::vector<std::string> out;
  for (const std::string& m : known_methods())
    if (used.count(m) > 0) out.push_back(m);
  return out;
}

std::string extremes(const Pair& pair) {
  const auto [low, high] = std::minmax_element(pair.ratios.begin(), pair.ratios.end());
  const auto name = [&](auto it) {
    return escaped(pair.models[static_cast<std::size_t>(it - pair.ratios.begin())]);
  };
  return "Median " + number(quantile(pair.ratios, 0.5), 3) + "; greatest " + number(*high, 3) + " (" +
         name(high) + "), least " + number(*low, 3) + " (" + name(low) + ").";
}

std::string shares_table(const std::vector<std::pair<std::string, Shares>>& lines) {
  std::string out =
      "<table><tr><th></th><th>models</th><th>equal</th><th>four faster</th><th>four slower</th></tr>\n";
  for (const auto& [name, s] : lines)
    out += "<tr>" + cell(name) + cell(std::to_string(s.count)) + cell(percent(s.equal)) +
           cell(percent(s.above)) + cell(percent(s.below)) + "</tr>\n";
  return out + "<tr>" + cell("published") + cell("953") + cell(number(kPublishedEqual, 0) + " %") +
         cell(number(kPublishedFaster, 0) + " %") + cell(number(kPublishedSlower, 0) + " %") +
         "</tr></table>\n";
}

std::string published_experiment(const std::vector<Row>& rows) {
  const Pair printable = compare_methods(rows, "ahsan", "thesis");
  if (printable.ratios.empty()) return {};
  std::string out = "<h2>The published experiment, run again</h2>\n";
  out += paragraph(
      "Print time in the direction the three criteria choose (height, trapped volume, contours) over print "
      "time in the "
      "one the four choose (void distance as well), with the published weights. Above 1 the four criteria "
      "print "
      "faster. Times within " +
      percent(kSame) + " are equal.");
  out += ratio_histogram(printable.ratios, kSame, "time(three criteria) / time(four criteria)");
  std::vector<std::pair<std::string, Shares>> lines = {
      {"best printable direction", shares_of(printable.ratios)}};
  const Pair exact = compare_methods(rows, "ahsan-published", "thesis-published");
  if (!exact.ratios.empty())
    lines.emplace_back("as published, where both can be printed", shares_of(exact.ratios));
  return out + shares_table(lines) + paragraph(extremes(printable));
}

std::string against_default(const std::vector<Row>& rows, const std::vector<std::string>& methods) {
  std::vector<StripRow> strips;
  std::string table =
      "<div class=\"scroll\"><table><tr><th>method</th><th>models</th><th>median</th><th>95 % "
      "below</th><th>worst</th>"
      "<th>mean</th><th>slower than default</th><th>faster than default</th><th>what it is</th></tr>\n";
  for (const std::string& m : methods) {
    if (m == "toolpath") continue;
    const Pair pair = compare_methods(rows, m, "toolpath");
    if (pair.ratios.empty()) continue;
    strips.push_back({m, pair.ratios, pair.models});
    double sum = 0;
    for (const double r : pair.ratios) sum += r;
    const Shares s = shares_of(pair.ratios);
    table += "<tr>" + cell(m) + cell(std::to_string(s.count)) + cell(number(quantile(pair.ratios, 0.5), 3)) +
             cell(number(quantile(pair.ratios, 0.95), 3)) + cell(number(quantile(pair.ratios, 1), 3)) +
             cell(number(sum / static_cast<double>(s.count), 3)) + cell(percent(s.above)) +
             cell(percent(s.below)) + "<td style=\"text-align:left;white-space:normal\">" +
             escaped(words_of(m)) + "</td></tr>\n";
  }
  if (strips.empty()) return {};
  return "<h2>Every method against the default</h2>\n" +
         paragraph(
             "Print time in the direction a method chooses over print time in the one <b>toolpath</b> "
             "chooses. One "
             "dot a model; the stroke is the median.") +
         ratio_strips(strips, "time(method) / time(toolpath)") + table + "</table></div>\n";
}

std::string gains(const std::vector<Row>& rows) {
  std::string out;
  for (const auto& [method, words] :
       {std::pair("as-delivered", "as delivered"), std::pair("thesis", "the four criteria"),
        std::pair("ahsan", "the three criteria")}) {
    const Pair pair = compare_methods(rows, "toolpath", method);
    if (pair.ratios.empty()) continue;
    out += "<li>Against " + std::string(words) + ": print time less by " +
           percent(1 - quantile(pair.ratios, 0.5)) + " at the median, " +
           percent(1 - quantile(pair.ratios, 0)) + " at best, " + percent(1 - quantile(pair.ratios, 1)) +
           " at worst, over " + std::to_string(pair.ratios.size()) + " models.</li>\n";
  }
  const Pair regret = compare_methods(rows, "toolpath", "oracle");
  if (!regret.ratios.empty())
    out += "<li>Regret against the quickest of all printable candidates: " +
           percent(quantile(regret.ratios, 0.5) - 1) + " at the median, " +
           percent(quantile(regret.ratios, 0.95) - 1) + " at the 95th percentile, " +
           percent(quantile(regret.ratios, 1) - 1) + " at worst, over " +
           std::to_string(regret.ratios.size()) + " models.</li>\n";
  return out.empty() ? out : "<h2>What the default gains</h2>\n<ul>" + out + "</ul>\n";
}

std::string model_table(const std::vector<Row>& rows, const std::vector<std::string>& methods) {
  std::string out =
      "<h2>Models</h2>\n<p>Print time by method; in brackets over the time as delivered. Bold: the "
      "quickest.</p>\n<div class=\"scroll\"><table><tr><th>model</th><th>triangles</th>";
  for (const std::string& m : methods) out += "<th>" + escaped(m) + "</th>";
  out += "</tr>\n";
  for (const std::string& model : models_of(rows)) {
    std::string line;
    double best = 1e300;
    std::size_t triangles = 0;
    for (const Row& r : rows) {
      if (r.model != model) continue;
      triangles = std::max(triangles, r.triangles);
      if (r.predicted_s) best = std::min(best, *r.predicted_s);
    }
    for (const std::string& m : methods) {
      const Row* r = find_row(rows, model, m);
      if (r == nullptr || !r->predicted_s) {
        line +=
            "<td class=\"note\" title=\"" + escaped(r == nullptr ? "not asked for" : r->why) + "\">–</td>";
        continue;
      }
      const std::string ratio = r->ratio ? " (" + number(*r->ratio, 2) + ")" : "";
      line += cell(clock_text(*r->predicted_s) + ratio, *r->predicted_s <= best * (1 + kSame) ? "best" : "");
    }
    if (best < 1e300) out += "<tr>" + cell(model) + cell(std::to_string(triangles)) + line + "</tr>\n";
  }
  return out + "</table></div>\n";
}

std::string failures(const std::vector<Row>& rows) {
  std::string out;
  for (const Row& r : rows)
    if (r.method.empty()) out += "<li>" + escaped(r.model) + ": " + escaped(r.why) + "</li>\n";
  return out.empty() ? out : "<h2>Left out</h2>\n<ul>" + out + "</ul>\n";
}

}  // namespace

std::string comparison_page(const std::vector<Row>& rows,
                            const std::vector<std::pair<std::string, std::string>>& facts) {
  const std::vector<std::string> methods = methods_of(rows);
  std::string out = page_begin("Print time by how the orientation is chosen");
  out += "<table>\n";
  for (const auto& [name, value] : facts)
    out += "<tr><td>" + escaped(name) + "</td><td style=\"text-align:left;white-space:normal\">" +
           escaped(value) + "</td></tr>\n";
  out += "</table>\n";
  out += published_experiment(rows) + against_default(rows, methods) + gains(rows) +
         model_table(rows, methods) + failures(rows);
  return out + page_end();
}

}  // namespace voidpath::evaluate
