#include "engine/evaluate/table.h"

#include "engine/evaluate/csv.h"

#include <array>
#include <charconv>
#include <stdexcept>

namespace voidpath::evaluate {

namespace {

constexpr const char* kHeader =
    "model,triangles,method,dx,dy,dz,H_mm,V_mm3,C,D_mm,predicted_s,ratio_to_as_delivered,elapsed_s,why,"
    "turn_rad,asked,in_full,sampled,complete";
constexpr std::size_t kColumns = 19;

template <class T>
std::string text_of(T value) {
  std::array<char, 40> buffer;  // the shortest text of a double has at most 24 characters
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end.ptr};
}

std::string text_of(const std::optional<double>& value) { return value ? text_of(*value) : std::string(); }

template <class T>
T parse(const std::string& text, std::size_t line) {
  T value{};
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size())
    throw std::runtime_error("line " + std::to_string(line) + ": '" + text + "' is not a number");
  return value;
}

std::optional<double> parse_optional(const std::string& text, std::size_t line) {
  if (text.empty()) return std::nullopt;
  return parse<double>(text, line);
}

}  // namespace

std::string to_csv(const std::vector<Row>& rows) {
  std::string out = std::string(kHeader) + "\n";
  for (const Row& r : rows) {
    out += csv_cell(r.model) + "," + text_of(r.triangles) + "," + csv_cell(r.method);
    const auto& k = r.criteria;
    for (const double v : {r.direction.x(), r.direction.y(), r.direction.z(), k.height_mm, k.trapped_mm3,
                           k.contours, k.void_mm})
      out += "," + text_of(v == 0 ? 0.0 : v);
    out += "," + text_of(r.predicted_s) + "," + text_of(r.ratio) + "," + text_of(r.elapsed_s) + "," +
           csv_cell(r.why) + "," + text_of(r.turn_rad) + "," + text_of(r.asked) + "," + text_of(r.in_full) +
           "," + text_of(r.sampled) + "," + (r.complete ? "1" : "0") + "\n";
  }
  return out;
}

std::vector<Row> from_csv(std::string_view text) {
  std::vector<Row> out;
  const std::vector<CsvRow> lines = parse_csv(text);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const auto& [cells, line] = lines[i];
    if (cells.size() != kColumns)
      throw std::runtime_error("line " + std::to_string(line) + ": " + std::to_string(kColumns) +
                               " cells are wanted");
    const auto number = [&](std::size_t k) { return parse<double>(cells[k], line); };
    Row r;
    r.model = cells[0];
    r.triangles = parse<std::size_t>(cells[1], line);
    r.method = cells[2];
    r.direction = {number(3), number(4), number(5)};
    r.criteria = {number(6), number(7), number(8), number(9)};
    r.predicted_s = parse_optional(cells[10], line);
    r.ratio = parse_optional(cells[11], line);
    r.elapsed_s = number(12);
    r.why = cells[13];
    r.turn_rad = number(14);
    r.asked = parse<std::size_t>(cells[15], line);
    r.in_full = parse<std::size_t>(cells[16], line);
    r.sampled = parse<std::size_t>(cells[17], line);
    r.complete = cells[18] != "0";
    out.push_back(std::move(r));
  }
  return out;
}

}  // namespace voidpath::evaluate
