#pragma once

#include <string>
#include <string_view>

/// Text of pages: numbers and escaping.
namespace voidpath::report {

/// For element content and quoted attributes. Bytes that are not UTF-8 and characters XML forbids become
/// U+FFFD, so that the page stays well-formed whatever a file is called.
std::string escaped(std::string_view text);

/// Exactly `decimals` digits after the point; never "-0".
std::string fixed(double value, int decimals);
/// As few digits as tell it to `decimals`: for coordinates of drawings.
std::string brief(double value, int decimals = 1);
/// "1 h 02 min", "3 min 20 s", "12 s".
std::string duration(double seconds);
/// "38 % less", "12 % more", "the same"; empty where there is nothing to compare with.
std::string change(double now, double before);

/// Appends ` name="value"`; the value needs no escaping.
void attribute(std::string& out, std::string_view name, std::string_view value);
void attribute(std::string& out, std::string_view name, double value);

struct Rgb {
  double r = 0, g = 0, b = 0;  ///< 0 to 255
};
Rgb mix(const Rgb& a, const Rgb& b, double share_of_b);
std::string hex(const Rgb& c);

}  // namespace voidpath::report
