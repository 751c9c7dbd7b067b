#pragma once

#include "config/prusa/import.h"

#include <optional>
#include <set>
#include <string>

/// The pencil and paper of import_prusa(): reads values, remembers which were looked at, and takes down ours.
namespace voidpath::config {

class PrusaImporter {
 public:
  explicit PrusaImporter(const IniValues& values);

  struct Amount {
    double value = 0;
    bool percent = false;
    double of(double whole) const { return percent ? whole * value / 100 : value; }
  };
  bool has(const std::string& key) const { return values_.contains(key); }
  const IniValues& values() const { return values_; }

  // Of a list (one value an extruder, or one a mode) the first. Empty: not in the file, or nil. They throw
  // ConfigError for what cannot be read.
  std::optional<Amount> amount(const std::string& key);
  std::optional<double> number(const std::string& key);
  std::optional<bool> flag(const std::string& key);
  std::optional<std::string> word(const std::string& key);
  std::optional<double> part_of(const std::string& key, std::optional<double> whole);

  /// Whether our profiles have such a key.
  bool known(const std::string& ours) const { return schema_.contains(ours); }
  // Take down a value; of a key that our profiles do not have, nothing, and false.
  bool put(const std::string& ours, std::optional<double> value);
  bool put_flag(const std::string& ours, std::optional<bool> value);
  bool put_text(const std::string& ours, const std::string& value);
  bool put_yaml(const std::string& ours, const std::string& yaml);
  void approximated(const std::string& sentence) { out_.approximated.push_back(sentence); }
  void note(const std::string& sentence) { out_.notes.push_back(sentence); }
  void leave_out(const std::string& what) { out_.left_out.push_back(what); }
  /// The key was looked at and came over, in whatever way.
  void use(const std::string& key) { used_.insert(key); }

  PrusaImport finish();

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& why) const;
  const IniValues& values_;
  std::set<std::string> used_;
  std::vector<std::string> order_;  ///< of our keys
  std::set<std::string> schema_;
  PrusaImport out_;
};

std::string millimetres(double value);

// Each takes over one part of the configuration.
struct PrusaLayers {
  std::optional<double> height;
  std::optional<double> first;
  std::optional<double> nozzle;
  std::optional<double> width;  ///< of perimeters
};
PrusaLayers import_layers(PrusaImporter& in);
void import_shells(PrusaImporter& in, const PrusaLayers& layers);
void import_supports(PrusaImporter& in, const PrusaLayers& layers);
void import_speeds(PrusaImporter& in);
void import_filament(PrusaImporter& in);
void import_machine(PrusaImporter& in);

}  // namespace voidpath::config
