#include <cstdio>
#include <string>
#include <variant>

#include <CLI/CLI.hpp>

#include "pled_vins/config/app_config.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

class ConfigCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "config"; }
  std::string_view summary() const noexcept override {
    return "Print the documented default settings, or check a settings file";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins config --print-default > my.yaml\n"
           "  pled-vins config --check my.yaml";
  }

  void declare(CLI::App& app) override {
    auto* group = app.add_option_group("what", "One of:");
    group->add_flag("--print-default", print_default_,
                    "Print every setting with its meaning, unit, range and default");
    group->add_option("--check", file_, "Read a settings file and print it completed");
    group->require_option(1);
  }

  ExitCode run() override {
    AppConfig config;
    if (!print_default_) {
      auto loaded = load_config(file_);
      if (const auto* error = std::get_if<ConfigError>(&loaded)) {
        print_error(error->message());
        return ExitCode::kFailed;
      }
      config = std::get<AppConfig>(std::move(loaded));
    }
    std::fputs(to_documented_yaml(config).c_str(), stdout);
    return ExitCode::kDone;
  }

 private:
  bool print_default_ = false;
  std::string file_;
};

}  // namespace

std::unique_ptr<Command> make_config_command() { return std::make_unique<ConfigCommand>(); }

}  // namespace pled::apps
