#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "src/apps/commands.hpp"
#include "src/apps/estimator_storage.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

class BudgetCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "budget"; }
  std::string_view summary() const noexcept override {
    return "Print the static memory of the estimator: bytes and name of every buffer";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins budget\n"
           "  pled-vins budget --sensor davis346";
  }

  void declare(CLI::App& app) override {
    app.add_option("--sensor", sensor_,
                   "Sensor class: davis240, davis346, vga, wvga or hd; default: every class that "
                   "this build has memory for");
  }

  ExitCode run() override {
    if (sensor_.empty()) {
      for (const limits::SensorClass& sensor : limits::kSensorClasses)
        if (has_storage(sensor)) print(sensor, std::string(sensor.name) + ".");
      return ExitCode::kDone;
    }
    const limits::SensorClass* sensor = class_by_name(sensor_);
    if (sensor == nullptr) {
      print_error("there is no sensor class '" + sensor_ +
                  "': choose davis240, davis346, vga, wvga or hd");
      return ExitCode::kMisused;
    }
    if (!has_storage(*sensor)) {
      print_error("this build has no memory for '" + sensor_ +
                  "': build with -DPLED_SENSOR=" + sensor_ + " or all");
      return ExitCode::kFailed;
    }
    print(*sensor, "");
    return ExitCode::kDone;
  }

 private:
  static void print(const limits::SensorClass& sensor, const std::string& prefix) {
    for (const BufferInfo& buffer : memory_table(sensor))
      std::printf("%zu\t%s%.*s\n", buffer.bytes, prefix.c_str(),
                  static_cast<int>(buffer.name.size()), buffer.name.data());
    std::printf("%zu\t%stotal\n", static_bytes(sensor), prefix.c_str());
  }

  std::string sensor_;
};

}  // namespace

std::unique_ptr<Command> make_budget_command() { return std::make_unique<BudgetCommand>(); }

}  // namespace pled::apps
