#pragma once

#include <string>
#include <vector>

/// Small pictures as SVG text, to be put into an HTML page. Colours are CSS classes of page_begin(), so that
/// they follow light and dark.
namespace voidpath::evaluate {

/// Text for HTML and SVG.
std::string escaped(const std::string& text);

/// Everything before a page's own content: head, style, title. Nothing is loaded from elsewhere.
std::string page_begin(const std::string& title);
std::string page_end();

/// Ratios as bars over a logarithmic axis; what is within `same` of 1 makes a bar of its own, in grey.
/// Beyond the outermost ticks the ratios count to the last bar. Ratios are positive.
std::string ratio_histogram(const std::vector<double>& ratios, double same, const std::string& axis_title);

struct StripRow {
  std::string label;
  std::vector<double> ratios;
  std::vector<std::string> names;  ///< of each ratio, shown when pointed at
};
/// One line a row: a dot a ratio, a stroke at the median, over a common logarithmic axis that begins at the
/// least and ends at the greatest.
std::string ratio_strips(const std::vector<StripRow>& rows, const std::string& axis_title);

struct Stack {
  std::string name;
  std::vector<double> values;  ///< one a column, not negative
};
/// Stacked columns, with a legend. More columns than fit are put together, showing their mean.
std::string stacked_columns(const std::vector<Stack>& stacks, const std::vector<std::string>& column_names,
                            const std::string& value_title, const std::string& column_title);

}  // namespace voidpath::evaluate
