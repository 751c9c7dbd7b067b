#pragma once

/// Heaters as bodies of first order under ideal control: full power until the target is reached, then exactly
/// on it; cooling follows Newton. Closed forms, so any two times give the same temperatures however they are
/// reached. °C, s.
namespace voidpath::test::mock {

struct HeaterModel {
  double ambient = 25;
  double full_power = 330;     ///< temperature that full power would end at
  double time_constant = 120;  ///< s
  double maximum = 260;        ///< targets above are clamped
};

class Heater {
 public:
  explicit Heater(const HeaterModel& model) : model_(model), temperature_(model.ambient) {}

  /// Brings the model to time `now` (s, never backwards).
  void update(double now);
  /// Clamped to the model's maximum. The caller has updated to the present.
  void set_target(double target);
  double target() const { return target_; }
  double temperature() const { return temperature_; }
  /// 0 to 127, the duty the firmware would report.
  int power() const;
  /// The element no longer heats, whatever the firmware wants.
  void break_element() { broken_ = true; }
  const HeaterModel& model() const { return model_; }
  /// Seconds from now until `temperature` is crossed, or infinity.
  double seconds_until(double temperature) const;

 private:
  HeaterModel model_;
  double temperature_;
  double target_ = 0;
  double time_ = 0;
  bool broken_ = false;
};

}  // namespace voidpath::test::mock
